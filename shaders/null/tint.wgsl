//@ use data/material
// No surface lets a share of light pass alone.
fn tint_through(light: vec3<f32>, evaluated: EvaluatedMaterial, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return light;
}
