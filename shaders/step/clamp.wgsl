//@ alternative clamp when clamp & event
//@ use bind/settings
// `--clamp N`: limits each contribution (throughput times radiance) of light that reaches the camera by two scattering events or
// more. If its largest component is above the limit, the contribution is scaled down to it, which keeps its hue. Light seen
// directly, and light on the first surface or medium of a path, is not limited, whether light sampling or BSDF sampling found it.

fn limited(contribution: vec3<f32>) -> vec3<f32> {
    let most = max(max(contribution.x, contribution.y), contribution.z);
    return select(contribution, contribution * (settings.indirect_limit / most), most > settings.indirect_limit);
}

// A contribution found after `depth` events, limited if it is indirect.
fn limited_indirect(contribution: vec3<f32>, depth: u32) -> vec3<f32> {
    if depth < INDIRECT_FROM {
        return contribution;
    }
    return limited(contribution);
}

// The weight of a shadow ray from an event at this depth. No contribution is negative, so a negative weight marks indirect
// light; the state of a path has no room for a flag.
fn weight_of_light(weight: vec3<f32>, depth: u32) -> vec3<f32> {
    return select(weight, -weight, depth + 1u >= INDIRECT_FROM);
}

// The contribution of a shadow ray with such a weight, limited if it is indirect.
fn limited_light(contribution: vec3<f32>) -> vec3<f32> {
    if any(contribution < vec3<f32>(0.0)) {
        return limited(-contribution);
    }
    return contribution;
}

//@ without
// Without a clamp, no contribution is limited.
fn limited_indirect(contribution: vec3<f32>, depth: u32) -> vec3<f32> {
    return contribution;
}

fn weight_of_light(weight: vec3<f32>, depth: u32) -> vec3<f32> {
    return weight;
}

fn limited_light(contribution: vec3<f32>) -> vec3<f32> {
    return contribution;
}
