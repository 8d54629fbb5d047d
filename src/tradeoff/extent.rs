//! The size of the images that a budget allows, and the scaling of their times and noise to the full size.

use std::time::{Duration, Instant};

use super::pace::median;
use super::replicates::{FEWEST_ROUNDS, Pixels, Weights, noise, signed_bias, squared_bias};
use super::sweep::{LEVEL, SAMPLES_OF_ROUND, Stop, Sweep, coarsened};
use crate::error::Result;
use crate::metrics::error::floor_of;
use crate::metrics::estimate::Estimate;

/// The most pixels of an image. More pixels would not change the findings about the settings.
const MOST_PIXELS: f64 = 65_536.0;
/// The fewest pixels that still show the scene.
pub const FEWEST_PIXELS: f64 = 1_024.0;
/// The number of rounds that the size is chosen for.
const ROUNDS: f64 = 12.0;

/// The number of pixels for which `time` suffices to measure all settings, if a sample of one pixel takes `of_pixel` seconds.
pub fn pixels_for(of_pixel: f64, settings: usize, time: Duration) -> f64 {
    let round = of_pixel * SAMPLES_OF_ROUND * settings as f64;
    (time.as_secs_f64() / (round * ROUNDS)).clamp(FEWEST_PIXELS, MOST_PIXELS)
}

/// Measurements of the defaults at full size.
#[derive(Clone, Debug)]
pub struct FullSize {
    /// Ratios of the seconds of a sample, and of the relative MSE of the noise, to those at the sweep's size. All settings
    /// are assumed to change by the same factors.
    pub slower: f64,
    pub noisier: f64,
    pub size: (u32, u32),
    /// Images of the defaults, each with its own random numbers; none if there was not enough time.
    pub images: Vec<Pixels>,
    /// The seconds that denoising an image takes; 0 if no setting does.
    pub seconds_to_denoise: f64,
}

impl FullSize {
    /// The ratios if the full size was not measured: the time is assumed to grow with the number of pixels. If the sweep itself is of this size,
    /// it has the images.
    pub fn assumed(sweep: &Sweep<'_>, size: (u32, u32)) -> FullSize {
        let defaults = sweep.subjects.first().filter(|_| size == sweep.size);
        let images = defaults.map_or(Vec::new(), |defaults| defaults.images(LEVEL));
        FullSize { slower: pixels_ratio(size, sweep.size), noisier: 1.0, size, images, seconds_to_denoise: 0.0 }
    }

    /// The bias of the mean, and the squared bias of the pixels, of an image with smaller sides. The expectation of a
    /// pixel is the mean over the full-size pixels that it covers, so that the full-size images determine the bias, and
    /// nothing else is rendered. Images of another size would have another bias, because edges cover a larger share of
    /// a smaller image.
    pub fn lost_detail(&self, share: f64) -> Option<(Estimate, Estimate)> {
        let weights = Weights::of_rounds(self.images.iter().enumerate().map(|(i, image)| (i, 1, image)), floor_of)?;
        let coarse: Vec<Pixels> = self.images.iter().map(|image| coarsened(image, self.size, share)).collect();
        let signed = signed_bias(&coarse, &self.images, &weights.image)?;
        Some((signed, squared_bias(&coarse, &self.images, &weights, 1)?))
    }
}

/// The standard error of the logarithm of a ratio of noises in the prior, whose mean ratio is 1. Without a prior, a
/// ratio from few images with rare bright paths was 0.46 by chance, and the predicted times were wrong by this factor.
const USUAL: f64 = 0.1;

