//! Tables for light sampling: alias tables, and the distribution of the sky's radiance.

use std::f64::consts::PI;

use crate::bitmap::Bitmap;
use crate::data::{AliasEntry, luminance};

/// The number of values of a uniform number on the device: the multiples of 2^-24.
const UNIFORMS: u64 = 1 << 24;

/// The most entries of a table. Each entry gets at least one of the 2^24 uniform numbers. A full table needs 1/16 of
/// them for this minimum.
pub const MAX_ENTRIES: usize = 1 << 20;

/// The most cells of the sky's grid. 2^16 cells are 1 MiB of entries, with 256 uniform numbers per cell on average.
pub const MAX_CELLS: usize = 1 << 16;

/// An entry of a table for the alias method (shaders/light/alias.wgsl).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Draw {
    /// The entry itself is drawn if the rest of the uniform number is below this.
    pub threshold: f32,
    /// The entry that is drawn otherwise.
    pub alias: u32,
    /// The exact probability that this entry is drawn, directly or as an alias.
    pub probability: f32,
    /// The probability of the entry that the alias names.
    pub alias_probability: f32,
}

/// The number of uniform numbers for each weight: in proportion, but at least one for each positive weight.
fn apportion(weights: &[f64]) -> Option<Vec<u64>> {
    if weights.len() > MAX_ENTRIES || weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
        return None;
    }
    // Relative to the largest weight, the sum neither overflows nor underflows.
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let sum: f64 = weights.iter().map(|w| w / largest).sum();
    if largest == 0.0 {
        return None;
    }
    let positive = weights.iter().filter(|w| **w > 0.0).count() as u64;
    let excess = |w: f64| ((w / largest) / sum * UNIFORMS as f64 - 1.0).max(0.0);
    let sum_of_excess: f64 = weights.iter().map(|w| excess(*w)).sum();
    let rest = UNIFORMS - positive;
    // The running totals are rounded, so that every part is within one of its exact share and the sum is exact.
    let last = weights.iter().rposition(|w| excess(*w) > 0.0)?;
    let (mut total, mut given) = (0.0, 0);
    let parts = weights.iter().enumerate().map(|(i, &w)| {
        total += excess(w);
        let until = if i >= last { rest } else { (((total / sum_of_excess) * rest as f64) as u64).min(rest) };
        let part = until - given;
        given = until;
        part + u64::from(w > 0.0)
    });
    Some(parts.collect())
}

/// A table for the alias method. Probabilities are in proportion to weights, rounded to multiples of 2^-24, so that they are
/// exactly the probabilities with which the device draws.
///
/// None if no weight is positive, if a weight is negative or not finite, or if there are more than [`MAX_ENTRIES`].
pub fn alias_table(weights: &[f64]) -> Option<Vec<Draw>> {
    let wanted = apportion(weights)?;
    let count = wanted.len() as u64;
    // Entry i is found by the uniform numbers k from ceil(i 2^24 / n) on. k n = i 2^24 + rest, and the rest grows
    // by n with each k.
    let first = |i: u64| (i * UNIFORMS).div_ceil(count);
    // Vose, "A Linear Algorithm for Generating Random Numbers with a Given Distribution", IEEE Trans. Softw. Eng. 17(9),
    // 1991, in integers: entries that need fewer uniform numbers than find them give the others to entries that need more.
    let found_by: Vec<u64> = (0..count).map(|i| first(i + 1) - first(i)).collect();
    let mut left = wanted.clone();
    let (mut less, mut more) = (Vec::new(), Vec::new());
    for (i, (wants, found)) in wanted.iter().zip(&found_by).enumerate() {
        if wants < found { less.push(i) } else { more.push(i) }
    }
    let mut own = found_by.clone();
    let mut alias: Vec<usize> = (0..wanted.len()).collect();
    while let Some(i) = less.pop() {
        // The sums are equal, so that if one entry needs fewer, another needs more.
        let Some(&from) = more.last() else { break };
        let missing = found_by[i] - left[i];
        // One that needs all numbers that find it, but is found by one fewer, has none to give.
        if left[from] < missing {
            more.pop();
            less.push(i);
            continue;
        }
        own[i] = left[i];
        alias[i] = from;
        left[from] -= missing;
        if left[from] < found_by[from] {
            more.pop();
            less.push(from);
        }
    }
    let share = |draws: u64| (draws as f64 / UNIFORMS as f64) as f32;
    let entry = |i: usize| {
        let rest = first(i as u64) * count - i as u64 * UNIFORMS;
        let threshold = match own[i] {
            0 => 0,
            all if all == found_by[i] => UNIFORMS,
            some => rest + (some - 1) * count + 1,
        };
        Draw {
            threshold: share(threshold),
            alias: alias[i] as u32,
            probability: share(wanted[i]),
            alias_probability: share(wanted[alias[i]]),
        }
    };
    Some((0..wanted.len()).map(entry).collect())
}

