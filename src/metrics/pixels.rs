//! Tests single pixels: whether one differs by more than any noise that it may have.
//!
//! The variance of a pixel's mean is not enough. It comes from two halves, which agree by chance in some pixels. Two other things are used.
//!
//! - **Equal pixels.** Renders with random numbers of their own differ in nearly all pixels that have noise. If most of these are equal to
//!   the bit, the images share their random numbers, and what differs in the others is no noise of sampling.
//! - **The variance of a pixel's samples.** It has many degrees of freedom, and a rare bright sample shows in it.
//!
//! docs/comparing.md has the derivation and measurements.

use std::collections::HashMap;

use super::estimate::{LEVEL, corrected};
use super::grid::Grid;
use super::images::{Images, QUANTITIES, Quantity, SampleVariances};
use super::{shift, student};
use crate::data::SampleVariance;

/// The shares of the false alarms of both tests.
const SHARE_EQUAL: f64 = 1.0 / 12.0;
const SHARE_BEYOND: f64 = 1.0 / 12.0;
/// The relative rounding of a pixel by f32 arithmetic, on one driver or on two. Smaller differences are none.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;
/// The images share their random numbers only if at most this share of their noisy pixels differs. More of them fill whole tiles, which are
/// tested by their means.
const MOST_THAT_DIFFER: f64 = 0.125;
/// A pixel counts as noisy if its noise is this many times the last digit of its value. Otherwise it is equal in many renders.
const DIGITS: f64 = 16.0;
/// The last digit of f32 and of the 16-bit floats that other programs write, relative to the value.
const DIGIT: f64 = 1.0 / (1u64 << 24) as f64;
const HALF_DIGIT: f64 = 1.0 / (1u64 << 11) as f64;
/// The bits of an f32 that a 16-bit float does not have.
const BEYOND_HALF: u32 = (1 << 13) - 1;

/// A pixel that differs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single {
    pub at: [usize; 2],
    pub quantity: Quantity,
    /// a − b there, and b.
    pub difference: f64,
    pub reference: f64,
    /// Its p-value, corrected for the number of pixels and for the other tests.
    pub p: f64,
}

/// The result of the tests of single pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pixels {
    /// The images share their random numbers. `differing` pixels differ, and all the others are equal; the one of them that differs most.
    Shared { differing: usize, most: Single },
    /// The pixel with the smallest p-value. `visible` is the relative difference from which on a single pixel shows, in the median over
    /// pixels; infinite if there are too few samples to know its noise.
    Tested { most: Single, visible: f64 },
    /// The noise of single pixels is unknown. The pixel with the largest difference, with the p-value of a shift of all of them; none if all
    /// are equal.
    Untested(Option<Single>),
}

impl Pixels {
    /// The p-value of the tests of single pixels.
    pub fn p(&self) -> f64 {
        match self {
            Pixels::Shared { most, .. } | Pixels::Tested { most, .. } => most.p,
            Pixels::Untested(most) => most.map_or(1.0, |most| most.p),
        }
    }
}

/// Tests the pixels that count.
pub(super) fn pixels(images: &Images<'_>, grid: &Grid) -> Pixels {
    if let Some(shared) = shared(images) {
        return shared;
    }
    let tested = images.sample_variances.and_then(|sample_variances| beyond(images, grid, sample_variances));
    tested.unwrap_or_else(|| {
        Pixels::Untested(most_different(images).map(|(single, _)| Single { p: shift::p(images, grid), ..single }))
    })
}

fn differs(images: &Images<'_>, pixel: usize) -> bool {
    let channels = images.a[pixel].into_iter().zip(images.b[pixel]).map(|(a, b)| [a, b].map(f64::from));
    channels.into_iter().any(|[a, b]| (a - b).abs() > ROUNDING * a.abs().max(b.abs()))
}

