// An invocation has the slot of its number.
fn queued_slot(index: u32) -> u32 {
    return index;
}
