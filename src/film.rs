//! The film: exact totals of what each pixel has received, in which order cannot matter.
//!
//! The device delivers sums over short runs of samples in f32. Here they are added as integers of a fixed scale (a sum of integers is
//! the same in any order and split), together with the sums of squares that the error estimate needs.

use crate::data::{ODD_RUN, RUN_LENGTH, Sampler, luminance};
use crate::error::{Error, Result};

/// What [`Picture::variance`] holds where the variance is not known: the largest finite f32. An image file must hold finite values, 0
/// would claim exactness, and whoever takes this one for a number concludes that the pixel is worthless, which is right.
pub const UNKNOWN_VARIANCE: f32 = f32::MAX;

/// Bits after the binary point of a pixel's sum, in device units.
const SUM_FRACTION: i32 = 88;
/// Bits after the binary point of a pixel's sum of squares, in device units squared.
const SQUARE_FRACTION: i32 = 96;
/// The largest power of two, up or down, between device units and scene units: its square is far inside f64.
const MAX_EXPONENT: i32 = 300;
/// The share of the image's mean luminance that keeps dark pixels from ruling the relative error (design.md, section 2).
const DARK_PIXEL_FLOOR: f64 = 0.01;
/// How many times the stated error the one relative to the other half of the samples may be, where it is called reliable.
const MOST_ACROSS: f64 = 2.0;
/// The standard error, as a share, up to which a stated relative error is called reliable.
const RELIABLE: f64 = 0.1;

/// One run as the device delivers it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RunRecord {
    /// Sum of the accepted samples' radiance, in device units, as added in f32 in sample order.
    pub sum: [f32; 3],
    /// Index of the pixel: row 0 on top, `y * width + x`.
    pub pixel: u32,
    /// Accepted samples | rejected as NaN << 8 | rejected as infinite << 16 | rejected as cut short << 24; their sum is
    /// at most [`RUN_LENGTH`]. And [`ODD_RUN`] where the run is one of odd number.
    pub counts: u32,
    /// Rays traced for the run.
    pub rays: u32,
}

impl RunRecord {
    /// `[accepted, NaN, infinite, cut short]`, or nothing where they cannot be the counts of one run.
    fn counts(&self) -> Option<[u32; 4]> {
        let counts = (self.counts & !ODD_RUN).to_le_bytes().map(u32::from);
        (counts.iter().sum::<u32>() <= RUN_LENGTH).then_some(counts)
    }
}

/// Samples that were left out of the image, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejected {
    /// The device found a NaN.
    pub nan: u64,
    /// The device found an infinity, or the run's sum overflowed f32.
    pub infinite: u64,
    /// The ray's walk through the BVH was given up as too long (shaders/scene/traverse.wgsl).
    pub cut: u64,
    /// The record itself was refused: its pixel is not in the image, its sum is negative or NaN, or its counts are not those of a run.
    pub refused: u64,
}

impl Rejected {
    pub fn total(&self) -> u64 {
        self.nan + self.infinite + self.cut + self.refused
    }
}

/// Totals over the whole film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Camera samples, accepted or rejected.
    pub paths: u64,
    /// Rays of every kind.
    pub rays: u64,
    pub rejected: Rejected,
}

/// What one pixel has received, in device units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Zeroable)]
struct Pixel {
    /// Σ s over runs, s the run's sum, in units of 2^-[`SUM_FRACTION`].
    sum: [u128; 3],
    /// What tells the variance. Of independent samples: Σ s²/n over runs, n the run's accepted samples, in units of
    /// 2^-[`SQUARE_FRACTION`]. Of Sobol points: Σ s over odd runs, in the units of `sum`.
    spread: [u128; 3],
    /// Accepted samples.
    samples: u64,
    /// Of independent samples: runs with at least one accepted sample. Of Sobol points: accepted samples of odd runs.
    replicates: u32,
    rejected: u32,
}

impl Pixel {
    /// The pixel's mean in device units; 0 without samples.
    fn mean(&self, channel: usize) -> f64 {
        if self.samples == 0 {
            return 0.0;
        }
        self.sum[channel] as f64 * exp2(-SUM_FRACTION) / self.samples as f64
    }

