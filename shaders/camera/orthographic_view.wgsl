//@ alternative camera_view when projection.orthographic
//@ use camera/pixel
//@ use choice/camera_pose
// A point as seen by an orthographic camera: the direction to the camera is given, and the film's point follows from the point.
fn view_from_camera(point: vec3<f32>, u: vec4<f32>) -> CameraView {
    let from_camera = point - from_lens(vec3<f32>(0.0));
    let distance = dot(from_camera, camera_forward());
    let density = select(0.0, 1.0 / area_of_pixel(), distance > 0.0);
    return CameraView(-camera_forward(), distance, from_corner(in_pixels(from_camera)), u.zw, density);
}

// An area of the plane.
fn area_of_pixel() -> f32 {
    return length(cross(camera_pixel_x(), camera_pixel_y()));
}

// Camera rays do not spread: their density does not depend on the distance.
fn log_density_of_camera(direction: vec3<f32>) -> f32 {
    return -log_of_density(area_of_pixel());
}

fn log_spread_of_camera(distance: f32) -> f32 {
    return 0.0;
}
