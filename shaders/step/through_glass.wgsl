//@ use data/path
//@ use data/light
//@ use bind/counters
//@ use bind/settings
//@ use lib/carry
//@ use lib/rng
// Counts the light that mirrors and glass block from light sampling. Mirrors and glass scatter to one direction only, so only
// BSDF sampling can find such light, by chance. It finds small lights so rarely that an image may lack them and still seem free
// of noise. So some specular events send a shadow ray to a light within a cone around their direction. The light that these
// rays find is counted, and so is the light that BSDF sampling finds there. The counts do not change the image.

// The value of `pdf` after a specular event if an earlier event of the path sampled lights. If none did, `pdf` is 0.
const BY_CHANCE: f32 = -1.0;
// One in this many specular events sends such a shadow ray.
const EVENTS_A_QUESTION: u32 = 4u;
// The cosine of the cone's half angle, 25 degrees. The cone is wide enough to find small lights, and narrow enough that BSDF
// sampling finds what the shadow rays find.
const CONE: f32 = 0.90630779;
// The cone's solid angle, 2 pi (1 - CONE).
const SOLID_ANGLE_OF_CONE: f32 = 0.58868553;

// The number of bins in which lights are counted.
const LIGHT_BINS: u32 = 32u;
// Each bin has two counts: light that shadow rays found (ASKED), and light that BSDF sampling found (MET).
const ASKED: u32 = 0u;
const MET: u32 = 1u;

// The value of `pdf` after a specular event, from the value before it.
fn pdf_of_one_way(pdf: f32) -> f32 {
    return select(0.0, BY_CHANCE, pdf != 0.0);
}

// Whether the path's last event was specular and an earlier one sampled lights. Then only BSDF sampling can find light,
// and a shadow ray only counts it.
fn is_by_chance(path: ptr<function, Path>) -> bool {
    return (*path).pdf < 0.0;
}

fn asks_for_light(path: ptr<function, Path>) -> bool {
    return words_of_question(path).x % EVENTS_A_QUESTION == 0u;
}

// The response of a specular event to light from `direction`: the event's weight, spread over the cone around its own direction `way`.
fn response_to_question(weight: vec3<f32>, way: vec3<f32>, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let same_side = (dot(way, normal) < 0.0) == (dot(direction, normal) < 0.0);
    let within = same_side && dot(way, direction) > CONE;
    return select(vec3<f32>(0.0), weight * f32(EVENTS_A_QUESTION) / SOLID_ANGLE_OF_CONE, within);
}

// Counts light that a shadow ray found: the light's number, its radiance, and its possible contribution.
fn note_asked_light(path: ptr<function, Path>, light: u32, radiance: vec3<f32>, brought: vec3<f32>) {
    add_light(path, bin_of_light(light, radiance), ASKED, brought);
}

// Counts light that BSDF sampling found: the light's number, its radiance, and its contribution.
fn note_met_light(path: ptr<function, Path>, light: u32, radiance: vec3<f32>, brought: vec3<f32>) {
    if is_by_chance(path) && light < NOT_SAMPLED {
        add_light(path, bin_of_light(light, radiance), MET, brought);
    }
}

// Lights in different bins are counted separately, so that a light that is found does not hide one that is missing. Bins differ
// by the light's number and by the power of two of its radiance, because a sky with a sun in it is one light.
fn bin_of_light(light: u32, radiance: vec3<f32>) -> u32 {
    return (light + (bitcast<u32>(largest_component(radiance)) >> 23u)) % LIGHT_BINS;
}

fn add_light(path: ptr<function, Path>, bin: u32, sum: u32, brought: vec3<f32>) {
    // In units of 2^-24 of the device's unit of radiance. The remaining fraction of a unit is rounded up with a
    // probability equal to that fraction.
    let chance = f32(words_of_question(path).y >> 8u) * 0x1p-24f;
    let added = u32(min(largest_component(abs(brought)), 100.0) * 0x1p24f + chance);
    let before = atomicAdd(&counters.light[bin][sum][0], added);
    if carry(before, added) != 0u {
        atomicAdd(&counters.light[bin][sum][1], 1u);
    }
}

fn largest_component(colour: vec3<f32>) -> f32 {
    return max(max(colour.x, colour.y), colour.z);
}

// Random words for the counting. They do not depend on how stages are linked, and they are not among the path's own random numbers.
fn words_of_question(path: ptr<function, Path>) -> vec4<u32> {
    return pcg4d(vec4<u32>((*path).pixel, (*path).sample, (*path).depth, ~settings.seed));
}
