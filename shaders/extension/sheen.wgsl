//@ use data/material
// KHR_materials_sheen: the colour and the roughness.
fn begin_sheen(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.sheen != NO_EXTENSION;
}

fn take_sheen(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.sheen = min(colour, vec3<f32>(1.0));
        (*evaluated).lobes.sheen_roughness = row.parameter;
    }
}
