//! The observers of a running render: the line of progress, viewers, checkpoints, signals and changes of the scene's files.

use std::time::{Duration, Instant};

use super::changes::Changes;
use super::request::Request;
use super::viewers::Viewers;
use crate::commands::signals::Signals;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::job::{Goal, Job};
use crate::output::destination::can_be_replaced;
use crate::output::progress::{Progress, Status, Until};
use crate::output::writable::has_room;
use crate::render::{Next, Outcome, Snapshot, level_after, samples_at_check};

/// Under `--watch`: the most between two checkpoints, unless they would take too long.
const MOST_WATCHED: Duration = Duration::from_secs(2);
/// The largest share of the time that checkpoints take.
const MOST_OF_CHECKPOINTS: f64 = 0.03;

/// The first checkpoint is complete this long after the start, so that a disk that is full from the start is found.
const FIRST_CHECKPOINT: Duration = Duration::from_secs(45);
/// A pace counts once it has been measured for this long.
const MEASURED: Duration = Duration::from_secs(3);
/// Seconds that no render takes.
const LONG: f64 = 1e9;

/// What bringing the film from the device and measuring its error takes: 0.1 to 0.2 µs a pixel.
fn snapshot_time((width, height): (u32, u32)) -> Duration {
    Duration::from_nanos(u64::from(width) * u64::from(height) * 150)
}

/// The time between two snapshots: they shall cost 0.5 % at most, or 5 % where somebody watches the image, and nobody needs more than one a
/// second.
fn pause_after(snapshot: Duration, is_watched: bool) -> Duration {
    let share = if is_watched { 20 } else { 200 };
    (share * snapshot).max(Duration::from_secs(1))
}

/// The observers of a render.
pub struct Observers<'a> {
    pub progress: Progress,
    pub viewers: Viewers,
    pub signals: &'a Signals,
    /// The files that end the render at once when they change.
    changes: Option<&'a Changes>,
    pub checkpoints: Checkpoints,
    /// `None` if nothing shows snapshots.
    next_snapshot: Option<Instant>,
    /// Whether the message that a signal ends the render has been printed.
    signal_reported: bool,
    pace: Pace,
}

/// When checkpoints are due, and what came of the last one.
pub struct Checkpoints {
    /// `None` where the file cannot be replaced.
    next: Option<Instant>,
    /// The time at which the first one is to be complete; `None` once one has been tried.
    first: Option<Instant>,
    interval: Duration,
    /// Whether a user chose the interval.
    is_chosen: bool,
    /// Why the last one failed, if it did.
    failed: Option<String>,
    /// Whether one has been written.
    pub kept: bool,
}

/// What the progress of a job is measured by.
struct Pace {
    /// When the first of the paths that are counted began.
    begun: Instant,
    /// The paths that were counted last.
    paths: u64,
    goal: Goal,
    pixels: u64,
    /// Samples of a pixel that the film had before.
    earlier: u64,
    /// The error in the last snapshot.
    error: Option<f64>,
    until: Option<Until>,
    /// The time of `--time`, until it has been reported as too short.
    time: Option<Duration>,
}

