//! Checkpoints: the image so far in its file, at an interval.

use std::path::Path;
use std::time::{Duration, Instant};

use super::args::KeepArgs;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::gpu::numerics::Numerics;
use crate::output::destination::can_be_replaced;
use crate::output::progress::Progress;
use crate::output::writable::has_room;

/// Under `--watch`: the most between two checkpoints, unless they would take too long.
const MOST_WATCHED: Duration = Duration::from_secs(2);
/// The largest share of the time that checkpoints take.
const MOST_OF_CHECKPOINTS: f64 = 0.03;
/// The first checkpoint is complete this long after the start, so that a disk that is full from the start is found.
const FIRST_CHECKPOINT: Duration = Duration::from_secs(45);

/// The times of checkpoints, and the result of the last one.
pub struct Checkpoints {
    /// `None` where the file cannot be replaced.
    pub next: Option<Instant>,
    /// The time at which the first one is to be complete; `None` once one has been tried.
    pub first: Option<Instant>,
    pub interval: Duration,
    /// Whether a user chose the interval.
    is_chosen: bool,
    /// Why the last one failed, if it did.
    failed: Option<String>,
    /// Whether one has been written.
    pub kept: bool,
    /// The film of the present job when it began.
    pub before: Option<Before>,
}

/// A film before a job, without its pixels.
pub struct Before {
    pub begun: Instant,
    /// The samples of a pixel.
    pub samples: u64,
    /// The numerics of the devices that go on.
    pub numerics: Numerics,
}

/// Whether a time has come.
pub fn is_due(next: Option<Instant>, now: Instant) -> bool {
    next.is_some_and(|next| now >= next)
}

impl Checkpoints {
    /// Checkpoints of this image. Where the disk has no room for one, that is reported.
    pub fn new(args: &KeepArgs, image: &Path, progress: &Progress) -> Checkpoints {
        let next = can_be_replaced(image).then(Instant::now);
        let mut checkpoints = Checkpoints {
            next,
            first: next.map(|now| now + FIRST_CHECKPOINT),
            interval: if args.watch { args.checkpoint.min(MOST_WATCHED) } else { args.checkpoint },
            is_chosen: !args.watch,
            failed: None,
            kept: false,
            before: None,
        };
        if next.is_some() {
            checkpoints.report(has_room(image).err(), progress);
        }
        checkpoints
    }

    /// Begins with a job on this film.
    pub fn begin(&mut self, begun: Instant, film: &Accumulation, numerics: &Numerics) {
        self.before = Some(Before { begun, samples: film.samples.count(), numerics: numerics.clone() });
        self.next = self.next.map(|_| begun + self.interval);
    }

    /// Whether one is due, which consists of complete runs: those that have started end in the time of `runs`, if that is known.
    pub fn are_due(&self, now: Instant, runs: Option<Duration>) -> bool {
        runs.is_some_and(|runs| is_due(self.first, now + runs)) || is_due(self.next, now)
    }

    /// Notes whether the image was written, and then its picture. Tells what is new, and when the next one comes. A render goes on where a checkpoint
    /// fails.
    pub fn add(
        &mut self,
        image: Result<()>,
        picture: impl FnOnce() -> Result<()>,
        begin: Instant,
        progress: &Progress,
    ) {
        self.kept |= image.is_ok();
        self.first = None;
        self.report(image.and_then(|()| picture()).err(), progress);
        let took = begin.elapsed();
        let least = took.div_f64(MOST_OF_CHECKPOINTS);
        if least > self.interval {
            self.interval = least;
            if self.is_chosen {
                progress.message(&format!(
                    "a checkpoint takes {:.1} s: the next ones come every {:.0} s, so that they take {} % of the time",
                    took.as_secs_f64(),
                    least.as_secs_f64(),
                    100.0 * MOST_OF_CHECKPOINTS
                ));
            }
        }
        self.next = Some(Instant::now() + self.interval);
    }

    /// Tells why the file cannot be written, or that it can be again.
    fn report(&mut self, failed: Option<Error>, progress: &Progress) {
        let failed = failed.map(|error| error.to_string());
        if let Some(words) = about_checkpoint(self.failed.as_deref(), failed.as_deref()) {
            progress.message(&words);
        }
        self.failed = failed;
    }
}

/// The message about a checkpoint, by the reasons why the last one and this one failed, if they did. A reason is reported once.
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
    use crate::job::{Goal, Job};

    const JOB: Job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(1) };

    fn checkpoints(interval: Duration) -> (Checkpoints, Progress) {
        let progress = Progress::new(true, &JOB, 0);
        let args = KeepArgs {
            checkpoint: interval,
            resume: None,
            watch: false,
            mixed_drivers: false,
            no_state: false,
            force: false,
        };
        (Checkpoints::new(&args, Path::new("/dev/null/none.exr"), &progress), progress)
    }

    /// A picture that cannot be written is reported like a failed checkpoint. The EXR is kept, and can be resumed.
    #[test]
    fn a_checkpoint_is_kept_without_its_picture() {
        let written = |works: bool| if works { Ok(()) } else { Err(Error::Usage("the disk is full".to_string())) };
        for (exr, picture, kept) in [(true, false, true), (false, true, false), (true, true, true)] {
            let (mut checkpoints, progress) = checkpoints(Duration::ZERO);
            checkpoints.add(written(exr), || written(picture), Instant::now(), &progress);
            assert_eq!(checkpoints.kept, kept);
            assert_eq!(checkpoints.failed.is_some(), !(exr && picture));
        }
    }

    /// Whatever the interval, the first checkpoint is requested so early that the started runs end in time.
    #[test]
    fn the_first_checkpoint_is_early() {
        let seconds = Duration::from_secs;
        for (runs, is_due) in [(Some(80), true), (Some(40), true), (Some(10), false), (None, false)] {
            let (mut checkpoints, progress) = checkpoints(seconds(3600));
            let now = Instant::now();
            (checkpoints.first, checkpoints.next) = (Some(now + seconds(39)), Some(now + seconds(3600)));
            assert_eq!(checkpoints.are_due(now, runs.map(seconds)), is_due, "{runs:?}");
            checkpoints.add(Ok(()), || Ok(()), now, &progress);
            assert!(checkpoints.kept && !checkpoints.are_due(now, runs.map(seconds)));
        }
    }

    #[test]
    fn each_reason_of_failed_checkpoints_is_reported_once() {
        let is_reported = |before, now| about_checkpoint(before, now).is_some();
        let (full, gone) = (Some("the disk is full"), Some("the folder is gone"));
        assert!(is_reported(None, full) && is_reported(full, gone) && is_reported(gone, None));
        assert!(!is_reported(full, full) && !is_reported(None, None));
    }
}
