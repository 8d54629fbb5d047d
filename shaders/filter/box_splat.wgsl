//@ implements splat_filter when filter.box
// With a box filter only the pixel itself covers a point.
fn choose_pixel(at: vec2<f32>, u: vec2<f32>) -> TargetPixel {
    return TargetPixel(i32(floor(at.x)), i32(floor(at.y)), 1.0);
}
