// A material. `kind` is the place of its file in the list of materials.
struct Material {
    // Albedo or emission where no texture replaces it.
    colour: vec3<f32>,
    kind: u32,
    // The material's own, as its file says.
    parameter: f32,
    // Dielectric: (ior - 1)(ior + 1), and the same of 1/ior; rounded once, from f64.
    contrast_outside: f32,
    contrast_inside: f32,
    // Index of the texture of the colour, or NO_TEXTURE.
    texture: u32,
}

const NO_TEXTURE: u32 = 0xffffffffu;

// A ray arriving at a surface, as the materials see it.
struct Interaction {
    // Unit direction of the arriving ray.
    incoming: vec3<f32>,
    // Unit normal on the side that the ray comes from.
    normal: vec3<f32>,
    // Whether that is the side the surface's own normal points to.
    front: bool,
    // The material's colour at the point: albedo, or emission.
    colour: vec3<f32>,
}

const SCATTERED: u32 = 0u;
const ABSORBED: u32 = 1u;
const EMITTED: u32 = 2u;

// What a material makes of it. Scattered: the new unit direction and weight = BSDF x cosine / pdf.
// Emitted: weight = emitted radiance, and the path ends.
struct Scatter {
    event: u32,
    direction: vec3<f32>,
    weight: vec3<f32>,
}

// How a surface answers to light from a direction: BSDF times cosine, and the density by which its material would have drawn
// the direction.
struct Response {
    value: vec3<f32>,
    pdf: f32,
}

fn absorbed() -> Scatter {
    return Scatter(ABSORBED, vec3<f32>(0.0), vec3<f32>(0.0));
}
