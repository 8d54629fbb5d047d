//@ implements pane_evaluation when !(pane & textured_pane)
//@ use bind/materials
// No pane has a texture.
fn evaluate_pane(hit: Hit, surface: Surface, front: bool) -> EvaluatedMaterial {
    var evaluated: EvaluatedMaterial;
    evaluated.material = materials[surface.material];
    evaluated.colour = evaluated.material.colour;
    return evaluated;
}
