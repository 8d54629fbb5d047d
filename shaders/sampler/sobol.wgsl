//@ alternative sampler when sampler.sobol
// Owen-scrambled Sobol points: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020. A block of four dimensions is
// two points of the two-dimensional Sobol sequence, each with its own shuffled order of the sequence (section 4.3, padding).
// Each block, pixel, seed and half of a pixel's samples has its own scrambles. The functions replace those of
// sampler/independent. Within a block, x and y are stratified together, and so are z and w.

// The second dimension of the sequence, with its highest digit in the lowest bit. The first dimension is the index itself. The
// generator matrix is Pascal's triangle modulo 2 (Sobol', 1967; Burley, listing 2, has its columns): digit i is the parity of
// the bits j of the index for which C(j, i) is odd. These are the j that have all the bits of i set (Lucas, 1878). The parity
// over all such j is computed one bit of j at a time.
fn second_dimension(index: vec2<u32>) -> vec2<u32> {
    var v = index;
    v ^= (v >> vec2<u32>(1u)) & vec2<u32>(0x55555555u);
    v ^= (v >> vec2<u32>(2u)) & vec2<u32>(0x33333333u);
    v ^= (v >> vec2<u32>(4u)) & vec2<u32>(0x0f0f0f0fu);
    v ^= (v >> vec2<u32>(8u)) & vec2<u32>(0x00ff00ffu);
    v ^= (v >> vec2<u32>(16u)) & vec2<u32>(0x0000ffffu);
    return v;
}

// The block `dimension` of a sample: four stratified random words. The even and the odd runs are two halves with scrambles of
// their own, so the difference of the halves gives the error (src/film.rs).
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    let run = sample / RUN_LENGTH;
    let index = (run >> 1u) * RUN_LENGTH + sample % RUN_LENGTH;
    let seeds = pcg4d(vec4<u32>(pixel, run & 1u, dimension, seed));
    // The seeds of the shuffles, from those of the scrambles by one more hashing step.
    let turned = (seeds.zx ^ (seeds.zx >> vec2<u32>(15u))) * 0x9e3779b1u;
    let shuffles = turned ^ (turned >> vec2<u32>(13u));
    // The index is reversed, so that its high bits decide about its low ones. Then aligned blocks of the sequence stay
    // together. (Only two of the four lanes are used.)
    let index_reversed = vec4<u32>(reverseBits(index));
    let shuffled = reverseBits(nested_permutation(index_reversed, shuffles.xyxy).xy);
    let second = second_dimension(shuffled);
    return reverseBits(nested_permutation(vec4<u32>(shuffled.x, second.x, shuffled.y, second.y), seeds));
}

// The block `dimension` of a sample: four stratified uniform numbers in [0, 1).
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
