//@ implements aov_hit_slot when aov_hit
//@ use aov/hit
// Records the hit of a slot's camera ray.
fn record_hit_of_slot(slot: u32, path: ptr<function, Path>) {
    load_throughput(slot, path);
    load_sample_of_path(slot, path);
    load_aov_hit(slot, path);
    record_hit(path);
    store_aov_hit(slot, path);
}

//@ without
// The film has no channel of the surface that camera rays hit.
fn record_hit_of_slot(slot: u32, path: ptr<function, Path>) {
}
