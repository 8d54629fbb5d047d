//@ relies on uniforms
//@ relies on logarithm
// The optical depth to the next event in a medium.

// Exponentially distributed with mean 1: -ln(1 - U), where U is 48 random bits, the upper 24 of each word. One word alone
// knows no depths between 0 and 6e-8 nor beyond 16.6: thin media would scatter too often near an edge, thick ones let too
// little through. Where U is small, by its series, since a logarithm near 1 is promised to 2^-21 only (WGSL section
// 15.7.4); its next term is below 2^-28. Elsewhere 1 - U is made from integers, so that none of its digits cancel.
// Below 33.3, and 0 once in 2^48.
fn optical_depth(bits: vec2<u32>) -> f32 {
    let word = bits >> vec2<u32>(8u);
    let u = f32(word.x) * 0x1p-24f + f32(word.y) * 0x1p-48f;
    let complement = f32(0xffffffu - word.x) * 0x1p-24f + f32(0x1000000u - word.y) * 0x1p-48f;
    let series = u * (1.0 + u * (0.5 + u * (1.0 / 3.0 + u * 0.25)));
    return select(-log(complement), series, u < 0.01);
}
