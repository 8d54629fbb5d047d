//@ use bind/settings
//@ use choice/sampler
//@ use choice/faces
//@ use scene/primitives
// Random numbers by which rays pass surfaces.

// What is decided. Each has numbers of its own.
const COVERAGE: u32 = 0u;
const NEAR_SIDE_OF_PANE: u32 = 1u;
const FAR_SIDE_OF_PANE: u32 = 2u;
const COVERAGE_OF_FAR_SIDE: u32 = 3u;

// A random number of a surface for a ray. Each surface of the scene has its own, whatever the order of the walk.
fn random_of_surface(pixel: u32, sample: u32, dimension: u32, hit: Hit, decision: u32) -> f32 {
    let surface = pcg4d(vec4<u32>(primitive_order(hit), part_number(hit), decision, settings.seed));
    return random4(pixel, sample, dimension, surface.x).x;
}
