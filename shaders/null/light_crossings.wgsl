//@ use data/hit
//@ use data/light
//@ use data/ray
// A shadow ray ends where it meets its light first.
fn light_crossing(light: Light, ray: Ray, u: f32) -> LightCrossing {
    return LightCrossing(light.instance, 1.0);
}

fn share_of_crossing(index: u32, ray: Ray) -> f32 {
    return 1.0;
}

fn limit_at_crossing(near: Hit, instance: u32, pose: Pose, shadow: Ray) -> Hit {
    return near;
}
