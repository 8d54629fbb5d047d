//@ use data/material
// KHR_materials_diffuse_transmission: the share of scattered light that passes, and its colour.
fn begin_diffuse_transmission(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.diffuse_transmission != NO_EXTENSION;
}

fn take_diffuse_transmission(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.colour_through = min(colour, vec3<f32>(1.0));
        (*evaluated).lobes.through = row.parameter;
    }
}
