//@ use data/path
// No stage hands shadow rays to another.
fn store_no_light(slot: u32) {
}

fn store_shadow_ray(slot: u32, path: ptr<function, Path>) {
}
