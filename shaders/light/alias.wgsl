//@ relies on uniforms
// The alias method (Walker, "An Efficient Method for Generating Discrete Random Variables with General Distributions", ACM TOMS
// 3(3), 1977): one lookup finds an entry, and either the entry or its alias is drawn. It uses integers, so that the
// probabilities that the host states (src/light_distribution.rs) are exact.

// An entry that was drawn.
struct AliasChoice {
    index: u32,
    density: f32,
}

struct AliasPick {
    index: u32,
    // The rest of the uniform number, again a multiple of 2^-24 in [0, 1). Below the entry's threshold it draws the entry itself.
    rest: f32,
}

// u is a multiple of 2^-24 in [0, 1), and count is at most 2^24. Their product of 48 bits is computed as two numbers of
// 24 bits, from halves of 12 bits.
fn alias_pick(u: f32, count: u32) -> AliasPick {
    let k = u32(u * 0x1p24f);
    let middle = (k >> 12u) * (count & 0xfffu) + (k & 0xfffu) * (count >> 12u);
    let low = (k & 0xfffu) * (count & 0xfffu) + ((middle & 0xfffu) << 12u);
    let high = (k >> 12u) * (count >> 12u) + (middle >> 12u) + (low >> 24u);
    return AliasPick(high, f32(low & 0xffffffu) * 0x1p-24f);
}

// The entry that is drawn for a pick: its own or its alias.
fn alias_choice(pick: AliasPick, entry: AliasEntry) -> AliasChoice {
    let own = pick.rest < entry.threshold;
    return AliasChoice(select(entry.alias_index, pick.index, own), select(entry.alias_density, entry.density, own));
}
