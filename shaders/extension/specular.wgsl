// KHR_materials_specular: the share and the colour of the layer of glTF's material.
fn begin_specular(evaluated: ptr<function, EvaluatedMaterial>, own: Rows, front: bool) -> bool {
    (*evaluated).f0 = vec3<f32>((*evaluated).material.${pbr.f0});
    (*evaluated).f90 = 1.0;
    return own.specular != NO_EXTENSION;
}

fn take_specular(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    let tinted = row.${specular.share} * min((*evaluated).material.${pbr.f0} * colour, vec3<f32>(1.0));
    (*evaluated).f0 = select((*evaluated).f0, tinted, is_row);
    (*evaluated).f90 = select((*evaluated).f90, row.${specular.share}, is_row);
}
