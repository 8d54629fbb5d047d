//! Who follows a render: the line of progress, viewers, checkpoints, signals, and changes of the scene's files.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::checkpoints::{Before, Checkpoints, is_due};
use super::record::{Clock, Finish, per_sample, record, write_film};
use super::request::Request;
use super::resume::starting_film;
use super::viewers::{Viewers, pause_after, snapshot_time};
use crate::commands::changes::Changes;
use crate::commands::compiling::Compiling;
use crate::commands::signals::{EndsAtOnce, Signals};
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::{Accumulation, Film};
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::gpu::numerics::Numerics;
use crate::job::{Goal, Job};
use crate::output::exr::{State, read_state};
use crate::output::progress::{Progress, Status, Until};
use crate::render::{Next, Observer, Outcome, Snapshot, level_after, samples_at_check};

/// A pace counts once it has been measured for this long.
const MEASURED: Duration = Duration::from_secs(3);
/// Seconds that no render takes.
const LONG: f64 = 1e9;

/// The observers of a render.
pub struct Observers<'a> {
    request: &'a Request<'a>,
    signals: &'a Signals,
    /// The files that end the render at once when they change.
    changes: Option<&'a Changes>,
    pub progress: Progress,
    pub viewers: Viewers,
    pub checkpoints: Checkpoints,
    pub clock: Clock,
    /// `None` if nothing shows snapshots.
    next_snapshot: Option<Instant>,
    /// Whether the message that a signal ends the render has been printed.
    signal_reported: bool,
    headway: Headway,
    /// Whether compiling is not shown either.
    quiet: bool,
    /// Shows the kernels that compile, which the first signal ends.
    compiling: Option<(Compiling, EndsAtOnce<'a>)>,
}

/// The progress of a job, and the pace that it is predicted by.
struct Headway {
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
    /// `quiet` hides what compiles as well.
    pub fn new(
        request: &'a Request<'a>,
        signals: &'a Signals,
        changes: Option<&'a Changes>,
        clock: Clock,
        quiet: bool,
    ) -> Observers<'a> {
        let Request { args, job, image, .. } = request;
        let earlier = request.held.unwrap_or(0);
        let progress = Progress::new(args.messages.quiet, job, earlier);
        let viewers = Viewers::open(args, image.display().to_string(), job.size);
        let checkpoints = Checkpoints::new(&args.keep, image, &progress);
        let next_snapshot = (!args.messages.quiet || viewers.any()).then(Instant::now);
        let headway = Headway { time: args.goal.time, ..Headway::new(job, earlier) };
        Observers {
            request,
            signals,
            changes,
            progress,
            viewers,
            checkpoints,
            clock,
            next_snapshot,
            signal_reported: false,
            headway,
            quiet,
            compiling: None,
        }
    }

    /// Writes the image so far.
    fn write(&self, film: &Accumulation, so_far: &Outcome, before: &Before) -> Result<()> {
        let Before { begun, samples, numerics } = before;
        let finish = Finish::new(film, so_far.noise, false);
        let mut seconds = self.clock.seconds;
        let rendered = film.samples.count().saturating_sub(*samples);
        seconds.per_sample = per_sample(begun.elapsed().as_secs_f64(), rendered);
        write_film(self.request, film, &record(self.request, numerics, &finish, &seconds))?;
        let kept = self.request.what_is_in(&self.request.image, &film.samples);
        self.signals.set_loss(format!("the samples since the last checkpoint are lost. {kept}"));
        Ok(())
    }

    /// The state in the output, if that is a checkpoint of this render, or what it goes on with.
    pub fn kept(&self) -> Result<Option<State>> {
        match self.request.exr() {
            Some(exr) if self.checkpoints.kept || self.request.held.is_some() => read_state(exr),
            _ => Ok(None),
        }
    }
}

