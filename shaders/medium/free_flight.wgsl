//@ relies on uniforms
//@ relies on logarithm
// Samples the optical depth of a free flight, up to the next event in a medium.

// Exponentially distributed with mean 1: -ln(1 - U), where U has 48 random bits, the upper 24 of each word. One word alone
// could give no depth between 0 and 6e-8 and none beyond 16.6: thin media would scatter too often near an edge, and thick media
// would transmit too little. Small U use the series, because WGSL promises only an error of 2^-21 for a logarithm near 1
// (section 15.7.4). The first term that the series leaves out is below 2^-28. For other U, 1 - U is computed from integers, so
// there is no cancellation. The result is below 33.3, and it is 0 once in 2^48.
fn optical_depth(bits: vec2<u32>) -> f32 {
    let word = bits >> vec2<u32>(8u);
    let u = f32(word.x) * 0x1p-24f + f32(word.y) * 0x1p-48f;
    let complement = f32(0xffffffu - word.x) * 0x1p-24f + f32(0x1000000u - word.y) * 0x1p-48f;
    let series = u * (1.0 + u * (0.5 + u * (1.0 / 3.0 + u * 0.25)));
    return select(-log(complement), series, u < 0.01);
}
