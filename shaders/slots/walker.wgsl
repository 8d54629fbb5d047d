//@ implements walker_slot when alpha | varying | pane | motion | mix & queues
// The numbers by which a walk decides at random whether a transparent surface stops its ray and what passes a medium, and which queue its hit goes to.
fn load_walker(slot: u32, path: ptr<function, Path>) {
    load_throughput(slot, path);
    load_sample_of_path(slot, path);
}

//@ without
// No surface is transparent.
fn load_walker(slot: u32, path: ptr<function, Path>) {
}
