//@ use data/path
// A sample's radiance by light sampling, and by surfaces that emit and scatter, beside that at the end of its path.
fn with_sampled_light(path: ptr<function, Path>, radiance: vec3<f32>) -> vec3<f32> {
    return radiance + (*path).radiance;
}
