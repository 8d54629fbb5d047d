//@ use data/material
// KHR_materials_specular: the share and the colour of the layer of glTF's material.
fn begin_specular(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    (*evaluated).f0 = vec3<f32>((*evaluated).material.contrast_outside);
    (*evaluated).f90 = 1.0;
    return own.specular != NO_EXTENSION;
}

fn take_specular(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let tinted = row.parameter * min((*evaluated).material.contrast_outside * colour, vec3<f32>(1.0));
    (*evaluated).f0 = select((*evaluated).f0, tinted, is_row);
    (*evaluated).f90 = select((*evaluated).f90, row.parameter, is_row);
}
