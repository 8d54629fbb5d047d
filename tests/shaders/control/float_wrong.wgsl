// Wrong on purpose: a guard that takes infinities for NaN, and a neighbour by a relative step, which zero and rounding
// lead astray.
fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u;
}

fn is_infinite(x: f32) -> bool {
    return abs(x) > 0x1p126f;
}

fn next_float(x: f32, toward: f32) -> f32 {
    return x + sign(toward) * abs(x) * 0x1p-23f;
}
