//@ use data/emitted_ray
//@ use data/ray
// No light is without size.
fn emit_from_delta_light(code: u32, probability: f32, u: f32, v: vec2<f32>) -> EmittedRay {
    return no_emission();
}

fn density_of_delta_emission(code: u32, to_light: Ray) -> f32 {
    return 0.0;
}
