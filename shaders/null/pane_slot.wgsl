//@ use data/path
// A ray passes no pane.
fn store_passed(slot: u32, path: ptr<function, Path>) {
}
