//! Lamps that the camera sees: the error of a pixel at their edge if too few of its samples see the lamp, or none.

use std::collections::BTreeMap;

use super::Film;
use super::error::weighted;
use crate::data::{LampPixel, luminance};

/// The most pixels that are kept. If more have the edge of a lamp, each stands for several.
const MOST_PIXELS: usize = 1 << 10;
/// If at least so many samples of a pixel should see a lamp, some do, and tell its error.
const FEW: f64 = 8.0;

/// The squared relative errors by lamps, summed over pixels in which few samples see them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LampErrors {
    /// By what pixels lack.
    pub missing: f64,
    /// By what pixels have too much.
    pub excess: f64,
}

impl Film {
    /// Sets the pixels that lamps cover in part, by those of the full image.
    pub fn with_lamps(mut self, of_full_image: &[LampPixel]) -> Film {
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
        self.bound.lamps = lamps;
        self
    }

    /// The squared relative errors of pixels in which few samples see a lamp; `floor` is that of the relative error.
    ///
    /// A share c of a pixel's N samples should see the lamp, whose radiance is L. If k of them do, the pixel lacks (c - k/N) L, which is all
    /// of it if k = 0. These samples alone have the variance k/N (1 - k/N) L², from which k follows. If other noise adds to that, k is too
    /// large, and that noise is in the measured error.
    ///
    /// If k/N > c, the pixel has (k/N - c) L too much. The halves do not tell: with one such sample each, they agree. Other noise must not count
    /// as a lamp, so the square is at most 2 V, with V the variance of the pixel's mean by that of its samples. Two samples of a lamp that none
    /// should see have V = 2 (L/N)², half of the square.
    pub(super) fn errors_of_lamps(&self, floor: f64) -> LampErrors {
        let visible = self.visible_lamps();
        let mut errors = LampErrors::default();
        for lamp in &self.bound.lamps {
            let estimate = self.estimate(lamp.pixel as usize);
            let (samples, share) = (estimate.pixel.samples() as f64, f64::from(lamp.share));
            if samples == 0.0 || share * samples >= FEW {
                continue;
            }
            let (means, variances) = (estimate.means(), estimate.variances_of_samples());
            let (mut missing, mut excess, mut weights) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            for c in 0..3 {
                let (mean, square) = (f64::from(lamp.mean[c]), f64::from(lamp.square[c]));
                if square == 0.0 {
                    continue;
                }
                let of_lamp = (square / share).sqrt();
                let found = 0.5 - (0.25 - (variances[c] * samples / (of_lamp * of_lamp)).min(0.25)).sqrt();
                let rest = (means[c] - found * of_lamp).max(0.0);
                let lacks = mean * (1.0 - found / share);
                match found < share {
                    true => missing[c] = lacks * lacks,
                    false => excess[c] = (lacks * lacks).min(2.0 * variances[c]),
                }
                weights[c] = 1.0 / ((mean + rest) * (mean + rest) + floor);
            }
            let (count, visible) = (f64::from(lamp.count), visible.get(&lamp.lamp).copied().unwrap_or(1.0));
            errors.missing += count * visible * weighted(missing, weights);
            errors.excess += count * weighted(excess, weights);
        }
        errors
    }

