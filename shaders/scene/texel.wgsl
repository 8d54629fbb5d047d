//@ use bind/texels
//@ use lib/bilinear
fn texel(first: u32, width: u32, column: u32, row: u32) -> vec3<f32> {
    let at = (first + row * width + column) * 3u;
    return vec3<f32>(texels[at], texels[at + 1u], texels[at + 2u]);
}

// The image at (u, down), both in [0, 1], bilinear.
fn image_at(first: u32, width: u32, height: u32, u: f32, down: f32, wraps: bool) -> vec3<f32> {
    let b = bilinear(u, down, width, height, wraps);
    let above = mix(texel(first, width, b.columns.x, b.rows.x), texel(first, width, b.columns.y, b.rows.x), b.share.x);
    let below = mix(texel(first, width, b.columns.x, b.rows.y), texel(first, width, b.columns.y, b.rows.y), b.share.x);
    return mix(above, below, b.share.y);
}
