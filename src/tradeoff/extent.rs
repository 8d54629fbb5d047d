//! How large the images are that a budget is enough for, and what their numbers say of images of the whole size.

use std::time::{Duration, Instant};

use super::pace::median;
use super::replicates::{Pixels, noise};
use super::sweep::{Block, FEWEST_ROUNDS, LEVEL, LEVELS, SAMPLES_OF_FEWEST, SAMPLES_OF_ROUND, Subject, Sweep};
use crate::error::Result;

/// The most pixels of the images that are measured: more tell the same about the settings.
const MOST_PIXELS: f64 = 65_536.0;
/// The fewest, below which an image is no picture of its scene.
pub const FEWEST_PIXELS: f64 = 1_024.0;
/// The rounds that the size is chosen for.
const ROUNDS: f64 = 12.0;

/// Seconds of a sample a pixel of the subjects of a pilot. What it did not reach is taken to cost what the others do.
fn costs(pilot: &Sweep<'_>) -> Vec<f64> {
    let of_sample = |subject: &Subject<'_>| {
        let (samples, blocks) = subject.blocks.iter().next_back()?;
        Some(blocks.last()?.seconds / f64::from(*samples))
    };
    let each: Vec<Option<f64>> = pilot.subjects.iter().map(of_sample).collect();
    let known: Vec<f64> = each.iter().flatten().copied().collect();
    let usual = known.iter().sum::<f64>() / known.len().max(1) as f64;
    each.into_iter().map(|cost| cost.unwrap_or(usual)).collect()
}

/// The pixels that so much time is enough for, by what a round of the pilot took.
pub fn pixels_for(pilot: &Sweep<'_>, time: Duration) -> f64 {
    let of_pixel = costs(pilot).iter().sum::<f64>() / pixels_ratio(pilot.size, (1, 1));
    (time.as_secs_f64() / (of_pixel * SAMPLES_OF_ROUND * ROUNDS)).clamp(FEWEST_PIXELS, MOST_PIXELS)
}

/// How many of the pilot's subjects, the first ones, there is time for at its own size, so that it suffices for what they tell at least.
pub fn affordable(pilot: &Sweep<'_>, time: Duration) -> usize {
    // A little more than that: the machine may become slower.
    const MARGIN: f64 = 1.3;
    let sums = costs(pilot).into_iter().scan(0.0, |sum, cost| {
        *sum += cost;
        Some(*sum)
    });
    sums.take_while(|sum| MARGIN * SAMPLES_OF_FEWEST * sum <= time.as_secs_f64()).count().max(1)
}

/// What the defaults take and how noisy they are at the whole size, over the same at the sweep's: seconds of a sample, and relMSE by
/// noise. All settings are taken to change alike. Nothing where the time is not enough.
pub fn calibrate(
    sweep: &mut Sweep<'_>,
    whole: (u32, u32),
    until: Instant,
    stop: &dyn Fn() -> bool,
) -> Result<Option<(f64, f64)>> {
    let Some(defaults) = sweep.subjects.first() else { return Ok(None) };
    let Some(block) = defaults.blocks.get(&LEVEL).and_then(|blocks| blocks.last()) else { return Ok(None) };
    let of_sample = block.seconds / f64::from(LEVEL) * (1.0 + pixels_ratio(whole, sweep.size));
    let left = until.saturating_duration_since(Instant::now()).as_secs_f64() - defaults.seconds_compile;
    // As many samples as there is time for, up to those of a small block.
    let fitting = |samples: &u32| of_sample * f64::from(FEWEST_ROUNDS as u32 * samples) <= left;
    let Some(samples) = [LEVELS[0], 2, 1].into_iter().find(fitting).filter(|_| !stop()) else { return Ok(None) };
    let (mut large, setting) = (sweep.of_size(whole), defaults.setting.clone());
    large.add(setting)?;
    // In turn, so that what slows the machine slows both. The small image is timed with as many samples as the seconds that it is to
    // stretch: a single sample of it is over before the device is busy.
    let (mut at_whole, mut at_small, mut slower) = (Vec::new(), Vec::new(), Vec::new());
    for image in 0..FEWEST_ROUNDS as u32 {
        let seed = Sweep::seed_before(sweep.seed, 1 + image);
        let Some(timed) = sweep.image(0, LEVEL, seed, stop)? else { return Ok(None) };
        let Some(whole) = large.image(0, samples, seed, stop)? else { return Ok(None) };
        let Some(small) = sweep.image(0, samples, seed, stop)? else { return Ok(None) };
        slower.push(whole.seconds / f64::from(samples) / (timed.seconds / f64::from(LEVEL)));
        at_small.push(small);
        at_whole.push(whole);
    }
    let noise_of = |blocks: &[Block]| {
        let images: Vec<Pixels> = blocks.iter().map(|block| block.image.clone()).collect();
        Some(noise(&images, &mean_of(&images))?.value)
    };
    let noisier = noise_of(&at_whole).zip(noise_of(&at_small)).map(|(whole, small)| whole / small);
    Ok(Some((median(&slower), noisier.filter(|ratio| ratio.is_finite() && *ratio > 0.0).unwrap_or(1.0))))
}

/// How many times as many pixels the one size has.
pub fn pixels_ratio(a: (u32, u32), b: (u32, u32)) -> f64 {
    f64::from(a.0) * f64::from(a.1) / (f64::from(b.0) * f64::from(b.1))
}

fn mean_of(images: &[Pixels]) -> Pixels {
    let mut sum = vec![[0.0f64; 3]; images.first().map_or(0, Vec::len)];
    for image in images {
        sum.iter_mut().zip(image).for_each(|(sum, p)| (0..3).for_each(|c| sum[c] += f64::from(p[c])));
    }
    sum.iter().map(|p| p.map(|v| (v / images.len() as f64) as f32)).collect()
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
