//@ alternative sampler when sampler.independent
// Independent samples: each number is a hash of its own key.

// The block `dimension` of a sample: four random words.
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(pixel, sample, dimension, seed));
}

// The block `dimension` of a sample: four independent uniform numbers in [0, 1).
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
