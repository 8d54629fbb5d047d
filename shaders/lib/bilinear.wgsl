// The four texels around a point of an image, and their weights. Texel centres lie at half-integers.
struct Bilinear {
    // The left and the right column; the upper and the lower row.
    columns: vec2<u32>,
    rows: vec2<u32>,
    // The weights of the right column and of the lower row.
    share: vec2<f32>,
}

// u goes right and `down` goes to the bottom row, both in [0, 1]. `wraps` joins the right edge to the left, and the bottom to the top.
fn bilinear(u: f32, down: f32, width: u32, height: u32, wraps: vec2<bool>) -> Bilinear {
    let w = i32(width);
    let h = i32(height);
    let x = u * f32(width) - 0.5;
    let y = down * f32(height) - 0.5;
    let left = i32(floor(x));
    let top = i32(floor(y));
    let columns = vec2<i32>(left, left + 1);
    let rows = vec2<i32>(top, top + 1);
    return Bilinear(
        vec2<u32>(select(clamp(columns, vec2<i32>(0), vec2<i32>(w - 1)), (columns + vec2<i32>(w)) % vec2<i32>(w), wraps.x)),
        vec2<u32>(select(clamp(rows, vec2<i32>(0), vec2<i32>(h - 1)), (rows + vec2<i32>(h)) % vec2<i32>(h), wraps.y)),
        vec2<f32>(x - floor(x), y - floor(y)),
    );
}
