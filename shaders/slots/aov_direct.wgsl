//@ implements aov_direct_slot when aov_until_end
// The direct radiance, and that of groups of lights, of a path whose shadow ray is traced, and its depth.
fn load_direct_of_slot(slot: u32, path: ptr<function, Path>) {
    load_throughput(slot, path);
    load_direct(slot, path);
}

//@ without
// The film has no such channel.
fn load_direct_of_slot(slot: u32, path: ptr<function, Path>) {
}
