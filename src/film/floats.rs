//! Floats of sums.

/// 2^exponent, exact while it is a normal number.
pub(super) fn exp2(exponent: i32) -> f64 {
    2f64.powi(exponent)
}

/// `value` as f32; saturates at ±f32::MAX.
pub(super) fn to_f32(value: f64) -> f32 {
    (value as f32).clamp(f32::MIN, f32::MAX)
}
