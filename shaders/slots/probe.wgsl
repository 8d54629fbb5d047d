//@ implements probe_slot when probed
// What a path with a shadow ray keeps for the count of light in narrow lobes (step/narrow_lobe).
fn load_counted_path(slot: u32, path: ptr<function, Path>) {
    load_sample_of_path(slot, path);
    load_throughput(slot, path);
}

//@ without
// No light is counted.
fn load_counted_path(slot: u32, path: ptr<function, Path>) {
}
