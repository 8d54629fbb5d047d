//@ use bind/materials
// The radiance that a surface emits to the ray.
fn begin_emission(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.emission != NO_EXTENSION && (materials[own.emission].${emission.two_sided} != 0.0 || front);
}

fn take_emission(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    (*evaluated).emission = select((*evaluated).emission, colour, is_row);
}
