// A random permutation of words, in which the bits below a bit decide whether it is flipped. Read from the lowest bit on, this
// is Owen's scrambling ("Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995, section 3). Sums and products have this
// form: Laine and Karras, "Stratified Sampling for Stochastic Transparency", EGSR 2011, section 3.1.
// The affine map alone, with a random summand and a random odd factor, gives any two words the joint distribution of Owen's
// scrambling in the first 15 bits. The variance depends on this distribution (Owen, "Scrambled net variance for integrals of
// smooth functions", Annals of Statistics 25(4), 1997, section 2). Own derivation: for two words that first differ in bit k,
// the summand makes the bits of one word uniform, and the factor makes the bits above k of their difference uniform.
// The other steps make the map non-affine. Their factors are even, so each step is a permutation. A random search found the
// factors: each bit flips every higher bit with probability 1/2 within noise.
fn nested_permutation(words: vec4<u32>, seeds: vec4<u32>) -> vec4<u32> {
    var v = words ^ (words * 0xab13244eu);
    v += seeds;
    v *= (seeds >> vec4<u32>(16u)) | vec4<u32>(1u);
    v ^= v * 0xdebcc604u;
    v ^= v * 0x8e0cd510u;
    return v;
}
