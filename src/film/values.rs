//! The values of the channels of `--aov`, in scene units.

use super::Film;
use super::floats::{exp2, to_f32};
use crate::aov::{Aov, Channel, Sum};

/// The depth of a pixel whose rays all miss: beyond everything.
const NO_DEPTH: f32 = f32::MAX;
/// Indirect radiance below this share of a pixel's radiance is written as 0. It is the rounding of f32: a run's sum is rounded by 2^-24, and
/// so is each of the few contributions to a sample.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

impl Film {
    /// A channel of a pixel, in scene units; `f32::MAX` if the sum has left its range.
    ///
    /// The albedo and the normal are means over all samples; samples without a surface count as 0. An albedo above 1, which white bases have
    /// where glTF's formulas return too much light, is 1, because denoisers expect that. The depth and the position are means over
    /// the samples that hit a surface; without any, the depth is `f32::MAX` and the position 0. Objects and materials are those of the
    /// pixel's sample 0, numbered from 1; 0 is none. The indirect radiance is the radiance minus the direct one.
    pub fn channel(&self, index: usize, channel: &Channel) -> f32 {
        self.channel_value(index, channel).map_or(f32::MAX, to_f32)
    }

    fn channel_value(&self, index: usize, &Channel { aov, component, .. }: &Channel) -> Option<f64> {
        let pixel = self.pixels.get(index)?;
        let channels = &self.channels;
        let space = &channels.space;
        let samples = pixel.samples() as f64;
        let all = samples + f64::from(pixel.rejected);
        let hits = || channels.sum(index, Sum::Hits, 0);
        let radiance = exp2(self.exponent);
        let direct = || channels.mean(index, Sum::Direct, samples).map(|direct| direct[component]);
        Some(match aov {
            Aov::Albedo => channels.mean(index, Sum::Albedo, all)?[component].min(1.0),
            Aov::Normal => space.direction(channels.mean(index, Sum::Normal, all)?)[component],
            Aov::Depth => match hits()? {
                0.0 => f64::from(NO_DEPTH),
                hits => space.length(channels.sum(index, Sum::Depth, 0)? / hits),
            },
            Aov::Position => match hits()? {
                0.0 => 0.0,
                hits => space.point(channels.mean(index, Sum::Position, hits)?)[component],
            },
            Aov::Object => channels.sum(index, Sum::Object, 0)?,
            Aov::Material => channels.sum(index, Sum::Material, 0)?,
            Aov::Direct => direct()? * radiance,
            Aov::Indirect => {
                let (total, direct) = (self.estimate(index).mean(component), direct()?);
                let rest = total - direct;
                if rest.abs() <= ROUNDING * total.abs().max(direct.abs()) { 0.0 } else { rest * radiance }
            }
        })
    }
}
