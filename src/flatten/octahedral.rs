//! Directions in one word.

use glam::Vec3;

/// Encodes a unit vector with the octahedral map. shaders/lib/octahedral decodes it.
pub fn octahedral(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = match n.z < 0.0 {
        true => ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)),
        false => (n.x, n.y),
    };
    let word = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16;
    u32::from(word(x)) | u32::from(word(y)) << 16
}
