//@ use data/window
//@ use lib/owen
//@ use lib/rng
// Owen-scrambled Sobol points: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020. A block of four dimensions
// is two points of the two-dimensional Sobol sequence, whose order is shuffled anew for each (section 4.3, padding); blocks,
// pixels, seeds and the two halves of a pixel's samples have scrambles of their own. The words and uniforms stand in the place
// of those of sampler/independent: x and y are stratified together, and so are z and w.

// The sequence's second dimension, its highest digit in the lowest bit; the first is the index itself. Its matrix is Pascal's
// modulo 2 (Sobol', 1967; Burley, listing 2, has its columns): digit i is the parity of the bits j of the index of which
// C(j, i) is odd, those where j has all the bits that i has (Lucas, 1878). Parities over all such j are taken one bit of j
// at a time.
fn second_dimension(index: vec2<u32>) -> vec2<u32> {
    var v = index;
    v ^= (v >> vec2<u32>(1u)) & vec2<u32>(0x55555555u);
    v ^= (v >> vec2<u32>(2u)) & vec2<u32>(0x33333333u);
    v ^= (v >> vec2<u32>(4u)) & vec2<u32>(0x0f0f0f0fu);
    v ^= (v >> vec2<u32>(8u)) & vec2<u32>(0x00ff00ffu);
    v ^= (v >> vec2<u32>(16u)) & vec2<u32>(0x0000ffffu);
    return v;
}

// Four words of stratified bits of the block `dimension` of a sample. Even and odd runs are halves with scrambles of their own,
// so that their difference tells the error (src/film.rs).
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    let run = sample / RUN_LENGTH;
    let index = (run >> 1u) * RUN_LENGTH + sample % RUN_LENGTH;
    let seeds = pcg4d(vec4<u32>(pixel, run & 1u, dimension, seed));
    // The shuffles' seeds; a step of a hash away from those of the scrambles.
    let turned = (seeds.zx ^ (seeds.zx >> vec2<u32>(15u))) * 0x9e3779b1u;
    let shuffles = turned ^ (turned >> vec2<u32>(13u));
    // Aligned blocks of the sequence stay together: reversed, the index's high bits decide on the low ones. (Of four lanes, two work.)
    let index_reversed = vec4<u32>(reverseBits(index));
    let shuffled = reverseBits(nested_permutation(index_reversed, shuffles.xyxy).xy);
    let second = second_dimension(shuffled);
    return reverseBits(nested_permutation(vec4<u32>(shuffled.x, second.x, shuffled.y, second.y), seeds));
}

// Four stratified uniforms of the block `dimension` of a sample.
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
