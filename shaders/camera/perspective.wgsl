//@ alternative projection when !projection | projection.orthographic
//@ use camera/pixel
//@ use choice/camera_pose
// The film is a plane at distance 1.

// The direction from the middle of the lens through a point of the film, not normalised.
fn film_direction(at: vec2<f32>) -> vec3<f32> {
    return camera_forward() + (at.x * camera_pixel_x() + at.y * camera_pixel_y());
}

// Where a ray meets the film, in pixels from the left upper corner of the image. `shift` is that of its point of the lens.
fn film_point(direction: vec3<f32>, shift: vec3<f32>) -> vec2<f32> {
    return from_corner(in_pixels(direction / dot(direction, camera_forward()) + shift));
}

// The density with which the ray of a pixel has a unit direction: its point on the film is uniform in the pixel. An area of the film has the solid
// angle cos / D^2 from a distance D, and D is 1 / cos. It is 0 behind the camera.
fn density_of_camera_ray(direction: vec3<f32>, shift: vec3<f32>) -> f32 {
    let cosine = dot(direction, camera_forward());
    let pixel = length(cross(camera_pixel_x(), camera_pixel_y()));
    return select(0.0, 1.0 / (cosine * cosine * cosine * pixel), cosine > 0.0);
}
