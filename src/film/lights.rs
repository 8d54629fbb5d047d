//! The light of groups of lights, in the film's integers.

use super::Film;
use super::estimate::mean;
use super::floats::exp2;
use super::values::ROUNDING;
use crate::data::Rgb;

/// The sums of some light of a pixel: of even and of odd runs, and of their light paths.
type Light = [Rgb<i128>; 4];

impl Film {
    /// The light of a group, or behind all groups the rest of the pixel's light. `None` if a sum has left its range.
    fn light(&self, index: usize, group: usize) -> Option<Light> {
        let groups = self.channels.aovs.groups().len();
        if group < groups {
            return self.channels.light(index, group);
        }
        let super::Estimate { pixel, splats, .. } = self.estimate(index);
        let even = [0, 1, 2].map(|c| pixel.sum[c].saturating_sub(pixel.odd_sum[c]));
        let mut rest = [even, pixel.odd_sum, splats.halves[0], splats.halves[1]];
        for group in 0..groups {
            let light = self.channels.light(index, group)?;
            let sums = rest.iter_mut().flatten().zip(light.iter().flatten());
            sums.for_each(|(rest, light)| *rest = rest.saturating_sub(*light));
        }
        Some(rest)
    }

    /// The radiance of a group of lights of a pixel, or behind all groups that of the rest, in device units. Components of a group follow those of
    /// another. `None` if a sum has left its range.
    pub(super) fn light_value(&self, index: usize, component: usize) -> Option<f64> {
        let (group, c) = (component / 3, component % 3);
        let light = self.light(index, group)?;
        let estimate = self.estimate(index);
        let both = |half: usize| light[half][c].saturating_add(light[half + 1][c]);
        let value = mean(both(0), estimate.pixel.samples() as f64) + mean(both(2), estimate.light_paths.iter().sum());
        let is_rest = group == self.channels.aovs.groups().len();
        Some(if is_rest && value.abs() <= ROUNDING * estimate.mean(c).abs() { 0.0 } else { value })
    }

    /// The variance of a pixel's radiance, in scene units squared, if groups of lights have these factors; the last factor is that of the rest.
    /// It comes from the halves ([`super::estimate::Estimate`]). `None` where a half has no samples.
    pub fn variance_of_mix(&self, index: usize, factors: &[Rgb<f64>]) -> Option<Rgb<f64>> {
        let estimate = self.estimate(index);
        let pixel = estimate.pixel;
        if !pixel.has_halves() {
            return None;
        }
        let mut difference = [0.0; 3];
        for (group, factor) in factors.iter().enumerate() {
            let light = self.light(index, group)?;
            for c in 0..3 {
                let half = |half: usize, count: u32| {
                    mean(light[half][c], f64::from(count)) + mean(light[half + 2][c], estimate.light_paths[half])
                };
                difference[c] += factor[c] * (half(1, pixel.odd) - half(0, pixel.even));
            }
        }
        let all = pixel.samples() as f64;
        let weights = (f64::from(pixel.even) / all) * (f64::from(pixel.odd) / all);
        Some(difference.map(|difference| weights * (difference * exp2(self.exponent)).powi(2)))
    }
}
