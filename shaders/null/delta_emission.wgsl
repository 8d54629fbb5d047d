//@ use data/emitted_ray
// No light is without size.
fn emit_from_delta_light(code: u32, probability: f32, u: f32, v: vec2<f32>) -> EmittedRay {
    return no_emission();
}
