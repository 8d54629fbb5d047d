//@ use light/sample
// The sky is not sampled as a light.
fn sky_light_sample(u: vec3<f32>) -> DirectionSample {
    return NO_DIRECTION_SAMPLE;
}

fn emitted_by_sky(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}
