//! Quads of many sizes, and rays at them.

use glam::DVec3;
use gpu_rt::data::Quad;

use super::scenes::{flat, triple};
use super::stats::Random;
use super::trace::In;
use super::vectors::{decades, exact, unit};

pub fn quad_text(corner: DVec3, u: DVec3, v: DVec3) -> String {
    format!("Quad(corner: {}, u: {}, v: {}, material: \"m\")", triple(corner), triple(u), triple(v))
}

/// Parallelograms with a longer side of 1e-4 to 1e5, half of them up to 10^`aspect` times as long as wide, their angles from 30 to 150
/// degrees, and their corners at distances from the origin within these decades of the longer side.
pub fn assorted(random: &mut Random, count: usize, aspect: f64, distance: (f64, f64)) -> Vec<Quad> {
    let texts: Vec<String> = (0..count)
        .map(|i| {
            let longer = decades(random, -4.0, 5.0);
            let shorter = longer / if i % 2 == 0 { 1.0 } else { decades(random, 0.0, aspect) };
            let u = unit(random);
            let sideways = u.cross(unit(random)).normalize();
            let skew = (2.0 * random.uniform() - 1.0) * 0.866;
            let v = skew * u + (1.0 - skew * skew).sqrt() * sideways;
            let corner = longer * decades(random, distance.0, distance.1) * unit(random);
            match i % 3 {
                0 => quad_text(corner, longer * u, shorter * v),
                _ => quad_text(corner, shorter * u, longer * v),
            }
        })
        .collect();
    flat(&texts).shapes.quads
}

/// Rays at points of the quads' planes on the quads and a little outside, whose cosines with the normal are within these decades, from
/// distances within these decades of the longer side.
pub fn rays_at(
    random: &mut Random,
    quads: &[Quad],
    count: usize,
    cosines: (f64, f64),
    distances: (f64, f64),
) -> Vec<In> {
    (0..count)
        .map(|i| {
            let quad = &quads[i % quads.len()];
            let (corner, u, v) = (exact(quad.corner), exact(quad.u), exact(quad.v));
            let (a, b) = (1.1 * random.uniform() - 0.05, 1.1 * random.uniform() - 0.05);
            let target = corner + a * u + b * v;
            let normal = u.cross(v).normalize();
            let cos = decades(random, cosines.0, cosines.1) * if i % 2 == 0 { 1.0 } else { -1.0 };
            let along = normal.cross(unit(random)).normalize();
            let away = cos * normal + (1.0 - cos * cos).sqrt() * along;
            let origin = target + u.length().max(v.length()) * decades(random, distances.0, distances.1) * away;
            In::new(i % quads.len(), origin, -away)
        })
        .collect()
}
