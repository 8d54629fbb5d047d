//@ use data/path
// Every path goes on.
fn survivor(path: ptr<function, Path>, throughput: vec3<f32>) -> vec3<f32> {
    return throughput;
}
