//! The film: exact sums of the samples of each pixel, which do not depend on the order.
//!
//! The device adds sums over short runs of samples as integers of a fixed scale (shaders/step/film.wgsl): a sum of integers is the same in
//! any order and split. It also adds the sums of squares that the error estimate needs. The host joins the device's totals here.

mod channels;
mod estimate;
mod floats;
mod lamps;
mod pixel;
mod totals;
mod values;
mod verdict;
mod words;

use crate::aov::{Aovs, SceneSpace};
use crate::data::{LampPixel, PixelTotals, Rgb, Sampler, luminance};
use crate::error::{Error, Result};
use crate::job::Frame;
use crate::memory;
pub use channels::{device_bytes, record_bytes};
pub use totals::{HiddenLight, Rejected, TooDeep, Totals};
pub use verdict::Verdict;
pub use words::{sample_variance_of, word_names};

use channels::Channels;
use estimate::Estimate;
use floats::{exp2, to_f32};
use pixel::Pixel;

/// The value of [`Picture::variance`] if the variance is not known: the largest finite f32. An image file must hold finite values, 0
/// would mean an exact pixel, and a program that takes this one for a variance ignores the pixel, which is right.
pub const UNKNOWN_VARIANCE: f32 = f32::MAX;

/// The most bytes of a pixel on the host: its totals, and seven bytes while a PNG is written. An EXR is written row by row.
const BYTES_OF_A_PIXEL: u64 = size_of::<Pixel>() as u64 + 7;
/// The largest power of two, up or down, between device units and scene units: its square is far inside f64.
const MAX_EXPONENT: i32 = 300;
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
/// The exact totals of an image.
///
/// Range, in device units (scene radiance / 2^exponent). A pixel's sum holds 2^-88 to 2^39, of either sign: every f32 from 2^-65 on is added
/// without rounding, smaller ones are rounded to 2^-88, and 2^30 samples of mean 500 fit. Its squared deviations hold 2^-96 to 2^31: 2^29
/// samples that deviate by 2 fit. Deviations below about 2^-43 are not known; the variance then comes from the two halves, which are exact
/// to 2^-88. Sums of splats and of their squares have the same ranges. Beyond the range, a total saturates (a saturating sum of numbers of
/// one sign is still the same in any order), and the variance is unknown. So the device's unit should be about the radiance of the brightest
/// thing that is often seen.
///
/// Memory: 160 bytes a pixel, and 16 more for each sum of further channels and of splats: 144 in all with light paths.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    exponent: i32,
    sampler: Sampler,
    /// The largest radiance, in device units, of what its paths do not sample as a light: they find it by BSDF sampling alone.
    not_sampled: f64,
    /// The pixels that lamps cover in part, for the bound of the error.
    lamps: Vec<LampPixel>,
    /// The part of the image that the pixels are of.
    frame: Frame,
    pixels: Vec<Pixel>,
    /// The channels of `--aov`, and the splats of light paths.
    channels: Channels,
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

    /// An empty film. The error is estimated from all samples, or with Sobol points from two halves. Device radiance times 2^exponent is scene
    /// radiance; the exponent is within ±300. A render takes a film with the `radiance_exponent` of its scene, and refuses others.
    ///
    /// # Errors
    /// `Error::Usage` if the image has no pixels, more than 2^32, or more than memory holds.
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
        let needs = |memory: String| {
            Error::Usage(format!("an image of {width} x {height} pixels needs {memory}; use a smaller --size"))
        };
        memory::check(count * BYTES_OF_A_PIXEL).map_err(needs)?;
        let cannot = |_| needs("more memory than can be had".to_string());
        let count = usize::try_from(count).map_err(|_| cannot(()))?;
        // Zeroed pages of the system: writing zeros would take longer than anything else before the first pass of a large film.
        let pixels = bytemuck::allocation::try_zeroed_vec::<Pixel>(count).map_err(cannot)?;
        let frame = Frame::full((width, height));
        let (channels, totals) = (Channels::default(), Totals::default());
        Ok(Film { exponent, sampler, not_sampled: 0.0, lamps: Vec::new(), frame, pixels, channels, totals })
    }

    /// Sets the largest radiance, in device units, of what the paths do not sample as a light, and find by BSDF sampling alone. By default it is 0.
    pub fn not_sampling(self, radiance: f64) -> Film {
        Film { not_sampled: radiance, ..self }
    }

    /// The largest radiance, in device units, of what the paths do not sample as a light.
    pub fn not_sampled(&self) -> f64 {
        self.not_sampled
    }

    /// Adds channels of `--aov` to an empty film. `space` maps the kernels' space to the scene's.
    ///
    /// # Errors
    /// `Error::Usage` if memory does not hold them.
    pub fn with_aovs(self, aovs: &Aovs, space: SceneSpace) -> Result<Film> {
        let channels = Channels::new(self.pixels.len(), aovs, space, self.channels.light_paths)?;
        Ok(Film { channels, ..self })
    }

    /// Sets whether an empty film has sums of the splats of light paths. By default it has none.
    ///
    /// # Errors
    /// `Error::Usage` if memory does not hold them.
    pub fn with_light_paths(self, light_paths: bool) -> Result<Film> {
        let Channels { aovs, space, .. } = &self.channels;
        let channels = Channels::new(self.pixels.len(), aovs, *space, light_paths)?;
        Ok(Film { channels, ..self })
    }

    /// Whether it has sums of the splats of light paths.
    pub fn has_light_paths(&self) -> bool {
        self.channels.light_paths
    }

    /// The channels of `--aov` that it has.
    pub fn aovs(&self) -> &Aovs {
        &self.channels.aovs
    }

    /// The space of the kernels, if the film has channels of `--aov`.
    pub fn space(&self) -> Option<SceneSpace> {
        (!self.channels.aovs.is_empty()).then_some(self.channels.space)
    }

    /// Returns it as the film of a part of an image. The part has the film's size.
    pub fn of_part(self, frame: Frame) -> Film {
        Film { frame, ..self }
    }

    /// The part of the image that it holds.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.pixels.fill(Pixel::default());
        self.channels.clear();
        self.totals = Totals::default();
    }

    pub fn width(&self) -> u32 {
        self.frame.part.width
    }

    pub fn height(&self) -> u32 {
        self.frame.part.height
    }

    /// Scene radiance is the film's radiance times 2 to this exponent.
    pub fn exponent(&self) -> i32 {
        self.exponent
    }

    pub fn sampler(&self) -> Sampler {
        self.sampler
    }

    pub fn totals(&self) -> Totals {
        self.totals
    }

    /// Adds the device's totals of pixels, each with its index (row 0 on top, `y * width + x`), and the totals `counted` of the film. Any order
    /// and any split into calls gives the same film. A pixel outside the image is ignored.
    pub fn add<'a>(&mut self, pixels: impl IntoIterator<Item = (usize, &'a PixelTotals)>, counted: Totals) {
        for (index, totals) in pixels {
            if let Some(pixel) = self.pixels.get_mut(index) {
                pixel.add(&Pixel::from(totals));
            }
        }
        self.totals += counted;
    }

    /// Adds the totals of pixels in the layout of the device's film. The indices are those of [`Film::add`].
    pub fn add_from_device(&mut self, pixels: impl IntoIterator<Item = usize>, bytes: &[u8]) {
        if let (0, Ok(totals)) = (self.channels.count(), bytemuck::try_cast_slice::<u8, PixelTotals>(bytes)) {
            return self.add(pixels.into_iter().zip(totals), Totals::default());
        }
        let each = device_bytes(&self.channels.aovs, self.channels.light_paths) as usize;
        for (index, bytes) in pixels.into_iter().zip(bytes.chunks_exact(each)) {
            let (totals, sums) = bytes.split_at(size_of::<PixelTotals>());
            let totals: PixelTotals = bytemuck::pod_read_unaligned(totals);
            self.channels.add_from_device(index, &totals, sums);
            self.add([(index, &totals)], Totals::default());
        }
    }

    /// Adds another film of the same image. The result is the film of all samples of both.
    pub fn merge(&mut self, other: &Film) -> Result<()> {
        // Splats are divided by the light paths per pixel of the full image.
        let of_light_paths = |film: &Film| film.channels.light_paths.then_some(film.frame.full);
        let aovs = |film: &Film| film.channels.aovs.clone();
        let shape =
            |film: &Film| (film.frame.part.size(), film.exponent, film.sampler, aovs(film), of_light_paths(film));
        if shape(self) != shape(other) {
            let words = |film: &Film, pixels: &str| {
                let light_paths = if film.channels.light_paths { ", with light paths" } else { "" };
                let (width, height) = film.frame.part.size();
                format!("{width} x {height} {pixels}2^{} ({}{light_paths})", film.exponent, film.sampler)
            };
            return Err(Error::Usage(format!(
                "films of different images cannot be joined: {} and {}",
                words(self, "pixels of scale "),
                words(other, "of ")
            )));
        }
        self.pixels.iter_mut().zip(&other.pixels).for_each(|(mine, theirs)| mine.add(theirs));
        self.channels.add(&other.channels);
        self.totals += other.totals;
        self.not_sampled = self.not_sampled.max(other.not_sampled);
        if self.lamps.is_empty() {
            self.lamps.clone_from(&other.lamps);
        }
        Ok(())
    }

    /// The mean over the pixels of the largest component of their radiance, in device units.
    pub fn mean_radiance(&self) -> f64 {
        let largest = |estimate: Estimate| estimate.means().into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.estimates().map(largest).sum::<f64>() / self.pixels.len() as f64
    }

    /// The sums of a pixel that its value and its variance follow from; zeros outside the image.
    fn estimate(&self, index: usize) -> Estimate {
        Estimate {
            pixel: self.pixels.get(index).copied().unwrap_or_default(),
            splats: self.channels.splats(index),
            light_paths: self.light_paths_of_a_pixel(),
        }
    }

    /// The estimates of all pixels.
    fn estimates(&self) -> impl Iterator<Item = Estimate> {
        (0..self.pixels.len()).map(|index| self.estimate(index))
    }

    /// The light paths of even and of odd runs per pixel of the full image; 0 if it has no sums of splats.
    fn light_paths_of_a_pixel(&self) -> [f64; 2] {
        match self.channels.light_paths {
            true => self.totals.light_paths_of_a_pixel(self.frame.full),
            false => [0.0; 2],
        }
    }

    /// Returns the image in scene units.
    pub fn develop(&self) -> Picture {
        let mut picture = Picture { width: self.width(), height: self.height(), ..Picture::default() };
        for pixel in (0..self.pixels.len()).map(|index| self.developed(index)) {
            picture.rgb.push(pixel.rgb);
            picture.variance.push(pixel.variance);
            picture.samples.push(pixel.samples);
            picture.rejected.push(pixel.rejected);
        }
        picture
    }

    /// Returns a pixel in scene units; black outside the image.
    pub fn developed(&self, index: usize) -> PicturePixel {
        let scale = exp2(self.exponent);
        let estimate = self.estimate(index);
        PicturePixel {
            rgb: estimate.means().map(|mean| to_f32(mean * scale)),
            variance: [0, 1, 2].map(|c| variance_to_f32(estimate.variance(c, self.sampler), scale * scale)),
            samples: u32::try_from(estimate.pixel.samples()).unwrap_or(u32::MAX),
            rejected: estimate.pixel.rejected,
        }
    }

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
    ///   relative error of 3 %.
    /// - **A pixel near 0.** With samples of either sign (`--filter mitchell`), a bright edge makes pixels near 0, whose halves may have
    ///   different signs. The true value may then be 0, and the pixel counts with 1/(0.01 Ī²).
    /// - **Many rare bright paths.** If that sum is more than four times T, half of each weight still comes from the bright half, and is too
    ///   small. Then the weight moves to that of the darker half as v/I² approaches 1, where one half holds everything. The bound is the
    ///   larger of both.
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
        let (mut usual, mut rare) = (NoiseSum::default(), NoiseSum::default());
        for estimate in self.estimates() {
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
            let darker = [0, 1, 2].map(|c| {
                let most = halves[0][c].max(halves[1][c]).max(mean[c]);
                mean[c] + (v[c] * own[c]).min(1.0) * (most - mean[c])
            });
            total += weighted(v, own);
            let degrees = estimate.degrees(self.sampler);
            usual.add(weighted(v, mean), degrees, weighted(samples, mean));
            rare.add(weighted(v, darker), degrees, weighted(samples, darker));
            pixels += 1;
        }
        if pixels == 0 {
            return None;
        }
        let of_lamps = self.errors_of_lamps(floor);
        let missing = of_lamps.missing;
        let error = |total: f64| (total / pixels as f64).sqrt();
        if total == 0.0 && usual.largest.is_empty() && missing == 0.0 {
            return Some(ErrorEstimate { value: 0.0, bound: 0.0, against_better: 0.0, reliable: true });
        }
        let (bound, degrees) = usual.bound(level);
        let alike = usual.total <= MOST_ACROSS * MOST_ACROSS * total;
        let bound = if alike { bound } else { bound.max(rare.bound(level).0) };
        let is_known = alike && 0.5 / degrees <= RELIABLE * RELIABLE;
        let reliable = is_known && total + missing <= MOST_ACROSS * MOST_ACROSS * total;
        let bound = bound.max(total) + missing + of_lamps.excess;
        Some(ErrorEstimate { value: error(total), bound: error(bound), against_better: error(usual.total), reliable })
    }
}

