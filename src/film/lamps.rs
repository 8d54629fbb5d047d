//! Lamps that the camera sees, at their edges: what a pixel's error should be if few of its samples see the lamp, or none.

use std::collections::{BTreeMap, HashSet};

use super::{Film, NoiseSum, weighted};
use crate::data::{LampPixel, luminance};

/// The most pixels that are kept. If more have the edge of a lamp, each stands for several.
const MOST_PIXELS: usize = 1 << 10;
/// If fewer samples of a pixel see a lamp on average, what the others show does not tell its error.
const FEW: f64 = 8.0;

/// What is expected of the pixels in which few samples see a lamp.
#[derive(Default)]
pub(super) struct Expected {
    /// These pixels.
    pub pixels: HashSet<usize>,
    /// With the sum of their expected errors alone.
    pub noise: NoiseSum,
}

impl Film {
    /// Sets the pixels that lamps cover in part, by those of the full image.
    pub fn with_lamps(self, of_full_image: &[LampPixel]) -> Film {
        let (part, (width, _)) = (self.frame.part, self.frame.full);
        let own = |lamp: &LampPixel| {
            let column = (lamp.pixel % width).checked_sub(part.left).filter(|column| *column < part.width)?;
            let row = (lamp.pixel / width).checked_sub(part.top).filter(|row| *row < part.height)?;
            Some(LampPixel { pixel: row * part.width + column, ..*lamp })
        };
        let mut lamps: Vec<LampPixel> = of_full_image.iter().filter_map(own).collect();
        if lamps.len() > MOST_PIXELS {
            let count = lamps.len() as f32 / MOST_PIXELS as f32;
            // An even choice, which no pattern in the image can match: the fractions of multiples of the golden ratio.
            lamps.sort_by_cached_key(|lamp| (lamp.pixel + 1).wrapping_mul(0x9e37_79b9));
            lamps.truncate(MOST_PIXELS);
            lamps.iter_mut().for_each(|lamp| lamp.count *= count);
            lamps.sort_by_key(|lamp| lamp.pixel);
        }
        Film { lamps, ..self }
    }

    /// Sets the pixels that lamps cover in part, by its own indices.
    pub fn having_lamps(self, lamps: Vec<LampPixel>) -> Film {
        Film { lamps, ..self }
    }

    /// The pixels that lamps cover in part.
    pub fn lamps(&self) -> &[LampPixel] {
        &self.lamps
    }

    /// What is expected of the pixels in which few samples see a lamp: the error by independent samples. A share c of a pixel that shows the
    /// radiance L adds c (1 - c) L² / N to its variance.
    pub(super) fn expected_of_lamps(&self, floor: f64) -> Expected {
        let mut expected = Expected::default();
        let seen = self.seen_of_lamps();
        for lamp in &self.lamps {
            let index = lamp.pixel as usize;
            let estimate = self.estimate(index);
            let (samples, share) = (estimate.pixel.samples() as f64, f64::from(lamp.share));
            if samples == 0.0 || share * samples >= FEW {
                continue;
            }
            let (means, variances) = (estimate.means(), estimate.variances_of_samples());
            let mut weights = [0.0; 3];
            let variance = [0, 1, 2].map(|c| {
                let (mean, square) = (f64::from(lamp.mean[c]), f64::from(lamp.square[c]));
                // The rest of the pixel is what its samples show but for those that see the lamp. If k of them do, their variance is
                // k/N (1 - k/N) L².
                let of_lamp = (square / share).sqrt();
                let seen = (0.25 - (variances[c] * samples / (of_lamp * of_lamp)).min(0.25)).sqrt();
                let rest = if of_lamp > 0.0 { (means[c] - (0.5 - seen) * of_lamp).max(0.0) } else { means[c] };
                weights[c] = 1.0 / ((mean + rest) * (mean + rest) + floor);
                (square - mean * mean).max(0.0) / samples
            });
            let visible = seen.get(&lamp.lamp).copied().unwrap_or(1.0);
            let count = f64::from(lamp.count);
            let error = visible * weighted(variance, weights);
            if count == 1.0 {
                expected.pixels.insert(index);
            }
            let [sum, of_image] = &mut expected.noise.expected;
            *sum += count * error;
            *of_image += 2.0 * count * error * error;
        }
        expected
    }

    /// The share of each lamp that nothing hides, at most: its edges should be seen by k samples, and the pixels are as bright as by n. The limit
    /// of a Poisson variable by its value n is n + 2 √n + 3.
    fn seen_of_lamps(&self) -> BTreeMap<u32, f64> {
        let mut sums: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for lamp in &self.lamps {
            let estimate = self.estimate(lamp.pixel as usize);
            let (samples, count) = (estimate.pixel.samples() as f64, f64::from(lamp.count));
            let of_lamp = (luminance(lamp.square.map(f64::from)) / f64::from(lamp.share)).sqrt();
            let seen = (luminance(estimate.means()) / of_lamp).clamp(0.0, 1.0);
            let [expected, found] = sums.entry(lamp.lamp).or_default();
            *expected += count * samples * f64::from(lamp.share);
            *found += count * samples * seen;
        }
        let share = |[expected, found]: [f64; 2]| ((found + 2.0 * found.sqrt() + 3.0) / expected).min(1.0);
        sums.into_iter().map(|(lamp, sums)| (lamp, share(sums))).collect()
    }
}
