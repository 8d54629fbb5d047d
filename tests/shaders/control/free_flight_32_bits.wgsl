// Wrong on purpose: a word rounded to a float, which can be 1.
fn optical_depth(bits: vec2<u32>) -> f32 {
    return -log(1.0 - f32(bits.x) * 0x1p-32f);
}