    /// The variance of the pixel's mean, in device units squared. Unknown with less than two replicates, or where a total has saturated.
    fn variance(&self, channel: usize, sampler: Sampler) -> Option<f64> {
        let saturated = self.sum[channel] == u128::MAX || self.spread[channel] == u128::MAX;
        match (saturated || !self.has_replicates(sampler), sampler) {
            (true, _) => None,
            (false, Sampler::Independent) => Some(self.variance_of_runs(channel)),
            (false, Sampler::Sobol) => Some(self.variance_of_halves(channel)),
        }
    }

    /// Degrees of freedom of the variance.
    fn degrees(&self, sampler: Sampler) -> f64 {
        match sampler {
            Sampler::Independent => f64::from(self.replicates.saturating_sub(1)),
            Sampler::Sobol => 1.0,
        }
    }

    /// Of all channels.
    fn variances(&self, sampler: Sampler) -> Option<[f64; 3]> {
        Some([self.variance(0, sampler)?, self.variance(1, sampler)?, self.variance(2, sampler)?])
    }

    fn has_replicates(&self, sampler: Sampler) -> bool {
        match sampler {
            Sampler::Independent => self.replicates >= 2,
            Sampler::Sobol => {
                self.replicates > 0 && u64::from(self.replicates) < self.samples && self.replicates < u32::MAX
            }
        }
    }

    /// From the even runs' mean A and the odd ones' B, of a and b samples, N in all: v = a b (A - B)² / N². The halves are scrambled
    /// apart, and so independent, whatever is between the points of one: with variances V and W of their means, E[(A - B)²] = V + W,
    /// while the pixel's mean a A/N + b B/N has the variance (a² V + b² W) / N². With a = b both agree. Where the last run is missing
    /// on one side, v is right if V and W are as 1/a to 1/b, as for independent samples; where the larger half is better than
    /// that, v is too large, by a factor of a/b at most (own derivation: V a = W b gives v; V = 0 gives v = a b W / N² for b² W / N²).
    fn variance_of_halves(&self, channel: usize) -> f64 {
        let (odd, all) = (u64::from(self.replicates), self.samples);
        let even = all - odd;
        // Means are rounded down by 2^-88 at most, so that nothing cancels but equal digits.
        let mean_odd = self.spread[channel] / u128::from(odd);
        let mean_even = (self.sum[channel] - self.spread[channel].min(self.sum[channel])) / u128::from(even);
        let difference = mean_odd.abs_diff(mean_even) as f64 * exp2(-SUM_FRACTION);
        let weights = (even as f64 / all as f64) * (odd as f64 / all as f64);
        weights * difference * difference
    }

    /// From the runs as replicates of unequal size: with N = Σ n, K runs and
    /// Q = Σ s²/n − (Σ s)²/N, it is Q / ((K − 1) N). Own derivation: for independent samples of mean μ and variance σ²,
    /// E[Σ s²/n] = K σ² + N μ² and E[(Σ s)²/N] = σ² + N μ², so that E[Q] = (K − 1) σ², while the mean's variance is σ²/N.
    fn variance_of_runs(&self, channel: usize) -> f64 {
        // Q ≥ 0 by the Cauchy–Schwarz inequality; only the rounding of the squares could take it below.
        let spread = self.spread[channel].saturating_sub(square_over(self.sum[channel], self.samples));
        let divisor = f64::from(self.replicates - 1) * self.samples as f64;
        spread as f64 * exp2(-SQUARE_FRACTION) / divisor
    }

    fn reject(&mut self, samples: u32) {
        self.rejected = self.rejected.saturating_add(samples);
    }

    fn add(&mut self, other: &Pixel) {
        for channel in 0..3 {
            self.sum[channel] = self.sum[channel].saturating_add(other.sum[channel]);
            self.spread[channel] = self.spread[channel].saturating_add(other.spread[channel]);
        }
        self.samples += other.samples;
        self.replicates = self.replicates.saturating_add(other.replicates);
        self.reject(other.rejected);
    }

    /// What the even and the odd runs have of it; the odd ones of independent samples are kept beside it.
    fn halves(&self, odd: Option<&Pixel>) -> [Pixel; 2] {
        match odd {
            Some(odd) => [self.without(odd), *odd],
            None => {
                let odd = Pixel { sum: self.spread, samples: u64::from(self.replicates), ..Pixel::default() };
                [self.without(&odd), odd]
            }
        }
    }

