//@ implements camera_pose when !moving_camera
//@ use bind/settings
//@ use choice/lens_place
// A camera that rests.

fn begin_camera() {
}

// A point given relative to the middle of the lens.
fn from_lens(point: vec3<f32>) -> vec3<f32> {
    return placed(point);
}

fn camera_forward() -> vec3<f32> {
    return settings.forward;
}

fn camera_pixel_x() -> vec3<f32> {
    return settings.pixel_x;
}

fn camera_pixel_y() -> vec3<f32> {
    return settings.pixel_y;
}

fn camera_lens_x() -> vec3<f32> {
    return settings.lens_x;
}

fn camera_lens_y() -> vec3<f32> {
    return settings.lens_y;
}

fn camera_inverse_focus() -> f32 {
    return settings.inverse_focus;
}
