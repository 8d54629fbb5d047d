//@ implements pane_evaluation when pane & textured_pane
//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use choice/evaluation
// Some pane has a texture.
fn evaluate_pane(hit: Hit, surface: Surface, front: bool) -> EvaluatedMaterial {
    return evaluate_material(hit, surface, front);
}