/// The pixel that differs most, and the number of those that differ. It differs in luminance, if all its channels change in one direction.
fn most_different(images: &Images<'_>) -> Option<(Single, usize)> {
    let size = |pixel: usize| {
        let channels = images.a[pixel].into_iter().zip(images.b[pixel]);
        channels.map(|(a, b)| (f64::from(a) - f64::from(b)).abs()).fold(0.0, f64::max)
    };
    let differing = images.counted().filter(|&pixel| differs(images, pixel));
    let (mut most, mut count) = (None, 0);
    for (pixel, size) in differing.map(|pixel| (pixel, size(pixel))) {
        count += 1;
        if most.is_none_or(|(_, largest)| size > largest) {
            most = Some((pixel, size));
        }
    }
    let (pixel, _) = most?;
    let difference = |quantity: &Quantity| {
        let [a, b] = images.values(*quantity, pixel);
        a - b
    };
    let [_, colours @ ..] = QUANTITIES;
    let together = colours.iter().all(|colour| difference(colour) >= 0.0)
        || colours.iter().all(|colour| difference(colour) <= 0.0);
    let alone = colours.iter().filter(|colour| difference(colour) != 0.0).count() == 1;
    let largest = colours.into_iter().max_by(|a, b| difference(a).abs().total_cmp(&difference(b).abs()));
    let quantity = if together && !alone { Quantity::Luminance } else { largest.unwrap_or(Quantity::Luminance) };
    Some((single(images, quantity, pixel, 1.0), count))
}

fn single(images: &Images<'_>, quantity: Quantity, pixel: usize, p: f64) -> Single {
    let [a, b] = images.values(quantity, pixel);
    Single { at: [pixel % images.width, pixel / images.width], quantity, difference: a - b, reference: b, p }
}

/// Whether the images share their random numbers, and few pixels differ nevertheless.
///
/// Two images with random numbers of their own have the same value in a pixel with noise with a probability of at most 1/2. Noise is
/// continuous, or it is a number of samples that hit a lamp of one radiance. A number on which the two halves disagree, as they do in a
/// pixel that counts as noisy, has a probability of at most 1/2. So if k of m noisy pixels differ, the p-value is that of at most k heads of
/// m coins (own derivation).
fn shared(images: &Images<'_>) -> Option<Pixels> {
    let noise = Noise::new(images);
    let (mut noisy, mut different) = (0u64, 0u64);
    for pixel in images.counted().filter(|&pixel| noise.is_there(pixel)) {
        noisy += 1;
        different += u64::from(images.a[pixel] != images.b[pixel]);
    }
    if different as f64 > MOST_THAT_DIFFER * noisy as f64 {
        return None;
    }
    let (most, differing) = most_different(images)?;
    if differing as f64 > MOST_THAT_DIFFER * images.counted().count() as f64 {
        return None;
    }
    let p = corrected(few_heads(different as f64, noisy as f64), SHARE_EQUAL);
    (p < LEVEL).then_some(Pixels::Shared { differing, most: Single { p, ..most } })
}

/// A bound of the probability of at most `k` heads of `m` coins, for k ≤ m/8: that of k, times the geometric series of the ratio of the
/// last two.
fn few_heads(k: f64, m: f64) -> f64 {
    let choose = student::ln_gamma(m + 1.0) - student::ln_gamma(k + 1.0) - student::ln_gamma(m - k + 1.0);
    (choose - m * std::f64::consts::LN_2).exp() / (1.0 - k / (m - k + 1.0))
}

/// Where the images have noise.
struct Noise<'a> {
    images: &'a Images<'a>,
    /// The last digit of the values, relative to them.
    digit: f64,
}

