//@ use data/material
// The texel of a coat's normal map.
fn begin_coat_normal(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.coat_normal != NO_EXTENSION;
}

fn take_coat_normal(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    (*evaluated).coat_normal = select((*evaluated).coat_normal, colour, is_row);
}
