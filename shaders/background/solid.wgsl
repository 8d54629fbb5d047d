//@ use bind/settings
// The radiance of the sky where a ray leaves the scene: one colour.
fn background_radiance(direction: vec3<f32>) -> vec3<f32> {
    return settings.background_bottom;
}