/// The mean over channels.
fn weighted(variance: Rgb<f64>, weight: Rgb<f64>) -> f64 {
    (variance[0] * weight[0] + variance[1] * weight[1] + variance[2] * weight[2]) / 3.0
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

/// A developed image: linear scene radiance, row 0 on top. Every value is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Mean radiance, linear Rec. 709. Values beyond f32 are f32::MAX.
    pub rgb: Vec<Rgb<f32>>,
    /// Variance of that mean, radiance squared; [`UNKNOWN_VARIANCE`] if it is not known. Above zero it is at least the smallest normal
    /// f32: a smaller variance is overstated, not lost.
    pub variance: Vec<Rgb<f32>>,
    /// Accepted samples.
    pub samples: Vec<u32>,
    /// Rejected samples.
    pub rejected: Vec<u32>,
}

/// A pixel of a [`Picture`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PicturePixel {
    pub rgb: Rgb<f32>,
    pub variance: Rgb<f32>,
    pub samples: u32,
    pub rejected: u32,
}

impl Picture {
    /// One of its pixels.
    pub fn pixel(&self, index: usize) -> PicturePixel {
        PicturePixel {
            rgb: self.rgb[index],
            variance: self.variance[index],
            samples: self.samples[index],
            rejected: self.rejected[index],
        }
    }
}

fn variance_to_f32(variance: Option<f64>, scale: f64) -> f32 {
    match variance {
        None => UNKNOWN_VARIANCE,
        Some(0.0) => 0.0,
        Some(variance) => to_f32(variance * scale).max(f32::MIN_POSITIVE),
    }
}
