//! Skies on a square: the distribution from which directions are drawn is that of an image of latitude and longitude.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::bitmap::Bitmap;
use crate::light_distribution::MOST_COLUMNS;
use crate::threads::{cores, each};

/// The fewest columns, so that edges between few texels are found.
const FEWEST_COLUMNS: usize = 256;

/// The place of a unit vector on the square (shaders/lib/square_map.wgsl).
fn on_square(d: DVec3) -> DVec2 {
    let r = d.truncate().length() / (1.0 + d.z.abs()).sqrt();
    let share = d.y.abs().atan2(d.x.abs()) / (0.5 * PI);
    let upper = DVec2::new(r - r * share, r * share);
    let p = if d.z < 0.0 { 1.0 - DVec2::new(upper.y, upper.x) } else { upper };
    0.5 + 0.5 * p.copysign(d.truncate())
}

/// The direction of a place in an image of latitude and longitude, both from 0 to 1.
fn direction(u: f64, down: f64) -> DVec3 {
    let ((sin, cos), (sin_around, cos_around)) = ((PI * down).sin_cos(), (TAU * (u - 0.5)).sin_cos());
    DVec3::new(sin * sin_around, cos, -sin * cos_around)
}

/// The mean radiance that the square has in each texel of an image of latitude and longitude.
pub fn to_latitude_longitude(square: &Bitmap) -> Bitmap {
    let side = square.width as usize;
    let width = (4 * side).clamp(FEWEST_COLUMNS, MOST_COLUMNS);
    let height = width / 2;
    // As many samples as find each texel of the square.
    let times = (4 * side).div_ceil(width).max(2);
    let place = |index: usize, step: usize, of: usize| (index as f64 + (step as f64 + 0.5) / times as f64) / of as f64;
    let rows = each(cores(), 0..height, |row| {
        let radiance = |column: usize, step: usize| {
            let d = direction(place(column, step % times, width), place(row, step / times, height));
            let [x, y] = (side as f64 * on_square(d)).to_array().map(|x| (x as usize).min(side - 1));
            DVec3::from_array(square.texel(y * side + x).map(f64::from))
        };
        let mean = |column| {
            let sum: DVec3 = (0..times * times).map(|step| radiance(column, step)).sum();
            (sum / (times * times) as f64).as_vec3().to_array()
        };
        (0..width).map(mean).collect::<Vec<_>>()
    });
    Bitmap::of_floats(width as u32, height as u32, rows.into_iter().flatten())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clarberg's map from the square to the sphere, by which the texels of a file are made.
    fn on_sphere(p: DVec2) -> DVec3 {
        let p = 2.0 * p - 1.0;
        let q = p.abs();
        let signed = 1.0 - q.x - q.y;
        let r = 1.0 - signed.abs();
        let phi = if r == 0.0 { 0.0 } else { ((q.y - q.x) / r + 1.0) * PI / 4.0 };
        let (long, z) = (r * (2.0 - r * r).sqrt(), (1.0 - r * r).copysign(signed));
        DVec3::new((phi.cos() * long).copysign(p.x), (phi.sin() * long).copysign(p.y), z)
    }

    #[test]
    fn the_square_is_the_sphere() {
        for index in 0..10_000 {
            let p = DVec2::new(f64::from(index % 100) + 0.5, f64::from(index / 100) + 0.5) / 100.0;
            let d = on_sphere(p);
            assert!((d.length() - 1.0).abs() < 1e-12);
            assert!((on_square(d) - p).length() < 1e-12, "{p}: {d}, {}", on_square(d));
        }
    }

    /// A lamp of one texel in a dark sky has its solid angle, where it is, within the samples that find its edges.
    #[test]
    fn a_lamp_is_where_the_square_has_it() {
        let lamp = 17 * 64 + 40;
        let square =
            Bitmap::of_floats(64, 64, (0..64 * 64).map(|index| [0.0, f32::from(u8::from(index == lamp)), 0.0]));
        let sky = to_latitude_longitude(&square);
        let (width, height) = (f64::from(sky.width), f64::from(sky.height));
        let mut sum = DVec3::ZERO;
        for (index, texel) in sky.texels().enumerate() {
            let (u, down) = (index as f64 % width + 0.5, (index as f64 / width).floor() + 0.5);
            let solid = TAU * PI / (width * height) * (PI * down / height).sin();
            sum += f64::from(texel[1]) * solid * direction(u / width, down / height);
        }
        assert!((sum.length() / (4.0 * PI / 4096.0) - 1.0).abs() < 0.2, "{sum}");
        assert!(sum.normalize().dot(on_sphere(DVec2::new(40.5, 17.5) / 64.0)) > 0.99995, "{sum}");
    }
}