    /// What is left without a part of it. Exact, where no total has saturated.
    fn without(&self, part: &Pixel) -> Pixel {
        let less = |all: [u128; 3], part: [u128; 3]| [0, 1, 2].map(|c| all[c].saturating_sub(part[c]));
        Pixel {
            sum: less(self.sum, part.sum),
            spread: less(self.spread, part.spread),
            samples: self.samples - part.samples,
            replicates: self.replicates - part.replicates,
            rejected: self.rejected - part.rejected,
        }
    }

    /// A pixel's term of the squared relative error, the mean of v / (I² + floor) over its channels, with I of this one.
    fn term(&self, v: [f64; 3], floor: f64) -> f64 {
        let term = |channel: usize| {
            let mean = self.mean(channel);
            v[channel] / (3.0 * (mean * mean + floor))
        };
        term(0) + term(1) + term(2)
    }
}

/// The exact totals of a whole image.
///
/// Range, in device units (scene radiance / 2^exponent). A pixel's sum holds 2^-88 to 2^40: every f32 from 2^-65 on is added without
/// any rounding, smaller ones are rounded to 2^-88, and 2^30 samples of mean 1000 fit. Its sum of squares holds 2^-96 to 2^32: the
/// variance is exact for samples from about 2^-36 on and fades below 2^-46; one run of sum 2^17, 2^20 samples of 64 or 2^30 of 2
/// fit. Beyond, the total saturates (a saturating sum of numbers that are not negative is still the same in any order) and the
/// variance is reported as unknown. (Of Sobol points the sums of squares are not kept; the difference of the halves is exact to 2^-88.) So the device's unit should be about the radiance of the brightest thing that is often seen.
///
/// Memory: 112 bytes a pixel of Sobol points, 224 of independent samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    exponent: i32,
    sampler: Sampler,
    pixels: Vec<Pixel>,
    /// Of independent samples: what the odd runs have of all that is in `pixels`, for the error of the error. Else empty.
    odd: Vec<Pixel>,
    totals: Totals,
}

impl Film {
    /// An empty film of independent samples.
    ///
    /// # Errors
    /// As of [`Film::with_sampler`].
    pub fn new(width: u32, height: u32, exponent: i32) -> Result<Film> {
        Film::with_sampler(width, height, exponent, Sampler::Independent)
    }

    /// An empty film. The sampler decides what the error is told by: runs, or the difference of two halves. Device radiance times 2^exponent is scene radiance; the exponent is within ±300.
    ///
    /// Fails where the image has no pixels, more than 2^32, or more than the memory holds.
    pub fn with_sampler(width: u32, height: u32, exponent: i32, sampler: Sampler) -> Result<Film> {
        let count = u64::from(width) * u64::from(height);
        // The device names pixels by u32.
        if count == 0 || count > 1 << 32 {
            return Err(Error::Usage(format!(
                "an image of {width} x {height} pixels: expected 1 to 2^32 pixels in all"
            )));
        }
        if !(-MAX_EXPONENT..=MAX_EXPONENT).contains(&exponent) {
            return Err(Error::Usage(format!(
                "the scene's radiance has the scale 2^{exponent}: expected 2^-300 to 2^300"
            )));
        }
        let parts = match sampler {
            Sampler::Independent => 2,
            Sampler::Sobol => 1,
        };
        let too_large = || {
            let gib = parts as f64 * count as f64 * size_of::<Pixel>() as f64 / exp2(30);
            Error::Usage(format!(
                "an image of {width} x {height} pixels needs {gib:.1} GiB of memory, which cannot be had; use a smaller --size"
            ))
        };
        let count = usize::try_from(count).map_err(|_| too_large())?;
        // Zeros as the system hands them out: writing them would cost a large film more than all else before its first pass.
        let empty = |count| bytemuck::allocation::try_zeroed_vec::<Pixel>(count).map_err(|()| too_large());
        let (pixels, odd) = (empty(count)?, empty((parts - 1) * count)?);
        Ok(Film { width, height, exponent, sampler, pixels, odd, totals: Totals::default() })
    }

