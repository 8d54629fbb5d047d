//@ alternative sampler when sampler.independent
// Independent samples: each number is a hash of its own key.

// The block `dimension` of a sample: four random words.
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(pixel, sample, dimension, seed));
}

// The eighth of [0, 1) in which a fifth number of the block lies: 0 to 7.
fn random_eighth(pixel: u32, sample: u32, dimension: u32, seed: u32) -> u32 {
    return pcg4d(random_words(pixel, sample, dimension, seed)).x >> 29u;
}

// Independent numbers need no order.
fn sample_of_part(sample: u32, eighth: u32, first: u32, count: u32) -> u32 {
    return sample;
}

// The block `dimension` of a sample: four independent uniform numbers in [0, 1).
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
