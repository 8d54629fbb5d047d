//@ use bind/settings
//@ use choice/camera_pose
// A point of a pixel, in pixels from the image's middle: x to the right, y down. The pixel's own offset is exact before the jitter is added.
fn from_middle(column: u32, row: u32, jitter: vec2<f32>) -> vec2<f32> {
    let x = (f32(column) - 0.5 * f32(settings.image_width)) + jitter.x;
    let y = (f32(row) - 0.5 * f32(settings.image_height)) + jitter.y;
    return vec2<f32>(x, y);
}

// A point given from the image's middle, in pixels from its left upper corner.
fn from_corner(at: vec2<f32>) -> vec2<f32> {
    return at + 0.5 * vec2<f32>(f32(settings.image_width), f32(settings.image_height));
}

// A vector in lengths of a pixel: its components along x and y of the image.
fn in_pixels(v: vec3<f32>) -> vec2<f32> {
    let x = dot(v, camera_pixel_x()) / dot(camera_pixel_x(), camera_pixel_x());
    let y = dot(v, camera_pixel_y()) / dot(camera_pixel_y(), camera_pixel_y());
    return vec2<f32>(x, y);
}