    /// Takes everything back.
    pub fn clear(&mut self) {
        self.pixels.fill(Pixel::default());
        self.odd.fill(Pixel::default());
        self.totals = Totals::default();
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    pub fn height(&self) -> u32 {
        self.height
    }

    pub fn totals(&self) -> Totals {
        self.totals
    }

    /// Adds runs. Any order and any split into calls gives the same film.
    ///
    /// A record that no correct device delivers is refused as a whole and counted, so that it cannot corrupt a pixel.
    pub fn add(&mut self, records: &[RunRecord]) {
        for record in records {
            self.add_one(record);
        }
    }

    fn add_one(&mut self, record: &RunRecord) {
        self.totals.rays += u64::from(record.rays);
        let Some([accepted, nan, infinite, cut]) = record.counts() else {
            self.refuse(record, RUN_LENGTH);
            return;
        };
        let samples = accepted + nan + infinite + cut;
        // A NaN fails this too.
        let sum_is_valid = record.sum.iter().all(|s| *s >= 0.0);
        if accepted > 0 && !sum_is_valid {
            self.refuse(record, samples);
            return;
        }
        let Some(pixel) = self.pixels.get_mut(record.pixel as usize) else {
            self.refuse(record, samples);
            return;
        };
        self.totals.paths += u64::from(samples);
        self.totals.rejected.nan += u64::from(nan);
        self.totals.rejected.infinite += u64::from(infinite);
        self.totals.rejected.cut += u64::from(cut);
        pixel.reject(nan + infinite + cut);
        if accepted == 0 {
            return;
        }
        if record.sum.iter().any(|s| s.is_infinite()) {
            // Finite samples whose sum is not: too bright for the device's unit.
            self.totals.rejected.infinite += u64::from(accepted);
            pixel.reject(accepted);
            return;
        }
        let odd = record.counts & ODD_RUN != 0;
        let mut run = Pixel { samples: u64::from(accepted), ..Pixel::default() };
        for channel in 0..3 {
            let s = f64::from(record.sum[channel]);
            run.sum[channel] = to_fixed(s, SUM_FRACTION);
            run.spread[channel] = match self.sampler {
                // The square of an f32 is exact in f64, and so is its quotient by the n of a full run, 8.
                Sampler::Independent => to_fixed(s * s / f64::from(accepted), SQUARE_FRACTION),
                Sampler::Sobol if odd => run.sum[channel],
                Sampler::Sobol => 0,
            };
        }
        run.replicates = match self.sampler {
            Sampler::Independent => 1,
            Sampler::Sobol if odd => accepted,
            Sampler::Sobol => 0,
        };
        pixel.add(&run);
        if odd && let Some(part) = self.odd.get_mut(record.pixel as usize) {
            part.add(&run);
        }
    }

    /// Counts a record's samples as rejected and takes nothing else from it.
    #[cold]
    fn refuse(&mut self, record: &RunRecord, samples: u32) {
        self.totals.paths += u64::from(samples);
        self.totals.rejected.refused += u64::from(samples);
        if let Some(pixel) = self.pixels.get_mut(record.pixel as usize) {
            pixel.reject(samples);
        }
    }

    /// Adds another film of the same image. It is the same as if this film had got the other's records too.
    pub fn merge(&mut self, other: &Film) -> Result<()> {
        let shape = |film: &Film| (film.width, film.height, film.exponent, film.sampler);
        if shape(self) != shape(other) {
            return Err(Error::Usage(format!(
                "films of different images cannot be joined: {} x {} pixels of scale 2^{} ({}) and {} x {} of 2^{} ({})",
                self.width,
                self.height,
                self.exponent,
                self.sampler.name(),
                other.width,
                other.height,
                other.exponent,
                other.sampler.name()
            )));
        }
        let theirs = other.pixels.iter().chain(&other.odd);
        self.pixels.iter_mut().chain(&mut self.odd).zip(theirs).for_each(|(mine, theirs)| mine.add(theirs));
        self.totals.paths += other.totals.paths;
        self.totals.rays += other.totals.rays;
        self.totals.rejected.nan += other.totals.rejected.nan;
        self.totals.rejected.infinite += other.totals.rejected.infinite;
        self.totals.rejected.cut += other.totals.rejected.cut;
        self.totals.rejected.refused += other.totals.rejected.refused;
        Ok(())
    }

    /// The mean over the pixels of the largest component of their radiance, in device units.
    pub fn mean_radiance(&self) -> f64 {
        let largest = |pixel: &Pixel| pixel.mean(0).max(pixel.mean(1)).max(pixel.mean(2));
        self.pixels.iter().map(largest).sum::<f64>() / self.pixels.len() as f64
    }

    /// The image in scene units.
    pub fn develop(&self) -> Picture {
        let scale = exp2(self.exponent);
        let channels = [0, 1, 2];
        Picture {
            width: self.width,
            height: self.height,
            rgb: self.pixels.iter().map(|p| channels.map(|c| to_f32(p.mean(c) * scale))).collect(),
            variance: self
                .pixels
                .iter()
                .map(|p| channels.map(|c| variance_to_f32(p.variance(c, self.sampler), scale * scale)))
                .collect(),
            samples: self.pixels.iter().map(|p| u32::try_from(p.samples).unwrap_or(u32::MAX)).collect(),
            rejected: self.pixels.iter().map(|p| p.rejected).collect(),
        }
    }

    /// The image's relative error: sqrt(mean(v / (I² + 0.01 Ī²))) over pixels and channels, v the variance of the pixel's mean, I that
    /// mean, Ī the image's mean luminance (design.md, section 2). It is taken channel by channel, so that v and I belong to the same
    /// quantity and the file's layers suffice to compute it: the variance of a luminance would need the channels' covariance.
    ///
    /// Pixels that have rejected samples and less than two replicates are left out, lest one broken pixel hides the error of all others.
    /// Nothing while any other pixel has less than two, where a total has saturated, and for an image without light.
    pub fn relative_error(&self) -> Option<f64> {
        self.error_estimate(0.5).map(|estimate| estimate.value)
    }

    /// The relative error, and the bound that the one of this very image is above with a probability of `level` only: the one that a
    /// reference without error would tell, sqrt(mean((I - R)² / (R² + 0.01 R̄²))).
    ///
    /// With x the mean of v / (I² + 0.01 Ī²) over a pixel's channels, T = Σ x over n pixels tells the expectation of Y = Σ y, y the same
    /// with (I - R)² in place of v. Both scatter about it. Pixels are independent, since random numbers are keyed by them, so that Var T =
    /// Σ Var x and Var Y = Σ Var y, and as sums of scaled chi-squares T and Y have about ν = 2 (E T)²/Var T and μ = 2 (E T)²/Var Y degrees of
    /// freedom (Satterthwaite, Biometrics Bulletin 2(6), 1946, equation 17). What the halves of normal samples differ in is independent of what
    /// they have in common, so that Y/T has Fisher's distribution F(μ, ν). (Tails heavier than normal ones let Y and T go together, which is safe.)
    ///
    /// - With the pixel's deviations normal, of covariances C_cd between its channels, y = Σ w_c d_c² has Var y = 2 Σ w_c w_d C_cd² ≤ 2 (E
    ///   x)², since C_cd² ≤ C_cc C_dd; with equality where the channels vary together. An x of k degrees of freedom, one of two halves or
    ///   those of all runs but one, has E[x²] ≤ (1 + 2/k) (E x)². So 2 k/(k + 2) Σ x² is what is at hand of Var Y (own derivation).
    /// - Of two halves, Var T is the same.
    /// - Of independent samples the even and the odd runs give two estimates of each x. Scaled to what all runs have, X of the even ones
    ///   and Y of the odd ones, of samples of the shares a and b of all, they differ by nothing but chance: (X - Y)² a b has the
    ///   expectation of Var x, whatever the distribution, if runs are many. Of R runs, it is too large by (R - 1)/(R - 2) at most, with
    ///   normal runs.
    ///
    /// To compare a pixel with its neighbours, as if they were alike, is not good enough: of independent samples what they truly differ
    /// in outweighs what they differ in by chance, and of two halves, it is known less well than by all x.
    ///
    /// T has a bias of the order of x itself: I goes together with v where bright samples are rare. Two things take it from the bound.
    ///
    /// - Of independent samples: the bias falls as 1/N, so that the halves have twice as much, and x + δ, δ = Z - (a X + b Y), none
    ///   in that order (Quenouille, Biometrika 43(3/4), 1956). Z is a X + b Y with both halves' v over the whole pixel's I: in place of x,
    ///   whose v has the difference of the halves too, it leaves that chance out of δ. What δ has of it may go together with x: D = Σ (|X -
    ///   Y| √(a b) + |δ|)², as if they had a correlation of up to E|y| E|z| = 2/π, of two normal ones.
    /// - Always: the bound is no less than that of T with 1/(I² + 0.01 Ī²) as the mean of the halves' own. A pixel that a rare bright path met
    ///   has a large v and a large I, and x is near 1 whatever it is; the half that the path is not in says how bright the pixel mostly is. What this
    ///   one has too much, by the noise of halves, is some 12 v/I² of itself: 1 % where the relative error is 3 %. (Measured on nine
    ///   scenes of 16x16 and 64x64 pixels at 16 to 256 samples: T alone falls short of the true sum by up to 45 % at 16 samples, and the bound by it is
    ///   true of 3 to 98 % of renders; this one of 93 to 100 %.)
    ///
    /// The relative error is known to sqrt(1/(2ν)) of itself. Where that is more than a tenth, ν < 50, few pixels carry the sum, as rare
    /// bright paths make it: one that has a share s of T makes ν at most 3/s² or so. Then what has not been seen yet may be more than
    /// what has, and the estimate is called unreliable. So it is where T with the halves' own I is more than four times as large: the error relative
    /// to a better image is more than twice the stated one. (Measured at 16 and 64 samples: 1.02 to 1.9 times in scenes without caustics, 10 to
    /// 17 in glass.ron.)
    pub fn error_estimate(&self, level: f64) -> Option<ErrorEstimate> {
        let luminance = |p: &Pixel| luminance(std::array::from_fn(|c| p.mean(c)));
        let mean_luminance = self.pixels.iter().map(luminance).sum::<f64>() / self.pixels.len() as f64;
        if mean_luminance <= 0.0 {
            return None;
        }
        let floor = DARK_PIXEL_FLOOR * mean_luminance * mean_luminance;
        let (mut total, mut across, mut squares, mut pixels) = (0.0, 0.0, 0.0, 0u64);
        let mut degrees_of_x = f64::INFINITY;
        // Nothing, where a pixel has not two runs in each half.
        let mut halves = (self.sampler == Sampler::Independent).then_some(Halves::default());
        for (index, pixel) in self.pixels.iter().enumerate() {
            if pixel.rejected > 0 && !pixel.has_replicates(self.sampler) {
                continue;
            }
            let v = pixel.variances(self.sampler)?;
            let [even, odd] = pixel.halves(self.odd.get(index));
            let x = pixel.term(v, floor);
            across += 0.5 * even.term(v, floor);
            across += 0.5 * odd.term(v, floor);
            total += x;
            squares += x * x;
            degrees_of_x = degrees_of_x.min(pixel.degrees(self.sampler));
            pixels += 1;
            halves = halves.and_then(|halves| halves.with(pixel, [&even, &odd], floor));
        }
        if pixels == 0 {
            return None;
        }
        let error = |total: f64| (total / pixels as f64).sqrt();
        if total == 0.0 {
            return Some(ErrorEstimate { value: 0.0, bound: 0.0, against_better: 0.0, reliable: true });
        }
        let deviations = 2.0 * degrees_of_x / (degrees_of_x + 2.0) * squares;
        let (corrected, variance) = match halves {
            Some(halves) => (total + halves.correction, halves.variance),
            None => (total, deviations),
        };
        // Halves that agree to the last bit, though there is noise, are too few to tell anything.
        let degrees = |variance: f64| match corrected > 0.0 && variance > 0.0 {
            true => (2.0 * corrected * corrected / variance - 2.0).max(0.0),
            false => 0.0,
        };
        let (of_image, of_estimate) = (degrees(deviations), degrees(variance));
        let bound = error(corrected.max(across)) * upper_fisher(of_image, of_estimate, level).sqrt();
        let known = 0.5 / of_estimate <= RELIABLE * RELIABLE;
        let alike = across <= MOST_ACROSS * MOST_ACROSS * total;
        let reliable = known && alike;
        Some(ErrorEstimate { value: error(total), bound, against_better: error(across), reliable })
    }
}

/// What the even and the odd runs tell of an estimated sum over pixels ([`Film::error_estimate`]).
#[derive(Clone, Copy, Debug, Default)]
struct Halves {
    /// Σ δ: what takes the sum's bias from it.
    correction: f64,
    /// D: the variance of the corrected sum.
    variance: f64,
}

impl Halves {
    /// These with another pixel; nothing where it has less than two runs in a half.
    fn with(self, pixel: &Pixel, [even, odd]: [&Pixel; 2], floor: f64) -> Option<Halves> {
        let share = |half: &Pixel| half.samples as f64 / pixel.samples as f64;
        let (a, b) = (share(even), share(odd));
        // By samples, variances of a half's mean are a or b of that of the pixel's.
        let (v, w) = (even.variances(Sampler::Independent)?, odd.variances(Sampler::Independent)?);
        let (of_even, of_odd) = (a * even.term(v, floor), b * odd.term(w, floor));
        let pooled = a * a * pixel.term(v, floor) + b * b * pixel.term(w, floor);
        let change = pooled - a * of_even - b * of_odd;
        let deviation = (of_even - of_odd).abs() * (a * b).sqrt() + change.abs();
        Some(Halves { correction: self.correction + change, variance: self.variance + deviation * deviation })
    }
}

/// The relative error of an image ([`Film::error_estimate`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    pub value: f64,
    /// What the error of this image is below, but for the probability asked; infinite where nothing is known.
    pub bound: f64,
    /// The error relative to an image without the bright samples of this one, as far as its halves tell.
    pub against_better: f64,
    /// Whether enough pixels tell it, and the halves agree in what it is relative to.
    pub reliable: bool,
}

