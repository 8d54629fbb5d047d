//@ use bind/settings
// Limits what one path may bring of light that reaches the camera by two scattering events or more (`--clamp N`): a contribution,
// throughput times radiance, whose largest component is above the limit is scaled down to it, so that its hue stays. What is
// seen directly and what lights the first surface or medium that a path meets is as it is, whether a light was sampled or met.

// Of fewer events light is direct.
const INDIRECT_FROM: u32 = 2u;

fn limited(contribution: vec3<f32>) -> vec3<f32> {
    let most = max(max(contribution.x, contribution.y), contribution.z);
    return select(contribution, contribution * (settings.indirect_limit / most), most > settings.indirect_limit);
}

// A contribution that was met after so many events.
fn limited_indirect(contribution: vec3<f32>, depth: u32) -> vec3<f32> {
    if depth < INDIRECT_FROM {
        return contribution;
    }
    return limited(contribution);
}

// The weight of a ray to a light, sent by the event after so many others. Nothing that it brings is negative, and so the sign is
// free to say that the light is indirect: a path's state has no room for that.
fn weight_of_light(weight: vec3<f32>, depth: u32) -> vec3<f32> {
    return select(weight, -weight, depth + 1u >= INDIRECT_FROM);
}

// A contribution by such a weight.
fn limited_light(contribution: vec3<f32>) -> vec3<f32> {
    if any(contribution < vec3<f32>(0.0)) {
        return limited(-contribution);
    }
    return contribution;
}
