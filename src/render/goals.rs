//! Renders whose number of samples is not given: until a deadline, or until an error.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::outcome::{Noise, level_after};
use super::renderer::Renderer;
use super::sample_range::{Caller, PaceProbe};
use crate::data::RUN_LENGTH;
use crate::error::Result;
use crate::film::{Film, Totals};
use crate::job::{Goal, Job};
use crate::samples::Samples;

/// The samples at which a render until an error looks first.
pub const FIRST_LOOK: u32 = 2 * RUN_LENGTH;
/// The samples at which it gives up where more are of no use: nothing bounds the error, because pixels are too few or have no light; or
/// the noise is small, and paths still do not find light that is there.
pub const LAST_LOOK: u32 = 1 << 14;

/// The samples at which a render until an error looks at it, after so many looks: 16, 32, 48, 64, and from there on at each quarter of a
/// doubling. Both halves of a pixel then have as many samples.
pub fn look_after(looks: u32) -> u32 {
    match looks.checked_sub(4) {
        None => FIRST_LOOK * (looks + 1),
        Some(later) => FIRST_LOOK.saturating_mul(5 + later % 4).saturating_mul(2u32.saturating_pow(later / 4)),
    }
}

/// The result of a look at a film with so many samples of a pixel, after so many looks; and whether the render ends here.
pub fn look_at(film: &Film, samples: u32, looks: u32, error: f64) -> (Noise, bool) {
    let verdict = film.verdict(level_after(looks));
    let bound = verdict.error.map_or(f64::INFINITY, |found| found.bound);
    let noise = Noise { looks: looks.saturating_add(1), reached: bound < error && !verdict.lacks_light() };
    let is_hopeless = bound == f64::INFINITY || bound < error;
    (noise, noise.reached || (is_hopeless && samples >= LAST_LOOK))
}

/// A run of every pixel that takes less time than this is rendered to its end, also where a deadline comes first.
const SHORT_RUN: Duration = Duration::from_secs(2);

/// Whether a render of so many samples a second ends with whole runs.
fn ends_with_runs(pace: f64) -> bool {
    f64::from(RUN_LENGTH) < pace * SHORT_RUN.as_secs_f64()
}

fn seconds_until(deadline: Instant) -> f64 {
    deadline.saturating_duration_since(Instant::now()).as_secs_f64()
}

