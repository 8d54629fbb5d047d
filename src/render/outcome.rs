//! What a render came to, beside its film.

use crate::data::{Counters, LIGHT_BINS, PATHS, RAYS, TOO_DEEP, TOO_DEEP_THROUGHPUT};
use crate::film::{Rejected, Totals};
use crate::samples::Samples;

/// What a render came to, beside its film.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The samples that every pixel has, and none beyond. While a render goes on, those of the last snapshot of a whole film.
    pub samples: Samples,
    pub interrupted: bool,
    /// What this render has added to the film, including what only the device's film has so far.
    pub totals: Totals,
    /// Of a render until an error: what came of it.
    pub noise: Option<Noise>,
    /// Seconds of the passes, from the first to the last.
    pub seconds: f64,
    /// Seconds until the first pass had ended.
    pub first_pass: f64,
    /// Processor seconds of the thread that renders, from the first pass to the last. A driver's own threads are not in it.
    pub host_seconds: f64,
    /// The times on the device, where they were asked for and the device can tell.
    pub profile: Profile,
}

/// Times on the device.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// Seconds by stage.
    pub stages: Vec<(String, f64)>,
    /// The share of the time in which the device ran no kernel, 0 to 1.
    pub idle: Option<f64>,
}

impl Outcome {
    /// Adds what a later render of the same film came to.
    pub fn join(&mut self, later: Outcome) {
        let idle = [&*self, &later].map(|outcome| outcome.profile.idle.map(|idle| idle * outcome.seconds));
        self.samples = later.samples;
        self.interrupted |= later.interrupted;
        self.totals += later.totals;
        self.noise = later.noise.or(self.noise);
        if self.first_pass == 0.0 {
            self.first_pass = later.first_pass;
        }
        self.seconds += later.seconds;
        self.host_seconds += later.host_seconds;
        later.profile.stages.iter().for_each(|(name, seconds)| self.add_stage(name, *seconds));
        let known: Vec<f64> = idle.into_iter().flatten().collect();
        self.profile.idle = (!known.is_empty()).then(|| known.iter().sum::<f64>() / self.seconds.max(1e-9));
    }

    /// Adds seconds of a stage.
    pub(super) fn add_stage(&mut self, name: &str, seconds: f64) {
        match self.profile.stages.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += seconds,
            None => self.profile.stages.push((name.to_owned(), seconds)),
        }
    }
}

/// What came of a render until an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// How often the error has been compared with the requested one, in all renders that this one goes on with.
    pub checks: u32,
    /// Whether the bound was below the requested error.
    pub reached: bool,
}

/// The probability that a render until an error ends with a larger one, over all its checks.
pub const NOISE_LEVEL: f64 = 0.05;

/// The probability that a check has for finding the error below its bound by chance, after so many checks: of the k-th check a share of
/// 1 / (k (k + 1)), so that all have [`NOISE_LEVEL`] together.
pub fn level_after(checks: u32) -> f64 {
    let number = f64::from(checks) + 1.0;
    NOISE_LEVEL / (number * (number + 1.0))
}

impl Noise {
    /// The probability that was left to the last check.
    pub fn level(&self) -> f64 {
        level_after(self.checks.saturating_sub(1))
    }
}

/// What has been added to a count of 64 bits since the last reading.
fn added([low, high]: [u32; 2], [low_before, high_before]: [u32; 2]) -> u64 {
    let count = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
    count(low, high).wrapping_sub(count(low_before, high_before))
}

/// What has been counted since the last reading.
pub(super) fn totals_since(now: &Counters, before: &Counters) -> Totals {
    let since = |which: u32| added(now.counts[which as usize], before.counts[which as usize]);
    let count = |of: fn(&Counters) -> u32| u64::from(of(now).wrapping_sub(of(before)));
    let mut light = [[0; 2]; LIGHT_BINS];
    for (bin, (now, before)) in light.iter_mut().zip(now.light.iter().zip(&before.light)) {
        *bin = [added(now[0], before[0]), added(now[1], before[1])];
    }
    Totals {
        paths: since(PATHS),
        rays: since(RAYS),
        rejected: Rejected {
            nan: count(|counters| counters.nan),
            infinite: count(|counters| counters.infinite),
            cut: count(|counters| counters.cut),
            refused: count(|counters| counters.refused),
        },
        too_deep: since(TOO_DEEP),
        too_deep_throughput: since(TOO_DEEP_THROUGHPUT),
        light,
    }
}
