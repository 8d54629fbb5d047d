//@ use data/path
// All radiance of a sample comes at the end of its path.
fn with_sampled_light(path: ptr<function, Path>, radiance: vec3<f32>) -> vec3<f32> {
    return radiance;
}
