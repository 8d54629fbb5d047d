//@ use data/medium
//@ use data/path
// No light is sampled.
fn sample_light_in_medium(path: ptr<function, Path>, medium: Medium, point: vec3<f32>, direction: vec3<f32>) {
}
