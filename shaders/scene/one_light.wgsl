//@ alternative light_choice when !several_lights
//@ use scene/at_run_time
// With a single light, there is nothing to choose.

fn choose_light(from_point: vec3<f32>, u: vec2<f32>) -> LightChoice {
    return LightChoice(at_run_time(0u), 1.0);
}

// The probability that choose_light chooses a given light.
fn light_probability(index: u32, from_point: vec3<f32>) -> f32 {
    return 1.0;
}
