//@ use data/path
// The film has no channel of direct radiance.
fn load_direct_of_slot(slot: u32, path: ptr<function, Path>) {
}
