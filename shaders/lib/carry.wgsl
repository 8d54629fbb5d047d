// Whether a word that was `before` has wrapped when `added` was added to it: 1 is then to be added to the next word of the sum.
fn carry(before: u32, added: u32) -> u32 {
    return select(0u, 1u, before + added < before);
}

// Whether a word that was `before` has wrapped when `taken` was subtracted from it: 1 is then to be subtracted from the next word.
fn borrow(before: u32, taken: u32) -> u32 {
    return select(0u, 1u, before < taken);
}
