// One scatter kernel for all materials: an invocation a slot.
fn slot_of_turn(turn: u32) -> u32 {
    return turn;
}