impl<'a> Observers<'a> {
    /// `earlier` is the number of samples of a pixel that the film has already.
    pub fn new(
        request: &Request<'_>,
        signals: &'a Signals,
        changes: Option<&'a Changes>,
        earlier: u64,
    ) -> Observers<'a> {
        let Request { args, job, image, .. } = request;
        let progress = Progress::new(args.quiet, job, earlier);
        let viewers = Viewers::open(args, image.display().to_string(), job.size);
        let mut observers = Observers::silent(progress, viewers, signals, job);
        observers.changes = changes;
        observers.checkpoints.interval = if args.watch { args.checkpoint.min(MOST_WATCHED) } else { args.checkpoint };
        observers.checkpoints.is_chosen = !args.watch;
        observers.checkpoints.next = can_be_replaced(image).then(Instant::now);
        observers.checkpoints.first = observers.checkpoints.next.map(|now| now + FIRST_CHECKPOINT);
        observers.pace.time = args.time;
        if observers.checkpoints.next.is_some() {
            observers.checkpoints.report(has_room(image).err(), &observers.progress);
        }
        observers.next_snapshot = (!args.quiet || observers.viewers.any()).then(Instant::now);
        observers
    }

    /// Observers that take no snapshots and write no checkpoints.
    fn silent(progress: Progress, viewers: Viewers, signals: &'a Signals, job: &Job) -> Observers<'a> {
        let checkpoints = Checkpoints {
            next: None,
            first: None,
            interval: Duration::ZERO,
            is_chosen: true,
            failed: None,
            kept: false,
        };
        let pace = Pace::new(job, 0);
        Observers {
            progress,
            viewers,
            signals,
            changes: None,
            checkpoints,
            next_snapshot: None,
            signal_reported: false,
            pace,
        }
    }

    /// Gets ready for a job, on a film that has `earlier` samples of a pixel, after `compile` seconds of compiling.
    pub fn begin(&mut self, job: &Job, earlier: u64, compile: f64) {
        let time = self.pace.time;
        self.pace = Pace { time, ..Pace::new(job, earlier) };
        if let Some(words) = self.pace.is_late(compile) {
            self.progress.message(&words);
        }
        let begun = self.pace.begun;
        let pause = pause_after(snapshot_time(job.size), self.viewers.any());
        self.next_snapshot = self.next_snapshot.map(|_| begun + pause);
        self.checkpoints.next = self.checkpoints.next.map(|_| begun + self.checkpoints.interval);
    }

    /// Called after each submission. `checkpoint` writes the image, and `picture` the PNG.
    pub fn follow(
        &mut self,
        outcome: &Outcome,
        snapshot: Option<Snapshot<'_>>,
        checkpoint: &dyn Fn(&Film, &Outcome) -> Result<()>,
        picture: &dyn Fn(&Film) -> Result<()>,
    ) -> Next {
        let is_due = |next: Option<Instant>, now| next.is_some_and(|next| now >= next);
        let now = Instant::now();
        self.pace.count(outcome);
        // A checkpoint consists of complete runs: those that have started come first.
        let first = self.checkpoints.first.filter(|_| now - self.pace.begun >= MEASURED);
        let first = is_due(first, now + self.pace.time_of_runs(outcome));
        let (keep, show) = (first || is_due(self.checkpoints.next, now), is_due(self.next_snapshot, now));
        let had_snapshot = snapshot.is_some();
        if let Some(Snapshot { film, begin, is_complete }) = snapshot {
            if keep && is_complete {
                let kept = checkpoint(film, outcome);
                self.checkpoints.kept |= kept.is_ok();
                self.checkpoints.add(kept.and_then(|()| picture(film)), begin.elapsed(), &self.progress);
            } else if self.next_snapshot.is_some() {
                self.pace.measure_error(film, outcome);
                self.viewers.show(film, &self.progress);
                self.next_snapshot = Some(Instant::now() + pause_after(begin.elapsed(), self.viewers.any()));
            }
        }
        self.progress.update(self.pace.status(outcome));
        if let Some(words) = self.pace.will_be_late(outcome) {
            self.progress.message(&words);
        }
        let is_stopped = self.signals.are_pending();
        if is_stopped && !std::mem::replace(&mut self.signal_reported, true) {
            let signal = self.signals;
            self.progress.message(&format!("{signal}: ending the samples under way; a second signal ends at once"));
        }
        match is_stopped {
            true => Next::Stop,
            false if self.changes.is_some_and(Changes::have_changed) => Next::Drop,
            false if had_snapshot => Next::GoOn,
            false if keep => Next::CompleteSnapshot,
            false if show => Next::Snapshot,
            false => Next::GoOn,
        }
    }
}

