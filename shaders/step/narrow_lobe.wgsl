//@ alternative probe when probed & !kernel.light_path
//@ use bind/settings
//@ use choice/delta_lights
//@ use scene/lights
//@ use step/counted_light
// Narrow lobes (of mirrors, clear glass, polished metal and forward scattering) hide light from light sampling. Only directions
// sampled from such a lobe find its light, or a sampled light that happens to lie in it. Small lights are found so rarely that an
// image may lack them and still seem free of noise. So some events with a narrow lobe send a probe: a shadow ray to a light
// within a cone around the sampled direction. The light that probes find is counted, and the light that paths find through
// narrow lobes. The counts do not change the image.

// The bits of a path's history.
// One of its events was not specular.
const AFTER_SPREADING: u32 = 1u;
// The path's ray was drawn from a narrow lobe after such an event.
const IN_NARROW_LOBE: u32 = 2u;
// The light of the path's shadow ray counts as found through a narrow lobe.
const LIGHT_IN_NARROW_LOBE: u32 = 4u;

// The events with a narrow lobe send probes in one of so many samples.
const SAMPLES_PER_PROBE: u32 = 4u;
// The cosine of the cone's half angle, 25 degrees. The cone is wide enough to find small lights, and narrow enough that paths find what
// the probes find.
const CONE: f32 = 0.90630779;
// The cone's solid angle, 2 pi (1 - CONE).
const SOLID_ANGLE_OF_CONE: f32 = 0.58868553;

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

// Whether an event whose direction is sampled from this lobe sends a probe: only after an event that is not specular. Before that, the camera
// sees what narrow lobes show, and its rays find it directly. All pixels probe in the same samples, so that the paths of a wave do so together.
fn sends_probe(path: ptr<function, Path>, lobe: u32) -> bool {
    let follows = ((*path).history & AFTER_SPREADING) != 0u && (*path).depth < settings.max_depth;
    let sample = (*path).sample;
    let probing = pcg4d(vec4<u32>(sample / SAMPLES_PER_PROBE, 0u, 0u, ~settings.seed)).x;
    return follows && lobe != LOBE_WIDE && (sample ^ probing) % SAMPLES_PER_PROBE == 0u;
}

// Sets the probe weight of the path's shadow ray, per unit of throughput and radiance, before the division by the light's density. The
// probe stands for a uniform direction in the cone around the sampled one, on the same side of the surface. `share` is
// the share of light from this direction that counts.
fn aim_probe(path: ptr<function, Path>, probes: bool, drawn: Scatter, to_light: vec3<f32>, normal: vec3<f32>, share: f32) {
    let same_side = (dot(drawn.direction, normal) < 0.0) == (dot(to_light, normal) < 0.0);
    let within = probes && same_side && dot(drawn.direction, to_light) > CONE;
    (*path).probe = select(0.0, share * f32(SAMPLES_PER_PROBE) / SOLID_ANGLE_OF_CONE, within);
}

fn is_probe(path: ptr<function, Path>) -> bool {
    return (*path).probe != 0.0;
}

// Divides a probe's weight by the density of its light.
fn weigh_probe(path: ptr<function, Path>, pdf: f32) {
    (*path).probe = select(0.0, (*path).probe / pdf, pdf > 0.0);
}

// Records an event in the path's history: the lobe of its sampled direction, and whether the light that it samples counts as found
// through a narrow lobe. That has the probability `share`: the share of narrow lobes in the response to the light.
fn record_event(path: ptr<function, Path>, lobe: u32, share: f32) {
    let follows = (*path).history & AFTER_SPREADING;
    let is_narrow_light = follows != 0u && share > 0.0 && f32(words_of_count(path).z >> 8u) * 0x1p-24f < share;
    let drawn = follows | select(AFTER_SPREADING, 0u, lobe == LOBE_SPECULAR);
    let in_narrow_lobe = select(0u, IN_NARROW_LOBE, follows != 0u && lobe != LOBE_WIDE);
    (*path).history = drawn | in_narrow_lobe | select(0u, LIGHT_IN_NARROW_LOBE, is_narrow_light);
}

// Counts light that the path's ray found at a hit: the emitted radiance, and its contribution.
fn record_found_light(path: ptr<function, Path>, hit: Hit, radiance: vec3<f32>, contribution: vec3<f32>) {
    let light = number_of_light(hit);
    if is_hidden_light(path) && light < NOT_SAMPLED {
        add_light(words_of_count(path), bin_of_light(light, radiance), FOUND, contribution);
    }
}

// Counts light of the sky that the path's ray found.
fn record_found_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
    if is_hidden_light(path) {
        add_light(words_of_count(path), bin_of_light(NUMBER_OF_SKY, radiance), FOUND, contribution);
    }
}

fn is_hidden_light(path: ptr<function, Path>) -> bool {
    return ((*path).history & IN_NARROW_LOBE) != 0u;
}

// Counts light that the path's shadow ray found, as a probe and by light sampling: the emitted radiance, and what media let pass.
fn record_light_of_shadow(path: ptr<function, Path>, hit: Hit, emitted: vec3<f32>, arriving: vec3<f32>) {
    let bin = bin_of_light(number_of_light(hit), emitted);
    let words = words_of_count(path);
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

//@ without
// No lobe of the scene hides light from light sampling: nothing is counted.

fn pack_depth(path: ptr<function, Path>) -> u32 {
    return (*path).depth;
}

fn unpack_depth(path: ptr<function, Path>, word: u32) {
    (*path).depth = word;
}

fn start_history(path: ptr<function, Path>) {
}

fn sends_probe(path: ptr<function, Path>, lobe: u32) -> bool {
    return false;
}

fn aim_probe(path: ptr<function, Path>, probes: bool, drawn: Scatter, to_light: vec3<f32>, normal: vec3<f32>, share: f32) {
}

fn is_probe(path: ptr<function, Path>) -> bool {
    return false;
}

fn weigh_probe(path: ptr<function, Path>, pdf: f32) {
}

fn record_event(path: ptr<function, Path>, lobe: u32, share: f32) {
}

fn record_found_light(path: ptr<function, Path>, hit: Hit, radiance: vec3<f32>, contribution: vec3<f32>) {
}

fn record_found_sky(path: ptr<function, Path>, radiance: vec3<f32>, contribution: vec3<f32>) {
}

fn record_light_of_shadow(path: ptr<function, Path>, hit: Hit, emitted: vec3<f32>, arriving: vec3<f32>) {
}
