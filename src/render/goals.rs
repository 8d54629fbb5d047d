//! Renders until a deadline or until an error, whose number of samples is not given.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::noise::{Noise, check_error, samples_at_check};
use super::renderer::Renderer;
use super::sample_range::{Caller, PaceProbe};
use crate::data::RUN_LENGTH;
use crate::error::Result;
use crate::film::Totals;
use crate::job::{Goal, Job};

/// A run of every pixel that takes less time than this is completed, even after the deadline.
const SHORT_RUN: Duration = Duration::from_secs(2);

/// Whether a render ends with complete runs, by its pace in samples per second.
fn ends_with_runs(pace: f64) -> bool {
    f64::from(RUN_LENGTH) < pace * SHORT_RUN.as_secs_f64()
}

fn seconds_until(deadline: Instant) -> f64 {
    deadline.saturating_duration_since(Instant::now()).as_secs_f64()
}

impl Renderer {
    /// Renders as many samples as fit before the deadline, and at least a run of each pixel, or a sample where a run takes long.
    pub(super) fn render_until(&mut self, most: Range<u32>, deadline: Instant, caller: &mut Caller<'_>) -> Result<()> {
        if let Some(mut pace) = self.probe_pace(&most, deadline, caller)? {
            self.fill(most, deadline, &mut pace, caller)?;
        }
        Ok(())
    }

    /// Renders one sample of each pixel, and removes it. Returns the pace in samples per second; `None` if that sample is all that is rendered:
    /// no further one fits, or it is the last.
    fn probe_pace(&mut self, most: &Range<u32>, deadline: Instant, caller: &mut Caller<'_>) -> Result<Option<f64>> {
        let begin = Instant::now();
        // In a film that goes on with an earlier render, the one would cut a run in two.
        let goes_on = caller.film.film.totals.paths > 0;
        caller.probe = Some(PaceProbe { is_dropped: goes_on });
        self.render_samples(most.start..most.start + 1, caller)?;
        caller.probe = None;
        let pace = 1.0 / begin.elapsed().as_secs_f64().max(1e-6);
        let interrupted = caller.outcome.interrupted;
        let goes_further = ends_with_runs(pace) || (pace * seconds_until(deadline) >= 1.0 && !interrupted);
        if !goes_on && (!goes_further || most.len() <= 1) {
            return Ok(None);
        }
        // Runs of this one sample would be parts of longer runs.
        self.drop_film();
        if !goes_on {
            caller.film.clear();
        }
        caller.outcome.totals = Totals::default();
        if interrupted && goes_on {
            return Ok(None);
        }
        // The first runs are rendered even so. Then the caller interrupts again.
        caller.outcome.interrupted = false;
        Ok(Some(pace))
    }

    /// Renders as many samples as fit before the deadline, and at least something if the film is empty. Returns one past the last.
    ///
    /// Their number is fixed before the last range begins, from the pace of the one before it: a render that stopped when a pass
    /// happened to end would favour short paths. The last range is short, so that an error of the pace matters little. Ranges end with
    /// complete runs, so that a resumed render has the bytes of an uninterrupted one; only the last range of a slow render may not.
    fn fill(&mut self, most: Range<u32>, deadline: Instant, pace: &mut f64, caller: &mut Caller<'_>) -> Result<u32> {
        /// The shares of the time after which the pace is measured again. The last leaves room for its error.
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
            // If the machine has become faster, there is time for more samples in this share.
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

    /// Renders until the relative error is below the requested one.
    ///
    /// The error is checked several times ([`samples_at_check`]), and each check may pass by chance. So each check has a share of the total
    /// probability of being wrong ([`level_after`](super::noise::level_after)), by the union bound. All samples stay in the film, and the image is that of `--spp`
    /// with their number.
    ///
    /// The error of a few pixels, or of an image without light, is never known with such confidence. Such renders end without reaching it.
    pub(super) fn render_noise(&mut self, job: &Job, caller: &mut Caller<'_>) -> Result<()> {
        let Goal::Noise { error, deadline, end, begun, checks } = job.goal else { return Ok(()) };
        let most = job.first_sample..end;
        let mut done = most.start;
        let mut noise = Noise { checks, reached: false };
        caller.outcome.noise = Some(noise);
        let mut timed = None;
        if let Some(deadline) = deadline {
            match self.probe_pace(&most, deadline, caller)? {
                Some(pace) => timed = Some((deadline, pace)),
                None => return Ok(()),
            }
        }
        // A resumed render checks where the earlier one would have checked next.
        let aim = |check: u32| begun.saturating_add(samples_at_check(check));
        let mut check = (checks..).find(|check| aim(*check) >= done).unwrap_or(checks);
        loop {
            let end = most.end.min(aim(check));
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
            self.read_film(&mut caller.film.film)?;
            let ends;
            (noise, ends) = check_error(&caller.film.film, done - begun, noise.checks, error);
            (caller.outcome.noise, caller.film.checks) = (Some(noise), noise.checks);
            if ends || done < end || done == most.end {
                return Ok(());
            }
            check += 1;
        }
    }
}
