//@ implements pane_evaluation when pane & textured_pane
//@ use choice/evaluation
// Some pane has a texture.
fn evaluate_pane(hit: Hit, surface: Surface, front: bool) -> EvaluatedMaterial {
    return evaluate_material(hit, surface, front);
}
