//@ use bind/settings
// The radiance of a ray that leaves the scene: one colour.
fn solid_background(direction: vec3<f32>) -> vec3<f32> {
    return settings.background_bottom;
}
