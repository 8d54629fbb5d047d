//@ implements evaluation when evaluated
//@ use bind/extensions
//@ use bind/materials
//@ use choice/colour
//@ use choice/vertex_colours
//@ use choice/vertex_emission
//@ each own_extension
//@ use extension/${name}
//@ end
// A material with further rows of the table of materials, each with a colour or a texture. begin_NAME and take_NAME of most stand in
// generated/lobes.

// The most loop iterations that shading takes: seven octaves of noise over eight corners, for each texture of a material and one of a light.
const ITERATIONS_OF_SHADING: u32 = ${iterations_of_shading}u;

const OWN_COLOUR: u32 = 1u;
//@ each extension
const BIT_OF_${name}: u32 = 2u << ${rank}u;
//@ end

// One loop evaluates all rows: compilers inline each call of a function, and the code of all textures is long. `front`: whether the
// ray hits the front of the surface.
fn evaluate_material(hit: Hit, surface: Surface, front: bool) -> EvaluatedMaterial {
    let rows = extensions[surface.material];
    var evaluated: EvaluatedMaterial;
    evaluated.material = materials[surface.material];
    var left = OWN_COLOUR;
    //@ each extension
    left |= select(0u, BIT_OF_${name}, begin_${name}(&evaluated, rows, front));
    //@ end
    while left != 0u {
        let part = left & (~left + 1u);
        left ^= part;
        var index = surface.material;
        //@ each extension
        index = select(index, rows.${name}, part == BIT_OF_${name});
        //@ end
        let row = materials[index];
        var framed = surface;
        framed.frame += select(row.kind, 0u, part == OWN_COLOUR);
        let colour = surface_colour(row, hit, framed);
        evaluated.colour = select(evaluated.colour, colour, part == OWN_COLOUR);
        //@ each extension
        take_${name}(&evaluated, row, colour, part == BIT_OF_${name});
        //@ end
    }
    evaluated.colour = times_vertex_colour(evaluated.colour, hit, surface);
    evaluated.emission = times_vertex_emission(evaluated.emission, hit, surface);
    return evaluated;
}
