//! A range of samples of every pixel, which devices share.

use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::observer::{Next, Observer, Snapshot};
use super::outcome::Outcome;
use super::tiles::Schedule;
use crate::film::{Accumulation, Totals};
use crate::job::{blocks, samples_of};

/// The caller of a render: its film, its outcome so far, and who follows.
pub struct Caller<'a> {
    pub film: &'a mut Accumulation,
    pub observer: &'a mut dyn Observer,
    pub start: Instant,
    pub outcome: &'a mut Outcome,
    /// Whether the caller wants a complete snapshot.
    pub wants_complete: bool,
    /// Set while a sample is rendered only to measure the pace. No snapshot has it.
    pub probe: Option<PaceProbe>,
}

/// A sample that is rendered to measure the pace, and again later.
#[derive(Clone, Copy)]
pub struct PaceProbe {
    /// Whether it must not be added to the film.
    pub is_dropped: bool,
}

impl Caller<'_> {
    /// Tells the observer, and returns its decision. `snapshot`: when it began, and whether the film is complete.
    pub fn notify(&mut self, snapshot: Option<(Instant, bool)>) -> Next {
        let snapshot = snapshot.map(|(begin, is_complete)| Snapshot { film: self.film, begin, is_complete });
        let next = self.observer.follow(self.outcome, snapshot);
        let next = if self.probe.is_some() && !matches!(next, Next::Stop | Next::Drop) { Next::GoOn } else { next };
        self.wants_complete |= next == Next::CompleteSnapshot;
        self.outcome.interrupted |= next == Next::Stop;
        next
    }

    /// Whether what is rendered now is not added to the film.
    pub fn drops_film(&self) -> bool {
        self.probe.is_some_and(|probe| probe.is_dropped)
    }

    /// Adds the totals of a submission, and returns the caller's decision.
    pub fn add(&mut self, counted: Totals) -> Next {
        self.outcome.totals += counted;
        if self.outcome.first_pass == 0.0 {
            self.outcome.first_pass = self.start.elapsed().as_secs_f64();
        }
        self.notify(None)
    }
}

/// The samples that devices share, and the devices that take part.
pub struct SampleRange<'a, 'b> {
    pub samples: Range<u32>,
    /// The number of devices that may take part.
    pub devices: usize,
    state: Mutex<Shared<'a, 'b>>,
    changed: Condvar,
}

pub struct Shared<'a, 'b> {
    pub caller: &'a mut Caller<'b>,
    /// The blocks of samples that no device has taken, in order.
    left: Vec<Range<u32>>,
    /// The number of devices that take part, and of those that wait for a complete snapshot.
    working: usize,
    waiting: usize,
    /// Complete snapshots so far.
    snapshots: u64,
    /// Whether a device has failed.
    failed: bool,
}

impl Shared<'_, '_> {
    /// Whether devices must stop after the block of samples that they have started.
    pub fn ends_early(&self) -> bool {
        self.caller.wants_complete || self.ends()
    }

    /// Whether devices must not start another block.
    fn ends(&self) -> bool {
        self.caller.outcome.interrupted || self.failed
    }
}

impl<'a, 'b> SampleRange<'a, 'b> {
    pub fn new(samples: Range<u32>, devices: usize, caller: &'a mut Caller<'b>) -> SampleRange<'a, 'b> {
        let left = Vec::from([blocks(samples.clone())]);
        let state = Shared { caller, left, working: 0, waiting: 0, snapshots: 0, failed: false };
        SampleRange { samples, devices, state: Mutex::new(state), changed: Condvar::new() }
    }

    pub fn state(&self) -> MutexGuard<'_, Shared<'a, 'b>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Registers a device, until the result is dropped.
    pub fn enter(&self) -> Participant<'_, 'a, 'b> {
        self.state().working += 1;
        Participant { range: self, failed: true }
    }

    /// Takes the next blocks of samples, up to the size of the schedule's next round. Of several devices, each takes at most its share of
    /// half of what is left, so that all end at about the same time.
    pub fn take(&self, schedule: &Schedule) -> Option<Range<u32>> {
        let mut state = self.state();
        if state.ends() {
            return None;
        }
        let all: usize = state.left.iter().map(ExactSizeIterator::len).sum();
        let most = if self.devices > 1 { all.div_ceil(2 * self.devices) } else { all };
        let first = state.left.iter_mut().find(|blocks| blocks.start < blocks.end)?;
        let mut taken = schedule.next(first);
        taken.end = taken.end.min(taken.start.saturating_add(u32::try_from(most).unwrap_or(u32::MAX)));
        first.start = taken.end;
        Some(taken)
    }

    /// Adds the blocks that a device has rendered, and gives back the others up to `end`. Returns whether the caller wants a complete
    /// snapshot.
    pub fn finish(&self, rendered: Range<u32>, end: u32) -> bool {
        let mut state = self.state();
        let rest = rendered.end..end;
        if !rest.is_empty() {
            let index = state.left.partition_point(|blocks| blocks.start < rest.start);
            state.left.insert(index, rest);
        }
        if !state.caller.drops_film() {
            state.caller.film.samples.add(samples_of(&rendered, &self.samples));
        }
        state.caller.wants_complete
    }

    /// Waits until all devices have added their films, and one of them has shown the complete film to the caller.
    pub fn show_complete(&self, begin: Instant) {
        let mut state = self.state();
        let snapshots = state.snapshots;
        state.waiting += 1;
        while state.snapshots == snapshots && !state.failed {
            if state.waiting == state.working {
                state.caller.wants_complete = false;
                state.caller.notify(Some((begin, true)));
                state.snapshots += 1;
                self.changed.notify_all();
            } else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
        state.waiting -= 1;
    }
}

/// A device that takes part.
pub struct Participant<'s, 'a, 'b> {
    range: &'s SampleRange<'a, 'b>,
    /// True until the device leaves, so that a panic of its thread counts.
    failed: bool,
}

impl Participant<'_, '_, '_> {
    /// Ends the device's part without a failure.
    pub fn leave(mut self) {
        self.failed = false;
    }
}

impl Drop for Participant<'_, '_, '_> {
    fn drop(&mut self) {
        let mut state = self.range.state();
        state.working -= 1;
        state.failed |= self.failed;
        // All remaining devices may be waiting.
        self.range.changed.notify_all();
    }
}
