// One scatter kernel for all materials: nothing to sort.
fn sort_slot(slot: u32, code: u32, instance: u32) {
}
