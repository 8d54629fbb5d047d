//! The error that a film states of itself: the relative error, and a bound of it.

use super::Film;
use crate::data::{Rgb, luminance};

/// This share of the image's mean luminance keeps dark pixels from dominating the relative error.
const DARK_PIXEL_FLOOR: f64 = 0.01;
/// A stated error is unreliable if the error against a better image is more than this many times as large.
const MOST_ACROSS: f64 = 2.0;
/// A stated error is unreliable if its standard error is more than this share of it.
const RELIABLE: f64 = 0.1;
/// The largest share of a sum over pixels that may come from the two halves of a single pixel. If these agree by chance, the sum is too
/// small by this share, and the error by half of it.
const MOST_OF_HALVES: f64 = 0.02;
/// Degrees of freedom of a variance from the squared deviations of a pixel's samples. If k bright samples make the variance, its standard
/// error is 1/√k of it, as with 2k degrees of freedom. Two bright samples are assumed.
const DEGREES_OF_SAMPLES: f64 = 4.0;

impl Film {
    /// The image's relative error: sqrt(mean(v / (I² + 0.01 Ī²))) over pixels and channels, v the variance of the pixel's mean, I that
    /// mean, Ī the image's mean luminance (docs/light-transport.md, "The stated error"). It is computed by channel, from the
    /// layers of the file alone: the variance of a luminance would need the covariances of the channels.
    ///
    /// A pixel with rejected samples and an empty half is left out, so that it does not hide the error of all others. `None` if any other
    /// pixel has an empty half or a saturated total, and for an image without light.
    pub fn relative_error(&self) -> Option<f64> {
        self.error_estimate(0.5).map(|estimate| estimate.value)
    }

