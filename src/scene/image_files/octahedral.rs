//! Skies on a square, as pbrt-v4 has them: the equal-area octahedral map of Clarberg ("Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD",
//! Journal of Graphics Tools 13(3), 2008). The kernels know latitude and longitude alone, so such a sky is resampled.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::budget::Budget;
use crate::bitmap::Bitmap;
use crate::data::luminance;
use crate::printable::percent;
use crate::threads::{cores, each};

/// The usual bounds of the width: the edges of few texels stay sharp, and many fit a device that binds 128 MiB.
const WIDTHS: [u32; 2] = [1024, 4096];

/// Weights of samples are integers, whose sums are the same in any order.
const UNITS: f64 = (1u64 << 32) as f64;

/// The size of a square of this side, resampled: its texels are smaller than those of the square.
fn size(side: u32) -> (u32, u32) {
    let width = side.saturating_mul(4).clamp(WIDTHS[0], WIDTHS[1]).max(side.saturating_mul(2));
    (width, width / 2)
}

/// Where a unit vector lies on the square, both from 0 to 1: +z in the middle, +x at the right, +y below, -z in the corners.
fn on_square(d: DVec3) -> DVec2 {
    let r = (1.0 - d.z.abs()).max(0.0).sqrt();
    let share = d.y.abs().atan2(d.x.abs()) / (0.5 * PI);
    let (u, v) = (r * (1.0 - share), r * share);
    let (u, v) = if d.z < 0.0 { (1.0 - v, 1.0 - u) } else { (u, v) };
    0.5 + 0.5 * DVec2::new(u.copysign(d.x), v.copysign(d.y))
}

/// The direction of a place in an image of latitude and longitude, both from 0 to 1.
fn direction(u: f64, down: f64) -> DVec3 {
    let ((sin, cos), (sin_around, cos_around)) = ((PI * down).sin_cos(), (TAU * (u - 0.5)).sin_cos());
    DVec3::new(sin * sin_around, cos, -sin * cos_around)
}

