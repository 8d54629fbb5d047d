//@ use data/ray
// No medium is between surfaces and lights.
fn transmit_light(
    radiance: vec3<f32>,
    ray: Ray,
    t: f32,
    steps: ptr<function, u32>,
    status: ptr<function, u32>,
) -> vec3<f32> {
    return radiance;
}
