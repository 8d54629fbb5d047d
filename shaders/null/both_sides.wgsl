//@ use data/hit
//@ use data/material
//@ use data/surface
// The sides of no surface have points of their own.
fn points_of_event(evaluated: EvaluatedMaterial, hit: Hit) -> f32 {
    return 1.0;
}

fn choose_side(
    samples_lights: bool,
    evaluated: EvaluatedMaterial,
    point: vec3<f32>,
    hit: Hit,
    surface: Surface,
    facing: vec3<f32>,
    u: f32,
) -> LightSide {
    return LightSide(point, false, false);
}

fn respond_on_side(sampled: LightResponse, side: LightSide, direction: vec3<f32>, shading: vec3<f32>) -> LightResponse {
    return sampled;
}