impl<'a> Noise<'a> {
    fn new(images: &'a Images<'a>) -> Noise<'a> {
        let is_half = |v: &f32| v.to_bits() & BEYOND_HALF == 0;
        let halves = [images.a, images.b].into_iter().all(|image| image.as_flattened().iter().all(is_half));
        Noise { images, digit: if halves { HALF_DIGIT } else { DIGIT } }
    }

    /// By the variance, if it is known. Otherwise a pixel counts that differs from its neighbours in both images, as noise does.
    fn is_there(&self, pixel: usize) -> bool {
        let [a, b] = self.images.values(Quantity::Luminance, pixel);
        let least = DIGITS * self.digit * a.abs().max(b.abs());
        match self.images.variance(Quantity::Luminance, pixel) {
            Some(variance) => variance > least * least,
            None => {
                least > 0.0 && [self.images.a, self.images.b].iter().all(|image| self.stands_out(image, pixel, least))
            }
        }
    }

    fn stands_out(&self, image: &[[f32; 3]], pixel: usize, least: f64) -> bool {
        let (width, height) = (self.images.width, self.images.height);
        let (x, y) = (pixel % width, pixel / width);
        let of = |x: usize, y: usize| Quantity::Luminance.value(image[y * width + x].map(f64::from));
        let near = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        let mut near = near.into_iter().filter(|(x, y)| *x < width && *y < height).peekable();
        near.peek().is_some() && near.all(|(u, v)| (of(u, v) - of(x, y)).abs() > least)
    }
}

/// The pixel that is farthest beyond its noise, by the variance of its samples. None if this is known of no pixel.
///
/// With s² the variance of a sample, as estimated from n samples of A or m of B, whichever is larger, the difference has the variance
/// s² (1/n + 1/m). The larger one, because an image that has found no light of a kind does not know its noise, and because one that has
/// found a bright sample beside the truth must not be judged by the truth's noise.
///
/// By other settings, an image may find light more seldom than the other does. Then it knows its noise by the pixels around. If a share q of
/// its samples brings the radiance L, and the others nothing, their mean is q L and their variance q L² (1 − q). So the sum of variances over
/// the sum of means is L, but for a factor 1 − q, and a pixel of the mean I has this variance at least: L I (own derivation).
fn beyond(
    images: &Images<'_>,
    grid: &Grid,
    SampleVariances { images: sample_variances, alike }: SampleVariances<'_>,
) -> Option<Pixels> {
    let mut most: Option<(usize, Quantity, f64)> = None;
    let mut visible = Vec::new();
    let share = SHARE_BEYOND / (QUANTITIES.len() * images.counted().count()) as f64;
    // By what they depend on: the numbers of samples, and the degrees of freedom.
    let mut limits = HashMap::new();
    for quantity in QUANTITIES {
        let sources = [images.a, images.b].into_iter().zip(sample_variances).filter(|_| !alike);
        let contributions: Vec<Vec<f64>> = sources
            .map(|(image, sample_variance)| contribution_of_samples(grid, images, quantity, image, sample_variance))
            .collect();
        for pixel in images
            .counted()
            .filter(|&pixel| sample_variances.iter().all(|sample_variance| is_known(&sample_variance[pixel])))
        {
            let [a, b] = images.values(quantity, pixel);
            let largest = a.abs().max(b.abs());
            let brightest = contributions.iter().map(|of_tiles| of_tiles[grid.tile_of(pixel)]).fold(0.0, f64::max);
            let noise = Samples::new(
                quantity,
                sample_variances.map(|sample_variance| sample_variance[pixel]),
                brightest * largest,
            );
            let error = (noise.variance + (ROUNDING * largest).powi(2)).sqrt();
            if quantity == Quantity::Luminance {
                let key = [noise.counts[0], noise.counts[1], noise.degrees].map(f64::to_bits);
                visible.push(*limits.entry(key).or_insert_with(|| limit(&noise, share)) * error / b.abs());
            }
            let z = if a == b { 0.0 } else { (a - b).abs() / error };
            // Most pixels are far from the smallest p-value.
            let p = if z < 2.0 { 1.0 } else { corrected(noise.p(z), share) };
            if most.is_none_or(|(.., least)| p < least) {
                most = Some((pixel, quantity, p));
            }
        }
    }
    let (pixel, quantity, p) = most?;
    let middle = visible.len() / 2;
    let (_, visible, _) = visible.select_nth_unstable_by(middle, f64::total_cmp);
    Some(Pixels::Tested { most: single(images, quantity, pixel, p), visible: *visible })
}

