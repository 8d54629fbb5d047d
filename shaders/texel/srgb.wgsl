//@ use bind/texels
// Three sRGB codes in a word, red in the lowest byte. Their linear values are in a table before all images.
fn srgb_texel(first: u32, index: u32) -> vec3<f32> {
    let codes = texels[first + index];
    let red = texels[codes & 255u];
    let green = texels[(codes >> 8u) & 255u];
    let blue = texels[(codes >> 16u) & 255u];
    return bitcast<vec3<f32>>(vec3<u32>(red, green, blue));
}
