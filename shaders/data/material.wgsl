// An element of the table of materials. The `kind` of a material is its number in the list of materials. The `kind` of a further row is the offset
// of its texture's frame from the frame of the material's own texture.
struct Material {
    // Albedo or emission, unless a texture replaces it.
    colour: vec3<f32>,
    kind: u32,
    // Each kind names its numbers (src/material): `material.${metal.fuzz}`. They are computed in f64 and rounded once.
    numbers: vec3<f32>,
    // Index of the texture that gives the colour, or NO_TEXTURE.
    texture: u32,
}

const NO_TEXTURE: u32 = 0xffffffffu;

// Instead of the index of a row (`Rows`) that a material does not have.
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
    // The lobes of glTF's material, 0 where it has none.
    lobes: Lobes,
    // Unit normal of the coat, on the side from which the ray comes.
    coat_normal: vec3<f32>,
    // The radiance that it emits to the ray, under its coat.
    emission: vec3<f32>,
    // Unit direction along which microfacets are rougher, perpendicular to the normal.
    tangent: vec3<f32>,
    // Not 0 if the microfacets have the distribution of Beckmann.
    beckmann: f32,
    // The channel that the path follows through glass with dispersion: red is -1, green 0 and blue 1.
    followed: f32,
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
    lobes: Lobes,
    // The texel of the coat's normal map.
    coat_normal: vec3<f32>,
    // The direction of the anisotropy in the axes of the texture coordinates.
    turn: vec2<f32>,
    beckmann: f32,
    // As in Interaction, and what is kept of light that crosses the surface (step/followed_channel).
    followed: f32,
    kept: vec3<f32>,
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

// The response of a lobe, or of several, with the weight of what lies around: (1 - weight) of `inner` and `weight` of `outer`, whose
// directions are drawn with the probability `share`.
fn mixed_response(inner: Response, outer: Response, weight: f32, share: f32) -> Response {
    let value = (1.0 - weight) * inner.value + weight * outer.value;
    let pdfs = vec2<f32>((1.0 - share) * inner.pdf, share * outer.pdf);
    let pdf = pdfs.x + pdfs.y;
    let narrow = pdfs.x * inner.narrow + pdfs.y * outer.narrow;
    return Response(value, pdf, select(0.0, min(narrow / pdf, 1.0), pdf > 0.0));
}

// Glass: its roughness, its index of refraction, and its contrasts (n - 1)(n + 1) from outside and from inside (lib/fresnel). A pane has no index:
// 1 in its place gives it inner reflections (material/inner_reflections).
struct Glass {
    roughness: f32,
    ior: f32,
    contrasts: vec2<f32>,
}

// A boundary of glass: the index of the far side over that of the near one, and (eta - 1)(eta + 1).
struct Boundary {
    eta: f32,
    contrast: f32,
}

// What a boundary of glass does to light: reflection is drawn with the probability `chance`, and has this colour as its weight.
struct Reflected {
    colour: vec3<f32>,
    chance: f32,
}

// Draws one lobe of several, the outermost first.
struct LobeDraw {
    // The rest of the uniform that chooses.
    u: f32,
    // What lies around leaves this of the weight of the lobes that are left, over the probability that one of them is drawn.
    rest: f32,
    is_drawn: bool,
    // The drawn direction. Only that of a specular lobe has its weight.
    scatter: Scatter,
}

fn begin_draw(u: f32) -> LobeDraw {
    return LobeDraw(u, 1.0, false, absorbed());
}

// A uniform again, of one that is below `share` or not.
fn uniform_below(u: f32, share: f32) -> f32 {
    return min(u / share, 0x0.ffffffp0f);
}

fn uniform_above(u: f32, share: f32) -> f32 {
    return min((u - share) / (1.0 - share), 0x0.ffffffp0f);
}

// The draw from what is left, which is not drawn with the probability `share`.
fn draw_from_rest(draw: LobeDraw, share: f32, factor: f32) -> LobeDraw {
    return LobeDraw(uniform_above(draw.u, share), draw.rest * (factor / (1.0 - share)), false, draw.scatter);
}

fn take_lobe(draw: LobeDraw, scatter: Scatter) -> LobeDraw {
    return LobeDraw(draw.u, draw.rest, true, scatter);
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
