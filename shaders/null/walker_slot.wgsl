//@ use data/path
// No surface is transparent.
fn load_walker(slot: u32, path: ptr<function, Path>) {
}
