//@ alternative axes when camera_axes
//@ use bind/settings
// Render space has not the axes of the background, which are the rows of a rotation: it has the camera's, or the sky is turned.
fn to_world(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(settings.world_x, direction), dot(settings.world_y, direction), dot(settings.world_z, direction));
}

fn from_world(direction: vec3<f32>) -> vec3<f32> {
    return direction.x * settings.world_x + (direction.y * settings.world_y + direction.z * settings.world_z);
}
