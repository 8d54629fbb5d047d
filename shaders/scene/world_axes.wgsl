//@ alternative axes when !camera_axes
// Render space has the axes of the background.
fn to_world(direction: vec3<f32>) -> vec3<f32> {
    return direction;
}

fn from_world(direction: vec3<f32>) -> vec3<f32> {
    return direction;
}
