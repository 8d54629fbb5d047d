//@ use generated/slots
// What the count of light in narrow lobes needs of a path whose shadow ray is traced.
fn load_counted_path(slot: u32, path: ptr<function, Path>) {
    load_sample_of_path(slot, path);
    load_throughput(slot, path);
}
