//@ alternative filter when filter.tent
// A point around the middle of a pixel with the density of a tent, (1 - |x|) (1 - |y|), two pixels wide: each half is a square root.
fn filter_point(u: vec2<f32>) -> vec2<f32> {
    let rising = sqrt(2.0 * u) - 0.5;
    let falling = 1.5 - sqrt(2.0 - 2.0 * u);
    return select(falling, rising, u < vec2<f32>(0.5));
}
