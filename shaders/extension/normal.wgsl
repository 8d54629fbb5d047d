//@ use data/material
// The texel of a normal map.
fn begin_normal(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.normal != NO_EXTENSION;
}

fn take_normal(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    (*evaluated).normal = select((*evaluated).normal, colour, is_row);
}