/// What a variable of Fisher's distribution F(μ, ν) is above with the probability `level` ≤ 1/2, by Paulson's cube root (Annals of
/// Mathematical Statistics 13(2), 1942; Abramowitz and Stegun, 26.6.15). Of ν below 10 it is too large, infinite at last, which errs on the
/// safe side.
fn upper_fisher(mu: f64, nu: f64, level: f64) -> f64 {
    if !(mu > 0.0 && nu > 0.0) {
        return f64::INFINITY;
    }
    // Abramowitz and Stegun, 26.2.23: to 4.5e-4.
    let t = (-2.0 * level.clamp(1e-300, 0.5).ln()).sqrt();
    let top = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let z = t - top / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let (a, b) = (2.0 / (9.0 * mu), 2.0 / (9.0 * nu));
    let (p, q) = (1.0 - a, 1.0 - b);
    // From z = (q F^⅓ - p) / √(b F^⅔ + a).
    let divisor = q * q - b * z * z;
    if q <= 0.0 || divisor <= 0.0 {
        return f64::INFINITY;
    }
    let root = (p * p * b + q * q * a - a * b * z * z).max(0.0).sqrt();
    ((p * q + z * root) / divisor).powi(3)
}

/// A developed image: linear scene radiance, row 0 on top. Every value is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Mean radiance, linear Rec. 709. What f32 cannot hold is f32::MAX.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of that mean, radiance squared; [`UNKNOWN_VARIANCE`] where it is not known. Above zero it is at least the smallest
    /// normal f32: a variance that is too small for the format is overstated, not lost.
    pub variance: Vec<[f32; 3]>,
    /// Accepted samples.
    pub samples: Vec<u32>,
    /// Rejected samples.
    pub rejected: Vec<u32>,
}

