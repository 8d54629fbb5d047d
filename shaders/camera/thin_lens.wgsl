//@ alternative camera when lens & !projection.orthographic
//@ use camera/pixel
//@ use choice/camera_direction
//@ use choice/camera_pose
//@ use choice/projection
// A point on the lens relative to its middle, uniform by area.
fn lens_point(u: vec2<f32>) -> vec3<f32> {
    let lens = sample_disk(u);
    return lens.x * camera_lens_x() + lens.y * camera_lens_y();
}

// A ray starts at a point of the lens. It goes to the point at the focus distance through which the pinhole's ray would go
// (Cook, Porter, Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984, section 4.3).
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    let origin = lens_point(u.zw);
    return Ray(from_lens(origin), camera_direction(film_direction(from_middle(column, row, u.xy)), lens_shift(origin)));
}

// How far a direction through a point of the film moves if its ray starts at this point of the lens.
fn lens_shift(lens: vec3<f32>) -> vec3<f32> {
    return camera_inverse_focus() * lens;
}
