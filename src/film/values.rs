//! The values of the channels of `--aov`, in scene units.

use glam::DVec3;

use super::Film;
use super::floats::{exp2, to_f32};
use crate::aov::{Aov, Channel, ChannelNames, Sum};

/// The depth of a pixel whose rays all miss: beyond everything. The motion of what leaves the view.
const UNKNOWN: f32 = f32::MAX;
/// A rest below this share of a pixel's radiance, such as the indirect radiance, is written as 0. It is the rounding of f32: a run's sum is rounded by 2^-24, and
/// so is each of the few contributions to a sample.
pub(super) const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

impl Film {
    /// The word of a channel's value for a pixel: a number of faces, or the bits of [`Film::channel`].
    pub fn channel_word(&self, index: usize, channel: &Channel) -> u32 {
        match channel.aov {
            Aov::Face0 => self.words0(index, Aov::Face0).first().copied().unwrap_or(0),
            _ => self.channel(index, channel).to_bits(),
        }
    }

    /// A channel of a pixel, in scene units; `f32::MAX` if the sum has left its range.
    ///
    /// The albedo and the normal are means over all samples; samples without a surface count as 0. An albedo above 1, which white bases have
    /// where glTF's formulas return too much light, is 1, because denoisers expect that. The depth and the position are means over
    /// the samples that hit a surface; without any, the depth is `f32::MAX` and the position 0. Objects and materials are those of the
    /// pixel's sample 0, numbered from 1; 0 is none. The indirect radiance is the radiance minus the direct one. What is of sample 0 is 0 where that sample has hit
    /// nothing or is not in the film, but distances and motions are `f32::MAX` there.
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
        // The kernels store no word of 0 but where there is nothing.
        let words = self.words0(index, aov);
        let float = |number: usize| {
            words.get(number).filter(|word| **word != 0).map(|word| f64::from(f32::from_bits(*word)) + 0.0)
        };
        let vector = || Some(DVec3::new(float(0)?, float(1)?, float(2)?));
        Some(match aov {
            Aov::Albedo => channels.mean(index, Sum::Albedo, all)?[component].min(1.0),
            Aov::Normal => space.direction(channels.mean(index, Sum::Normal, all)?)[component],
            Aov::Depth => match hits()? {
                0.0 => f64::from(UNKNOWN),
                hits => space.length(channels.sum(index, Sum::Depth, 0)? / hits),
            },
            Aov::Position => match hits()? {
                0.0 => 0.0,
                hits => space.point(channels.mean(index, Sum::Position, hits)?)[component],
            },
            Aov::Object => channels.sum(index, Sum::Object, 0)?,
            Aov::Material => channels.sum(index, Sum::Material, 0)?,
            Aov::Direct => direct()? * radiance,
            Aov::Lights => self.light_value(index, component)? * radiance,
            Aov::Indirect => {
                let (total, direct) = (self.estimate(index).mean(component), direct()?);
                let rest = total - direct;
                if rest.abs() <= ROUNDING * total.abs().max(direct.abs()) { 0.0 } else { rest * radiance }
            }
            // Blender counts rows upwards. X and Y are the place in the frame before minus this one; Z and W are this place minus the next one.
            Aov::Motion if channels.aovs.names == ChannelNames::Blender => {
                let sign = if component == 1 || component == 2 { -1.0 } else { 1.0 };
                float(component).map_or(f64::from(UNKNOWN), |motion| sign * motion)
            }
            Aov::Motion => float(2 + component).unwrap_or(f64::from(UNKNOWN)),
            Aov::Depth0 | Aov::Distance0 => float(0).map_or(f64::from(UNKNOWN), |length| space.length(length)),
            Aov::Position0 => vector().map_or(0.0, |point| space.point(point)[component]),
            Aov::Normal0 => vector().map_or(0.0, |normal| space.direction(normal)[component]),
            Aov::Uv0 | Aov::Offset0 => float(component).unwrap_or(0.0),
            Aov::Face0 => words.first().map_or(0.0, |number| f64::from(*number)),
            Aov::Cryptomatte | Aov::Cryptoasset => self.mattes.value(index, channels.aovs.matte_value(component), all),
        })
    }

    /// In how many pixels mattes lack samples, as the camera sees too many names there; `None` without mattes.
    pub fn matte_pixels_lost(&self) -> Option<u64> {
        self.mattes.pixels_lost()
    }

    /// The words of a channel of sample 0; empty of others.
    fn words0(&self, index: usize, aov: Aov) -> &[u32] {
        let words = self.channels.words_of_pixel(index);
        words.get(self.channels.aovs.first_word(aov)..).unwrap_or_default()
    }
}
