// The pixel that a splat goes to. It may be outside the image.
struct TargetPixel {
    column: i32,
    row: i32,
    // The sign of the filter times the sum of its absolute values over all pixels that cover the point.
    weight: f32,
}
