//@ use bind/texels
// One linear code, four texels in a word. The factor is 1/255 (src/bitmap.rs).
fn number_texel(first: u32, index: u32) -> vec3<f32> {
    let codes = texels[first + index / 4u];
    return vec3<f32>(f32((codes >> (8u * (index % 4u))) & 255u) * 0.003921569);
}
