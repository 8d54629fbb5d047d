//@ use data/material
//@ use data/path
// The film has no channel of the surface that the camera sees.
fn record_surface(path: ptr<function, Path>, evaluated: EvaluatedMaterial, bsdf: Scatter, normal: vec3<f32>) {
}

fn record_medium(path: ptr<function, Path>, albedo: vec3<f32>) {
}
