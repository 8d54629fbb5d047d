//@ use data/hit
//@ use data/light
//@ use data/material
//@ use data/path
//@ use bind/counters
//@ use bind/settings
//@ use lib/carry
//@ use lib/rng
//@ use choice/delta_lights
//@ use choice/density_ratio
//@ use scene/lights
// Narrow lobes (of mirrors, clear glass, polished metal and forward scattering) hide light from light sampling. Only directions
// sampled from such a lobe find its light, or a sampled light that happens to lie in it. Small lights are found so rarely that an
// image may lack them and still seem free of noise. So some events with a narrow lobe send a probe: a shadow ray to a light
// within a cone around the sampled direction. The light that probes find is counted, and the light that paths find through
// narrow lobes. The counts do not change the image.

// The bits of a path's history. An event with a wide lobe has sampled a light.
const AFTER_WIDE_LOBE: u32 = 1u;
// The path's ray was drawn from a narrow lobe.
const IN_NARROW_LOBE: u32 = 2u;
// The light of the path's shadow ray counts as found through a narrow lobe.
const LIGHT_IN_NARROW_LOBE: u32 = 4u;

// One in this many events with a narrow lobe sends a probe.
const EVENTS_PER_PROBE: u32 = 4u;
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

// The depth's word has the history in its highest bits. No path has as many events as the other bits can count.
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

// Whether an event whose direction is sampled from this lobe sends a probe: only after an event with a wide lobe, which has sampled a
// light. Before that, the camera sees what narrow lobes show, and its rays find it directly.
fn sends_probe(path: ptr<function, Path>, lobe: u32) -> bool {
    let follows = ((*path).history & AFTER_WIDE_LOBE) != 0u && (*path).depth < settings.max_depth;
    return follows && lobe != LOBE_WIDE && !light_paths_follow(path, lobe) && words_of_probe(path).x % EVENTS_PER_PROBE == 0u;
}

// Sets the probe weight of the path's shadow ray, per unit of throughput and radiance, before the division by the light's density. The
// probe stands for a uniform direction in the cone around the sampled one, on the same side of the surface. `share` is
// the share of light from this direction that counts. The weight is negative in a specular lobe.
fn aim_probe(path: ptr<function, Path>, probes: bool, drawn: Scatter, to_light: vec3<f32>, normal: vec3<f32>, share: f32) {
    let same_side = (dot(drawn.direction, normal) < 0.0) == (dot(to_light, normal) < 0.0);
    let within = probes && same_side && dot(drawn.direction, to_light) > CONE;
    let weight = select(1.0, -1.0, drawn.lobe == LOBE_SPECULAR) * f32(EVENTS_PER_PROBE) / SOLID_ANGLE_OF_CONE;
    (*path).probe = select(0.0, share * weight, within);
}

fn is_probe(path: ptr<function, Path>) -> bool {
    return (*path).probe != 0.0;
}

// Divides a probe's weight by the density of its light. The probe of a light without size does not count in a specular lobe: no path
// finds that light, and the host warns of it.
fn weigh_probe(path: ptr<function, Path>, pdf: f32, has_size: bool) {
    let weight = (*path).probe;
    (*path).probe = select(0.0, abs(weight) / pdf, has_size || weight > 0.0);
}

// Records an event in the path's history: the lobe of its sampled direction, and whether the light that it samples counts as found
// through a narrow lobe. That has the probability `share`: the share of narrow lobes in the response to the light.
fn record_event(path: ptr<function, Path>, lobe: u32, share: f32) {
    let follows = (*path).history & AFTER_WIDE_LOBE;
    let is_narrow_light = follows != 0u && share > 0.0 && f32(words_of_probe(path).z >> 8u) * 0x1p-24f < share;
    let drawn = select(follows | IN_NARROW_LOBE, AFTER_WIDE_LOBE, lobe == LOBE_WIDE);
    (*path).history = drawn | select(0u, LIGHT_IN_NARROW_LOBE, is_narrow_light);
}

// Counts light that the path's ray found at a hit: the emitted radiance, and its contribution.
fn record_found_light(path: ptr<function, Path>, hit: Hit, radiance: vec3<f32>, contribution: vec3<f32>) {
    let light = number_of_light(hit);
    if is_hidden_light(path) && light < NOT_SAMPLED {
        add_light(words_of_probe(path), bin_of_light(light, radiance), FOUND, contribution);
    }
}

// Counts light of the sky that the path's ray found.
fn record_found_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
    if is_hidden_light(path) {
        add_light(words_of_probe(path), bin_of_light(NUMBER_OF_SKY, radiance), FOUND, contribution);
    }
}

fn is_hidden_light(path: ptr<function, Path>) -> bool {
    if (*path).pdf == 0.0 && light_paths_follow(path, LOBE_SPECULAR) {
        return false;
    }
    return ((*path).history & (AFTER_WIDE_LOBE | IN_NARROW_LOBE)) == (AFTER_WIDE_LOBE | IN_NARROW_LOBE);
}

// Counts light that the path's shadow ray found, as a probe and by light sampling: the emitted radiance, and what media let pass.
fn record_light_of_shadow(path: ptr<function, Path>, hit: Hit, emitted: vec3<f32>, arriving: vec3<f32>) {
    let bin = bin_of_light(number_of_light(hit), emitted);
    let words = words_of_probe(path);
    if ((*path).history & LIGHT_IN_NARROW_LOBE) != 0u {
        add_light(words, bin, FOUND, (*path).light_weight * arriving);
    }
    if (*path).probe > 0.0 {
        var probed = (*path).probe * arriving;
        if is_delta_light(hit.code) {
            probed *= intensity_of_delta_light(hit.code, (*path).shadow.direction);
        }
        add_light(words, bin, PROBED, (*path).throughput * probed);
    }
}

// Lights in different bins are counted separately, so that a light that is found does not hide one that is missing. Bins differ
// by the light's number and by the power of two of its radiance, because a sky with a sun in it is one light.
fn bin_of_light(light: u32, radiance: vec3<f32>) -> u32 {
    return (light + (bitcast<u32>(largest_component(radiance)) >> 23u)) % LIGHT_BINS;
}

// `words` is words_of_probe.
fn add_light(words: vec4<u32>, bin: u32, sum: u32, contribution: vec3<f32>) {
    // In units of 2^-24 of the device's unit of radiance. The remaining fraction of a unit is rounded up with a
    // probability equal to that fraction.
    let rounding = f32(words.y >> 8u) * 0x1p-24f;
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
