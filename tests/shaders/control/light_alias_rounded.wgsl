// Wrong on purpose: the product of uniform and count rounded to f32, which loses the digits that the threshold needs.
fn alias_pick(u: f32, count: u32) -> AliasPick {
    let x = u * f32(count);
    let index = min(u32(x), count - 1u);
    return AliasPick(index, x - f32(index));
}
