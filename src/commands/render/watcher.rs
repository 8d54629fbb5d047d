//! What a render does while it goes on: it shows progress, looks at the film, writes checkpoints, and passes signals on.

use std::time::{Duration, Instant};

use super::changes::Changes;
use super::viewers::Viewers;
use crate::commands::signals::Signals;
use crate::error::Result;
use crate::film::Film;
use crate::job::Goal;
use crate::output::progress::{Progress, Status, Until};
use crate::render::{Look, Next, Outcome, level_after, look_after};

/// What bringing the film from the device and measuring its error takes: 0.1 to 0.2 µs a pixel.
pub fn look_time((width, height): (u32, u32)) -> Duration {
    Duration::from_nanos(u64::from(width) * u64::from(height) * 150)
}

/// The time between two looks: they shall cost 0.5 % at most, and no terminal needs more than one a second.
pub fn pause_after(look: Duration) -> Duration {
    (200 * look).max(Duration::from_secs(1))
}

/// The largest share of the time that checkpoints take.
const MOST_OF_CHECKPOINTS: f64 = 0.03;

/// Called after each submission.
pub struct Watcher<'a> {
    pub progress: &'a Progress,
    pub signals: &'a Signals,
    pub begun: Instant,
    pub pixels: u64,
    /// Samples of a pixel that the film had before.
    pub earlier: u64,
    /// Nothing where nobody watches.
    pub next_look: Option<Instant>,
    /// Nothing where the file cannot be replaced.
    pub next_checkpoint: Option<Instant>,
    pub interval: Duration,
    /// What ends the render at once.
    pub changes: Option<&'a Changes>,
    /// What the last look told of the error.
    pub error: Option<f64>,
    pub until: Option<Until>,
    /// What the render is to end at.
    pub goal: Goal,
    /// Why the last checkpoint failed, if it did.
    pub failed: Option<String>,
    /// Whether a checkpoint has been written.
    pub kept: bool,
    /// Whether it has been told that a signal ends the render.
    pub told: bool,
    pub checkpoint: &'a (dyn Fn(&Film, &Outcome) -> Result<()> + Sync),
    /// Writes the picture of a checkpoint, after it.
    pub picture: &'a (dyn Fn(&Film) -> Result<()> + Sync),
    pub viewers: &'a mut Viewers,
}

impl Watcher<'_> {
    pub fn watch(&mut self, outcome: &Outcome, look: Option<Look<'_>>) -> Next {
        let now = Instant::now();
        let keep = self.next_checkpoint.is_some_and(|next| now >= next);
        let is_due = self.next_look.is_some_and(|next| now >= next);
        let looked = look.is_some();
        if let Some(Look { film, begin, whole }) = look {
            if keep && whole {
                let kept = (self.checkpoint)(film, outcome);
                self.kept |= kept.is_ok();
                self.note_checkpoint(kept.and_then(|()| (self.picture)(film)), begin.elapsed());
            } else if self.next_look.is_some() {
                self.note_error(film, outcome);
                self.viewers.show(film, self.progress);
                self.next_look = Some(Instant::now() + pause_after(begin.elapsed()));
            }
        }
        let paths = outcome.totals.paths;
        self.progress.update(Status {
            samples_per_pixel: self.earlier + paths / self.pixels.max(1),
            paths_per_second: paths as f64 / self.begun.elapsed().as_secs_f64().max(1e-6),
            relative_error: self.error,
            until: self.until,
        });
        let stopped = self.signals.came();
        if stopped && !std::mem::replace(&mut self.told, true) {
            let signal = self.signals;
            self.progress.message(&format!("{signal}: ending the samples under way; a second signal ends at once"));
        }
        match stopped {
            true => Next::Stop,
            false if self.changes.is_some_and(Changes::came) => Next::Drop,
            false if looked => Next::GoOn,
            false if keep => Next::Whole,
            false if is_due => Next::Look,
            false => Next::GoOn,
        }
    }

    /// Measures the film's error; for a render until an error with the confidence of the next time that it decides, and with the samples that are
    /// still needed if the bound falls with their square root.
    fn note_error(&mut self, film: &Film, outcome: &Outcome) {
        let Goal::Noise { error: wanted, begun, .. } = self.goal else {
            self.error = film.relative_error();
            return;
        };
        let looks = outcome.noise.map_or(0, |noise| noise.looks);
        let verdict = film.verdict(level_after(looks));
        self.error = verdict.error.map(|error| error.value);
        let samples = self.earlier + outcome.totals.paths / self.pixels.max(1);
        let done = samples.saturating_sub(u64::from(begun));
        self.until = verdict.error.map(|error| {
            let lacks_light = error.bound < wanted && verdict.lacks_light();
            let needed = done as f64 * (error.bound / wanted).max(1.0).powi(2);
            // No render has more looks: the last ones are at more samples than a pixel can have.
            const MOST_LOOKS: u32 = 128;
            let mut ends = (looks..looks + MOST_LOOKS).map(|look| u64::from(look_after(look)));
            let ends = ends.find(|at| *at > done && *at as f64 >= needed).map(|at| at + u64::from(begun));
            Until { bound: error.bound, samples: ends.filter(|_| !lacks_light), lacks_light }
        });
    }

    /// Tells what is new, and when the next checkpoint comes. One that fails is tried again; the render is worth more than it.
    fn note_checkpoint(&mut self, kept: Result<()>, took: Duration) {
        let failed = kept.err().map(|error| error.to_string());
        if let Some(words) = about_checkpoint(self.failed.as_deref(), failed.as_deref()) {
            self.progress.message(&words);
        }
        self.failed = failed;
        let least = took.div_f64(MOST_OF_CHECKPOINTS);
        if least > self.interval {
            self.interval = least;
            // Under --watch the interval was nobody's wish.
            if self.changes.is_none() {
                self.progress.message(&format!(
                    "a checkpoint takes {:.1} s: the next ones come every {:.0} s, so that they take {} % of the time",
                    took.as_secs_f64(),
                    least.as_secs_f64(),
                    100.0 * MOST_OF_CHECKPOINTS
                ));
            }
        }
        self.next_checkpoint = Some(Instant::now() + self.interval);
    }
}

