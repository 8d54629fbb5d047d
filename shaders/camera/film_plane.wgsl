//@ use bind/settings
//@ use choice/camera_pose
// The direction from the middle of the lens through a point of the pixel, not normalised. The pixel's offset from the image's
// middle is exact before the jitter is added.
fn film_direction(column: u32, row: u32, jitter: vec2<f32>) -> vec3<f32> {
    let x = (f32(column) - 0.5 * f32(settings.image_width)) + jitter.x;
    let y = (f32(row) - 0.5 * f32(settings.image_height)) + jitter.y;
    return camera_forward() + (x * camera_pixel_x() + y * camera_pixel_y());
}
