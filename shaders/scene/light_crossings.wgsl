//@ implements light_crossings when crossed_light
//@ use bind/lights
//@ use choice/crossings
//@ use choice/pose
// Convex bodies with an alpha that emit on both sides. A ray from outside enters such a body and leaves it, and either side may be where it ends.
// A sampled direction chooses one of them, with probability 1/2.

fn meets_both_sides(code: u32, ray: Ray) -> bool {
    let inside = interval_of_body(code, pose_at(code, NO_INSTANCE), ray);
    return inside.x > 0.0 && inside.x < inside.y;
}

// The side at which a shadow ray to a light ends. The lowest bit of the uniform number `u`, which is a multiple of 2^-24, chooses it.
fn light_crossing(light: Light, ray: Ray, u: f32) -> LightCrossing {
    if light.part != CROSSED || !meets_both_sides(light.code, ray) {
        return LightCrossing(light.instance, 1.0);
    }
    return LightCrossing(select(light.instance, FAR_SIDE, (u32(u * 0x1p24f) & 1u) != 0u), 0.5);
}

// The probability of that choice, for the light of this index.
fn share_of_crossing(index: u32, ray: Ray) -> f32 {
    if index >= NOT_SAMPLED {
        return 1.0;
    }
    return light_crossing(lights[index], ray, 0.0).share;
}

// The end of a shadow ray, given that on the near side of its light.
fn limit_at_crossing(near: Hit, instance: u32, pose: Pose, shadow: Ray) -> Hit {
    var limit = near;
    if instance == FAR_SIDE {
        limit.t = interval_of_body(near.code, pose, shadow).y;
        limit.instance = FAR_SIDE;
    }
    return limit;
}

//@ without
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
