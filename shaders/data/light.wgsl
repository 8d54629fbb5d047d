// Something that is sampled as a light: an emitting primitive, a face of an emitting mesh, or the sky.
struct Light {
    // Code of the primitive (data/primitive); HIT_NOTHING is the sky.
    code: u32,
    // With a triangle's code: the instance that it is part of.
    instance: u32,
    // The way to it in the tree (scene/light_tree), from the lowest bit on: whether it goes to the second of a pair.
    trail: u32,
    padding: u32,
}

// A light that was chosen for a point.
struct LightChoice {
    index: u32,
    probability: f32,
}

// A node of the tree over the lights: the sphere around its lights, and the cone around the directions in which they are turned.
struct LightNode {
    center: vec3<f32>,
    radius: f32,
    // Radiance times the area that its lights show on the mean, over that of the brightest light.
    intensity: f32,
    // Octahedral.
    axis: u32,
    cos_spread: f32,
    // The index of a pair of nodes or of a light, and three bits.
    child: u32,
}

const LIGHT_NODE_LEAF: u32 = 0x80000000u;
// Its lights shine against the cone as they do along it.
const LIGHT_NODE_TWO_SIDED: u32 = 0x40000000u;
// It is the sky: around all points, and as bright from each.
const LIGHT_NODE_SKY: u32 = 0x20000000u;
const LIGHT_NODE_INDEX: u32 = 0x1fffffffu;

// From here on no light has its place: what emits and has such a one is not sampled.
const NOT_SAMPLED: u32 = 0x80000000u;

// Of the sky among the bins of lights (step/through_glass), whatever its place among the lights.
const NUMBER_OF_SKY: u32 = 0u;

// What stands for the code of a light where none is asked.
const NO_LIGHT: u32 = 0xfffffff9u;

// The share of a light in what a direction brings, of two ways to draw that direction: the power heuristic with exponent 2
// (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995, section 4.1), by the
// ratio of the densities so that no square overflows.
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = min(other / own, 0x1p60f);
    return 1.0 / (1.0 + ratio * ratio);
}
