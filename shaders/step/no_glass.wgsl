//@ use data/path
// No clear solid is between anything and a light (step/through_glass).
fn note_met_light(path: ptr<function, Path>, radiance: vec3<f32>) {}

fn note_sampling(path: ptr<function, Path>) {}

fn forget_glass(path: ptr<function, Path>) {}
