//! Vectors between the device's f32 and the oracles' f64, random directions, and quantiles.

use glam::DVec3;

use super::stats::Random;

/// 2^-24: the relative error of one correctly rounded operation in f32.
pub const U: f64 = 1.0 / (1u32 << 24) as f64;

/// The exact value of what the device was given or gave.
pub fn exact(v: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

/// Rounded to f32.
pub fn rounded(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Uniform over the unit sphere.
pub fn unit(random: &mut Random) -> DVec3 {
    let z = 2.0 * random.uniform() - 1.0;
    let phi = std::f64::consts::TAU * random.uniform();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// 10 to an exponent uniform between the two.
pub fn decades(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * random.uniform())
}

/// The value below which this share of the values lies.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    assert!(!values.is_empty());
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}
