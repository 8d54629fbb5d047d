//@ implements transmittance when medium
//@ use choice/media_transmittance
// Light times its transmittance. A walk that takes too many steps cuts the path.
fn transmit_light(
    radiance: vec3<f32>,
    ray: Ray,
    t: f32,
    steps: ptr<function, u32>,
    status: ptr<function, u32>,
) -> vec3<f32> {
    let through = transmittance(ray, t, steps);
    if through == WALK_CUT {
        *status = PATH_CUT;
        return vec3<f32>(0.0);
    }
    return radiance * through;
}

//@ without
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
