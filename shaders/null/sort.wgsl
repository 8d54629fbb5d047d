//@ use data/hit
// Slots are not sorted here.
fn sort_slot(slot: u32, hit: Hit) {
}
