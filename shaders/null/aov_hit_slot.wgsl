//@ use data/path
// The film has no channel of the surface that camera rays hit.
fn record_hit_of_slot(slot: u32, path: ptr<function, Path>) {
}
