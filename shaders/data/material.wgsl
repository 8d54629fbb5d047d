// A material. `kind` is its number in the list of materials.
struct Material {
    // Albedo or emission, unless a texture replaces it.
    colour: vec3<f32>,
    kind: u32,
    // The material's file defines what this means.
    parameter: f32,
    // Dielectric: (ior - 1)(ior + 1), and the same for 1/ior. Computed in f64 and rounded once.
    contrast_outside: f32,
    contrast_inside: f32,
    // Index of the texture that gives the colour, or NO_TEXTURE.
    texture: u32,
}

const NO_TEXTURE: u32 = 0xffffffffu;

// The extensions of a material. Each is the index of a row of the table of materials, behind those of all materials, or NO_EXTENSION.
// Such a row has a colour or a texture. Its `kind` is the offset of the texture's frame from that of the material's own texture.
struct Extension {
    // The absorption of a transmissive solid, per unit of length. It is no index.
    absorption: vec3<f32>,
    // The radiance that it emits. The row's parameter is 0 if it emits from its front alone.
    emission: u32,
    // The share of light that it stops.
    alpha: u32,
    // Its roughness and how metallic it is, where they vary over the surface.
    roughness: u32,
    metallic: u32,
    // The normal in the frame of the texture coordinates.
    normal: u32,
    // A row if the colours of a mesh's vertices multiply the material's. The row is not read.
    vertex_colours: u32,
    // A row if the material has energy compensation (scene/multiscatter). The row is not read.
    multiscatter: u32,
    // Of glTF's material: the row's colour multiplies the layer's reflectance at normal incidence, and its parameter that at all angles.
    specular: u32,
    // A row if the alpha of a mesh's vertices multiplies the material's. The row is not read.
    vertex_alpha: u32,
    // A row if the colours of a mesh's vertices multiply the emitted radiance. The row is not read.
    vertex_emission: u32,
    padding0: u32,
    padding1: u32,
    padding2: u32,
}

const NO_EXTENSION: u32 = 0xffffffffu;

// The interaction of a ray with a surface, as materials take it.
struct Interaction {
    // Unit direction of the incoming ray.
    incoming: vec3<f32>,
    // Unit shading normal, on the side from which the ray comes.
    normal: vec3<f32>,
    // Whether the ray comes from the side to which the surface's own normal points.
    front: bool,
    // The material's colour at the hit point: albedo or emission.
    colour: vec3<f32>,
    // The material's second part, if its kind has two elements of the table (scene/second_parts).
    second: Material,
    // (1 - E) / E of the energy compensation; 0 for a material without it (scene/multiscatter).
    compensation: f32,
    // Of glTF's material, the reflectance of its layer at normal and at grazing incidence (extension/specular).
    f0: vec3<f32>,
    f90: f32,
}

// A surface's material at a hit, with its textures evaluated. Each extension sets its own members; the others are not read.
struct EvaluatedMaterial {
    // With the parameters that it has at the hit.
    material: Material,
    colour: vec3<f32>,
    // The radiance that it emits to the ray, in addition to what it scatters.
    emission: vec3<f32>,
    // The texel of its normal map.
    normal: vec3<f32>,
    // As in Interaction.
    f0: vec3<f32>,
    f90: f32,
}

const SCATTERED: u32 = 0u;
const ABSORBED: u32 = 1u;
const EMITTED: u32 = 2u;

// The width of the lobe that a direction was drawn from. A LOBE_SPECULAR has one direction, so light sampling cannot find its light. Of a
// LOBE_NARROW it rarely does. Lights that only such lobes reach are counted (step/narrow_lobe).
const LOBE_WIDE: u32 = 0u;
const LOBE_NARROW: u32 = 1u;
const LOBE_SPECULAR: u32 = 2u;
// The width in radians from which on a lobe is wide. Measured: docs/light-transport.md, "Light that narrow lobes hide".
const NARROW_LOBE: f32 = 0.1;

// Whether a lobe of this width in radians is narrow: half of its directions are within about this angle of its axis.
fn is_narrow(width: f32) -> bool {
    return width < NARROW_LOBE;
}

// The kind of a lobe by its width in radians.
fn lobe_of(width: f32) -> u32 {
    return select(LOBE_WIDE, LOBE_NARROW, is_narrow(width));
}

// A BSDF sample. SCATTERED: the new unit direction, and weight = BSDF x cosine / pdf. EMITTED: weight =
// emitted radiance, and the path ends.
struct Scatter {
    event: u32,
    direction: vec3<f32>,
    weight: vec3<f32>,
    // The lobe that the direction was drawn from.
    lobe: u32,
}

// The response of a surface to light from a given direction, without that of its specular lobes: BSDF times cosine, and the pdf with
// which the material would sample that direction.
struct Response {
    value: vec3<f32>,
    pdf: f32,
    // The share of the pdf that narrow lobes have.
    narrow: f32,
}

fn scatter_towards(direction: vec3<f32>, weight: vec3<f32>, lobe: u32) -> Scatter {
    return Scatter(SCATTERED, direction, weight, lobe);
}

fn emit(radiance: vec3<f32>) -> Scatter {
    return Scatter(EMITTED, vec3<f32>(0.0), radiance, LOBE_WIDE);
}

fn absorbed() -> Scatter {
    return Scatter(ABSORBED, vec3<f32>(0.0), vec3<f32>(0.0), LOBE_WIDE);
}

fn no_response() -> Response {
    return Response(vec3<f32>(0.0), 0.0, 0.0);
}

// The side of a surface from which a light is sampled.
struct LightSide {
    point: vec3<f32>,
    // Whether it was chosen from two.
    is_chosen: bool,
    // Whether the ray comes from the other one.
    is_below: bool,
}

// The response of a surface, as light sampling uses it.
struct LightResponse {
    response: Response,
    // The density of the BSDF's own sample, for its MIS weight.
    drawn_pdf: f32,
    // The share of light from this direction that a probe counts (step/narrow_lobe).
    probed: f32,
}
