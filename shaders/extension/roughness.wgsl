//@ use data/material
// A roughness that varies over the surface.
fn begin_roughness(evaluated: ptr<function, EvaluatedMaterial>, own: Extension, front: bool) -> bool {
    return own.roughness != NO_EXTENSION;
}

fn take_roughness(evaluated: ptr<function, EvaluatedMaterial>, row: Material, colour: vec3<f32>, is_row: bool) {
    // Rounding may have put a number above its largest texel.
    (*evaluated).material.parameter = select((*evaluated).material.parameter, min(colour.x, 1.0), is_row);
}
