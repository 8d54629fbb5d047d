//@ use data/material
// A metallic share that varies over the surface.
fn begin_metallic(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.metallic != NO_EXTENSION;
}

fn take_metallic(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    (*evaluated).material.contrast_inside = select((*evaluated).material.contrast_inside, min(colour.x, 1.0), is_row);
}
