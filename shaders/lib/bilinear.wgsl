// The four texels around a point of an image, and their weights. Texel centres lie at half-integers.
struct Bilinear {
    // The left and the right column; the upper and the lower row.
    columns: vec2<u32>,
    rows: vec2<u32>,
    // The weights of the right column and of the lower row.
    share: vec2<f32>,
}

// Indices of `count` texels, of which those beyond the edges are the ones at the other edge or at the same one.
fn within_edges(indices: vec2<i32>, count: i32, wraps: bool) -> vec2<u32> {
    let other = (indices + vec2<i32>(count)) % vec2<i32>(count);
    return vec2<u32>(select(clamp(indices, vec2<i32>(0), vec2<i32>(count - 1)), other, wraps));
}

// u goes right and `down` goes to the bottom row, both in [0, 1]. `wraps` joins the right edge to the left, and the bottom to the top.
fn bilinear(u: f32, down: f32, width: u32, height: u32, wraps: vec2<bool>) -> Bilinear {
    let x = u * f32(width) - 0.5;
    let y = down * f32(height) - 0.5;
    let left = i32(floor(x));
    let top = i32(floor(y));
    return Bilinear(
        within_edges(vec2<i32>(left, left + 1), i32(width), wraps.x),
        within_edges(vec2<i32>(top, top + 1), i32(height), wraps.y),
        vec2<f32>(x - floor(x), y - floor(y)),
    );
}
