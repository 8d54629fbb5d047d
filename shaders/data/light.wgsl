// Something that is sampled as a light: an emitting primitive, a face of an emitting mesh, or the sky.
struct Light {
    // Code of the primitive (data/primitive); HIT_NOTHING is the sky.
    code: u32,
    // With a triangle's code: the instance that it is part of.
    instance: u32,
    // That it is chosen.
    probability: f32,
    // Its entry in the alias table (light/alias): below the threshold itself, above it another one.
    threshold: f32,
    other: u32,
    padding0: u32,
    padding1: u32,
    padding2: u32,
}

// What stands for the code of a light where none is asked.
const NO_LIGHT: u32 = 0xfffffff9u;

// The share of a light in what a direction brings, of two ways to draw that direction: the power heuristic with exponent 2
// (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995, section 4.1), by the
// ratio of the densities so that no square overflows.
fn power_share(own: f32, other: f32) -> f32 {
    let ratio = min(other / own, 0x1p60f);
    return 1.0 / (1.0 + ratio * ratio);
}
