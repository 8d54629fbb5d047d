//@ use data/hit
//@ use data/light
//@ use data/material
//@ use data/path
//@ use bind/counters
//@ use bind/settings
//@ use lib/carry
//@ use lib/rng
//@ use choice/delta_lights
//@ use scene/lights
// Counts the light that narrow lobes hide from light sampling: those of mirrors, clear glass, polished metal and forward scattering. Only
// directions that such a lobe draws find its light, or a sampled light that happens to lie in it. Small lights are found so
// rarely that an image may lack them and still seem free of noise. So some events with a narrow lobe send a probe: a shadow ray
// to a light within a cone around the direction that the lobe has drawn. The light that probes find is counted, and so is the light that the
// path brings from these lobes. The counts do not change the image.

// A path's history, in bits. An event with a wide lobe has sampled a light.
const AFTER_WIDE_LOBE: u32 = 1u;
// The path's ray was drawn from a narrow lobe.
const IN_NARROW_LOBE: u32 = 2u;
// The light that the path's shadow ray brings counts as that of a narrow lobe.
const LIGHT_IN_NARROW_LOBE: u32 = 4u;

// One in this many events with a narrow lobe sends a probe.
const EVENTS_A_PROBE: u32 = 4u;
// The cosine of the cone's half angle, 25 degrees. The cone is wide enough to find small lights, and narrow enough that paths find what
// the probes find.
const CONE: f32 = 0.90630779;
// The cone's solid angle, 2 pi (1 - CONE).
const SOLID_ANGLE_OF_CONE: f32 = 0.58868553;

// The number of bins in which lights are counted.
const LIGHT_BINS: u32 = 32u;
// Each bin has two counts: light that probes found, and light that paths found.
const PROBED: u32 = 0u;
const FOUND: u32 = 1u;

// The word of the depth has the history in its highest bits. No path has as many events as are left for the depth.
const DEPTH_BITS: u32 = 29u;

fn pack_depth(path: ptr<function, Path>) -> u32 {
    return min((*path).depth, (1u << DEPTH_BITS) - 1u) | ((*path).history << DEPTH_BITS);
}

fn unpack_depth(path: ptr<function, Path>, word: u32) {
    (*path).depth = word & ((1u << DEPTH_BITS) - 1u);
    (*path).history = word >> DEPTH_BITS;
}

fn start_history(path: ptr<function, Path>) {
    (*path).history = 0u;
}

// Whether an event that draws a direction from a lobe sends a probe: only where an earlier event with a wide lobe has sampled a light. Before
// such an event, the light of narrow lobes is that of a few directions, which the camera's rays see as they are.
fn sends_probe(path: ptr<function, Path>, lobe: u32) -> bool {
    let follows = ((*path).history & AFTER_WIDE_LOBE) != 0u && (*path).depth < settings.max_depth;
    return follows && lobe != LOBE_WIDE && words_of_probe(path).x % EVENTS_A_PROBE == 0u;
}

// Sets the weight of the path's shadow ray as a probe, per unit of throughput and radiance, for light sampling with the density 1. The
// probe spreads the drawn direction evenly over the cone around it, on its side of the surface. `share` is what counts of lights in this
// direction. The weight is negative in a specular lobe.
fn aim_probe(path: ptr<function, Path>, probes: bool, drawn: Scatter, to_light: vec3<f32>, normal: vec3<f32>, share: f32) {
    let same_side = (dot(drawn.direction, normal) < 0.0) == (dot(to_light, normal) < 0.0);
    let within = probes && same_side && dot(drawn.direction, to_light) > CONE;
    let weight = select(1.0, -1.0, drawn.lobe == LOBE_SPECULAR) * f32(EVENTS_A_PROBE) / SOLID_ANGLE_OF_CONE;
    (*path).probe = select(0.0, share * weight, within);
}

fn is_probe(path: ptr<function, Path>) -> bool {
    return (*path).probe != 0.0;
}

