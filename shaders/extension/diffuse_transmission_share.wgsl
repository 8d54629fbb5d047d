//@ use data/material
// KHR_materials_diffuse_transmission: the share of scattered light that passes, where it varies. It comes after the colour.
fn begin_diffuse_transmission_share(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.diffuse_transmission_share != NO_EXTENSION;
}

fn take_diffuse_transmission_share(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.through = min(colour.x, 1.0);
    }
}