    /// The share of each lamp that nothing hides, at most: its edges should be seen by k samples, and the pixels are as bright as by n. The limit
    /// of a Poisson variable by its value n is n + 2 √n + 3.
    fn visible_lamps(&self) -> BTreeMap<u32, f64> {
        let mut sums: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        for lamp in &self.bound.lamps {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{PixelTotals, SQUARE_FRACTION, SUM_FRACTION, Sampler};
    use crate::film::Totals;
    use crate::job::{Crop, Frame};

    const RADIANCE: f32 = 64.0;

    fn lamp(pixel: u32, share: f32) -> LampPixel {
        let (mean, square) = ([share * RADIANCE; 3], [share * RADIANCE * RADIANCE; 3]);
        LampPixel { pixel, count: 1.0, lamp: 0, share, mean, square }
    }

    /// 100 pixels of radiance 1 with 16 samples, in one of which some samples have seen the lamp.
    fn film(seen: [u32; 100]) -> Film {
        let mut film = Film::with_sampler(100, 1, 0, Sampler::Sobol).expect("it is small");
        let words = |sum: f64, fraction: u32| {
            let sum = (sum * 2f64.powi(fraction as i32)) as i128;
            [0, 32, 64, 96].map(|shift| (sum >> shift) as u32)
        };
        let pixels: Vec<PixelTotals> = (0..100)
            .map(|index| {
                let mut totals = PixelTotals { samples: [8, 8], runs: 2, ..PixelTotals::default() };
                let k = f64::from(seen[index]);
                // A little noise. All that see the lamp are in the first run.
                let noise = if index % 2 == 0 { 0.03 } else { -0.03 };
                let squares = f64::from(RADIANCE).powi(2) * k * (1.0 - k / 8.0) + 0.01;
                for c in 0..3 {
                    totals.sums[c] = words(8.0 + noise + k * f64::from(RADIANCE), SUM_FRACTION);
                    totals.sums[3 + c] = words(8.0 - noise, SUM_FRACTION);
                    totals.sums[6 + c] = words(squares, SQUARE_FRACTION);
                }
                totals
            })
            .collect();
        film.add(pixels.iter().enumerate(), Totals::default());
        film
    }

    /// A pixel that shows nothing of the lamp lacks c L, relative to what it should show.
    #[test]
    fn a_lamp_that_no_sample_has_seen_is_missing() {
        let film = film([0; 100]);
        let own = film.error_estimate(0.05).expect("it has light");
        let share = 0.01f32;
        let with = film.clone().with_lamps(&[lamp(7, share)]).error_estimate(0.05).expect("it has light");
        let lacks = f64::from(share * RADIANCE);
        let missing = (lacks / (1.0 + lacks)).powi(2) / 1.01;
        let expected = (own.bound.powi(2) + missing / 100.0).sqrt();
        assert!((with.bound / expected - 1.0).abs() < 0.02, "{with:?} {own:?} {expected}");
        assert_eq!((with.value, with.reliable), (own.value, false));
        // If it were a small part of the error, that would be reliable.
        let little = film.clone().with_lamps(&[lamp(7, 0.0004)]).error_estimate(0.05).expect("it has light");
        assert!(little.reliable && little.bound > own.bound, "{little:?} {own:?}");
        // Where many samples see it, their variance is measured.
        assert_eq!(film.with_lamps(&[lamp(7, 0.6)]).error_estimate(0.05), Some(own));
    }

    /// The rest of a lamp that few samples have seen is missing; nothing if they are enough.
    #[test]
    fn samples_that_have_seen_the_lamp_are_not_missing() {
        let with = |seen: u32| {
            let mut all = [0; 100];
            all[7] = seen;
            let film = film(all).with_lamps(&[lamp(7, 3.0 / 16.0)]);
            film.errors_of_lamps(0.01).missing
        };
        let missing = [0, 1, 2, 3, 4].map(with);
        let lacks = |samples: f64| (samples * 64.0 / 16.0 / 13.0).powi(2);
        for (found, samples) in missing.into_iter().zip([3.0, 2.0, 1.0]) {
            assert!((found / lacks(samples) - 1.0).abs() < 0.2, "{missing:?}");
        }
        // The samples of one run say k/8 (1 - k/8) for 2k/16 (1 - 2k/16).
        assert!(missing[3] < 0.02 && missing[4] < 0.005, "{missing:?}");
    }

    /// A lamp that one of a hundred samples should see, and more do.
    #[test]
    fn samples_of_a_lamp_that_are_too_many_are_an_excess() {
        let with = |seen: u32| {
            let mut all = [0; 100];
            all[7] = seen;
            let film = film(all).with_lamps(&[lamp(7, 0.01)]);
            film.errors_of_lamps(0.01)
        };
        for seen in [1, 2, 4] {
            let (errors, k) = (with(seen), f64::from(seen));
            // The variance of a sample, over L², of k that one run of eight has seen.
            let variance = k * (1.0 - k / 8.0) / 14.0;
            let found = 0.5 - (0.25 - variance).sqrt();
            let should = 1.0 + f64::from(RADIANCE) * (k / 16.0 - found + 0.01);
            // Four are as noise of twice the variance of the mean.
            let square = if seen < 4 { (found - 0.01).powi(2) } else { 2.0 * variance / 16.0 };
            let expected = square * (f64::from(RADIANCE) / should).powi(2);
            assert!((errors.excess / expected - 1.0).abs() < 0.05, "{errors:?} {expected}");
            assert_eq!(errors.missing, 0.0);
        }
        assert_eq!(with(0).excess, 0.0);
    }

    /// A lamp that should be seen by many samples and is seen by none is hidden.
    #[test]
    fn a_lamp_that_is_hidden_is_not_missing() {
        let film = film([0; 100]);
        let few = film.clone().with_lamps(&[lamp(7, 0.1)]).errors_of_lamps(0.01).missing;
        let lamps: Vec<_> = (7..40).map(|pixel| lamp(pixel, if pixel == 7 { 0.1 } else { 0.9 })).collect();
        let hidden = film.with_lamps(&lamps).errors_of_lamps(0.01).missing;
        assert!(few > 0.5 && hidden < 0.1 * few, "{few} {hidden}");
    }

    #[test]
    fn a_part_of_an_image_has_the_lamps_of_its_pixels() {
        let frame = Frame { part: Crop { left: 2, top: 1, width: 3, height: 2 }, full: (10, 5) };
        let film = Film::new(3, 2, 0).expect("it is small").of_part(frame);
        let lamps: Vec<LampPixel> = [1, 11, 12, 14, 15, 22, 32].map(|pixel| lamp(pixel, 0.5)).to_vec();
        let own: Vec<u32> = film.with_lamps(&lamps).bound.lamps.iter().map(|lamp| lamp.pixel).collect();
        assert_eq!(own, [0, 2, 3]);
        // Some stand for all.
        let film = Film::new(100, 100, 0).expect("it is small");
        let lamps: Vec<LampPixel> = (0..5000).map(|pixel| lamp(2 * pixel, 0.5)).collect();
        let film = film.with_lamps(&lamps);
        let count: f32 = film.bound.lamps.iter().map(|lamp| lamp.count).sum();
        let left: f32 = film.bound.lamps.iter().filter(|lamp| lamp.pixel < 5000).map(|lamp| lamp.count).sum();
        assert_eq!((film.bound.lamps.len(), count), (MOST_PIXELS, 5000.0));
        assert!((left - 2500.0).abs() < 50.0, "{left}");
    }

    /// Files keep every bit.
    #[test]
    fn pixels_are_the_same_from_a_file() {
        let lamps =
            [LampPixel { lamp: 3, mean: [0.1, -1e-30, 3e30], ..lamp(u32::MAX, 1.0 / 3.0) }, LampPixel::default()];
        let text = serde_json::to_string(&lamps).expect("they are numbers");
        assert_eq!(serde_json::from_str::<Vec<LampPixel>>(&text).expect("they are numbers"), lamps);
        assert!(text.len() < 200, "{text}");
    }
}
