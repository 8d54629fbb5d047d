// Wrong on purpose: without the squares of the distance and of the falloff.
fn delta_light_sample(from_point: vec3<f32>, light: DeltaLight) -> DirectionSample {
    let to_light = to_delta_light(from_point, light);
    let distance2 = dot(to_light, to_light);
    if !(distance2 > LEAST_DISTANCE_SQUARED) {
        return NO_DIRECTION_SAMPLE;
    }
    return DirectionSample(to_light * inverseSqrt(distance2), sqrt(distance2));
}

fn delta_light_intensity(direction: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    let apart = direction + light.axis;
    return light.colour * clamp((light.height - 0.5 * dot(apart, apart)) * light.slope, 0.0, 1.0);
}
