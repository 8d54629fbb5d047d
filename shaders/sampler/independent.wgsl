//@ use lib/rng
// Independent samples: every number is a hash of its own key.

// Four words of random bits of the block `dimension` of a sample.
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(pixel, sample, dimension, seed));
}

// Four independent uniforms of the block `dimension` of a sample.
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
