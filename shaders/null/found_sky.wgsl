//@ use data/path
// The sky is not sampled as a light.
fn weigh_sky(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    return throughput;
}

fn record_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
}
