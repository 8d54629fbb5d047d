//@ alternative camera when !lens & !projection.orthographic
//@ use camera/pixel
//@ use choice/camera_direction
//@ use choice/camera_pose
//@ use choice/projection
// All rays start at one point.
fn camera_ray(column: u32, row: u32, u: vec4<f32>) -> Ray {
    return Ray(from_lens(vec3<f32>(0.0)), camera_direction(film_direction(from_middle(column, row, u.xy)), vec3<f32>(0.0)));
}

fn lens_point(u: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}

// How far a direction through a point of the film moves if its ray starts at this point of the lens.
fn lens_shift(lens: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}