/// A table for the alias method as kernels read it: weights, and the size of what each entry stands for, by which its density is divided.
///
/// None as of [`alias_table`].
pub fn alias_entries(weights: &[f64], sizes: &[f64]) -> Option<Vec<AliasEntry>> {
    let table = alias_table(weights)?;
    let entry = |(draw, size): (&Draw, &f64)| AliasEntry {
        threshold: draw.threshold,
        alias_index: draw.alias,
        density: (f64::from(draw.probability) / size) as f32,
        alias_density: (f64::from(draw.alias_probability) / sizes[draw.alias as usize]) as f32,
    };
    Some(table.iter().zip(sizes).map(entry).collect())
}

/// The distribution of directions towards the sky: cells of a grid over its image. The weight of a cell is its mean
/// luminance, as the kernels interpolate it, times its solid angle.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyDistribution {
    pub columns: u32,
    pub rows: u32,
    /// Row by row, from the top.
    pub cells: Vec<AliasEntry>,
}

/// The texels that contribute to the interpolation between x0 and x1 (in texels), with the integral of each one's
/// weight. The weight is a tent around the texel's centre, two texels wide and 1 high.
fn tents(x0: f64, x1: f64) -> impl Iterator<Item = (i64, f64)> {
    // The integral of the tent from its start to t.
    let until = |t: f64| match t.clamp(-1.0, 1.0) {
        t if t < 0.0 => 0.5 * (t + 1.0) * (t + 1.0),
        t => 1.0 - 0.5 * (1.0 - t) * (1.0 - t),
    };
    let (first, last) = ((x0 - 0.5).floor() as i64, (x1 + 0.5).floor() as i64);
    (first..=last).filter_map(move |i| {
        let centre = i as f64 + 0.5;
        let share = until(x1 - centre) - until(x0 - centre);
        (share > 0.0).then_some((i, share))
    })
}

impl SkyDistribution {
    /// None if the image is black everywhere or empty. Negative and non-finite texels count as black.
    pub fn new(image: &Bitmap) -> Option<SkyDistribution> {
        let (w, h) = (image.width as usize, image.height as usize);
        if image.is_empty() {
            return None;
        }
        // The finest grid of complete texels with at most MAX_CELLS cells.
        let block = (1..).find(|block| w.div_ceil(*block) * h.div_ceil(*block) <= MAX_CELLS)?;
        let (columns, rows) = (w.div_ceil(block), h.div_ceil(block));
        let brightness = |texel: [f32; 3]| {
            let y = luminance(texel.map(f64::from));
            let lit = texel.iter().any(|x| *x > 0.0);
            if y.is_finite() && lit { y.max(0.0) } else { 0.0 }
        };
        // The mean of the interpolated luminance over each cell, first along x and then along y.
        let (wide, high) = (w as f64 / columns as f64, h as f64 / rows as f64);
        let across: Vec<Vec<(usize, f64)>> = (0..columns)
            .map(|c| {
                let tents = tents(c as f64 * wide, (c + 1) as f64 * wide);
                tents.map(|(x, share)| (x.rem_euclid(w as i64) as usize, share / wide)).collect()
            })
            .collect();
        let mut weights = vec![0.0; columns * rows];
        let mut row = vec![0.0; columns];
        let mut line = vec![0.0; w];
        // Every row of texels contributes to the cells that its tents reach.
        let mut given: Vec<Vec<(usize, f64)>> = vec![Vec::new(); h];
        for r in 0..rows {
            for (y, share) in tents(r as f64 * high, (r + 1) as f64 * high) {
                given[y.clamp(0, h as i64 - 1) as usize].push((r, share / high));
            }
        }
        for (y, given) in given.iter().enumerate() {
            for (to, x) in line.iter_mut().zip(y * w..) {
                *to = brightness(image.texel(x));
            }
            for (to, shares) in row.iter_mut().zip(&across) {
                *to = shares.iter().map(|(x, share)| share * line[*x]).sum();
            }
            for (r, share) in given {
                for (to, mean) in weights[r * columns..].iter_mut().zip(&row) {
                    *to += share * mean;
                }
            }
        }
        // 2 pi / columns times the difference of the cosines, written as a product.
        let solid_angles: Vec<f64> = (0..rows)
            .map(|r| {
                let step = 0.5 * PI / rows as f64;
                4.0 * PI / columns as f64 * step.sin() * ((2 * r + 1) as f64 * step).sin()
            })
            .collect();
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight *= solid_angles[i / columns];
        }
        let sizes: Vec<f64> = (0..weights.len()).map(|i| solid_angles[i / columns]).collect();
        let cells = alias_entries(&weights, &sizes)?;
        Some(SkyDistribution { columns: columns as u32, rows: rows as u32, cells })
    }
}
