// Wrong on purpose: texel centres at integers, and no wrapping.
struct Bilinear {
    columns: vec2<u32>,
    rows: vec2<u32>,
    share: vec2<f32>,
}

fn bilinear(u: f32, down: f32, width: u32, height: u32, wraps: bool) -> Bilinear {
    let x = u * f32(width - 1u);
    let y = down * f32(height - 1u);
    let left = u32(floor(x));
    let top = u32(floor(y));
    return Bilinear(
        vec2<u32>(left, min(left + 1u, width - 1u)),
        vec2<u32>(top, min(top + 1u, height - 1u)),
        vec2<f32>(x - floor(x), y - floor(y)),
    );
}
