// The share of the layer of glTF's material, where it varies over the surface. It comes after the layer's colour.
fn begin_specular_share(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.specular_share != NO_EXTENSION;
}

fn take_specular_share(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let share = select(1.0, min(colour.x, 1.0), is_row);
    (*evaluated).f0 *= share;
    (*evaluated).f90 *= share;
}
