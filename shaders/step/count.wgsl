//@ use bind/counters
// Adds to a counter of 64 bits.
fn count(which: u32, added: u32) {
    let before = atomicAdd(&counters.counts[which][0], added);
    if carry(before, added) != 0u {
        atomicAdd(&counters.counts[which][1], 1u);
    }
}
