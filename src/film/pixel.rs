//! The exact sums of the camera samples of a pixel.

use super::channels::has_saturated;
use crate::data::{CHANNELS, PixelTotals, Rgb};

/// A sum of squares counts as known from this value for each run on, in units of 2^-[`crate::data::SQUARE_FRACTION`]: a run's squares are
/// rounded by at most half a unit.
pub(super) const LEAST_SQUARES: i128 = 1 << 10;

/// The totals of a pixel, in device units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Zeroable)]
pub(super) struct Pixel {
    /// Σ s over runs, s the run's sum, in units of 2^-[`crate::data::SUM_FRACTION`].
    pub sum: Rgb<i128>,
    /// The part of the odd runs.
    pub odd_sum: Rgb<i128>,
    /// The squared deviations of samples from the means of their runs, summed, in units of 2^-[`crate::data::SQUARE_FRACTION`].
    pub squared_deviations: Rgb<i128>,
    /// Accepted samples of even and of odd runs. 32 bits number a pixel's samples, so either count is at most 2^31.
    pub even: u32,
    pub odd: u32,
    /// Runs with at least one accepted sample.
    pub runs: u32,
    pub rejected: u32,
}

impl From<&PixelTotals> for Pixel {
    fn from(totals: &PixelTotals) -> Pixel {
        let sum = |index: usize| match has_saturated(totals, index) {
            false => i128::from_le_bytes(bytemuck::cast(totals.sums[index].map(u32::to_le))),
            true => i128::MAX,
        };
        let sums = |first: usize| [0, 1, 2].map(|channel| sum(first * CHANNELS.len() + channel));
        let (even_sum, odd_sum) = (sums(0), sums(1));
        let [even, odd] = totals.samples;
        Pixel {
            sum: [0, 1, 2].map(|channel| even_sum[channel].saturating_add(odd_sum[channel])),
            odd_sum,
            squared_deviations: sums(2),
            even,
            odd,
            runs: totals.runs,
            rejected: totals.rejected,
        }
    }
}

impl Pixel {
    pub fn samples(&self) -> u64 {
        u64::from(self.even) + u64::from(self.odd)
    }

    pub fn has_halves(&self) -> bool {
        self.even > 0 && self.odd > 0
    }

    pub fn add(&mut self, other: &Pixel) {
        for channel in 0..3 {
            self.sum[channel] = self.sum[channel].saturating_add(other.sum[channel]);
            self.odd_sum[channel] = self.odd_sum[channel].saturating_add(other.odd_sum[channel]);
            self.squared_deviations[channel] =
                self.squared_deviations[channel].saturating_add(other.squared_deviations[channel]);
        }
        self.even = self.even.saturating_add(other.even);
        self.odd = self.odd.saturating_add(other.odd);
        self.runs = self.runs.saturating_add(other.runs);
        self.rejected = self.rejected.saturating_add(other.rejected);
    }
}
