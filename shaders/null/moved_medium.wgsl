//@ use data/medium
// The textures of media rest.
fn offset_at_rest(medium: Medium, point: vec3<f32>) -> vec3<f32> {
    return point - medium.center;
}
