//@ implements filter_value when filter.mitchell
// The cubic of filter/mitchell along an axis: Mitchell and Netravali, equation 8, with B = C = 1/3.
fn mitchell(distance: f32) -> f32 {
    let x = abs(distance);
    let near = 8.0 / 9.0 + x * x * (x * (7.0 / 6.0) - 2.0);
    let y = 2.0 - x;
    let far = y * y * (y * (7.0 / 18.0) - 1.0 / 3.0);
    return select(select(far, near, x < 1.0), 0.0, x >= 2.0);
}

fn filter_value(at: vec2<f32>) -> f32 {
    return mitchell(at.x) * mitchell(at.y);
}
