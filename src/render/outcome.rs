//! What a render came to, beside its film.

use std::ops::Range;

use crate::data::{Counters, LIGHT_BINS, PATHS, RAYS, TOO_DEEP, TOO_DEEP_THROUGHPUT};
use crate::film::{Rejected, Totals};

/// What a render came to, beside its film.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The samples of every pixel; of an interrupted render pixels may have a run less.
    pub samples: Range<u32>,
    pub interrupted: bool,
    /// Of an interrupted render: one past the last sample that any pixel has.
    pub stopped_at: Option<u32>,
    /// Samples and rays, including those that only the device's film has so far.
    pub totals: Totals,
    /// Paths that max_depth ended.
    pub too_deep: TooDeep,
    /// What is met by mirrors and through glass by chance.
    pub through_glass: ThroughGlass,
    /// Of a render until an error: what came of it.
    pub noise: Option<Noise>,
    /// Seconds of the passes, from the first to the last.
    pub seconds: f64,
    /// Seconds until the first pass had ended.
    pub first_pass: f64,
    /// Processor seconds of the thread that renders, from the first pass to the last. A driver's own threads are not in it.
    pub host_seconds: f64,
    /// Seconds on the device by stage, where they were asked for and the device can tell.
    pub stages: Vec<(String, f64)>,
    /// The share of the time in which the device ran no kernel, where it was asked for and the device can tell; 0 to 1.
    pub device_idle: Option<f64>,
}

/// What came of a render until an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The probability that was left to the last look for finding the error below its bound by chance.
    pub level: f64,
    /// Whether the bound was below the error asked.
    pub reached: bool,
}

/// The probability that a render until an error ends with a larger one, over all its looks.
pub const NOISE_LEVEL: f64 = 0.05;

/// What max_depth cut off. The throughput of such a path is the largest share of radiance that it could still have added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TooDeep {
    pub paths: u64,
    /// The sum of the largest components of their throughput, each rounded up to a multiple of 2^-16.
    pub throughput: f64,
}

impl TooDeep {
    /// The mean throughput of a path that was cut.
    pub fn mean(&self) -> f64 {
        self.throughput / self.paths.max(1) as f64
    }

    /// What has been counted since the last reading.
    pub(super) fn add(&mut self, now: &Counters, before: &Counters) {
        self.paths += since(TOO_DEEP, now, before);
        self.throughput += since(TOO_DEEP_THROUGHPUT, now, before) as f64 / 65_536.0;
    }
}

/// What has been added to a count of 64 bits since the last reading.
fn added([low, high]: [u32; 2], [low_before, high_before]: [u32; 2]) -> u64 {
    let count = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
    count(low, high).wrapping_sub(count(low_before, high_before))
}

fn since(which: u32, now: &Counters, before: &Counters) -> u64 {
    added(now.counts[which as usize], before.counts[which as usize])
}

/// Samples and rays since the last reading.
pub(super) fn totals_since(now: &Counters, before: &Counters) -> Totals {
    let count = |of: fn(&Counters) -> u32| u64::from(of(now).wrapping_sub(of(before)));
    Totals {
        paths: since(PATHS, now, before),
        rays: since(RAYS, now, before),
        rejected: Rejected {
            nan: count(|counters| counters.nan),
            infinite: count(|counters| counters.infinite),
            cut: count(|counters| counters.cut),
            refused: count(|counters| counters.refused),
        },
    }
}

/// Light of lights that are sampled, by mirrors and through glass, in device units, summed over all samples
/// (shaders/step/through_glass.wgsl).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThroughGlass {
    /// By bins of lights: the light that shadow rays found, and the light that paths found by chance.
    bins: [(f64, f64); LIGHT_BINS],
}

impl ThroughGlass {
    /// What has been counted since the last reading.
    pub(super) fn add(&mut self, now: &Counters, before: &Counters) {
        for ((asked, met), (now, before)) in self.bins.iter_mut().zip(now.light.iter().zip(&before.light)) {
            *asked += added(now[0], before[0]) as f64 / 16_777_216.0;
            *met += added(now[1], before[1]) as f64 / 16_777_216.0;
        }
    }

    /// The same in other units.
    pub fn times(&self, factor: f64) -> ThroughGlass {
        ThroughGlass { bins: self.bins.map(|(asked, met)| (asked * factor, met * factor)) }
    }

    /// What there is of it.
    pub fn blocked_by_dielectrics(&self) -> f64 {
        self.bins.iter().map(|(asked, _)| asked).sum()
    }

    /// What paths met of it.
    pub fn found_by_bsdf(&self) -> f64 {
        self.bins.iter().map(|(_, met)| met).sum()
    }

    /// What is certainly missing of it. What rays find is about what paths would meet; a quarter of that may be error.
    pub fn missing(&self) -> f64 {
        self.bins.iter().map(|(asked, met)| (0.75 * asked - met).max(0.0)).sum()
    }
}
