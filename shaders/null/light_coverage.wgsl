//@ use data/hit
//@ use data/ray
// Lights cover all that is behind them.
fn cover_light_at_hit(radiance: vec3<f32>, ray: Ray, hit: Hit) -> vec3<f32> {
    return radiance;
}
