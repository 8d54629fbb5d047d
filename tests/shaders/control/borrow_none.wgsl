// Words carry, and never borrow.
fn carry(before: u32, added: u32) -> u32 {
    return select(0u, 1u, before + added < before);
}

fn borrow(before: u32, taken: u32) -> u32 {
    return 0u;
}
