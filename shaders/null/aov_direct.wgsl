//@ use data/path
// The film has no channel of direct radiance.
fn record_direct(path: ptr<function, Path>, contribution: vec3<f32>, events: u32) {
}

fn add_direct(path: ptr<function, Path>) {
}
