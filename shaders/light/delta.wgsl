//@ use light/sample
// Lights without size. The irradiance of a point or spot light is its intensity over the squared distance. For a directional light, the
// same formula has a vector to the light of length 1 from every point.

// Nearer points get no light, because the irradiance there is beyond the range of f32.
const LEAST_DISTANCE_SQUARED: f32 = 0x1p-80f;

fn to_delta_light(from_point: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    return light.position - light.has_position * from_point;
}

// The direction to the light. Instead of a pdf it has the squared distance: the estimator divides by either.
fn delta_light_sample(from_point: vec3<f32>, light: DeltaLight) -> DirectionSample {
    let to_light = to_delta_light(from_point, light);
    let distance2 = dot(to_light, to_light);
    if !(distance2 > LEAST_DISTANCE_SQUARED) {
        return NO_DIRECTION_SAMPLE;
    }
    return DirectionSample(to_light * inverseSqrt(distance2), distance2);
}