/// Resamples a square of one radiance a texel: each new texel has the mean of its place, and each old one keeps its light. A warning says what that changes.
pub fn resampled(square: &Bitmap, budget: &Budget) -> Result<Bitmap, String> {
    let side = square.width;
    if square.height != side {
        return Err(format!(
            "expected a square, as its layout is Octahedral, found {side} by {} texels",
            square.height
        ));
    }
    let (width, height) = size(side);
    let bytes = |texels| size_of::<[f32; 3]>() as u64 * texels as u64;
    budget.check((width as usize, height as usize), bytes, square.bytes())?;
    let times = (8 * side).div_ceil(width).max(2);
    let texel_at = |column: f64, row: f64| {
        let p = f64::from(side) * on_square(direction(column / f64::from(width), row / f64::from(height)));
        let [x, y] = p.to_array().map(|x| (x as usize).min(side as usize - 1));
        y * side as usize + x
    };
    let radiance = |texel: usize| DVec3::from_array(square.texel(texel).map(f64::from));
    let place = |index: u32, step: u32| f64::from(index) + (f64::from(step) + 0.5) / f64::from(times);
    let samples = |column: u32, row: u32| {
        (0..times * times).map(move |step| texel_at(place(column, step % times), place(row, step / times)))
    };
    let solid = |row: f64| (PI * row / f64::from(height)).sin();
    // A lamp of one texel keeps its light: its samples weigh what it is of the sphere.
    let parts = cores().min(4) as u32;
    let of_rows = each(cores(), 0..parts, |part| {
        let mut weights = vec![0; square.len()];
        for row in (part..height).step_by(parts as usize) {
            let of_texels = (0..width).flat_map(|column| samples(column, row));
            let own = (UNITS * solid(f64::from(row) + 0.5)) as u64;
            of_texels.for_each(|texel| weights[texel] += own);
        }
        weights
    });
    let sum = |texel| of_rows.iter().map(|weights| weights[texel]).sum::<u64>() as f64;
    let weights: Vec<f64> = (0..square.len()).map(sum).collect();
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    let rows = each(cores(), 0..height, |row| {
        let mean_of = |column: u32| {
            let sum: DVec3 = samples(column, row).map(|texel| mean / weights[texel] * radiance(texel)).sum();
            (sum / f64::from(times * times)).as_vec3().to_array()
        };
        (0..width).map(mean_of).collect::<Vec<_>>()
    });
    // Where four texels meet, blending them changes most.
    let differences = rows.windows(2).enumerate().map(|(row, pair)| {
        let both = pair[0].windows(2).zip(pair[1].windows(2)).enumerate().map(|(column, (above, below))| {
            let four = above.iter().chain(below).map(|texel| luminance(texel.map(f64::from)));
            let was = luminance(radiance(texel_at(column as f64 + 1.0, row as f64 + 1.0)).to_array());
            DVec2::new((0.25 * four.sum::<f64>() - was).abs(), was)
        });
        solid(row as f64 + 1.0) * both.sum::<DVec2>()
    });
    let sum: DVec2 = differences.sum();
    let mut made = Bitmap::of_floats(width, height, rows.into_iter().flatten());
    let change = if sum.y > 0.0 { sum.x / sum.y } else { 0.0 };
    let message = format!(
        "its square of {side} by {side} texels becomes {width} by {height} of latitude and longitude, which changes a direction's light by \
         {} of the mean",
        percent(change)
    );
    made.warning = Some(square.warning.iter().cloned().chain([message]).collect::<Vec<_>>().join("; "));
    Ok(made)
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
            assert!((on_square(d) - p).length() < 1e-7, "{p}: {d}, {}", on_square(d));
        }
        let middles =
            [(DVec3::Z, [0.5, 0.5]), (DVec3::X, [1.0, 0.5]), (DVec3::Y, [0.5, 1.0]), (DVec3::NEG_X, [0.0, 0.5])];
        for (d, at) in middles {
            assert!((on_square(d) - DVec2::from_array(at)).length() < 1e-12, "{d}");
        }
    }

    /// Its light from all directions, and what a white plane with this normal gets of it.
    fn light(sky: &Bitmap, normal: DVec3) -> [f64; 2] {
        let (width, height) = (sky.width as usize, sky.height as usize);
        let mut sums = [0.0; 2];
        for (index, texel) in sky.texels().enumerate() {
            let (u, down) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let d = direction(u / width as f64, down / height as f64);
            let solid = TAU * PI / (width * height) as f64 * (PI * down / height as f64).sin();
            sums[0] += solid * f64::from(texel[1]);
            sums[1] += solid * f64::from(texel[1]) * d.dot(normal).max(0.0);
        }
        sums
    }

    #[test]
    fn a_resampled_sky_has_the_light_of_its_square() {
        // A lamp of one texel in a dim sky: all texels are of one solid angle.
        let (side, lamp) = (64, 17 * 64 + 40);
        let texel = |index| [0.0, if index == lamp { 500.0 } else { 0.1 }, 0.0];
        let square = Bitmap::of_floats(side, side, (0..64 * 64).map(texel));
        let sky = resampled(&square, &Budget::default()).unwrap();
        assert_eq!((sky.width, sky.height), (1024, 512));
        let middle = DVec2::new(40.5, 17.5) / 64.0;
        let solid = 4.0 * PI / f64::from(side * side);
        let [all, on_plane] = light(&sky, on_sphere(middle));
        let expected = [solid * (500.0 + 0.1 * 4095.0), solid * 499.9 + PI * 0.1];
        // All light is there; on the plane the lamp's texel is not a point.
        assert!((all / expected[0] - 1.0).abs() < 1e-5, "{all} {}", expected[0]);
        assert!((on_plane / expected[1] - 1.0).abs() < 1e-3, "{on_plane} {}", expected[1]);
        assert!(sky.warning.as_ref().is_some_and(|warning| warning.contains("64 by 64 texels becomes 1024 by 512")));
        // Another axis in the middle would move the lamp.
        let [_, moved] = light(&sky, on_sphere(DVec2::new(17.5, 40.5) / 64.0));
        assert!((moved / expected[1] - 1.0).abs() > 0.3, "{moved}");
    }
}
