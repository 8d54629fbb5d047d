//@ implements evaluation when !evaluated
//@ use bind/materials
//@ use choice/colour
// A material without extensions: its row of the table, and its colour, which may be a texture.

// The most loop iterations that shading takes: seven octaves of noise over eight corners.
const ITERATIONS_OF_SHADING: u32 = 64u;

fn evaluate_material(hit: Hit, surface: Surface, front: bool) -> EvaluatedMaterial {
    var evaluated: EvaluatedMaterial;
    evaluated.material = materials[surface.material];
    evaluated.colour = surface_colour(evaluated.material, hit, surface);
    return evaluated;
}
