//@ use data/material
// KHR_materials_iridescence: the share of a thin film, its index of refraction and its thickness in nm.
fn begin_iridescence(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.iridescence != NO_EXTENSION;
}

fn take_iridescence(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    if is_row {
        (*evaluated).lobes.film = min(colour.x, 1.0);
        (*evaluated).lobes.film_ior = row.parameter;
        (*evaluated).lobes.film_thickness = row.contrast_outside;
    }
}
