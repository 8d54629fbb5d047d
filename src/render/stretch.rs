//! A stretch of rendering: a range of samples of every pixel, which the devices share out among themselves.

use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::outcome::Outcome;
use super::turns::Rounds;
use super::{Look, Next, Watch};
use crate::data::RUN_LENGTH;
use crate::film::{Film, Totals};
use crate::job::blocks;

/// What a stretch of rendering reports to.
pub struct Stretch<'a> {
    pub film: &'a mut Film,
    pub watch: Watch<'a>,
    pub start: Instant,
    pub outcome: &'a mut Outcome,
    /// Whether a look at the whole film is asked for.
    pub whole: bool,
    /// What is rendered only to learn its pace. Nobody looks at it.
    pub pilot: Option<Pilot>,
}

/// A sample that will be taken back.
#[derive(Clone, Copy)]
pub struct Pilot {
    /// Whether the film must not get it.
    pub discards: bool,
}

impl Stretch<'_> {
    /// Asks what is wanted next, with a look or without.
    pub fn ask(&mut self, look: Option<(Instant, bool)>) -> Next {
        let look = look.map(|(begin, whole)| Look { film: self.film, begin, whole });
        let next = (self.watch)(self.outcome, look);
        let next = if self.pilot.is_some() && !matches!(next, Next::Stop | Next::Drop) { Next::GoOn } else { next };
        self.whole |= next == Next::Whole;
        self.outcome.interrupted |= next == Next::Stop;
        next
    }

    /// Adds what a submission has counted, and asks what is wanted next.
    pub fn landed(&mut self, counted: Totals) -> Next {
        self.outcome.totals += counted;
        if self.outcome.first_pass == 0.0 {
            self.outcome.first_pass = self.start.elapsed().as_secs_f64();
        }
        self.ask(None)
    }
}

/// What the devices of a stretch share.
pub struct Shared<'a, 'b> {
    pub samples: Range<u32>,
    /// The devices that may take part.
    pub lanes: usize,
    state: Mutex<State<'a, 'b>>,
    changed: Condvar,
}

pub struct State<'a, 'b> {
    pub stretch: &'a mut Stretch<'b>,
    /// The blocks of samples that nobody has taken, in order.
    left: Vec<Range<u32>>,
    /// The devices that take part, and those of them that wait for a look at the whole film.
    working: usize,
    waiting: usize,
    /// Looks at the whole film so far.
    looks: u64,
    /// Whether a device has failed.
    failed: bool,
}

impl State<'_, '_> {
    /// Whether turns are to end with the block of samples that has been started.
    pub fn ends_early(&self) -> bool {
        self.stretch.whole || self.ends()
    }

    /// Whether nobody is to begin anything.
    fn ends(&self) -> bool {
        self.stretch.outcome.interrupted || self.failed
    }
}

impl<'a, 'b> Shared<'a, 'b> {
    pub fn new(samples: Range<u32>, lanes: usize, stretch: &'a mut Stretch<'b>) -> Shared<'a, 'b> {
        let left = Vec::from([blocks(samples.clone())]);
        let state = State { stretch, left, working: 0, waiting: 0, looks: 0, failed: false };
        Shared { samples, lanes, state: Mutex::new(state), changed: Condvar::new() }
    }

    pub fn state(&self) -> MutexGuard<'_, State<'a, 'b>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes part until the result is dropped.
    pub fn enter(&self) -> Present<'_, 'a, 'b> {
        self.state().working += 1;
        Present { shared: self, failed: true }
    }

    /// Takes the next blocks of samples, as many as a round of this device has. Several devices leave the others something to do: half of
    /// what is left is for the next rounds, so that all end at about the same time.
    pub fn take(&self, rounds: &Rounds) -> Option<Range<u32>> {
        let mut state = self.state();
        if state.ends() {
            return None;
        }
        let all: usize = state.left.iter().map(ExactSizeIterator::len).sum();
        let most = if self.lanes > 1 { all.div_ceil(2 * self.lanes) } else { all };
        let first = state.left.iter_mut().find(|blocks| blocks.start < blocks.end)?;
        let mut taken = rounds.next(first);
        taken.end = taken.end.min(taken.start.saturating_add(u32::try_from(most).unwrap_or(u32::MAX)));
        first.start = taken.end;
        Some(taken)
    }

    /// Notes the blocks that a device has rendered, and gives back those up to `end` that it has not. The result is whether a look at the
    /// whole film is asked for.
    pub fn note(&self, rendered: Range<u32>, end: u32) -> bool {
        let mut state = self.state();
        let rest = rendered.end..end;
        if !rest.is_empty() {
            let place = state.left.partition_point(|blocks| blocks.start < rest.start);
            state.left.insert(place, rest);
        }
        let start = (rendered.start * RUN_LENGTH).max(self.samples.start);
        let end = (rendered.end * RUN_LENGTH).min(self.samples.end);
        state.stretch.outcome.samples.add(start..end);
        state.stretch.whole
    }

    /// Waits until all devices have brought their films, and one of them has shown it.
    pub fn show_whole(&self, begin: Instant) {
        let mut state = self.state();
        let looks = state.looks;
        state.waiting += 1;
        while state.looks == looks && !state.failed {
            if state.waiting == state.working {
                state.stretch.whole = false;
                state.stretch.ask(Some((begin, true)));
                state.looks += 1;
                self.changed.notify_all();
            } else {
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
        state.waiting -= 1;
    }
}

/// A device that takes part.
pub struct Present<'s, 'a, 'b> {
    shared: &'s Shared<'a, 'b>,
    /// Also if its thread panics.
    failed: bool,
}

impl Present<'_, '_, '_> {
    /// Leaves without a failure.
    pub fn leave(mut self) {
        self.failed = false;
    }
}

impl Drop for Present<'_, '_, '_> {
    fn drop(&mut self) {
        let mut state = self.shared.state();
        state.working -= 1;
        state.failed |= self.failed;
        // Those who wait may be all that are left.
        self.shared.changed.notify_all();
    }
}
