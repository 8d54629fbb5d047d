//@ use data/hit
//@ use data/ray
//@ use data/surface
// No surface with a coat emits.
fn radiance_through_coat(radiance: vec3<f32>, hit: Hit, surface: Surface, ray: Ray) -> vec3<f32> {
    return radiance;
}