/// The ratio of two noises: the measured logarithm and the prior, weighted by their precisions.
fn ratio(full: Estimate, small: Estimate) -> f64 {
    let error = (full.error / full.value).hypot(small.error / small.value);
    let believed = USUAL * USUAL / (USUAL * USUAL + error * error);
    let ratio = (believed * (full.value / small.value).ln()).exp();
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

/// The most samples of an image of the full size.
const MOST_SAMPLES: u32 = LEVEL;

/// Measures the defaults at full size; none if the time is too short.
pub fn calibrate(sweep: &mut Sweep<'_>, full: (u32, u32), until: Instant, stop: Stop<'_>) -> Result<Option<FullSize>> {
    let sweep_seed = sweep.seed;
    let Some(defaults) = sweep.subjects.first() else { return Ok(None) };
    let Some(block) = defaults.blocks_of(LEVEL).last() else { return Ok(None) };
    let (compiling, setting, of_small) = (defaults.seconds_compile, defaults.setting.clone(), block.timed.seconds);
    let left = || until.saturating_duration_since(Instant::now()).as_secs_f64();
    // A pixel of a large image takes less time than one of a small image. One sample measures how much.
    let of_sample = of_small / f64::from(LEVEL) * pixels_ratio(full, sweep.size);
    if stop() || compiling + of_sample > left() {
        return Ok(None);
    }
    let mut large = sweep.of_size(full);
    large.add(setting)?;
    let seed = |image: u32| Sweep::seed_before(sweep_seed, 1 + image);
    let Some(sample) = large.image(0, 1, seed(0), stop)? else { return Ok(None) };
    // The largest number of samples that there is time for.
    let fitting = |samples: &u32| {
        let small = of_small * (1.0 + f64::from(*samples) / f64::from(LEVEL));
        f64::from(FEWEST_ROUNDS as u32) * (sample.timed.seconds * f64::from(*samples) + small) <= left()
    };
    let samples = (0..u32::BITS).map(|halved| MOST_SAMPLES >> halved).take_while(|samples| *samples > 0).find(fitting);
    let Some(samples) = samples else { return Ok(None) };
    // The two sizes alternate, so that other load on the machine slows both. The small image is timed with as many samples as the
    // measured seconds had: a single sample of it ends before the device is busy.
    let (mut at_full_size, mut at_small, mut slower) = (Vec::new(), Vec::new(), Vec::new());
    for image in 0..FEWEST_ROUNDS as u32 {
        let seed = seed(image);
        let Some(timed) = sweep.image(0, LEVEL, seed, stop)? else { return Ok(None) };
        let Some(full) = large.image(0, samples, seed, stop)? else { return Ok(None) };
        let Some(small) = sweep.image(0, samples, seed, stop)? else { return Ok(None) };
        slower.push(full.timed.seconds / f64::from(samples) / (timed.timed.seconds / f64::from(LEVEL)));
        at_small.push(small.image);
        at_full_size.push(full.image);
    }
    let noise_of = |images: &[Pixels]| {
        let weights = Weights::of_rounds(images.iter().enumerate().map(|(i, image)| (i, samples, image)), floor_of)?;
        noise(images, &weights, 1)
    };
    let noisier = noise_of(&at_full_size).zip(noise_of(&at_small)).map_or(1.0, |(full, small)| ratio(full, small));
    Ok(Some(FullSize { slower: median(&slower), noisier, size: full, images: at_full_size, seconds_to_denoise: 0.0 }))
}

/// The ratio of the numbers of pixels of two sizes.
pub fn pixels_ratio(a: (u32, u32), b: (u32, u32)) -> f64 {
    f64::from(a.0) * f64::from(a.1) / (f64::from(b.0) * f64::from(b.1))
}

/// The size of the middle part of an image whose sides have enough divisors. It is all of the image, unless the smallest
/// image of complete pixels would have sixteen times [`FEWEST_PIXELS`]. If so, both sides become multiples of 15, or of 24
/// if even. A side keeps its parity, so that the middle of the part is exactly the middle of the image.
pub fn middle_of((width, height): (u32, u32)) -> (u32, u32) {
    let (w, h) = size_of((width, height), FEWEST_PIXELS, true);
    if f64::from(w) * f64::from(h) <= 16.0 * FEWEST_PIXELS {
        return (width, height);
    }
    let both_even = width.is_multiple_of(2) && height.is_multiple_of(2);
    let side = |side: u32| match (both_even, side.is_multiple_of(2)) {
        (true, _) => side / 24 * 24,
        (false, true) => side / 30 * 30,
        // The largest odd multiple of 15.
        (false, false) => (side / 15 - (side / 15 + 1) % 2) * 15,
    };
    (side(width), side(height))
}

/// The sides of measured images are multiples of this if possible, so that images of half and a quarter of the sides
/// show the same view.
const SIDES: u32 = 4;

/// The full size, reduced to about `pixels` pixels. If `exact`, both sides are divided by a common divisor.
pub fn size_of((width, height): (u32, u32), pixels: f64, exact: bool) -> (u32, u32) {
    let times = (f64::from(width) * f64::from(height) / pixels).sqrt().max(1.0);
    if exact {
        let divides = |by: &u32| width.is_multiple_of(*by) && height.is_multiple_of(*by);
        let enough = || (1..=width.min(height)).filter(divides).filter(|by| f64::from(*by) >= times);
        let even = |by: &u32| (width / by).is_multiple_of(SIDES) && (height / by).is_multiple_of(SIDES);
        let near = |by: &u32| f64::from(*by) < 1.5 * times;
        let by = enough().filter(near).find(even).or_else(|| enough().next());
        // If no divisor fits, the largest common one.
        let by = by.or_else(|| (1..=width.min(height)).rfind(divides)).unwrap_or(1);
        return (width / by, height / by);
    }
    if times <= 1.0 {
        return (width, height);
    }
    let side = |side: u32| ((f64::from(side) / times / f64::from(SIDES)).round() as u32 * SIDES).clamp(1, side);
    (side(width).max(1), side(height).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_by_chance_is_not_believed() {
        let noise = |value: f64, share: f64| Estimate { value, error: share * value, degrees: 2.0 };
        assert!((ratio(noise(0.8, 0.01), noise(1.0, 0.01)) / 0.8 - 1.0).abs() < 0.01);
        assert!((0.9..1.0).contains(&ratio(noise(0.46, 0.3), noise(1.0, 0.2))));
        assert_eq!(ratio(noise(0.0, 0.0), noise(0.0, 0.0)), 1.0);
    }

    #[test]
    fn the_middle_of_an_image_has_divisors() {
        for size in [(600, 600), (1200, 675), (48, 48), (1, 1), (47, 43)] {
            assert_eq!(middle_of(size), size);
        }
        for (full, middle) in [
            ((211, 199), (195, 195)),
            ((1000, 667), (990, 645)),
            ((998, 662), (984, 648)),
            ((4001, 16001), (3975, 15975)),
        ] {
            assert_eq!(middle_of(full), middle);
            assert!((full.0 - middle.0).is_multiple_of(2) && (full.1 - middle.1).is_multiple_of(2), "{full:?}");
            let (w, h) = size_of(middle, FEWEST_PIXELS, true);
            assert!(u64::from(w) * u64::from(h) * 100 < u64::from(full.0) * u64::from(full.1), "{full:?}: {w}x{h}");
        }
    }
}
