// A random permutation of words that lets each bit be flipped by what the bits below it are: read from its lowest bit on, a
// word is scrambled as Owen does it ("Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995, section 3). Sums and products
// have this form: Laine and Karras, "Stratified Sampling for Stochastic Transparency", EGSR 2011, section 3.1. The affine map alone, of
// a random summand and odd factor, gives any two words the joint distribution that Owen asks for in the first 15 bits, on
// which the variance depends (Owen, "Scrambled net variance for integrals of smooth functions", Annals of Statistics 25(4),
// 1997, section 2; own derivation: for words that first differ in bit k the summand makes the bits of one uniform, the factor
// those above k of the difference). The other steps make it anything but affine. Their factors are even, so that each is a
// permutation; found by a random search, such that every bit flips every higher one with probability 1/2 within noise.
fn nested_permutation(words: vec4<u32>, seeds: vec4<u32>) -> vec4<u32> {
    var v = words ^ (words * 0xab13244eu);
    v += seeds;
    v *= (seeds >> vec4<u32>(16u)) | vec4<u32>(1u);
    v ^= v * 0xdebcc604u;
    v ^= v * 0x8e0cd510u;
    return v;
}
