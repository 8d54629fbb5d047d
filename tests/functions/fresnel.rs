//! lib/fresnel: reflectance and refraction against f64, as the index nears 1, at total reflection and at grazing angles.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::kernel::{Kernel, Setup};
use crate::stats::Random;
use crate::vectors::{U, decades, exact, rounded, unit};

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct In {
    incoming: [f32; 3],
    eta: f32,
    normal: [f32; 3],
    contrast: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Out {
    refracted: [f32; 3],
    cos_incident: f32,
    reflectance: f32,
    cos_transmitted: f32,
    padding: [u32; 2],
}

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

/// The same for an index of the far side relative to the near one.
pub fn fresnel(c: f64, eta: f64) -> (f64, f64) {
    fresnel_of(c, eta, (eta - 1.0) * (eta + 1.0) + c * c)
}

/// How far the results may be off: what a change of eta^2 - 1 by 2 u and of the squared cosine by 4 u does to them, and
/// relatively some thirty roundings, with the 2.5 ulps of WGSL's quotients and roots in the formulas' squares.
fn allowed(c: f64, eta: f64, c_error: f64) -> (f64, f64) {
    let m = (eta - 1.0) * (eta + 1.0);
    let (reflectance, transmitted) = fresnel(c, eta);
    let (mut of_r, mut of_t) = (0.0f64, 0.0f64);
    for sign in [1.0, -1.0] {
        let c = c + sign * c_error;
        let (r, t) = fresnel_of(c, eta, m + c * c + sign * (2.0 * U * m.abs() + 4.0 * U * c * c));
        of_r = of_r.max((r - reflectance).abs());
        of_t = of_t.max((t - transmitted).abs());
    }
    (of_r + 32.0 * U * reflectance, of_t + 8.0 * U * transmitted)
}

/// Relative indices 1 +- 1e-7 .. 1 +- 0.5 and up to 4, each with its inverse.
fn etas() -> Vec<f64> {
    let mut all = vec![1.5, 2.4, 1.33, 4.0];
    for exponent in -7..=0 {
        all.extend([1.0, 2.0, 5.0].map(|digit| 1.0 + digit * 10f64.powi(exponent)));
    }
    all.retain(|eta| *eta <= 4.0);
    let inverse: Vec<f64> = all.iter().map(|eta| 1.0 / eta).collect();
    all.extend(inverse);
    all
}

/// A boundary across z, the ray in a random plane, at cosines from 1e-4 to 1 and on both sides of total reflection.
fn rows(random: &mut Random) -> Vec<(f64, In)> {
    let mut all = Vec::new();
    for eta in etas() {
        for i in 0..200 {
            let critical = (1.0 - eta * eta).max(0.0).sqrt();
            let cos = match i % 3 {
                0 => decades(random, -4.0, 0.0),
                1 => random.uniform(),
                _ => (critical * (1.0 + decades(random, -6.0, -1.0) * (1.0 - 2.0 * (i % 2) as f64))).clamp(1e-4, 1.0),
            };
            let sin = (1.0 - cos * cos).sqrt();
            let phi = std::f64::consts::TAU * random.uniform();
            let incoming = DVec3::new(sin * phi.cos(), sin * phi.sin(), -cos);
            let contrast = ((eta - 1.0) * (eta + 1.0)) as f32;
            let row = In { incoming: rounded(incoming), eta: eta as f32, normal: [0.0, 0.0, 1.0], contrast };
            all.push((eta, row));
        }
    }
    all
}

/// What was found, each in units of what is allowed.
#[derive(Debug, Default)]
struct Verdict {
    reflectance: f64,
    cos: f64,
    sum: f64,
    snell: f64,
    direction: f64,
    length: f64,
    /// Largest error of the reflectance as it is, and relatively.
    absolute: f64,
    relative: f64,
}

fn judge(kernel: &Kernel, rows: &[(f64, In)]) -> Verdict {
    let given: Vec<In> = rows.iter().map(|(_, row)| *row).collect();
    let mut found = Verdict::default();
    for ((eta, row), out) in rows.iter().zip(kernel.run::<_, Out>(&given)) {
        let c = f64::from(out.cos_incident);
        let (reflectance, transmitted) = fresnel(c, *eta);
        let (of_r, of_t) = allowed(c, *eta, 0.0);
        let (r, t) = (f64::from(out.reflectance), f64::from(out.cos_transmitted));
        let error = (r - reflectance).abs();
        found.reflectance = found.reflectance.max(error / of_r);
        found.absolute = found.absolute.max(error);
        found.relative = found.relative.max(error / reflectance);
        found.cos = found.cos.max((t - transmitted).abs() / of_t);
        if t == 0.0 {
            continue;
        }
        // What goes through, from the transmitted cosine that the shader gives: the amplitudes' squares times the ratio
        // of the beams' widths and indices.
        let through = eta * t / c * 0.5 * ((2.0 * c / (c + eta * t)).powi(2) + (2.0 * c / (eta * c + t)).powi(2));
        let of_through = of_r + through * of_t / t;
        found.sum = found.sum.max((r + through - 1.0).abs() / of_through);
        // The refracted ray: its tangent over the incoming one's is 1 / eta, to the roundings of a sum of three products
        // and of normalize, and the incoming vector's own length.
        let (incoming, refracted, n) = (exact(row.incoming), exact(out.refracted), exact(row.normal));
        found.length = found.length.max((refracted.length() - 1.0).abs() / (4.0 * U));
        let across = |v: DVec3| v - v.dot(n) * n;
        let residual = (across(refracted) * *eta - across(incoming)).length();
        found.snell = found.snell.max(residual / (eta.max(1.0) * (of_t + 8.0 * U)));
        let expected = across(incoming) / eta - transmitted * n;
        found.direction = found.direction.max((refracted - expected).length() / (of_t + 8.0 * U));
    }
    found
}

impl Verdict {
    fn worst(&self) -> f64 {
        [self.reflectance, self.cos, self.sum, self.snell, self.direction, self.length].into_iter().fold(0.0, f64::max)
    }
}

#[test]
fn fresnel_and_snell_hold_near_every_edge() {
    let rows = rows(&mut Random(53));
    let found = judge(&Kernel::new("test/fresnel"), &rows);
    assert!(found.worst() <= 1.0, "{found:?}");
    // The textbook's form is 14 % off at an index of 1 + 1e-6.
    let control =
        |with| Kernel::with("test/fresnel", &Setup { replaced: &[("lib/fresnel", with)], ..Setup::default() });
    let found = judge(&control("test/control/fresnel_textbook"), &rows);
    assert!(found.reflectance > 10.0 && found.relative > 0.1, "{found:?}");
    // Schlick's approximation is another function: wrong by 0.2 at 1.1, and by 1 as the index nears 1.
    let found = judge(&control("test/control/fresnel_schlick"), &rows);
    assert!(found.reflectance > 1e3 && found.absolute > 0.5 && found.sum > 1e3, "{found:?}");
}

#[test]
fn an_index_of_one_reflects_nothing() {
    let mut random = Random(54);
    let rows: Vec<In> = (0..1000)
        .map(|i| {
            // The last along the boundary, where every other index reflects all.
            let direction = if i == 999 { DVec3::X } else { unit(&mut random) };
            In { incoming: rounded(-direction.abs()), eta: 1.0, normal: [0.0, 0.0, 1.0], contrast: 0.0 }
        })
        .collect();
    for (row, out) in rows.iter().zip(Kernel::new("test/fresnel").run::<_, Out>(&rows)) {
        assert_eq!((out.reflectance, out.cos_transmitted), (0.0, out.cos_incident), "{row:?}");
    }
}