impl Checkpoints {
    /// Tells what is new after a checkpoint, and when the next one comes. One that fails is tried again; the render is worth more than it.
    fn add(&mut self, kept: Result<()>, took: Duration, progress: &Progress) {
        self.first = None;
        self.report(kept.err(), progress);
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

impl Pace {
    fn new(job: &Job, earlier: u64) -> Pace {
        let pixels = job.pixels();
        Pace { begun: Instant::now(), paths: 0, goal: job.goal, pixels, earlier, error: None, until: None, time: None }
    }

    /// Counts the paths. Restarts the clock if the paths of a pace probe were dropped.
    fn count(&mut self, outcome: &Outcome) {
        let before = std::mem::replace(&mut self.paths, outcome.totals.paths);
        if self.paths < before {
            self.begun = Instant::now();
        }
    }

    /// The time of a run of each pixel at the pace so far; a long time before the pace is known.
    fn time_of_runs(&self, outcome: &Outcome) -> Duration {
        let paths = (u64::from(RUN_LENGTH) * self.pixels) as f64;
        let seconds = self.begun.elapsed().as_secs_f64() * paths / outcome.totals.paths.max(1) as f64;
        Duration::from_secs_f64(seconds.min(LONG))
    }

    /// A warning, once, if `--time` is over before rendering begins.
    fn is_late(&mut self, compile: f64) -> Option<String> {
        let deadline = self.goal.deadline()?;
        let time = self.time.take_if(|_| Instant::now() >= deadline)?;
        Some(format!(
            "warning: --time {} s is over before rendering begins: {compile:.1} s went into compiling. At least one sample of each pixel is rendered",
            time.as_secs_f64()
        ))
    }

    /// A warning, once, if the first sample of each pixel will end after `--time`.
    fn will_be_late(&mut self, outcome: &Outcome) -> Option<String> {
        let deadline = self.goal.deadline()?;
        let sample = self.time_of_runs(outcome) / RUN_LENGTH;
        if outcome.totals.paths >= self.pixels {
            // The first one has ended.
            self.time = None;
        }
        let is_known = self.begun.elapsed() >= MEASURED;
        // The pace of a start is not that of all.
        let time = self.time.take_if(|time| is_known && self.begun + sample > deadline + *time / 10)?;
        Some(format!(
            "warning: --time {} s cannot be kept: a sample of each pixel takes about {:.0} s",
            time.as_secs_f64(),
            sample.as_secs_f64()
        ))
    }

    fn samples(&self, outcome: &Outcome) -> u64 {
        self.earlier + outcome.totals.paths / self.pixels.max(1)
    }

    fn status(&self, outcome: &Outcome) -> Status {
        Status {
            samples_per_pixel: self.samples(outcome),
            paths_per_second: outcome.totals.paths as f64 / self.begun.elapsed().as_secs_f64().max(1e-6),
            relative_error: self.error,
            until: self.until,
        }
    }

    /// Measures the film's error; for a render until an error with the confidence of the next time that it decides, and with the samples that are
    /// still needed if the bound falls with their square root.
    fn measure_error(&mut self, film: &Film, outcome: &Outcome) {
        let Goal::Noise { error: wanted, begun, .. } = self.goal else {
            self.error = film.relative_error();
            return;
        };
        let checks = outcome.noise.map_or(0, |noise| noise.checks);
        let verdict = film.verdict(level_after(checks));
        self.error = verdict.error.map(|error| error.value);
        let done = self.samples(outcome).saturating_sub(u64::from(begun));
        self.until = verdict.error.map(|error| {
            let lacks_light = error.bound < wanted && verdict.lacks_light();
            let needed = done as f64 * (error.bound / wanted).max(1.0).powi(2);
            // No render has more checks: the last ones are at more samples than a pixel can have.
            const MOST_CHECKS: u32 = 128;
            let mut ends = (checks..checks + MOST_CHECKS).map(|check| u64::from(samples_at_check(check)));
            let ends = ends.find(|at| *at > done && *at as f64 >= needed).map(|at| at + u64::from(begun));
            Until { bound: error.bound, samples: ends.filter(|_| !lacks_light), lacks_light }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Totals;

    const JOB: Job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(1) };

    /// Observers that take a snapshot at this time, and write checkpoints at this interval.
    fn observers(signals: &Signals, next_snapshot: Option<Instant>, interval: Duration) -> Observers<'_> {
        let mut observers = Observers::silent(Progress::new(true, &JOB, 0), Viewers::default(), signals, &JOB);
        observers.next_snapshot = next_snapshot;
        observers.checkpoints.interval = interval;
        observers.checkpoints.next = Some(Instant::now() + interval);
        observers
    }

    /// The number of snapshots of a film that takes 10 ms to be read, after `calls` submissions.
    fn snapshots(next_snapshot: Option<Instant>, interval: Duration, calls: usize) -> usize {
        let signals = Signals::default();
        let mut observers = observers(&signals, next_snapshot, interval);
        let (film, outcome) = (Film::new(1, 1, 0).unwrap(), Outcome::default());
        let mut follow = |snapshot| observers.follow(&outcome, snapshot, &|_, _| Ok(()), &|_| Ok(()));
        let mut count = 0;
        for _ in 0..calls {
            let next = follow(None);
            if next != Next::GoOn {
                count += 1;
                let begin = Instant::now() - Duration::from_millis(10);
                let snapshot = Snapshot { film: &film, begin, is_complete: next == Next::CompleteSnapshot };
                assert_eq!(follow(Some(snapshot)), Next::GoOn);
            }
        }
        count
    }

    /// A picture that cannot be written is reported like a failed checkpoint. The EXR is kept, and can be resumed.
    #[test]
    fn a_checkpoint_is_kept_without_its_picture() {
        let signals = Signals::default();
        let (film, outcome) = (Film::new(1, 1, 0).unwrap(), Outcome::default());
        let written = |works: bool| if works { Ok(()) } else { Err(Error::Usage("the disk is full".to_string())) };
        for (exr, picture, kept) in [(true, false, true), (false, true, false), (true, true, true)] {
            let mut observers = observers(&signals, None, Duration::ZERO);
            let mut follow =
                |snapshot| observers.follow(&outcome, snapshot, &|_, _| written(exr), &|_| written(picture));
            assert_eq!(follow(None), Next::CompleteSnapshot);
            follow(Some(Snapshot { film: &film, begin: Instant::now(), is_complete: true }));
            assert_eq!(observers.checkpoints.kept, kept);
            assert_eq!(observers.checkpoints.failed.is_some(), !(exr && picture));
        }
    }

    /// An outcome of so many paths of the one pixel.
    fn outcome_of(paths: u64) -> Outcome {
        Outcome { totals: Totals { paths, ..Totals::default() }, ..Outcome::default() }
    }

    /// Whatever the interval, the first checkpoint is requested so early that the started runs end in time.
    #[test]
    fn the_first_checkpoint_is_early() {
        let signals = Signals::default();
        let seconds = Duration::from_secs;
        // A run of 8 samples takes 80 s, 40 s and 10 s.
        for (measured, paths, is_due) in [(10, 1, true), (10, 2, true), (10, 8, false), (1, 1, false)] {
            let mut observers = observers(&signals, None, seconds(3600));
            observers.checkpoints.first = Some(Instant::now() + seconds(39));
            observers.pace.begun = Instant::now() - seconds(measured);
            let (film, outcome) = (Film::new(1, 1, 0).unwrap(), outcome_of(paths));
            let mut follow = |snapshot| observers.follow(&outcome, snapshot, &|_, _| Ok(()), &|_| Ok(()));
            assert_eq!(follow(None) == Next::CompleteSnapshot, is_due, "{measured} {paths}");
            if is_due {
                follow(Some(Snapshot { film: &film, begin: Instant::now(), is_complete: true }));
                assert!(observers.checkpoints.kept && observers.checkpoints.first.is_none());
                assert_eq!(observers.follow(&outcome, None, &|_, _| Ok(()), &|_| Ok(())), Next::GoOn);
            }
        }
    }

    /// It is reported once, as soon as it is known.
    #[test]
    fn a_time_that_cannot_be_kept_is_told() {
        let seconds = Duration::from_secs;
        let time = seconds(25);
        let pace = |left: u64, measured: u64| {
            let goal = Goal::Until { deadline: Instant::now() + seconds(left), end: 100 };
            let mut pace = Pace { time: Some(time), ..Pace::new(&Job { goal, ..JOB }, 0) };
            (pace.begun, pace.pixels) = (Instant::now() - seconds(measured), 100);
            pace
        };
        let mut late = pace(0, 0);
        let says = "warning: --time 25 s is over before rendering begins: 31.4 s went into compiling";
        assert!(late.is_late(31.4).is_some_and(|words| words.starts_with(says)));
        assert_eq!((late.is_late(31.4), late.will_be_late(&outcome_of(1))), (None, None));
        // Ten seconds for five of a hundred pixels.
        let mut slow = pace(15, 10);
        let says = "warning: --time 25 s cannot be kept: a sample of each pixel takes about 200 s";
        assert_eq!(slow.is_late(9.0), None);
        assert_eq!(
            (slow.will_be_late(&outcome_of(5)).as_deref(), slow.will_be_late(&outcome_of(5))),
            (Some(says), None)
        );
        for (left, measured, paths) in [(300, 10, 5), (15, 1, 1), (15, 10, 100)] {
            assert_eq!(pace(left, measured).will_be_late(&outcome_of(paths)), None, "{left} {measured} {paths}");
        }
    }

    #[test]
    fn each_reason_of_failed_checkpoints_is_reported_once() {
        let is_reported = |before, now| about_checkpoint(before, now).is_some();
        let (full, gone) = (Some("the disk is full"), Some("the folder is gone"));
        assert!(is_reported(None, full) && is_reported(full, gone) && is_reported(gone, None));
        assert!(!is_reported(full, full) && !is_reported(None, None));
    }

    /// A snapshot of 10 ms is followed by two seconds without one, as is one of 100 ms that somebody watches. A quiet render has none but for
    /// checkpoints.
    #[test]
    fn snapshots_are_rare_and_for_somebody() {
        let hour = Duration::from_secs(3600);
        assert_eq!(snapshots(Some(Instant::now()), hour, 1000), 1);
        assert_eq!(snapshots(None, hour, 1000), 0);
        // Checkpoints that take 10 ms each come every third of a second, however often they are due.
        assert_eq!(snapshots(None, Duration::ZERO, 10), 1);
        assert_eq!(pause_after(Duration::from_millis(10), false), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::from_millis(100), true), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::ZERO, true), Duration::from_secs(1));
    }
}