fn is_known(sample_variance: &SampleVariance) -> bool {
    sample_variance.degrees > 0 && sample_variance.variance.iter().all(|v| v.is_finite())
}

/// The variance of a sample. Channels are assumed to be fully correlated, as in `Images::variances`.
fn variance(quantity: Quantity, sample_variance: &SampleVariance) -> f64 {
    quantity.value(sample_variance.variance.map(|v| f64::from(v).sqrt())).powi(2)
}

/// The radiance of single samples of an image, estimated for each tile from it and the tiles around it.
fn contribution_of_samples(
    grid: &Grid,
    images: &Images<'_>,
    quantity: Quantity,
    image: &[[f32; 3]],
    sample_variance: &[SampleVariance],
) -> Vec<f64> {
    let mut tiles = vec![(0.0, 0.0); grid.tiles()];
    for pixel in images.counted().filter(|&pixel| is_known(&sample_variance[pixel])) {
        let (means, variances) = &mut tiles[grid.tile_of(pixel)];
        *means += quantity.value(image[pixel].map(f64::from)).abs();
        *variances += variance(quantity, &sample_variance[pixel]);
    }
    let around = |tile: usize| {
        let near = grid.around(tile).map(|near| tiles[near]);
        let (means, variances) = near.fold((0.0, 0.0), |sum, tile| (sum.0 + tile.0, sum.1 + tile.1));
        if means > 0.0 { variances / means } else { 0.0 }
    };
    (0..grid.tiles()).map(around).collect()
}

/// The noise of the difference of a pixel.
struct Samples {
    /// The variance of the difference, and its degrees of freedom.
    variance: f64,
    degrees: f64,
    /// The samples of A and B.
    counts: [f64; 2],
}

impl Samples {
    /// `least` is the least variance of a sample.
    fn new(quantity: Quantity, sample_variances: [SampleVariance; 2], least: f64) -> Samples {
        let counts = sample_variances.map(|sample_variance| f64::from(sample_variance.samples));
        let [a, b] = sample_variances.map(|sample_variance| variance(quantity, &sample_variance));
        let degrees = f64::from(if a > b { sample_variances[0].degrees } else { sample_variances[1].degrees });
        Samples { variance: a.max(b).max(least) * (1.0 / counts[0] + 1.0 / counts[1]), degrees, counts }
    }

    /// The probability that noise alone makes a difference of at least `z` standard errors: the larger one of two extremes.
    ///
    /// - Samples are normal: Student's t.
    /// - Samples are dark, but for some of one brightness, and all of these are in one image, as is most significant. If these are K of n
    ///   samples there, with m in the other image, then z² = K (n − 1) m / ((n − K) (n + m)). All ways to deal n + m samples to both
    ///   images are equally likely, so that the probability is C(n + m − K, m) / C(n + m, m), and twice that of either image.
    fn p(&self, z: f64) -> f64 {
        let [n, m] = self.counts;
        student::two_sided(z, self.degrees).max(all_in_one(z, n, m)).max(all_in_one(z, m, n))
    }
}

fn all_in_one(z: f64, n: f64, m: f64) -> f64 {
    if n < 2.0 {
        return 1.0;
    }
    let odds = z * z * (n + m) / ((n - 1.0) * m);
    let bright = if odds.is_finite() { n * odds / (1.0 + odds) } else { n };
    let ln_factorial = |k: f64| student::ln_gamma(k + 1.0);
    let ln = ln_factorial(n + m - bright) + ln_factorial(n) - ln_factorial(n - bright) - ln_factorial(n + m);
    (2.0 * ln.exp()).min(1.0)
}

/// How many standard errors a pixel must differ by.
fn limit(noise: &Samples, share: f64) -> f64 {
    let shows = |z: f64| corrected(noise.p(z), share) < LEVEL;
    let (mut low, mut high) = (1.0, 1e9);
    if !shows(high) {
        return f64::INFINITY;
    }
    // To a thousandth, which a sentence needs.
    while high > 1.001 * low {
        let middle = f64::sqrt(low * high);
        if shows(middle) { high = middle } else { low = middle }
    }
    high
}
