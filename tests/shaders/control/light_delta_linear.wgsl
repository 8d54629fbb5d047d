//@ use light/sample
// As light/delta, without the squares of the distance and of the falloff.

// Nearer points get no light, because the irradiance there is beyond the range of f32.
const LEAST_DISTANCE_SQUARED: f32 = 0x1p-80f;

fn to_delta_light(from_point: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    return light.position - light.has_position * from_point;
}

// The direction to the light. In magnitude of a pdf the squared distance: the estimator divides by either.
fn delta_light_sample(from_point: vec3<f32>, light: DeltaLight) -> DirectionSample {
    let way = to_delta_light(from_point, light);
    let distance2 = dot(way, way);
    if !(distance2 > LEAST_DISTANCE_SQUARED) {
        return NO_DIRECTION_SAMPLE;
    }
    return DirectionSample(way * inverseSqrt(distance2), sqrt(distance2));
}

// The light's intensity against a direction to it: that of a spot falls with the angle from its axis as in glTF's extension
// KHR_lights_punctual. 1 - cos is half the square of the difference of two unit vectors, which keeps its digits in narrow beams.
fn delta_light_intensity(direction: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    let apart = direction + light.axis;
    let share = clamp((light.height - 0.5 * dot(apart, apart)) * light.slope, 0.0, 1.0);
    return light.colour * share;
}

// The length of a shadow ray. It ends before the light by more than the rounding of a surface that the light lies on, but by half
// the way at most.
fn delta_light_distance(origin: vec3<f32>, direction: vec3<f32>, light: DeltaLight) -> f32 {
    let distance = dot(to_delta_light(origin, light), direction);
    let magnitude = abs(light.position);
    let rounding = 0x1p-20f * (max(max(magnitude.x, magnitude.y), magnitude.z) + distance);
    return max(distance - rounding, 0.5 * distance);
}
