//! The size of the images that a budget allows, and how their times and noise scale to the whole size.

use std::time::{Duration, Instant};

use super::pace::median;
use super::replicates::{FEWEST_ROUNDS, Pixels, Weights, noise, signed_bias, squared_bias};
use super::sweep::{LEVEL, SAMPLES_OF_ROUND, Sweep, coarsened};
use crate::error::Result;
use crate::metrics::estimate::Estimate;

/// The most pixels of an image: more say the same about the settings.
const MOST_PIXELS: f64 = 65_536.0;
/// The fewest pixels that still show the scene.
pub const FEWEST_PIXELS: f64 = 1_024.0;
/// The size is chosen for this many rounds.
const ROUNDS: f64 = 12.0;

/// The pixels of each image, so that `time` is enough for all settings; a sample of one pixel takes `of_pixel` seconds.
pub fn pixels_for(of_pixel: f64, settings: usize, time: Duration) -> f64 {
    let round = of_pixel * SAMPLES_OF_ROUND * settings as f64;
    (time.as_secs_f64() / (round * ROUNDS)).clamp(FEWEST_PIXELS, MOST_PIXELS)
}

/// The defaults at the whole size.
#[derive(Clone, Debug)]
pub struct Whole {
    /// Seconds of a sample and relMSE by noise over those at the sweep's size. All settings are taken to change alike.
    pub slower: f64,
    pub noisier: f64,
    pub size: (u32, u32),
    /// Images of the defaults, each with its own random numbers; none where the time was not enough.
    pub images: Vec<Pixels>,
}

impl Whole {
    /// Of a sweep that is itself at the whole size.
    pub fn of_sweep(sweep: &Sweep<'_>) -> Whole {
        let blocks = sweep.subjects.first().and_then(|defaults| defaults.blocks.get(&LEVEL));
        let images = blocks.into_iter().flatten().map(|block| block.image.clone()).collect();
        Whole { slower: 1.0, noisier: 1.0, size: sweep.size, images }
    }

    /// Where it was not measured, the time is taken to be that of so many more pixels.
    pub fn unknown(sweep: &Sweep<'_>, size: (u32, u32)) -> Whole {
        Whole { slower: pixels_ratio(size, sweep.size), noisier: 1.0, size, images: Vec::new() }
    }

    /// The bias of an image of a share of the sides: of the mean, and squared pixel by pixel. A pixel of it has the expectation of the mean over
    /// those that it stands for, which the images of the whole size tell: nothing else needs to be rendered. That of another size
    /// would be another bias, since edges take more of a smaller image.
    pub fn lost_detail(&self, share: f64) -> Option<(Estimate, Estimate)> {
        let weights = Weights::of_rounds(self.images.iter().enumerate().map(|(i, image)| (i, 1, image)))?;
        let coarse: Vec<Pixels> = self.images.iter().map(|image| coarsened(image, self.size, share)).collect();
        let signed = signed_bias(&coarse, &self.images, &weights.image)?;
        Some((signed, squared_bias(&coarse, &self.images, &weights)?))
    }
}

/// A ratio of noises is believed to be 1 at first, with this standard error of its logarithm. Where few images with rare bright paths tell it, it
/// was 0.46 by chance, and so were the times that are promised.
const USUAL: f64 = 0.1;

