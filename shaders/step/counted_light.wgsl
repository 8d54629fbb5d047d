//@ use bind/counters
//@ use bind/settings
// Counts of light by lights, which do not change the image (step/narrow_lobe).

// Each bin has two counts: light that probes found, and light that paths found.
const PROBED: u32 = 0u;
const FOUND: u32 = 1u;

// Lights in different bins are counted separately, so that a light that is found does not hide one that is missing. Bins differ
// by the light's number and by the power of two of its radiance, because a sky with a sun in it is one light.
fn bin_of_light(light: u32, radiance: vec3<f32>) -> u32 {
    return (light + (bitcast<u32>(largest_component(radiance)) >> 23u)) % LIGHT_BINS;
}

// `words` is words_of_count.
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
fn words_of_count(path: ptr<function, Path>) -> vec4<u32> {
    return pcg4d(vec4<u32>((*path).pixel, (*path).sample, (*path).depth, ~settings.seed));
}
