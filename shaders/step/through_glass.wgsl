//@ use data/path
//@ use data/light
//@ use bind/counters
//@ use bind/settings
//@ use lib/carry
//@ use lib/rng
// Light that mirrors and glass block from light sampling. They scatter one way only, so BSDF sampling must find such light by chance. It
// finds small lights so seldom that an image may lack them and still seem free of noise. So some specular events send a shadow ray
// to a light within a cone around their direction. What these rays find is counted beside what BSDF sampling finds there. The counts
// are no part of the image.

// The pdf of a path whose last event was specular after one that sampled lights; 0 if none did.
const BY_CHANCE: f32 = -1.0;
// One specular event in so many sends such a ray.
const EVENTS_A_QUESTION: u32 = 4u;
// The cosine of the cone's half angle, 25 degrees: wide enough to find small lights, and narrow enough that paths find what rays find.
const CONE: f32 = 0.90630779;
// Its solid angle, 2 pi (1 - CONE).
const SOLID_ANGLE_OF_CONE: f32 = 0.58868553;

// Bins that lights are counted in.
const LIGHT_BINS: u32 = 32u;
// Of a bin's words, the low ones of its sums.
const ASKED: u32 = 0u;
const MET: u32 = 2u;

// The pdf of a path that was sent one way.
fn pdf_of_one_way(pdf: f32) -> f32 {
    return select(0.0, BY_CHANCE, pdf != 0.0);
}

// Whether only chance can find the light that the path has hit, so that its shadow ray only counts.
fn is_by_chance(path: ptr<function, Path>) -> bool {
    return (*path).pdf < 0.0;
}

fn asks_for_light(path: ptr<function, Path>) -> bool {
    return words_of_question(path).x % EVENTS_A_QUESTION == 0u;
}

// The response of a specular event of this weight and direction to light from another direction.
fn response_to_question(weight: vec3<f32>, way: vec3<f32>, direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let same_side = (dot(way, normal) < 0.0) == (dot(direction, normal) < 0.0);
    let within = same_side && dot(way, direction) > CONE;
    return select(vec3<f32>(0.0), weight * f32(EVENTS_A_QUESTION) / SOLID_ANGLE_OF_CONE, within);
}

// Counts light that a shadow ray found: the light's number, radiance and possible contribution.
fn note_asked_light(path: ptr<function, Path>, light: u32, radiance: vec3<f32>, brought: vec3<f32>) {
    add_light(path, bin_of_light(light, radiance), ASKED, brought);
}

// Counts light that BSDF sampling found, with its contribution.
fn note_met_light(path: ptr<function, Path>, light: u32, radiance: vec3<f32>, brought: vec3<f32>) {
    if is_by_chance(path) && light < NOT_SAMPLED {
        add_light(path, bin_of_light(light, radiance), MET, brought);
    }
}

// Lights have counts of their own, so that a light that is found hides no other. They are told apart by number, and by powers of two of
// their radiance, since a sky is one light with a sun in it.
fn bin_of_light(light: u32, radiance: vec3<f32>) -> u32 {
    return (light + (bitcast<u32>(largest_component(radiance)) >> 23u)) % LIGHT_BINS;
}

fn add_light(path: ptr<function, Path>, bin: u32, sum: u32, brought: vec3<f32>) {
    // In units of 2^-24 of the device's unit of radiance. Less than one unit is rounded up with the probability of its share.
    let chance = f32(words_of_question(path).y >> 8u) * 0x1p-24f;
    let added = u32(min(largest_component(abs(brought)), 100.0) * 0x1p24f + chance);
    let before = atomicAdd(&counters.light[bin][sum], added);
    if carry(before, added) != 0u {
        atomicAdd(&counters.light[bin][sum + 1u], 1u);
    }
}

fn largest_component(colour: vec3<f32>) -> f32 {
    return max(max(colour.x, colour.y), colour.z);
}

// From words that do not depend on how stages are linked, and from none of the path's own random numbers.
fn words_of_question(path: ptr<function, Path>) -> vec4<u32> {
    return pcg4d(vec4<u32>((*path).pixel, (*path).sample, (*path).depth, ~settings.seed));
}
