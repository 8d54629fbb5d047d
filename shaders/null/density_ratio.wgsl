//@ use data/hit
//@ use data/material
//@ use data/path
//@ use data/surface
// No light paths are traced.
fn follow_ratio(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
) {
}

fn follow_ratio_in_medium(path: ptr<function, Path>, distance: f32) {
}

fn weigh_beside_light_paths(path: ptr<function, Path>, hit: Hit, surface: Surface, weight: f32) -> f32 {
    return weight;
}

fn weigh_sample_beside_light_paths(path: ptr<function, Path>, hit: Hit) -> f32 {
    return 1.0;
}
