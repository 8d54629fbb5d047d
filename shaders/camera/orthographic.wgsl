//@ alternative camera when projection.orthographic
//@ use camera/pixel
//@ use choice/camera_pose
// All rays are parallel to the camera's axis. They start on the plane across it.
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    let at = from_middle(column, row, u.xy);
    return Ray(from_lens(at.x * camera_pixel_x() + at.y * camera_pixel_y()), camera_forward());
}
