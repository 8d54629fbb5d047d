//@ use data/material
// KHR_materials_clearcoat: the share, the roughness and the reflectance of a coat.
fn begin_coat(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.coat != NO_EXTENSION;
}

fn take_coat(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.coat = min(colour.x, 1.0);
        (*evaluated).lobes.coat_roughness = row.parameter;
        (*evaluated).lobes.coat_f0 = row.contrast_outside;
    }
}
