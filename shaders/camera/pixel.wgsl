//@ use bind/settings
// A point of a pixel, in pixels from the image's middle: x to the right, y down. The pixel's own offset is exact before the jitter is added.
fn from_middle(column: u32, row: u32, jitter: vec2<f32>) -> vec2<f32> {
    let x = (f32(column) - 0.5 * f32(settings.image_width)) + jitter.x;
    let y = (f32(row) - 0.5 * f32(settings.image_height)) + jitter.y;
    return vec2<f32>(x, y);
}

// The same point in pixels from the left upper corner of the image.
fn from_corner(at: vec2<f32>) -> vec2<f32> {
    return at + 0.5 * vec2<f32>(f32(settings.image_width), f32(settings.image_height));
}
