// A light that can be sampled: an emitting primitive, a face of an emitting mesh, a part of one of these, a light without size, or the sky.
struct Light {
    // Code of the primitive or of the light without size (data/primitive). HIT_NOTHING stands for the sky.
    code: u32,
    // For a triangle: the instance of its mesh.
    instance: u32,
    // The way from the tree's root to this light (scene/light_tree), one bit per level, the lowest first: 1
    // for the second node of a pair.
    trail: u32,
    // The part of its shape that it is (light/parts), 0 for all of it; or one of the values below.
    part: u32,
}

// The entry is no light: its shape is cut into parts. They are the lights from `trail` on, and `instance` is their number.
const PARTS: u32 = 0xffffffffu;
// A convex body that emits on both sides, and lets light pass: a ray from outside may find it where it enters or where it leaves.
const CROSSED: u32 = 0x80000000u;

// Where a shadow ray meets a light: the side of a convex body as in Hit, and the probability of this choice.
struct LightCrossing {
    instance: u32,
    share: f32,
}

// A light without size.
struct DeltaLight {
    // Its position, with `has_position` 1; of a directional light the unit vector to it, with `has_position` 0.
    position: vec3<f32>,
    has_position: f32,
    // Its intensity; of a directional light its irradiance.
    colour: vec3<f32>,
    // 1 - cos of the angle from which on a beam has no light, or minus the angle if it falls linearly; 4 without a beam.
    height: f32,
    // Unit vector along the beam.
    axis: vec3<f32>,
    // 1 over the difference of the cosines, or of the angles, between which the beam falls; minus that if it falls smoothly.
    slope: f32,
}

// A light chosen to be sampled from a point, and the probability of that choice.
struct LightChoice {
    index: u32,
    probability: f32,
}

// A node of the light tree: a sphere that bounds its lights, and a cone that bounds their normals.
struct LightNode {
    center: vec3<f32>,
    // Negative if its lights emit nothing beyond the cone of their normals.
    radius: f32,
    // The sum over its lights of radiance times mean projected area, relative to the brightest light.
    intensity: f32,
    // The cone's axis, octahedral (lib/octahedral).
    axis: u32,
    cos_half_angle: f32,
    // The index of a pair of nodes or of a light, and three flags.
    child: u32,
}

const LIGHT_NODE_LEAF: u32 = 0x80000000u;
// Its lights emit equally along the cone's directions and opposite to them.
const LIGHT_NODE_TWO_SIDED: u32 = 0x40000000u;
// The node is the sky, which surrounds every point and is equally bright from each; or directional lights, apart from positional lights.
const LIGHT_NODE_SKY: u32 = 0x20000000u;
const LIGHT_NODE_INDEX: u32 = 0x1fffffffu;

// Values from here on are no indices of the table of lights. An emitter with such a value is not sampled.
const NOT_SAMPLED: u32 = 0x80000000u;

// The sky's number when lights are sorted into bins (step/narrow_lobe). It does not depend on the sky's index in the table of lights.
const NUMBER_OF_SKY: u32 = 0u;

// The MIS weight of a direction that one technique draws with density `own` and another one with density `other`: the power
// heuristic with exponent 2 (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH
// 1995, section 4.1). It uses the ratio of the densities, so that no square overflows.
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = min(other / own, 0x1p60f);
    return 1.0 / (1.0 + ratio * ratio);
}
