//@ implements pane_slot when pane
// Stores the throughput, which has taken the colours of panes on the ray.
fn store_passed(slot: u32, path: ptr<function, Path>) {
    store_throughput(slot, path);
}

//@ without
// A ray passes no pane.
fn store_passed(slot: u32, path: ptr<function, Path>) {
}
