//@ use data/path
// Without Russian roulette, every path continues.
fn russian_roulette(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    return throughput;
}