impl Observer for Observers<'_> {
    fn compiling(&mut self, devices: &[Arc<Device>]) -> Result<()> {
        let ending = self.signals.end_at_once("while compiling")?;
        self.compiling = Some((Compiling::show(devices, self.quiet, self.viewers.any()), ending));
        Ok(())
    }

    fn compiled(&mut self) {
        self.compiling = None;
        self.clock.seconds.compile += self.clock.lap();
        self.progress.restart();
    }

    fn begin(&mut self, job: &Job, film: &Accumulation, numerics: &Numerics) {
        let time = self.headway.time;
        self.headway = Headway { time, ..Headway::new(job, film.samples.count()) };
        if let Some(words) = self.headway.is_late(self.clock.seconds.compile) {
            self.progress.message(&words);
        }
        let begun = self.headway.begun;
        let pause = pause_after(snapshot_time(job.size), self.viewers.any());
        self.next_snapshot = self.next_snapshot.map(|_| begun + pause);
        self.checkpoints.begin(begun, film, numerics);
    }

    fn follow(&mut self, so_far: &Outcome, snapshot: Option<Snapshot<'_>>) -> Next {
        let now = Instant::now();
        self.headway.count(so_far);
        let keep = self.checkpoints.are_due(now, self.headway.time_of_runs(so_far));
        let show = is_due(self.next_snapshot, now);
        let had_snapshot = snapshot.is_some();
        if let Some(Snapshot { film, begin, is_complete }) = snapshot {
            if keep
                && is_complete
                && let Some(before) = &self.checkpoints.before
            {
                let (written, picture) =
                    (self.write(film, so_far, before), || self.request.write_png_so_far(&film.film));
                self.checkpoints.add(written, picture, begin, &self.progress);
            } else if self.next_snapshot.is_some() {
                self.headway.measure_error(&film.film, so_far);
                self.viewers.show(&film.film, &self.progress);
                self.next_snapshot = Some(Instant::now() + pause_after(begin.elapsed(), self.viewers.any()));
            }
        }
        self.progress.update(self.headway.status(so_far));
        if let Some(words) = self.headway.will_be_late(so_far) {
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

    fn lost(&mut self, why: &Error, view: &DeviceScene, on: &[Arc<Device>], _: &Accumulation) -> Option<Accumulation> {
        if self.signals.are_pending() {
            return None;
        }
        self.progress.message(&format!("warning: {why}; the device is opened once more"));
        starting_film(self.request, self.kept().ok()?.as_ref(), view, on).ok()
    }
}

impl Headway {
    fn new(job: &Job, earlier: u64) -> Headway {
        let pixels = job.pixels();
        Headway {
            begun: Instant::now(),
            paths: 0,
            goal: job.goal,
            pixels,
            earlier,
            error: None,
            until: None,
            time: None,
        }
    }

    /// Counts the paths. Restarts the clock if the paths of a pace probe were dropped.
    fn count(&mut self, outcome: &Outcome) {
        let before = std::mem::replace(&mut self.paths, outcome.totals.paths);
        if self.paths < before {
            self.begun = Instant::now();
        }
    }

    /// The time of a run of each pixel at the pace so far; `None` before the pace is known.
    fn time_of_runs(&self, outcome: &Outcome) -> Option<Duration> {
        if self.begun.elapsed() < MEASURED {
            return None;
        }
        let paths = (u64::from(RUN_LENGTH) * self.pixels) as f64;
        let seconds = self.begun.elapsed().as_secs_f64() * paths / outcome.totals.paths.max(1) as f64;
        Some(Duration::from_secs_f64(seconds.min(LONG)))
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
        if outcome.totals.paths >= self.pixels {
            // The first one has ended.
            self.time = None;
        }
        let sample = self.time_of_runs(outcome)? / RUN_LENGTH;
        // The pace of a start is not that of all.
        let time = self.time.take_if(|time| self.begun + sample > deadline + *time / 10)?;
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
    use std::path::Path;

    use clap::Parser;

    use super::*;
    use crate::commands::render::args::RenderArgs;
    use crate::film::Totals;
    use crate::scene::Scene;

    const JOB: Job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(1) };

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: RenderArgs,
    }

    /// The number of snapshots of a film that takes 10 ms to be read, after `calls` submissions; without checkpoints, or with some at this interval.
    fn snapshots(shown: bool, interval: Option<Duration>, calls: usize) -> usize {
        let folder = tempfile::tempdir().unwrap();
        let image = folder.path().join("a.exr");
        let Line { args } = Line::parse_from(["render", "a.ron", "--quiet", "-o", image.to_str().unwrap()]);
        let scene = Scene::parse(
            "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), \
            vertical_fov: 40), background: Solid((1, 1, 1)), objects: [])",
            Path::new("a.ron"),
        )
        .unwrap();
        let request = Request::new(&args, &scene, Instant::now()).unwrap();
        let signals = Signals::default();
        let mut observers = Observers::new(&request, &signals, None, Clock::new(Instant::now()), true);
        let film = Accumulation::empty(Film::new(1, 1, 0).unwrap());
        observers.begin(&JOB, &film, &Numerics::default());
        observers.next_snapshot = shown.then(Instant::now);
        observers.checkpoints.next = interval.map(|interval| Instant::now() + interval);
        observers.checkpoints.interval = interval.unwrap_or_default();
        let outcome = Outcome::default();
        let mut count = 0;
        for _ in 0..calls {
            let next = observers.follow(&outcome, None);
            if next != Next::GoOn {
                count += 1;
                let begin = Instant::now() - Duration::from_millis(10);
                let snapshot = Snapshot { film: &film, begin, is_complete: next == Next::CompleteSnapshot };
                assert_eq!(observers.follow(&outcome, Some(snapshot)), Next::GoOn);
            }
        }
        assert_eq!(observers.checkpoints.kept, interval.is_some());
        count
    }

    /// An outcome of so many paths of the one pixel.
    fn outcome_of(paths: u64) -> Outcome {
        Outcome { totals: Totals { paths, ..Totals::default() }, ..Outcome::default() }
    }

    /// It is reported once, as soon as it is known.
    #[test]
    fn a_time_that_cannot_be_kept_is_told() {
        let seconds = Duration::from_secs;
        let time = seconds(25);
        let pace = |left: u64, measured: u64| {
            let goal = Goal::Until { deadline: Instant::now() + seconds(left), end: 100 };
            let mut pace = Headway { time: Some(time), ..Headway::new(&Job { goal, ..JOB }, 0) };
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

    /// A snapshot of 10 ms is followed by two seconds without one, as is one of 100 ms that somebody watches. A quiet render has none but for
    /// checkpoints.
    #[test]
    fn snapshots_are_rare_and_for_somebody() {
        assert_eq!(snapshots(true, None, 1000), 1);
        assert_eq!(snapshots(false, None, 1000), 0);
        // Checkpoints that take 10 ms each come every third of a second, however often they are due.
        assert_eq!(snapshots(false, Some(Duration::ZERO), 10), 1);
        assert_eq!(pause_after(Duration::from_millis(10), false), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::from_millis(100), true), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::ZERO, true), Duration::from_secs(1));
    }
}
