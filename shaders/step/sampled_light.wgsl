//@ implements sampled_light when sampled_light
// Returns the radiance at the end of a path plus that of light sampling, and of surfaces that emit and scatter, on its way.
fn with_sampled_light(path: ptr<function, Path>, radiance: vec3<f32>) -> vec3<f32> {
    return radiance + (*path).radiance;
}

//@ without
// All radiance of a sample comes at the end of its path.
fn with_sampled_light(path: ptr<function, Path>, radiance: vec3<f32>) -> vec3<f32> {
    return radiance;
}
