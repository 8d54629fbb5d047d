//@ use bind/texels
// Three floats.
fn float_texel(first: u32, index: u32) -> vec3<f32> {
    let at = first + index * 3u;
    return bitcast<vec3<f32>>(vec3<u32>(texels[at], texels[at + 1u], texels[at + 2u]));
}
