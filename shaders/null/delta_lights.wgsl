//@ use data/hit
//@ use data/light
//@ use data/ray
//@ use light/sample
// All lights have a size.
fn is_delta_light(code: u32) -> bool {
    return false;
}

fn direction_to_delta_light(code: u32, from_point: vec3<f32>) -> DirectionSample {
    return NO_DIRECTION_SAMPLE;
}

fn intensity_of_delta_light(code: u32, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}

fn limit_at_delta_light(code: u32, shadow: Ray) -> Hit {
    return hit_at(code, 0.0);
}