/// How many times as large the one noise is: the logarithm, weighed by how sure it is against what is believed.
fn ratio(whole: Estimate, small: Estimate) -> f64 {
    let error = (whole.error / whole.value).hypot(small.error / small.value);
    let believed = USUAL * USUAL / (USUAL * USUAL + error * error);
    let ratio = (believed * (whole.value / small.value).ln()).exp();
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

/// The most samples of an image of the whole size.
const MOST_SAMPLES: u32 = LEVEL;

/// Measures the defaults at the whole size. None where the time is too short.
pub fn calibrate(
    sweep: &mut Sweep<'_>,
    whole: (u32, u32),
    until: Instant,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Whole>> {
    let sweep_seed = sweep.seed;
    let Some(defaults) = sweep.subjects.first() else { return Ok(None) };
    let Some(block) = defaults.blocks.get(&LEVEL).and_then(|blocks| blocks.last()) else { return Ok(None) };
    let (compiling, setting, of_small) = (defaults.seconds_compile, defaults.setting.clone(), block.seconds);
    let left = || until.saturating_duration_since(Instant::now()).as_secs_f64();
    // A pixel of a large image takes less than one of a small image: one sample tells how long.
    let of_sample = of_small / f64::from(LEVEL) * pixels_ratio(whole, sweep.size);
    if stop() || compiling + of_sample > left() {
        return Ok(None);
    }
    let mut large = sweep.of_size(whole);
    large.add(setting)?;
    let seed = |image: u32| Sweep::seed_before(sweep_seed, 1 + image);
    let Some(sample) = large.image(0, 1, seed(0), stop)? else { return Ok(None) };
    // As many samples as there is time for.
    let fitting = |samples: &u32| {
        let small = of_small * (1.0 + f64::from(*samples) / f64::from(LEVEL));
        f64::from(FEWEST_ROUNDS as u32) * (sample.seconds * f64::from(*samples) + small) <= left()
    };
    let samples = (0..u32::BITS).map(|halved| MOST_SAMPLES >> halved).take_while(|samples| *samples > 0).find(fitting);
    let Some(samples) = samples else { return Ok(None) };
    // In turn, so that what slows the machine slows both. The small image is timed with as many samples as the seconds that it is to
    // stretch: a single sample of it is over before the device is busy.
    let (mut at_whole, mut at_small, mut slower) = (Vec::new(), Vec::new(), Vec::new());
    for image in 0..FEWEST_ROUNDS as u32 {
        let seed = seed(image);
        let Some(timed) = sweep.image(0, LEVEL, seed, stop)? else { return Ok(None) };
        let Some(whole) = large.image(0, samples, seed, stop)? else { return Ok(None) };
        let Some(small) = sweep.image(0, samples, seed, stop)? else { return Ok(None) };
        slower.push(whole.seconds / f64::from(samples) / (timed.seconds / f64::from(LEVEL)));
        at_small.push(small.image);
        at_whole.push(whole.image);
    }
    let noise_of = |images: &[Pixels]| {
        let weights = Weights::of_rounds(images.iter().enumerate().map(|(i, image)| (i, samples, image)))?;
        noise(images, &weights, 1)
    };
    let noisier = noise_of(&at_whole).zip(noise_of(&at_small)).map_or(1.0, |(whole, small)| ratio(whole, small));
    Ok(Some(Whole { slower: median(&slower), noisier, size: whole, images: at_whole }))
}

/// The pixels of one size over those of another.
pub fn pixels_ratio(a: (u32, u32), b: (u32, u32)) -> f64 {
    f64::from(a.0) * f64::from(a.1) / (f64::from(b.0) * f64::from(b.1))
}

/// The part in the middle of an image whose sides have divisors enough: all of it, unless the smallest image of whole pixels would have sixteen
/// times as many as one needs. Then both sides are multiples of 15, or of 24 where that is even, and as odd as they were: the middle stays where
/// it is, to the pixel.
pub fn middle_of((width, height): (u32, u32)) -> (u32, u32) {
    let (w, h) = size_of((width, height), FEWEST_PIXELS, true);
    if f64::from(w) * f64::from(h) <= 16.0 * FEWEST_PIXELS {
        return (width, height);
    }
    let both_even = width.is_multiple_of(2) && height.is_multiple_of(2);
    let side = |side: u32| match (both_even, side.is_multiple_of(2)) {
        (true, _) => side / 24 * 24,
        (false, true) => side / 30 * 30,
        // The largest odd multiple.
        (false, false) => (side / 15 - (side / 15 + 1) % 2) * 15,
    };
    (side(width), side(height))
}

/// The sides of images that are measured are multiples of this, as far as that goes: so that half and a quarter of them show the same.
const SIDES: u32 = 4;

/// The whole size divided so that about so many pixels are left; by a common divisor of both sides where pixels must be whole ones.
pub fn size_of((width, height): (u32, u32), pixels: f64, exact: bool) -> (u32, u32) {
    let times = (f64::from(width) * f64::from(height) / pixels).sqrt().max(1.0);
    if exact {
        let divides = |by: &u32| width.is_multiple_of(*by) && height.is_multiple_of(*by);
        let enough = || (1..=width.min(height)).filter(divides).filter(|by| f64::from(*by) >= times);
        let even = |by: &u32| (width / by).is_multiple_of(SIDES) && (height / by).is_multiple_of(SIDES);
        let near = |by: &u32| f64::from(*by) < 1.5 * times;
        let by = enough().filter(near).find(even).or_else(|| enough().next());
        // None does: as small as it goes.
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
        for whole in [(600, 600), (1200, 675), (48, 48), (1, 1), (47, 43)] {
            assert_eq!(middle_of(whole), whole);
        }
        for (whole, middle) in [
            ((211, 199), (195, 195)),
            ((1000, 667), (990, 645)),
            ((998, 662), (984, 648)),
            ((4001, 16001), (3975, 15975)),
        ] {
            assert_eq!(middle_of(whole), middle);
            assert!((whole.0 - middle.0).is_multiple_of(2) && (whole.1 - middle.1).is_multiple_of(2), "{whole:?}");
            let (w, h) = size_of(middle, FEWEST_PIXELS, true);
            assert!(u64::from(w) * u64::from(h) * 100 < u64::from(whole.0) * u64::from(whole.1), "{whole:?}: {w}x{h}");
        }
    }
}
