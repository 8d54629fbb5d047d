//@ alternative camera_view when !projection.orthographic
//@ use choice/camera
//@ use choice/camera_pose
//@ use choice/projection
// A point as seen from a point of the lens.
fn view_from_camera(point: vec3<f32>, u: vec4<f32>) -> CameraView {
    let lens = lens_point(u.xy);
    let to_lens = from_lens(lens) - point;
    let distance = length(to_lens);
    let direction = to_lens / distance;
    let shift = lens_shift(lens);
    let density = density_of_camera_ray(-direction, shift);
    let is_seen = density > 0.0 && distance > 0.0;
    let on_film = film_point(-direction, shift);
    return CameraView(direction, distance, on_film, u.zw, select(0.0, density / (distance * distance), is_seen));
}

// The logarithm (base 2) of the density per solid angle with which the ray of a pixel has a direction.
fn log_density_of_camera(direction: vec3<f32>) -> f32 {
    return log_of_density(density_of_camera_ray(direction, vec3<f32>(0.0)));
}

// The logarithm of the area per solid angle at a distance.
fn log_spread_of_camera(distance: f32) -> f32 {
    return 2.0 * log_of_density(distance);
}
