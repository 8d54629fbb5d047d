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

// A sample's half, and its index there. The even and the odd runs are two halves with scrambles of their own, so the difference of the halves
// gives the error (src/film.rs).
fn half_of_sample(sample: u32) -> u32 {
    return (sample / RUN_LENGTH) & 1u;
}

fn index_in_half(sample: u32) -> u32 {
    return ((sample / RUN_LENGTH) >> 1u) * RUN_LENGTH + sample % RUN_LENGTH;
}

fn seeds_of_block(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    return pcg4d(vec4<u32>(pixel, half_of_sample(sample), dimension, seed));
}

// The places of a sample in the shuffled orders of the block's two points.
fn shuffled_indices(sample: u32, seeds: vec4<u32>) -> vec2<u32> {
    // The seeds of the shuffles, from those of the scrambles by one more hashing step.
    let turned = (seeds.zx ^ (seeds.zx >> vec2<u32>(15u))) * 0x9e3779b1u;
    let shuffles = turned ^ (turned >> vec2<u32>(13u));
    // The index is reversed, so that its high bits decide about its low ones. Then aligned blocks of the sequence stay
    // together. (Only two of the four lanes are used.)
    let index_reversed = vec4<u32>(reverseBits(index_in_half(sample)));
    return reverseBits(nested_permutation(index_reversed, shuffles.xyxy).xy);
}

// The block `dimension` of a sample: four stratified random words.
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {
    let seeds = seeds_of_block(pixel, sample, dimension, seed);
    let shuffled = shuffled_indices(sample, seeds);
    let second = second_dimension(shuffled);
    return reverseBits(nested_permutation(vec4<u32>(shuffled.x, second.x, shuffled.y, second.y), seeds));
}

// Each two bits of a word are an element h A + l of the field of four elements, and A A = A + 1. Returns each times A.
fn times_generator(word: u32) -> u32 {
    let high = (word >> 1u) & 0x55555555u;
    return ((word << 1u) & 0xaaaaaaaau) ^ (high << 1u) ^ high;
}

// A third dimension. In base 4, the three are a (0,3)-sequence: the first two are those of the matrices I and C(j, i) A^0, but for a
// permutation of digits, and this one has C(j, i) A^(j - i) (Niederreiter, "Point sets and sequences with small discrepancy", Monatshefte für
// Mathematik 104, 1987; Ahmed, Pharr, Ostromoukhov and Huang, "SZ Sequences", ACM TOG 44(6), 2025, have it as bits). As above,
// one bit of j at a time; A^(2^k) is A or A A in turn.
fn third_dimension(index: u32) -> u32 {
    var v = index;
    v ^= times_generator((v >> 2u) & 0x33333333u);
    v ^= times_generator(times_generator((v >> 4u) & 0x0f0f0f0fu));
    v ^= times_generator((v >> 8u) & 0x00ff00ffu);
    v ^= times_generator(times_generator((v >> 16u) & 0x0000ffffu));
    return v;
}

// The eighth of [0, 1) in which a fifth number of the block lies, 0 to 7. It is stratified together with x and y.
fn random_eighth(pixel: u32, sample: u32, dimension: u32, seed: u32) -> u32 {
    let seeds = seeds_of_block(pixel, sample, dimension, seed);
    let third = third_dimension(shuffled_indices(sample, seeds).x);
    return reverseBits(nested_permutation(vec4<u32>(third), vec4<u32>(pcg4d(seeds).x)).x) >> 29u;
}

// Each aligned block of eight points has one in each eighth. So the part of the samples that has `count` eighths, from `first` on, has an order
// without gaps. Returns the sample that has this place in the order of all: with its numbers, in blocks of its own, the part is stratified as
// all samples are.
fn sample_of_part(sample: u32, eighth: u32, first: u32, count: u32) -> u32 {
    let index = index_in_half(sample) / 8u * count + eighth - first;
    return (index / RUN_LENGTH * 2u + half_of_sample(sample)) * RUN_LENGTH + index % RUN_LENGTH;
}

// The block `dimension` of a sample: four stratified uniform numbers in [0, 1).
fn random4(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<f32> {
    return unit_interval(random_words(pixel, sample, dimension, seed));
}
