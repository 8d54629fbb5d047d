// KHR_materials_iridescence: the thickness of the film where it varies, from the row's first number to the second. It comes after the film.
fn begin_iridescence_thickness(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    return own.iridescence_thickness != NO_EXTENSION;
}

fn take_iridescence_thickness(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        let share = min(colour.x, 1.0);
        (*evaluated).lobes.film_thickness = (1.0 - share) * row.${iridescence_thickness.least} + share * row.${iridescence_thickness.most};
    }
}
