//! Totals over the film, in integers, which do not depend on the order.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use crate::data::LIGHT_BINS;

/// Samples that were left out of the image, by reason.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rejected {
    /// The device found a NaN.
    pub nan: u64,
    /// The device found an infinity, or the run's sum overflowed f32.
    pub infinite: u64,
    /// The ray's walk through the BVH was given up as too long (shaders/scene/traverse.wgsl).
    pub cut: u64,
    /// The sum of their run was negative or NaN, which no sum of accepted samples is.
    pub refused: u64,
}

impl Rejected {
    pub fn total(&self) -> u64 {
        [self.nan, self.infinite, self.cut, self.refused].into_iter().fold(0, u64::saturating_add)
    }
}

/// Totals over the film.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Totals {
    /// Camera samples, accepted or rejected.
    pub paths: u64,
    /// Rays of every kind.
    pub rays: u64,
    pub rejected: Rejected,
    /// Paths that max_depth ended.
    pub too_deep: u64,
    /// The sum of the largest components of their throughput, in units of 2^-16.
    pub too_deep_throughput: u64,
    /// Light that narrow lobes hide from light sampling, in device units of 2^-24 (shaders/step/narrow_lobe.wgsl). By bins of lights: the light that
    /// probes found, and the light that paths found.
    pub light: [[u64; 2]; LIGHT_BINS as usize],
    /// Light paths of even and of odd runs, of all pixels of the full image. States of before light paths do not have them.
    #[serde(default)]
    pub light_paths: [u64; 2],
}

impl std::ops::AddAssign for Totals {
    /// A saturating sum, which does not depend on the order either.
    fn add_assign(&mut self, other: Totals) {
        let (mine, theirs) = (std::slice::from_mut(self), [other]);
        let numbers = bytemuck::cast_slice_mut::<_, u64>(mine).iter_mut().zip(bytemuck::cast_slice(&theirs));
        numbers.for_each(|(mine, theirs)| *mine = mine.saturating_add(*theirs));
    }
}

impl Totals {
    /// The largest share of radiance that the paths which max_depth ended could still have added, summed.
    pub fn cut_throughput(&self) -> f64 {
        self.too_deep_throughput as f64 / 65_536.0
    }

    /// The light paths of even and of odd runs per pixel of the full image, which has this size.
    pub fn light_paths_of_a_pixel(&self, (width, height): (u32, u32)) -> [f64; 2] {
        self.light_paths.map(|paths| paths as f64 / (f64::from(width) * f64::from(height)))
    }

    /// Light that narrow lobes hide from light sampling, in device units, summed over all samples.
    pub fn hidden_light(&self) -> HiddenLight {
        let light = |[probed, found]: [u64; 2]| (probed as f64 / 16_777_216.0, found as f64 / 16_777_216.0);
        HiddenLight { bins: self.light.map(light) }
    }
}

/// Light that narrow lobes hide from light sampling: of mirrors, clear glass, polished metal and forward scattering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HiddenLight {
    /// By bins of lights: the light that probes found, and the light that paths found.
    bins: [(f64, f64); LIGHT_BINS as usize],
}

impl HiddenLight {
    /// The light times a factor, such as a change of units.
    pub fn times(&self, factor: f64) -> HiddenLight {
        HiddenLight { bins: self.bins.map(|(probed, found)| (probed * factor, found * factor)) }
    }

    /// The light that probes found.
    pub fn probed(&self) -> f64 {
        self.bins.iter().map(|(probed, _)| probed).sum()
    }

    /// The light that paths found.
    pub fn found(&self) -> f64 {
        self.bins.iter().map(|(_, found)| found).sum()
    }

    /// The light that is certainly missing. Paths should find about as much as probes; a quarter of that may be noise.
    pub fn missing(&self) -> f64 {
        self.bins.iter().map(|(probed, found)| (0.75 * probed - found).max(0.0)).sum()
    }
}