/// 2^exponent, exact while it is a normal number.
fn exp2(exponent: i32) -> f64 {
    2f64.powi(exponent)
}

/// `value`, finite and not negative, in units of 2^-fraction, rounded to the nearest (halves up); saturates.
fn to_fixed(value: f64, fraction: i32) -> u128 {
    // value = mantissa * 2^(exponent - 1075) (IEEE 754-2019, section 3.4). Denormals, below 2^-1022, round to 0 here anyway.
    let bits = value.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let mantissa = u128::from(bits & ((1 << 52) - 1) | 1 << 52);
    match exponent - 1075 + fraction {
        // The mantissa has 53 bits.
        76.. => u128::MAX,
        shift @ 0..76 => mantissa << shift,
        shift @ -53..0 => (mantissa + (1 << (-shift - 1))) >> -shift,
        _ => 0,
    }
}

/// sum²/samples, from units of 2^-[`SUM_FRACTION`] to units of 2^-[`SQUARE_FRACTION`], rounded down; saturates.
fn square_over(sum: u128, samples: u64) -> u128 {
    const SHIFT: i32 = 2 * SUM_FRACTION - SQUARE_FRACTION;
    let (low, high) = sum.carrying_mul(sum, 0);
    // Shifting before the division gives the same: floor(floor(x / a) / b) = floor(x / (a b)).
    let low = high << (128 - SHIFT) | low >> SHIFT;
    let high = high >> SHIFT;
    let n = u128::from(samples.max(1));
    if high == 0 {
        return low / n;
    }
    // Long division by one digit of 64 bits: each remainder is below n, so that it fits in front of the next digit.
    let (carry, rest) = (high / n, high % n);
    let upper = rest << 64 | low >> 64;
    let lower = (upper % n) << 64 | low & u128::from(u64::MAX);
    if carry > 0 { u128::MAX } else { ((upper / n) << 64) | (lower / n) }
}

