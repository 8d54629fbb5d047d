//@ use bind/lights
//@ use light/alias
// Lights chosen by their power alone: all points have the same chances.

fn choose_light(from_point: vec3<f32>, u: vec2<f32>) -> LightChoice {
    let pick = alias_pick(u.x, ${lights}u);
    let light = lights[pick.index];
    let index = alias_drawn(pick, light.threshold, light.other);
    return LightChoice(index, lights[index].probability);
}

// The probability that a light is chosen.
fn light_probability(index: u32, from_point: vec3<f32>) -> f32 {
    return lights[index].probability;
}
