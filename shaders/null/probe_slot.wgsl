//@ use data/path
// No light is counted.
fn load_counted_path(slot: u32, path: ptr<function, Path>) {
}
