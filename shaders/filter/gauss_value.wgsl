//@ implements filter_value when filter.gauss
//@ use filter/gauss
// The Gaussian of filter/gauss.
fn filter_value(at: vec2<f32>) -> f32 {
    let distance2 = dot(at, at);
    return select(0.0, exp(-2.0 * distance2) * (2.0 / (PI * WITHIN)), distance2 < 2.25);
}
