//@ use bind/settings
//@ use choice/camera
//@ use choice/camera_pose
// The inverse of a camera ray: where a ray from the lens meets the film.

// The density with which the ray of a pixel has a unit direction: its point on the film is uniform in the pixel. The film is at distance
// 1. An area of it has the solid angle cos / D^2 from a distance D, and D is 1 / cos. It is 0 behind the camera.
fn density_of_camera_ray(direction: vec3<f32>) -> f32 {
    let cosine = dot(direction, camera_forward());
    let pixel = length(cross(camera_pixel_x(), camera_pixel_y()));
    return select(0.0, 1.0 / (cosine * cosine * cosine * pixel), cosine > 0.0);
}

// Where a ray from a point of the lens meets the film, in pixels from the left upper corner of the image.
fn film_point_at(lens: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    let on_film = direction / dot(direction, camera_forward()) + lens_shift(lens);
    let x = dot(on_film, camera_pixel_x()) / dot(camera_pixel_x(), camera_pixel_x());
    let y = dot(on_film, camera_pixel_y()) / dot(camera_pixel_y(), camera_pixel_y());
    return vec2<f32>(x, y) + 0.5 * vec2<f32>(f32(settings.image_width), f32(settings.image_height));
}
