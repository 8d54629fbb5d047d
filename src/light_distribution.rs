//! Tables for light sampling: alias tables, and the distribution of the sky's radiance.

use std::f64::consts::PI;

use crate::bitmap::Bitmap;
use crate::data::{AliasEntry, luminance};
use crate::threads::{cores, each};

/// The number of values of a uniform number on the device: the multiples of 2^-24.
const UNIFORMS: u64 = 1 << 24;

/// The most entries of a table. Each entry gets at least one of the 2^24 uniform numbers. A full table needs 1/16 of
/// them for this minimum.
pub const MAX_ENTRIES: usize = 1 << 20;

/// The most columns and rows of the sky's distribution: 32 MiB of sums.
pub const MOST_COLUMNS: usize = 4096;
pub const MOST_ROWS: usize = 2048;

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
///
/// None if no weight is positive, if a weight is negative or not finite, or if there are more than [`MAX_ENTRIES`].
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
/// exactly the probabilities with which the device draws. None as of [`apportion`].
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

/// The distribution of directions towards the sky, drawn by inversion (shaders/scene/sky.wgsl): the texels of its image, or blocks of them.
/// The weight of one is what its mean luminance has above a base, times its solid angle.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyDistribution {
    pub columns: u32,
    pub rows: u32,
    /// Running sums of parts of 2^24, each list from 0 on: those of the rows from the top, then those of the texels of each row.
    pub sums: Vec<u32>,
}

/// The texels that the block `index` of `count` covers along a side of so many, with the share of each that it covers.
fn covered(index: usize, count: usize, side: usize) -> impl Iterator<Item = (usize, f64)> {
    let end = |index: usize| (index as f64 * side as f64 / count as f64).min(side as f64);
    let (start, end) = (end(index), end(index + 1));
    (start as usize..end.ceil() as usize).map(move |i| (i, end.min((i + 1) as f64) - start.max(i as f64)))
}

impl SkyDistribution {
    /// None if no texel is brighter than `base`, or one is infinite.
    pub fn new(image: &Bitmap, base: f64) -> Option<SkyDistribution> {
        let (w, h) = (image.width as usize, image.height as usize);
        let block = w.div_ceil(MOST_COLUMNS).max(h.div_ceil(MOST_ROWS)).max(1);
        let (columns, rows) = (w.div_ceil(block), h.div_ceil(block));
        // The sums below are those of blocks.
        let base = base * (w * h) as f64 / (columns * rows) as f64;
        // The weight of a row, and the parts of its texels.
        let row = |r: usize| {
            let mut line = vec![0.0; w];
            for (y, share) in covered(r, rows, h) {
                for (to, index) in line.iter_mut().zip(y * w..) {
                    *to += share * luminance(image.texel(index).map(f64::from));
                }
            }
            let above = |c: usize| covered(c, columns, w).map(|(x, share)| share * line[x]).sum::<f64>() - base;
            let weights: Vec<f64> = (0..columns).map(|c| above(c).max(0.0)).collect();
            // The solid angle, but for a factor that all have.
            let size = ((r as f64 + 0.5) * PI / rows as f64).sin();
            (size * weights.iter().sum::<f64>(), running_sums(&weights))
        };
        let (weights, texels): (Vec<f64>, Vec<_>) = each(cores(), 0..rows, row).into_iter().unzip();
        let mut sums = running_sums(&weights)?;
        // A row without weight is never drawn.
        sums.extend(texels.into_iter().flat_map(|sums| sums.unwrap_or_else(|| vec![0; columns + 1])));
        Some(SkyDistribution { columns: columns as u32, rows: rows as u32, sums })
    }
}

/// The sums of the parts of weights before each, and of all. None as of [`apportion`].
fn running_sums(weights: &[f64]) -> Option<Vec<u32>> {
    let mut sum = 0;
    let after = apportion(weights)?.into_iter().map(|parts| {
        sum += parts as u32;
        sum
    });
    Some(std::iter::once(0).chain(after).collect())
}
