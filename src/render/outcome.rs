//! The outcome of a render, apart from its film.

use super::noise::Noise;
use crate::data::{Counters, LIGHT_BINS, LIGHT_PATHS, PATHS, RAYS, TOO_DEEP, TOO_DEEP_THROUGHPUT};
use crate::film::{Rejected, Totals};

/// The outcome of a render, apart from its film.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub interrupted: bool,
    /// The totals that this render has added, including those that only a device's film has so far.
    pub totals: Totals,
    /// The checks of a render until an error.
    pub noise: Option<Noise>,
    /// Seconds from the first pass to the last.
    pub seconds: f64,
    /// Seconds until the first pass had ended.
    pub first_pass: f64,
    /// Processor seconds of the threads that render, without a driver's own threads.
    pub host_seconds: f64,
    /// Seconds by stage, if they were requested and the device has timestamps.
    pub stages: Vec<(String, f64)>,
    /// The share of the time in which the device ran no kernel, 0 to 1, if that is known.
    pub idle: Option<f64>,
}

impl Outcome {
    /// Adds the outcome of a later render of the same film.
    pub fn join(&mut self, later: Outcome) {
        let idle = [&*self, &later].map(|outcome| outcome.idle.map(|idle| idle * outcome.seconds));
        self.interrupted |= later.interrupted;
        self.totals += later.totals;
        self.noise = later.noise.or(self.noise);
        if self.first_pass == 0.0 {
            self.first_pass = later.first_pass;
        }
        self.seconds += later.seconds;
        self.host_seconds += later.host_seconds;
        later.stages.iter().for_each(|(name, seconds)| self.add_stage(name, *seconds));
        let known: Vec<f64> = idle.into_iter().flatten().collect();
        self.idle = (!known.is_empty()).then(|| known.iter().sum::<f64>() / self.seconds.max(1e-9));
    }

    /// Adds seconds of a stage.
    pub(super) fn add_stage(&mut self, name: &str, seconds: f64) {
        match self.stages.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += seconds,
            None => self.stages.push((name.to_owned(), seconds)),
        }
    }
}

/// The difference of two readings of a 64-bit counter.
fn added([low, high]: [u32; 2], [low_before, high_before]: [u32; 2]) -> u64 {
    let count = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
    count(low, high).wrapping_sub(count(low_before, high_before))
}

/// The difference of two readings of the counters.
pub(super) fn totals_since(now: &Counters, before: &Counters) -> Totals {
    let since = |which: u32| added(now.counts[which as usize], before.counts[which as usize]);
    let count = |of: fn(&Counters) -> u32| u64::from(of(now).wrapping_sub(of(before)));
    let mut light = [[0; 2]; LIGHT_BINS as usize];
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
        light_paths: [since(LIGHT_PATHS), since(LIGHT_PATHS + 1)],
    }
}
