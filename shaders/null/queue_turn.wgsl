// An invocation has the slot of its number.
fn queued_slot(turn: u32) -> u32 {
    return turn;
}
