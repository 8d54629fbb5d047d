//@ use bind/settings
//@ use choice/axes
// The radiance of a ray that leaves the scene: a blend of two colours by the height of its unit direction.
fn gradient_background(direction: vec3<f32>) -> vec3<f32> {
    return mix(settings.background_bottom, settings.background_top, 0.5 * (to_world(direction).y + 1.0));
}
