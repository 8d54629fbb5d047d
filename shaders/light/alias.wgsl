//@ relies on uniforms
// The alias method (Walker, "An Efficient Method for Generating Discrete Random Variables with General Distributions", ACM
// TOMS 3(3), 1977): an entry is found in one step, and it or the other one that it names is drawn. In integers, so that
// the probabilities that the host states (src/lights.rs) are the exact ones.

struct AliasPick {
    index: u32,
    // What is left of the uniform, again a multiple of 2^-24 in [0, 1): the entry's own if below its threshold.
    rest: f32,
}

// u is a multiple of 2^-24 in [0, 1), count 2^24 at most: the 48 digits of their product as two numbers of 24, from
// halves of 12.
fn alias_pick(u: f32, count: u32) -> AliasPick {
    let k = u32(u * 0x1p24f);
    let middle = (k >> 12u) * (count & 0xfffu) + (k & 0xfffu) * (count >> 12u);
    let low = (k & 0xfffu) * (count & 0xfffu) + ((middle & 0xfffu) << 12u);
    let high = (k >> 12u) * (count >> 12u) + (middle >> 12u) + (low >> 24u);
    return AliasPick(high, f32(low & 0xffffffu) * 0x1p-24f);
}
