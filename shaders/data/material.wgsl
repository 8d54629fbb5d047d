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

// What a material has beside its row of the table: for each, the index of a row behind those of all materials, or NO_EXTENSION. Such a row
// has a colour or a texture, whose frame is as far behind that of the material's own texture as `kind` says.
struct Extension {
    // Of a clear solid: what it absorbs per unit of length. It is no index.
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
    // It has a row if the colours of a mesh's vertices multiply its own. Nothing reads the row.
    vertex_colours: u32,
    // It has a row if it makes up for light that microfacets scatter more than once. Nothing reads the row.
    multiscatter: u32,
    // Of glTF's material: what the layer reflects straight on is multiplied by the row's colour, and all that it reflects by its parameter.
    specular: u32,
    // It has a row if the alpha of a mesh's vertices multiplies its own. Nothing reads the row.
    vertex_alpha: u32,
}

const NO_EXTENSION: u32 = 0xffffffffu;

// What a material knows of a ray that hits its surface.
struct Interaction {
    // Unit direction of the incoming ray.
    incoming: vec3<f32>,
    // Unit shading normal, on the side from which the ray comes.
    normal: vec3<f32>,
    // Whether the ray comes from the side to which the surface's own normal points.
    front: bool,
    // The material's colour at the hit point: albedo or emission.
    colour: vec3<f32>,
    // The next element of the table: of a kind of material that has two, its second part (scene/second_parts).
    second: Material,
    // What single scattering loses of the light over what it keeps; 0 in a material that does not make up for it (scene/multiscatter).
    lost_over_kept: f32,
    // Of glTF's material, what its layer reflects: of light straight on it, and of grazing light (extension/specular).
    straight: vec3<f32>,
    grazing: f32,
}

// A surface's material at a hit, with its textures evaluated. Modules set what they are about; nobody reads the rest.
struct EvaluatedMaterial {
    // With the numbers that it has there.
    material: Material,
    colour: vec3<f32>,
    // The radiance that it emits to the ray, beside what it scatters.
    emission: vec3<f32>,
    // The texel of its normal map.
    normal: vec3<f32>,
    // As in Interaction.
    straight: vec3<f32>,
    grazing: f32,
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

// The lobe of a material without any other.
fn lobe_of(width: f32) -> u32 {
    return select(LOBE_WIDE, LOBE_NARROW, is_narrow(width));
}

// What a material does with a ray. SCATTERED: the new unit direction, and weight = BSDF x cosine / pdf. EMITTED: weight =
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

// The side of a surface from which a light is aimed at: the point there, whether it was chosen among two, and whether it is the one that
// the ray does not come from.
struct LightSide {
    point: vec3<f32>,
    is_chosen: bool,
    is_below: bool,
}

// What light sampling takes from a surface.
struct LightResponse {
    response: Response,
    // The density with which light sampling's rival, the BSDF, draws the direction that it drew.
    drawn_pdf: f32,
    // How much a probe in this direction counts (step/narrow_lobe).
    probed: f32,
}
