//@ use bind/texels
// Three linear codes in a word, red in the lowest byte. The factor is 1/255 (src/bitmap.rs).
fn linear_texel(first: u32, index: u32) -> vec3<f32> {
    let codes = texels[first + index];
    return vec3<f32>(vec3<u32>(codes & 255u, (codes >> 8u) & 255u, (codes >> 16u) & 255u)) * 0.003921569;
}
