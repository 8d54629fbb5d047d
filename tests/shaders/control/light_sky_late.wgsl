//@ use bind/sky
// The first sum that is no less, instead of the first that is greater: each entry gives a part to the one before it.
struct SkyDraw {
    index: u32,
    rest: f32,
}

fn draw_sky(first: u32, count: u32, u: f32) -> SkyDraw {
    let k = u32(u * 0x1p24f);
    var index = 0u;
    while index + 1u < count && sky[first + index + 1u] < k {
        index += 1u;
    }
    let start = sky[first + index];
    return SkyDraw(index, (f32(k - start) + 0.5) / f32(sky[first + index + 1u] - start));
}