impl Renderer<'_> {
    /// Renders as many samples as fit until the deadline, and at least a run of each pixel; if that takes long, a sample.
    pub(super) fn render_until(&mut self, most: Range<u32>, deadline: Instant, caller: &mut Caller<'_>) -> Result<()> {
        if let Some(mut pace) = self.probe_pace(&most, deadline, caller)? {
            self.fill(most, deadline, &mut pace, caller)?;
        }
        Ok(())
    }

    /// Renders one sample and takes it back: the result is the pace, samples a second. Nothing where that sample is all that is rendered: there
    /// is time for no other one, or it is the last.
    fn probe_pace(&mut self, most: &Range<u32>, deadline: Instant, caller: &mut Caller<'_>) -> Result<Option<f64>> {
        let begin = Instant::now();
        // In a film that goes on with an earlier render, the one would cut a run in two.
        let goes_on = caller.film.totals().paths > 0;
        caller.probe = Some(PaceProbe { is_dropped: goes_on });
        self.render_samples(most.start..most.start + 1, caller)?;
        caller.probe = None;
        let pace = 1.0 / begin.elapsed().as_secs_f64().max(1e-6);
        let interrupted = caller.outcome.interrupted;
        let goes_further = ends_with_runs(pace) || (pace * seconds_until(deadline) >= 1.0 && !interrupted);
        if !goes_on && (!goes_further || most.len() <= 1) {
            return Ok(None);
        }
        // Its runs of one sample would be parts of longer runs.
        self.drop_film();
        if !goes_on {
            caller.film.clear();
        }
        caller.outcome.totals = Totals::default();
        caller.outcome.samples = Samples::default();
        if interrupted && goes_on {
            return Ok(None);
        }
        // The first runs are rendered even so. Then the caller interrupts again.
        caller.outcome.interrupted = false;
        Ok(Some(pace))
    }

    /// Renders as many samples as fit until the deadline, and at least something if nothing has been rendered; the result is one past the last.
    ///
    /// Their number is fixed before the last range begins, from the pace of the one before it: to stop when a pass happens
    /// to end would favour short paths. The last range is short, so that an error of the pace does little. Ranges end with whole runs, so that a
    /// render that goes on has the bytes of one; only the last range of a slow render does not.
    fn fill(&mut self, most: Range<u32>, deadline: Instant, pace: &mut f64, caller: &mut Caller<'_>) -> Result<u32> {
        /// The shares of the time at whose end the pace is taken again; the last leaves room for its error.
        const SHARES: [f64; 4] = [0.1, 0.5, 0.85, 0.985];
        let begin = Instant::now();
        let all = seconds_until(deadline);
        let mut done = most.start;
        let mut shares = &SHARES[..];
        while let [share, later @ ..] = shares {
            let spent = begin.elapsed().as_secs_f64();
            let fits = (*pace * (share * all - spent)).max(0.0) as u32;
            let aim = done.saturating_add(fits).min(most.end);
            let last = later.is_empty();
            let end = match aim == most.end || (last && !ends_with_runs(*pace)) {
                true => aim,
                false => aim / RUN_LENGTH * RUN_LENGTH,
            };
            // On a machine that has become faster, a share that ended early has room for more.
            if end <= done || last {
                shares = later;
            }
            if end <= done {
                continue;
            }
            self.render_samples(done..end, caller)?;
            *pace = f64::from(end - done) / (begin.elapsed().as_secs_f64() - spent).max(1e-6);
            done = end;
            if caller.outcome.interrupted || done == most.end {
                break;
            }
        }
        if caller.outcome.totals.paths == 0 {
            let run = (done / RUN_LENGTH + 1).saturating_mul(RUN_LENGTH);
            let end = if ends_with_runs(*pace) { run.min(most.end) } else { done + 1 };
            self.render_samples(done..end, caller)?;
            done = end;
        }
        Ok(done)
    }

    /// Renders until the relative error is below the one asked.
    ///
    /// The film is looked at again and again ([`look_after`]). To stop at the first look that pleases would favour those that are too low by
    /// chance: each look has a share of the probability of being wrong that all have together ([`level_after`]), by the union bound.
    /// Samples that have been looked at stay: they are as good as others, and the image is that of `--spp` with their number.
    ///
    /// The error of a handful of pixels is never known with such confidence, nor that of an image without light: there it gives up.
    pub(super) fn render_noise(&mut self, job: &Job, caller: &mut Caller<'_>) -> Result<()> {
        let Goal::Noise { error, deadline, end, begun, looks } = job.goal else { return Ok(()) };
        let most = job.first_sample..end;
        let mut done = most.start;
        let mut noise = Noise { looks, reached: false };
        caller.outcome.noise = Some(noise);
        let mut timed = None;
        if let Some(deadline) = deadline {
            match self.probe_pace(&most, deadline, caller)? {
                Some(pace) => timed = Some((deadline, pace)),
                None => return Ok(()),
            }
        }
        // A render that goes on with another looks where that one would have looked next.
        let aim = |look: u32| begun.saturating_add(look_after(look));
        let mut look = (looks..).find(|look| aim(*look) >= done).unwrap_or(looks);
        loop {
            let end = most.end.min(aim(look));
            done = match &mut timed {
                Some((deadline, pace)) => self.fill(done..end, *deadline, pace, caller)?,
                None => {
                    self.render_samples(done..end, caller)?;
                    end
                }
            };
            if caller.outcome.interrupted {
                return Ok(());
            }
            self.bring_film(caller.film)?;
            let ends;
            (noise, ends) = look_at(caller.film, done - begun, noise.looks, error);
            caller.outcome.noise = Some(noise);
            if ends || done < end || done == most.end {
                return Ok(());
            }
            look += 1;
        }
    }
}
