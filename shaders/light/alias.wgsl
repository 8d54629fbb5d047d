struct AliasPick { index: u32, rest: f32 }
fn alias_pick(u: f32, count: u32) -> AliasPick {
    let place = u * f32(count);
    let index = min(u32(place), count - 1u);
    return AliasPick(index, place - f32(index));
}
