//@ implements delta_lights when delta_light
//@ use bind/delta_lights
//@ use light/delta
//@ use choice/falloff
//@ use light/delta_distance
//@ use choice/moved_delta_light
// Lights without size, by their codes.

fn delta_light_at(index: u32) -> DeltaLight {
    return moved_delta_light(delta_lights[index], index);
}

fn is_delta_light(code: u32) -> bool {
    return primitive_kind(code) == KIND_DELTA_LIGHT;
}

fn direction_to_delta_light(code: u32, from_point: vec3<f32>) -> DirectionSample {
    return delta_light_sample(from_point, delta_light_at(primitive_index(code)));
}

fn intensity_of_delta_light(code: u32, direction: vec3<f32>) -> vec3<f32> {
    return delta_light_intensity(direction, delta_light_at(primitive_index(code)));
}

// The end of a shadow ray to such a light.
fn limit_at_delta_light(code: u32, shadow: Ray) -> Hit {
    let light = delta_light_at(primitive_index(code));
    let distance = delta_light_distance(shadow.origin, shadow.direction, light);
    return hit_at(code, select(VERY_FAR, distance, light.has_position > 0.0));
}

//@ without
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