/// `value`, not negative, as f32; saturates at f32::MAX.
fn to_f32(value: f64) -> f32 {
    (value as f32).min(f32::MAX)
}

fn variance_to_f32(variance: Option<f64>, scale: f64) -> f32 {
    match variance {
        None => UNKNOWN_VARIANCE,
        Some(0.0) => 0.0,
        Some(variance) => to_f32(variance * scale).max(f32::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_point_is_exact_and_rounds_to_nearest() {
        assert_eq!(to_fixed(0.0, 88), 0);
        assert_eq!(to_fixed(-0.0, 88), 0);
        assert_eq!(to_fixed(1.0, 88), 1 << 88);
        assert_eq!(to_fixed(f64::from(0.3f32), 88), u128::from(0.3f32.to_bits() & 0x7f_ffff | 0x80_0000) << (88 - 25));
        assert_eq!(to_fixed(exp2(-88), 88), 1);
        assert_eq!(to_fixed(exp2(-89), 88), 1);
        assert_eq!(to_fixed(exp2(-89) * 0.999, 88), 0);
        assert_eq!(to_fixed(exp2(-88) * 2.5, 88), 3);
        assert_eq!(to_fixed(exp2(-88) * 2.4, 88), 2);
        assert_eq!(to_fixed(exp2(39), 88), 1 << 127);
        assert_eq!(to_fixed(exp2(40), 88), u128::MAX);
        assert_eq!(to_fixed(f64::from(f32::MAX), 88), u128::MAX);
        assert_eq!(to_fixed(f64::MIN_POSITIVE, 88), 0);
        assert_eq!(to_fixed(f64::from_bits(1), 88), 0);
    }

    #[test]
    fn square_over_agrees_with_small_and_large_numbers() {
        for samples in [1u64, 3, 8, 1000, u64::MAX] {
            // (2^70)² = 2^140, less 80 bits: 2^60.
            assert_eq!(square_over(1 << 70, samples), (1u128 << 60) / u128::from(samples));
            // (2^100)² 2^-80 = 2^120: the division of one digit; (2^127)² 2^-80 = 2^174: of more.
            assert_eq!(square_over(1 << 100, samples), (1u128 << 120) / u128::from(samples));
        }
        assert_eq!(square_over(1 << 127, 1 << 50), 1 << 124);
        assert_eq!(square_over(1 << 127, 1 << 46), u128::MAX);
        // Expected values of the last two by Python's integers; the first is 2^174 / 3^30.
        assert_eq!(square_over(1 << 127, 205_891_132_094_649), 116_300_505_915_047_311_641_843_123_673_897_577_975);
        assert_eq!(square_over(u128::MAX, u64::MAX), 5_192_296_858_534_827_628_811_971_305_930_751);
    }
}
