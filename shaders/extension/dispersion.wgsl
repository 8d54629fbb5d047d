// KHR_materials_dispersion: the index of blue less that of green.
fn begin_dispersion(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.dispersion != NO_EXTENSION;
}

fn take_dispersion(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.dispersion = row.${dispersion.spread};
    }
}