    /// The relative error, and an upper bound that the error of this very image exceeds only with the probability `level`: its error against
    /// a reference R without noise, sqrt(mean((I - R)² / (R² + 0.01 R̄²))).
    ///
    /// Let x be the mean of v / (I² + 0.01 Ī²) over a pixel's channels, and y the same with (I - R)² for v. T = Σ x over n pixels estimates the
    /// expectation of Y = Σ y, and both have noise. Pixels are independent, because they are keys of the random numbers. (A light path may
    /// reach several pixels. It is one of very many and reaches few of the pixels, so that these are nearly independent with light paths too.)
    /// So Var T = Σ Var x and Var Y = Σ Var y. As sums of scaled chi-squares, T and Y have about ν = 2 (E T)²/Var T and μ = 2 (E T)²/Var Y
    /// degrees of freedom (Satterthwaite, Biometrics Bulletin 2(6), 1946, equation 17). The difference of two normal halves is independent
    /// of their mean, so Y/T has Fisher's distribution F(μ, ν).
    ///
    /// If the deviations d_c of a pixel are normal, with covariances C_cd between its channels, y = Σ w_c d_c² has Var y = 2 Σ w_c w_d C_cd² ≤
    /// 2 (E x)², because C_cd² ≤ C_cc C_dd; both are equal if the channels vary together. An x of k degrees of freedom has E[x²] ≤
    /// (1 + 2/k) (E x)², with k = 1 for two halves. So Σ 2k/(k + 2) x² estimates Var Y, and Var T if x comes from halves (own derivation).
    /// With independent samples it is too large for Var T.
    ///
    /// - **Few pixels with most of the noise.** If the halves of such a pixel agree by chance, it is missing in T and in Σ x² alike. Let w be x
    ///   with the variance σ²/N of the pixel's samples for v. If w is more than [`MOST_OF_HALVES`] of the sum, the pixel counts with w. Sobol
    ///   points remove much of σ² in smooth pixels and at edges, but not the part of single bright samples, so w is not too small. Pixels
    ///   are chosen by w alone, so the chance of the halves has no influence.
    /// - **The radiance that the error is relative to.** A pixel with a rare bright path has a large v and a large I, and its x is near 1,
    ///   whatever v is. The half without that path shows the usual radiance of the pixel. So in the bound, x and w have the mean of
    ///   1/(I² + 0.01 Ī²) over the two halves' I. The noise of the halves makes this too large by about 12 v/I² of itself: 1 % at a
    ///   relative error of 3 %. Half of that weight still comes from the bright half, so the neighbours count too: if at most one of the
    ///   eight is as bright, the pixel may owe its brightness to such a path, whose part in I is √v. Then it has the weight of I - √v, or of
    ///   the second brightest neighbour, whichever is brighter. Few such pixels would make ν small, so ν is that of the halves' weights.
    /// - **A pixel near 0.** With samples of either sign (`--filter mitchell`), a bright edge makes pixels near 0, whose halves may have
    ///   different signs. The true value may then be 0, and the pixel counts with 1/(0.01 Ī²).
    ///
    /// The bound is at least the relative error itself, whose weights may be larger in dark pixels.
    ///
    /// The relative error has a standard error of sqrt(1/(2ν)) of itself. If that is more than a tenth, ν < 50, few pixels carry the sum, as
    /// with rare bright paths. More light may then be missing than has been found, and the estimate is unreliable. It is also unreliable if T
    /// with the halves' I is more than four times as large: the error against a better image is then more than twice the stated one. How
    /// often the bound holds is measured in docs/light-transport.md.
    pub fn error_estimate(&self, level: f64) -> Option<ErrorEstimate> {
        let mean_luminance =
            self.estimates().map(|estimate| luminance(estimate.means())).sum::<f64>() / self.pixels.len() as f64;
        // A filter with negative lobes may make it negative. Only its square is used.
        if mean_luminance == 0.0 {
            return None;
        }
        let floor = DARK_PIXEL_FLOOR * mean_luminance * mean_luminance;
        let (mut total, mut pixels) = (0.0, 0u64);
        let (mut of_halves, mut of_bound) = (NoiseSum::default(), NoiseSum::default());
        let width = self.width() as usize;
        let row_of_means = |row: usize| -> Vec<Rgb<f64>> {
            let pixels = row * width..((row + 1) * width).min(self.pixels.len());
            pixels.map(|index| self.estimate(index).means()).collect()
        };
        let mut rows = [Vec::new(), row_of_means(0), row_of_means(1)];
        for (index, estimate) in self.estimates().enumerate() {
            let column = index % width;
            if column == 0 && index > 0 {
                rows.rotate_left(1);
                rows[2] = row_of_means(index / width + 1);
            }
            if estimate.pixel.rejected > 0 && !estimate.pixel.has_halves() {
                continue;
            }
            let v = estimate.variances(self.sampler)?;
            let samples = estimate.variances_of_samples();
            let own = estimate.means().map(|mean| 1.0 / (mean * mean + floor));
            let means = estimate.half_means();
            let halves = means.map(|means| means.map(|mean| 1.0 / (mean * mean + floor)));
            let mean = [0, 1, 2].map(|c| match (means[0][c] < 0.0) == (means[1][c] < 0.0) {
                true => 0.5 * (halves[0][c] + halves[1][c]),
                false => 1.0 / floor,
            });
            let spread = [0, 1, 2].map(|c| v[c].max(samples[c]).sqrt());
            let lone = without_lone_light(&rows, column, spread);
            let weights = [0, 1, 2].map(|c| mean[c].max(1.0 / (lone[c] * lone[c] + floor)));
            total += weighted(v, own);
            let degrees = estimate.degrees(self.sampler);
            of_halves.add(weighted(v, mean), degrees, weighted(samples, mean));
            of_bound.add(weighted(v, weights), degrees, weighted(samples, weights));
            pixels += 1;
        }
        if pixels == 0 {
            return None;
        }
        let of_lamps = self.errors_of_lamps(floor);
        let missing = of_lamps.missing;
        let error = |total: f64| (total / pixels as f64).sqrt();
        if total == 0.0 && of_halves.largest.is_empty() && missing == 0.0 {
            return Some(ErrorEstimate { value: 0.0, bound: 0.0, against_better: 0.0, reliable: true });
        }
        let ((_, degrees), (bound, _)) = (of_halves.bound(level), of_bound.bound(level));
        let alike = of_halves.total <= MOST_ACROSS * MOST_ACROSS * total;
        let is_known = alike && 0.5 / degrees <= RELIABLE * RELIABLE;
        let reliable = is_known && total + missing <= MOST_ACROSS * MOST_ACROSS * total;
        let bound = bound.max(total) + missing + of_lamps.excess;
        Some(ErrorEstimate {
            value: error(total),
            bound: error(bound),
            against_better: error(of_halves.total),
            reliable,
        })
    }
}

