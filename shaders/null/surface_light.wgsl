//@ use data/hit
//@ use data/material
//@ use data/path
//@ use data/surface
// No light is sampled.
fn sample_light_at_surface(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
    u: f32,
) {
}
