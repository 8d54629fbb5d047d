//! The exact sums of the channels of `--aov`.

use std::mem::size_of;

use glam::DVec3;

use super::floats::exp2;
use crate::aov::{Aovs, SceneSpace, Sum};
use crate::data::{FILM_SUMS, PixelTotals, RunRecord, SUM_FRACTION};
use crate::error::{Error, Result};
use crate::memory;

/// The sums of all pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Channels {
    pub aovs: Aovs,
    pub space: SceneSpace,
    /// The sums of each pixel, one pixel after the other, in units of 2^-[`SUM_FRACTION`]; `i128::MAX` for a sum that has left its range.
    sums: Vec<i128>,
}

/// Bytes of a pixel of the device's film.
pub fn device_bytes(aovs: &Aovs) -> u64 {
    (size_of::<PixelTotals>() + aovs.count() * size_of::<[u32; 4]>()) as u64
}

/// Bytes of a finished run's record.
pub fn record_bytes(aovs: &Aovs) -> u64 {
    (size_of::<RunRecord>() + aovs.count() * size_of::<f32>()) as u64
}

impl Channels {
    pub fn new(pixels: usize, aovs: &Aovs, space: SceneSpace) -> Result<Channels> {
        if aovs.is_empty() {
            return Ok(Channels::default());
        }
        let count = pixels.saturating_mul(aovs.count());
        let needs = |memory: String| Error::Usage(format!("the channels of --aov need {memory}; ask for fewer"));
        memory::check((count as u64).saturating_mul(size_of::<i128>() as u64)).map_err(needs)?;
        let cannot = |_| needs("more memory than can be had".to_string());
        let sums = bytemuck::allocation::try_zeroed_vec::<i128>(count).map_err(cannot)?;
        Ok(Channels { aovs: aovs.clone(), space, sums })
    }

    pub fn clear(&mut self) {
        self.sums.fill(0);
    }

    pub fn add(&mut self, other: &Channels) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(mine, theirs)| *mine = mine.saturating_add(*theirs));
    }

    /// Adds the sums of a pixel from a device, where they follow its totals.
    pub fn add_from_device(&mut self, index: usize, totals: &PixelTotals, sums: &[u8]) {
        let Some(mine) = self.of_mut(index) else { return };
        for (number, (mine, words)) in mine.iter_mut().zip(sums.chunks_exact(size_of::<[u32; 4]>())).enumerate() {
            let words: [u32; 4] = bytemuck::pod_read_unaligned(words);
            let sum = match totals.saturated >> (FILM_SUMS + number) & 1 {
                0 => i128::from_le_bytes(bytemuck::cast(words.map(u32::to_le))),
                _ => i128::MAX,
            };
            *mine = mine.saturating_add(sum);
        }
    }

    /// The sums of a pixel; empty if the pixel is not in the image.
    pub fn sums_of_pixel(&self, index: usize) -> &[i128] {
        let count = self.aovs.count();
        self.sums.get(index * count..(index + 1) * count).unwrap_or_default()
    }

    pub fn of_mut(&mut self, index: usize) -> Option<&mut [i128]> {
        let count = self.aovs.count();
        self.sums.get_mut(index * count..(index + 1) * count)
    }

    /// A component of a sum; 0 if the film lacks it, and `None` if it has left its range.
    pub fn sum(&self, index: usize, sum: Sum, component: usize) -> Option<f64> {
        let sum_index = self.aovs.first_sum(sum).map_or(usize::MAX, |first| first + component);
        match self.sums_of_pixel(index).get(sum_index).copied().unwrap_or(0) {
            i128::MAX => None,
            sum => Some(sum as f64 * exp2(-(SUM_FRACTION as i32))),
        }
    }

    /// The three components divided by a count; 0 if the count is 0.
    pub fn mean(&self, index: usize, sum: Sum, count: f64) -> Option<DVec3> {
        let component = |component| self.sum(index, sum, component);
        let sums = DVec3::new(component(0)?, component(1)?, component(2)?);
        Some(if count == 0.0 { DVec3::ZERO } else { sums / count })
    }
}