/// A pixel's radiance without light that its neighbours do not have: without its `spread`, but at least as bright as the second brightest of the
/// pixels around it. The pixel is in the middle one of three rows, of which the first or the last is empty at the border.
fn without_lone_light(rows: &[Vec<Rgb<f64>>; 3], column: usize, spread: Rgb<f64>) -> Rgb<f64> {
    let mut brightest = [[0.0f64; 2]; 3];
    for (i, row) in rows.iter().enumerate() {
        for x in (column.saturating_sub(1)..(column + 2).min(row.len())).filter(|x| (i, *x) != (1, column)) {
            for ([first, second], mean) in brightest.iter_mut().zip(row[x]) {
                *second = second.max(mean.min(*first));
                *first = first.max(mean);
            }
        }
    }
    let means = rows[1][column];
    [0, 1, 2].map(|c| means[c].min(brightest[c][1].max(means[c] - spread[c])).max(0.0))
}

/// The mean over channels.
pub(super) fn weighted(variance: Rgb<f64>, weight: Rgb<f64>) -> f64 {
    (variance[0] * weight[0] + variance[1] * weight[1] + variance[2] * weight[2]) / 3.0
}

/// [`Film::relative_error`] of an image whose pixels have these variances of their means. `None` if it has no light, or a pixel without a variance.
pub fn relative_error(rgb: &[Rgb<f64>], variances: &[Option<Rgb<f64>>]) -> Option<f64> {
    let mean = rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>() / rgb.len() as f64;
    let floor = DARK_PIXEL_FLOOR * mean * mean;
    let mut total = 0.0;
    for (rgb, variance) in rgb.iter().zip(variances) {
        total += weighted((*variance)?, rgb.map(|mean| 1.0 / (mean * mean + floor)));
    }
    (mean != 0.0).then(|| (total / rgb.len() as f64).sqrt())
}

/// The squared relative errors of pixels ([`Film::error_estimate`]), summed.
#[derive(Clone, Debug, Default)]
struct NoiseSum {
    /// Σ x, and the estimate of its variance.
    total: f64,
    variance: f64,
    /// The pixels with the largest w, the largest first: w, x, and the part of the variance. No more pixels than these can have more than
    /// [`MOST_OF_HALVES`] each.
    largest: Vec<Rgb<f64>>,
}

impl NoiseSum {
    /// Adds a pixel: its x, the degrees of freedom of x, and its w.
    fn add(&mut self, x: f64, degrees: f64, w: f64) {
        const MOST: usize = (1.0 / MOST_OF_HALVES) as usize;
        let variance = 2.0 * degrees / (degrees + 2.0) * x * x;
        self.total += x;
        self.variance += variance;
        if w > 0.0 && (self.largest.len() < MOST || self.largest.last().is_some_and(|[least, ..]| w > *least)) {
            let index = self.largest.partition_point(|[larger, ..]| *larger >= w);
            self.largest.insert(index, [w, x, variance]);
            self.largest.truncate(MOST);
        }
    }

    /// The bound that the sum of the image's own squared errors exceeds with the probability `level`, and the degrees of freedom of the estimate.
    fn bound(&self, level: f64) -> (f64, f64) {
        let (mut of_halves, mut of_samples) = ([self.total, self.variance], [0.0, 0.0]);
        for [w, x, variance] in &self.largest {
            if *w <= MOST_OF_HALVES * (of_samples[0] + of_halves[0]) {
                break;
            }
            of_samples = [of_samples[0] + w, of_samples[1] + 2.0 * w * w];
            of_halves = [(of_halves[0] - x).max(0.0), (of_halves[1] - variance).max(0.0)];
        }
        let total = of_samples[0] + of_halves[0];
        // T² overestimates (E T)² by the variance of T, which is subtracted for pixels that count by halves.
        let degrees = |of_samples: f64| match of_samples + of_halves[1] {
            variance if variance > 0.0 => (2.0 * (total * total - of_halves[1]) / variance).max(0.0),
            _ => f64::INFINITY,
        };
        let (of_image, of_estimate) = (degrees(of_samples[1]), degrees(of_samples[1] / DEGREES_OF_SAMPLES));
        (total * upper_fisher(of_image, of_estimate, level), of_estimate)
    }
}

/// The relative error of an image ([`Film::error_estimate`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    pub value: f64,
    /// The error of this image is below this, but for the requested probability; infinite if nothing is known.
    pub bound: f64,
    /// The error relative to an image without the bright samples of this one, estimated by its halves.
    pub against_better: f64,
    /// Whether enough pixels carry it, and the halves agree on the radiance that it is relative to.
    pub reliable: bool,
}

/// The value that a variable of Fisher's distribution F(μ, ν) exceeds with the probability `level` ≤ 1/2, by Paulson's cube root (Annals of
/// Mathematical Statistics 13(2), 1942; Abramowitz and Stegun, 26.6.15). For ν below 10 it is too large, and at last infinite, which is
/// safe.
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
