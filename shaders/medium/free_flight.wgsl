fn optical_depth(bits: vec2<u32>) -> f32 {
    let u = f32(bits.x >> 8u) * 0x1p-24f;
    return -log(1.0 - u);
}
