//@ use bind/settings
// The radiance of the sky where a ray leaves the scene: one colour.
fn solid_background(direction: vec3<f32>) -> vec3<f32> {
    return settings.background_bottom;
}