// Divides a probe's weight by the density of its light. No path finds a light without size in a specular lobe: its light is missing, which
// the host warns of.
fn weigh_probe(path: ptr<function, Path>, pdf: f32, has_size: bool) {
    let weight = (*path).probe;
    (*path).probe = select(0.0, abs(weight) / pdf, has_size || weight > 0.0);
}

// Notes an event in the path's history: the lobe of the drawn direction, and of the response to the sampled light the share that narrow
// lobes have. The share is a probability here, so that a light counts as a whole or not at all.
fn record_event(path: ptr<function, Path>, lobe: u32, share: f32) {
    let follows = (*path).history & AFTER_WIDE_LOBE;
    let is_narrow_light = follows != 0u && share > 0.0 && f32(words_of_probe(path).z >> 8u) * 0x1p-24f < share;
    let drawn = select(follows | IN_NARROW_LOBE, AFTER_WIDE_LOBE, lobe == LOBE_WIDE);
    (*path).history = drawn | select(0u, LIGHT_IN_NARROW_LOBE, is_narrow_light);
}

// Counts light that the path's ray found: the hit on it, its radiance, and its contribution.
fn record_found_light(path: ptr<function, Path>, hit: Hit, radiance: vec3<f32>, contribution: vec3<f32>) {
    let light = number_of_light(hit);
    if is_hidden_light(path) && light < NOT_SAMPLED {
        add_light(path, bin_of_light(light, radiance), FOUND, contribution);
    }
}

// Counts light of the sky that the path's ray found.
fn record_found_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
    if is_hidden_light(path) {
        add_light(path, bin_of_light(NUMBER_OF_SKY, radiance), FOUND, contribution);
    }
}

fn is_hidden_light(path: ptr<function, Path>) -> bool {
    return ((*path).history & (AFTER_WIDE_LOBE | IN_NARROW_LOBE)) == (AFTER_WIDE_LOBE | IN_NARROW_LOBE);
}

// Counts light that the path's shadow ray found, as a probe and by light sampling: its radiance, and what arrives of it.
fn record_light_of_shadow(path: ptr<function, Path>, hit: Hit, emitted: vec3<f32>, arriving: vec3<f32>) {
    let bin = bin_of_light(number_of_light(hit), emitted);
    if ((*path).history & LIGHT_IN_NARROW_LOBE) != 0u {
        add_light(path, bin, FOUND, (*path).light_weight * arriving);
    }
    if (*path).probe > 0.0 {
        var probed = (*path).probe * arriving;
        if is_delta_light(hit.code) {
            probed *= intensity_of_delta_light(hit.code, (*path).shadow.direction);
        }
        add_light(path, bin, PROBED, (*path).throughput * probed);
    }
}

// Lights in different bins are counted separately, so that a light that is found does not hide one that is missing. Bins differ
// by the light's number and by the power of two of its radiance, because a sky with a sun in it is one light.
fn bin_of_light(light: u32, radiance: vec3<f32>) -> u32 {
    return (light + (bitcast<u32>(largest_component(radiance)) >> 23u)) % LIGHT_BINS;
}

fn add_light(path: ptr<function, Path>, bin: u32, sum: u32, contribution: vec3<f32>) {
    // In units of 2^-24 of the device's unit of radiance. The remaining fraction of a unit is rounded up with a
    // probability equal to that fraction.
    let rounding = f32(words_of_probe(path).y >> 8u) * 0x1p-24f;
    let added = u32(min(largest_component(abs(contribution)), 100.0) * 0x1p24f + rounding);
    let before = atomicAdd(&counters.light[bin][sum][0], added);
    if carry(before, added) != 0u {
        atomicAdd(&counters.light[bin][sum][1], 1u);
    }
}

fn largest_component(colour: vec3<f32>) -> f32 {
    return max(max(colour.x, colour.y), colour.z);
}

// Random words for the counting. They do not depend on how stages are linked, and they are not among the path's own random numbers.
fn words_of_probe(path: ptr<function, Path>) -> vec4<u32> {
    return pcg4d(vec4<u32>((*path).pixel, (*path).sample, (*path).depth, ~settings.seed));
}
