//! Functions of the shaders in f64.

use std::f64::consts::PI;

use glam::DVec3;

use super::kernel::{Expression, MODULE, Plant};
use super::vectors::U;

/// Share of unpolarised light that a boundary reflects, and the transmitted cosine, for cos^2 of the transmitted ray times
/// eta^2 = `g2`: Fresnel's formulas as they stand (Born and Wolf, section 1.5.2).
pub fn fresnel_of(c: f64, eta: f64, g2: f64) -> (f64, f64) {
    if g2 <= 0.0 {
        return (1.0, 0.0);
    }
    let t = g2.sqrt() / eta;
    let s = (c - eta * t) / (c + eta * t);
    let p = (eta * c - t) / (eta * c + t);
    (0.5 * (s * s + p * p), t)
}

/// Schlick's approximation with the cosine of the incident side, as "Ray Tracing in One Weekend" has it.
pub const INCIDENT_SCHLICK: [Plant; 2] = [
    ("lib/fresnel", MODULE, "lib/fresnel_schlick"),
    ("lib/fresnel", "select(cos_transmitted, cos_incident, eta >= 1.0)", "cos_incident"),
];

/// Fresnel's reflectances for an index of the far side relative to the near one.
pub fn fresnel(c: f64, eta: f64) -> (f64, f64) {
    fresnel_of(c, eta, (eta - 1.0) * (eta + 1.0) + c * c)
}

/// Density of the metal lobe's directions over the sphere at an angle with its axis: (d+^3 - d-^3) / (4 pi fuzz^3), for a
/// line through the eye of the lobe is within the ball of radius fuzz around the mirror direction from d- to d+.
pub fn metal_density(theta: f64, fuzz: f64) -> f64 {
    let root2 = fuzz * fuzz - theta.sin().powi(2);
    if root2 <= 0.0 || theta >= 0.5 * PI {
        return 0.0;
    }
    let (cos, root) = (theta.cos(), root2.sqrt());
    let nearer = if fuzz >= 1.0 && root > cos { 0.0 } else { cos - root };
    ((cos + root).powi(3) - nearer.powi(3)) / (4.0 * PI * fuzz.powi(3))
}

/// PCG4D, from listing 3 of Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020.
pub fn pcg4d(key: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = key.map(|k| k.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |x: &mut u32, y: &mut u32, z: &mut u32, w: &mut u32| {
        *x = x.wrapping_add(y.wrapping_mul(*w));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
        *w = w.wrapping_add(y.wrapping_mul(*z));
    };
    mix(&mut x, &mut y, &mut z, &mut w);
    for word in [&mut x, &mut y, &mut z, &mut w] {
        *word ^= *word >> 16;
    }
    mix(&mut x, &mut y, &mut z, &mut w);
    [x, y, z, w]
}

/// How far the noise may be off in f32.
pub const NOISE_ERROR: f64 = 20.0 * U;

/// The noise at a point, and turbulence.
pub const NOISE: Expression<'_> =
    ["lib/perlin", "vec4<f32>", "vec2<f32>", "vec2<f32>(perlin(given.xyz), turbulence(given.xyz))"];

/// No fade, so that the slope jumps at the lattice; truncated cells, wrong below zero; a period of 255; and one octave.
pub const LINEAR_NOISE: [Plant; 5] = [
    ("lib/perlin", "bitcast<vec3<u32>>(cell) & vec3<u32>(255u)", "vec3<u32>((cell % 255 + 255) % 255)"),
    ("lib/perlin", "floor(point)", "trunc(point)"),
    ("lib/perlin", "base - 256.0 * floor(base * 0x1p-8f)", "base"),
    ("lib/perlin", "f * f * (3.0 - 2.0 * f)", "f"),
    ("lib/perlin", "octave < 7", "octave < 1"),
];

/// The gradient at a lattice point: the hash of its coordinates modulo 256 as a point of the cube, made unit.
fn gradient(cell: [i64; 3]) -> DVec3 {
    let [x, y, z] = cell.map(|c| c.rem_euclid(256) as u32);
    let bits = pcg4d([x, y, z, 0x9e37_79b9]);
    let coordinate = |word: u32| (2.0 * f64::from(word >> 8) + 1.0) / 16_777_216.0 - 1.0;
    DVec3::new(coordinate(bits[0]), coordinate(bits[1]), coordinate(bits[2])).normalize()
}

/// Gradient noise in f64, with the cubic fade.
pub fn perlin(p: DVec3) -> f64 {
    let base = p.floor();
    let f = p - base;
    let fade = f * f * (3.0 - 2.0 * f);
    let mut sum = 0.0;
    for corner in 0..8 {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2];
        let at = DVec3::new(step[0] as f64, step[1] as f64, step[2] as f64);
        let weight = at * fade + (1.0 - at) * (1.0 - fade);
        let cell = [base.x as i64 + step[0], base.y as i64 + step[1], base.z as i64 + step[2]];
        sum += weight.element_product() * gradient(cell).dot(f - at);
    }
    sum
}

/// The absolute value of seven octaves, each half as strong and twice as fine as the one before.
pub fn turbulence(p: DVec3) -> f64 {
    (0..7).map(|octave| perlin(p * f64::from(1 << octave)) / f64::from(1 << octave)).sum::<f64>().abs()
}
