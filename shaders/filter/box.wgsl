//@ alternative filter when filter.box
// Where a pixel takes a sample, in pixels from its left upper corner: anywhere in its square.
fn filter_point(u: vec2<f32>) -> vec2<f32> {
    return u;
}
