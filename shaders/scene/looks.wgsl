//@ use data/hit
//@ use data/material
//@ use data/surface
//@ use bind/details
//@ use bind/materials
//@ use choice/colour
//@ if vertex_colours
//@ use scene/vertex_colours
//@ end
// What a surface's material is at a hit, where it has more than a row of the table and a texture.

struct Look {
    // With the numbers that it has there.
    material: Material,
    colour: vec3<f32>,
    //@ if own_glow
    // The radiance that it emits to the ray.
    glow: vec3<f32>,
    //@ end
    //@ if normal_map
    // The texel of its normal map.
    normal: vec3<f32>,
    //@ end
    //@ if own_layer
    // What the layer of glTF's material reflects: of light straight on it, and of grazing light.
    straight: vec3<f32>,
    grazing: f32,
    //@ end
}

// One bit for each row that is to be evaluated.
const OWN_COLOUR: u32 = 1u;
const GLOW: u32 = 2u;
const ROUGHNESS: u32 = 4u;
const METALLIC: u32 = 8u;
const NORMAL: u32 = 16u;
const SPECULAR: u32 = 32u;

// One loop evaluates all rows: compilers write out each call of a function, and the code of all textures is long. `front` tells whether
// the ray comes from the front.
fn look_at(hit: Hit, surface: Surface, front: bool) -> Look {
    let own = details[surface.material];
    var look: Look;
    look.material = materials[surface.material];
    var left = OWN_COLOUR;
    //@ if own_glow
    let emits = own.emission != NO_DETAIL && (materials[own.emission].parameter != 0.0 || front);
    left |= select(0u, GLOW, emits);
    //@ end
    //@ if varying_roughness
    left |= select(0u, ROUGHNESS, own.roughness != NO_DETAIL);
    //@ end
    //@ if varying_metallic
    left |= select(0u, METALLIC, own.metallic != NO_DETAIL);
    //@ end
    //@ if normal_map
    left |= select(0u, NORMAL, own.normal != NO_DETAIL);
    //@ end
    //@ if own_layer
    look.straight = vec3<f32>(look.material.contrast_outside);
    look.grazing = 1.0;
    left |= select(0u, SPECULAR, own.specular != NO_DETAIL);
    //@ end
    while left != 0u {
        let part = left & (~left + 1u);
        left ^= part;
        var index = surface.material;
        //@ if own_glow
        index = select(index, own.emission, part == GLOW);
        //@ end
        //@ if varying_roughness
        index = select(index, own.roughness, part == ROUGHNESS);
        //@ end
        //@ if varying_metallic
        index = select(index, own.metallic, part == METALLIC);
        //@ end
        //@ if normal_map
        index = select(index, own.normal, part == NORMAL);
        //@ end
        //@ if own_layer
        index = select(index, own.specular, part == SPECULAR);
        //@ end
        let row = materials[index];
        var framed = surface;
        framed.frame += select(row.kind, 0u, part == OWN_COLOUR);
        let colour = surface_colour(row, hit, framed);
        look.colour = select(look.colour, colour, part == OWN_COLOUR);
        //@ if own_glow
        look.glow = select(look.glow, colour, part == GLOW);
        //@ end
        //@ if varying_roughness
        // Rounding may have put a number above its largest texel.
        look.material.parameter = select(look.material.parameter, min(colour.x, 1.0), part == ROUGHNESS);
        //@ end
        //@ if varying_metallic
        look.material.contrast_inside = select(look.material.contrast_inside, min(colour.x, 1.0), part == METALLIC);
        //@ end
        //@ if normal_map
        look.normal = select(look.normal, colour, part == NORMAL);
        //@ end
        //@ if own_layer
        let tinted = row.parameter * min(look.material.contrast_outside * colour, vec3<f32>(1.0));
        look.straight = select(look.straight, tinted, part == SPECULAR);
        look.grazing = select(look.grazing, row.parameter, part == SPECULAR);
        //@ end
    }
    //@ if vertex_colours
    look.colour *= vertex_colour(hit, surface);
    //@ end
    return look;
}