/// What is told of a checkpoint, by the reasons why the last one and this one failed, if they did. A reason is told once.
fn about_checkpoint(before: Option<&str>, now: Option<&str>) -> Option<String> {
    match now {
        Some(_) if now == before => None,
        Some(reason) => {
            Some(format!("warning: no checkpoint: {reason}. The render goes on, and the next one tries again"))
        }
        None => before.map(|_| "the checkpoint is written again".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;

    fn progress() -> Progress {
        let goal = Goal::Samples(1);
        Progress::new(true, &Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal }, 0)
    }

    fn watcher<'a>(
        progress: &'a Progress,
        signals: &'a Signals,
        viewers: &'a mut Viewers,
        next_look: Option<Instant>,
        checkpoint: Duration,
    ) -> Watcher<'a> {
        let begun = Instant::now();
        Watcher {
            progress,
            signals,
            begun,
            pixels: 1,
            earlier: 0,
            next_look,
            next_checkpoint: Some(begun + checkpoint),
            interval: checkpoint,
            changes: None,
            error: None,
            until: None,
            goal: Goal::Samples(1),
            failed: None,
            kept: false,
            told: false,
            checkpoint: &|_, _| Ok(()),
            picture: &|_| Ok(()),
            viewers,
        }
    }

    /// What a watcher says to `calls` submissions, with a film that takes 10 ms to be looked at: how often it looks.
    fn looks(next_look: Option<Instant>, checkpoint: Duration, calls: usize) -> usize {
        let (progress, signals, mut viewers) = (progress(), Signals::default(), Viewers::default());
        let mut watcher = watcher(&progress, &signals, &mut viewers, next_look, checkpoint);
        let (film, outcome) = (Film::new(1, 1, 0).unwrap(), Outcome::default());
        let mut count = 0;
        for _ in 0..calls {
            let next = watcher.watch(&outcome, None);
            if next != Next::GoOn {
                count += 1;
                let begin = Instant::now() - Duration::from_millis(10);
                let look = Look { film: &film, begin, whole: next == Next::Whole };
                assert_eq!(watcher.watch(&outcome, Some(look)), Next::GoOn);
            }
        }
        count
    }

    /// A picture that cannot be written is told as a checkpoint that failed is. The EXR is there all the same, and can be gone on with.
    #[test]
    fn a_checkpoint_is_kept_without_its_picture() {
        let (progress, signals, mut viewers) = (progress(), Signals::default(), Viewers::default());
        let (film, outcome) = (Film::new(1, 1, 0).unwrap(), Outcome::default());
        let fails = || Err(crate::error::Error::Usage("the disk is full".to_string()));
        for (exr, picture, kept) in [(true, false, true), (false, true, false), (true, true, true)] {
            let mut watcher = watcher(&progress, &signals, &mut viewers, None, Duration::ZERO);
            let (of_exr, of_picture) = (
                |_: &Film, _: &Outcome| if exr { Ok(()) } else { fails() },
                |_: &Film| if picture { Ok(()) } else { fails() },
            );
            watcher = Watcher { checkpoint: &of_exr, picture: &of_picture, ..watcher };
            assert_eq!(watcher.watch(&outcome, None), Next::Whole);
            watcher.watch(&outcome, Some(Look { film: &film, begin: Instant::now(), whole: true }));
            assert_eq!(watcher.kept, kept);
            assert_eq!(watcher.failed.is_some(), !(exr && picture));
        }
    }

    #[test]
    fn each_reason_of_failed_checkpoints_is_told_once() {
        let is_told = |before, now| about_checkpoint(before, now).is_some();
        let (full, gone) = (Some("the disk is full"), Some("the folder is gone"));
        assert!(is_told(None, full) && is_told(full, gone) && is_told(gone, None));
        assert!(!is_told(full, full) && !is_told(None, None));
    }

    /// A look of 10 ms is followed by two seconds without one, and nobody looks for a quiet render but to write checkpoints.
    #[test]
    fn looks_are_rare_and_for_somebody() {
        let hour = Duration::from_secs(3600);
        assert_eq!(looks(Some(Instant::now()), hour, 1000), 1);
        assert_eq!(looks(None, hour, 1000), 0);
        // Checkpoints that take 10 ms each come every third of a second, however often they are asked for.
        assert_eq!(looks(None, Duration::ZERO, 10), 1);
        assert_eq!(pause_after(Duration::from_millis(10)), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::ZERO), Duration::from_secs(1));
    }
}
