//! Progress on stderr: a bar on a terminal, a plain line every few seconds elsewhere. Nothing here writes to stdout.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{FormattedDuration, ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle, WeakProgressBar};

use crate::job::{Goal, Job};
use crate::printable::{known_bound, one_line, two_digits};
use crate::terminal::{columns_of_stderr, tell};

/// The time between lines if stderr is not a terminal. A long render writes few enough lines for a log.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Work that takes less time shows no bar, because nobody could read it.
const MOMENT: Duration = Duration::from_millis(500);
/// The steps of the bar. A step is a share of the work, because the work may be samples or seconds.
const BAR_STEPS: u64 = 10_000;
/// Indicatif omits the colour if stderr is not a terminal, or if NO_COLOR is set. It cuts off the text that is wider than the terminal.
const TEMPLATE: &str = "{bar:10.cyan} {wide_msg}";
/// The columns that the bar takes.
const BAR: usize = 11;

/// The state of the render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// The samples per pixel so far.
    pub samples_per_pixel: u64,
    pub paths_per_second: f64,
    /// The error by [`crate::film::Film::relative_error`].
    pub relative_error: Option<f64>,
    /// How far a render until an error is from its end.
    pub until: Option<Until>,
}

/// The end of a render until an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Until {
    /// The upper bound of the error, with the confidence of the render.
    pub bound: f64,
    /// The samples per pixel at which it is expected to end; none where nothing says so.
    pub samples: Option<u64>,
    /// Whether paths have not found light that is there, so that it goes on even if the bound is low enough.
    pub lacks_light: bool,
}

/// Shows the progress of a render. All methods may be called from any thread.
pub struct Progress {
    job: Job,
    /// Samples of a pixel that an earlier render has left.
    earlier: u64,
    start: Instant,
    display: Display,
    /// Messages that have been printed.
    lines: AtomicUsize,
}

enum Display {
    Hidden,
    Bar(ProgressBar),
    /// When the last line was printed.
    Lines(Mutex<Instant>),
}

impl Progress {
    /// Starts the clock. `quiet` shows nothing at all.
    pub fn new(quiet: bool, job: &Job, earlier: u64) -> Progress {
        let start = Instant::now();
        let display = if quiet { Display::Hidden } else { Display::for_stderr(start) };
        Progress { job: job.clone(), earlier, start, display, lines: AtomicUsize::new(0) }
    }

    /// Restarts the clock when rendering begins.
    pub fn restart(&mut self) {
        self.start = Instant::now();
    }

    /// Shows the new status. May be called as often as is convenient.
    pub fn update(&self, status: Status) {
        let elapsed = self.start.elapsed();
        self.display.show(self.share(&status, elapsed), |columns| self.describe(&status, elapsed, columns));
    }

    /// Prints a line above the bar, unless quiet.
    pub fn message(&self, text: &str) {
        if !matches!(self.display, Display::Hidden) {
            self.lines.fetch_add(1, Ordering::Relaxed);
        }
        self.display.message(text);
    }

    /// How many messages there were: what was drawn above the bar before stands higher by now.
    pub fn lines(&self) -> usize {
        self.lines.load(Ordering::Relaxed)
    }

    /// Draws above the bar.
    pub fn above(&self, draw: impl FnOnce()) {
        match &self.display {
            Display::Bar(bar) => bar.suspend(draw),
            _ => draw(),
        }
    }

    /// Removes the bar. Dropping does the same, so that an error message starts on a line of its own.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    /// The share of the work that is done, 0 to 1.
    fn share(&self, status: &Status, elapsed: Duration) -> f64 {
        let samples = status.samples_per_pixel as f64;
        let of_time = |deadline: Instant| {
            let limit = deadline.saturating_duration_since(self.start).as_secs_f64();
            elapsed.as_secs_f64() / limit.max(f64::MIN_POSITIVE)
        };
        let share = match self.job.goal {
            Goal::Samples(end) => samples / f64::from(end.saturating_sub(self.job.first_sample).max(1)),
            Goal::Until { deadline, .. } => of_time(deadline),
            Goal::Noise { deadline, .. } => {
                let expected = status.until.and_then(|until| until.samples);
                let of_error = expected.map_or(0.0, |expected| samples / expected.max(1) as f64);
                of_error.max(deadline.map_or(0.0, of_time))
            }
        };
        share.min(1.0)
    }

    /// The remaining time; for a number of samples, at the speed so far. None before any work is done.
    fn remaining(&self, status: &Status, elapsed: Duration) -> Option<Duration> {
        if let Goal::Until { deadline, .. } = self.job.goal {
            return Some(deadline.saturating_duration_since(self.start + elapsed));
        }
        let begun = self.share(&Status { samples_per_pixel: self.earlier, ..*status }, Duration::ZERO);
        let begun = if matches!(self.job.goal, Goal::Samples(_)) { begun } else { 0.0 };
        let share = (self.share(status, elapsed) - begun) / (1.0 - begun);
        // None also if a duration cannot represent it.
        Duration::try_from_secs_f64(elapsed.as_secs_f64() * (1.0 - share) / share).ok()
    }

    /// `12/500 spp  1.42 Mpaths/s  error 3.2 %  time 00:00:02  ETA 00:01:23`, or as much of it as fits into so many columns.
    fn describe(&self, status: &Status, elapsed: Duration, columns: usize) -> String {
        let done = status.samples_per_pixel;
        let samples = match self.job.goal {
            Goal::Samples(end) => format!("{done}/{} spp", end.saturating_sub(self.job.first_sample)),
            Goal::Until { .. } => format!("{done} spp"),
            Goal::Noise { .. } => match status.until.and_then(|until| until.samples) {
                Some(expected) => format!("{done} of about {expected} spp"),
                None => format!("{done} spp"),
            },
        };
        let speed = format!("{:.2} Mpaths/s", status.paths_per_second / 1e6);
        let error = match (self.job.goal, status.until) {
            (Goal::Noise { error, .. }, Some(until)) => Some(until.describe(error)),
            (Goal::Noise { error, .. }, None) => Some(format!("until the error is below {} %", percent(error))),
            _ => status.relative_error.map(|error| format!("error {} %", percent(error))),
        };
        let time = format!("time {}", FormattedDuration(elapsed));
        let remaining = self.remaining(status, elapsed).map(|time| format!("ETA {}", FormattedDuration(time)));
        // Each with its rank: those of the highest rank go first where there is no room.
        let mut parts: Vec<(u32, String)> =
            [(0, Some(samples)), (4, Some(speed)), (2, error), (3, Some(time)), (1, remaining)]
                .into_iter()
                .filter_map(|(rank, part)| Some((rank, part?)))
                .collect();
        loop {
            let words = parts.iter().map(|(_, part)| part.as_str()).collect::<Vec<_>>().join("  ");
            match parts.iter().enumerate().max_by_key(|(_, (rank, _))| *rank) {
                Some((last, (1.., _))) if words.len() > columns => _ = parts.remove(last),
                _ => return words,
            }
        }
    }
}

/// The bar that was shown last.
static LAST_BAR: Mutex<Option<WeakProgressBar>> = Mutex::new(None);

/// Removes the bar, if one is shown, before the program ends without its owner.
pub fn remove_bar() {
    let last = LAST_BAR.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bar) = last.as_ref().and_then(WeakProgressBar::upgrade) {
        bar.finish_and_clear();
    }
}

/// Whether stderr is a terminal, and not a dumb one.
pub fn is_terminal() -> bool {
    !ProgressDrawTarget::stderr().is_hidden()
}

impl Display {
    fn for_stderr(now: Instant) -> Display {
        let target = ProgressDrawTarget::stderr();
        // Indicatif hides the bar if stderr is not a terminal, or a dumb one.
        if target.is_hidden() {
            return Display::Lines(Mutex::new(now));
        }
        let style = ProgressStyle::with_template(TEMPLATE).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), target);
        Display::Bar(bar.with_style(style).with_finish(ProgressFinish::AndClear))
    }

    /// Prints a line above the bar.
    fn message(&self, text: &str) {
        match self {
            Display::Hidden => {}
            Display::Bar(bar) => bar.suspend(|| tell(text)),
            Display::Lines(_) => tell(text),
        }
    }

    /// Shows the share of the work that is done, 0 to 1, and the words, which get the columns that there are for them.
    fn show(&self, share: f64, words: impl FnOnce(usize) -> String) {
        match self {
            Display::Hidden => {}
            Display::Bar(bar) => {
                *LAST_BAR.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.downgrade());
                bar.set_position((share * BAR_STEPS as f64) as u64);
                let columns = columns_of_stderr().unwrap_or(usize::MAX);
                bar.set_message(one_line(&words(columns.saturating_sub(BAR))).into_owned());
            }
            Display::Lines(last) => {
                // A poisoned lock still holds a time.
                let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    tell(&words(usize::MAX));
                }
            }
        }
    }
}

/// Shows the progress of reading the scene's files, or of other work of a known length. The bar appears if the work
/// takes longer than a moment. Dropping it removes the bar.
pub struct Loading {
    start: Instant,
    /// None until the moment is over.
    display: Option<Display>,
}

impl Loading {
    /// Starts the clock. `quiet` shows nothing at all.
    pub fn new(quiet: bool) -> Loading {
        Loading { start: Instant::now(), display: quiet.then_some(Display::Hidden) }
    }

    /// Shows work at once, for somebody who waits for it.
    pub fn at_once(quiet: bool) -> Loading {
        let now = Instant::now();
        Loading { start: now.checked_sub(LINE_INTERVAL).unwrap_or(now), ..Loading::new(quiet) }
    }

    /// Shows the current work, and the share of it that is done.
    pub fn show(&mut self, words: &str, share: f64) {
        self.show_with(share, || words.to_string());
    }

    /// Prints a line above the bar, unless quiet.
    pub fn message(&self, text: &str) {
        self.display.as_ref().map_or_else(|| tell(text), |display| display.message(text));
    }

    /// Reports that `done` of the `total` bytes of a file are read. May be called as often as is convenient.
    pub fn update(&mut self, file: &Path, done: u64, total: u64) {
        self.show_with(done as f64 / total.max(1) as f64, || describe_file(file, done, total));
    }

    fn show_with(&mut self, share: f64, words: impl FnOnce() -> String) {
        if self.start.elapsed() >= MOMENT {
            self.display.get_or_insert_with(|| Display::for_stderr(self.start)).show(share, |_| words());
        }
    }
}

/// `reading meshes/dragon.ply  12/57 MiB`
fn describe_file(file: &Path, done: u64, total: u64) -> String {
    format!("reading {}  {}/{} MiB", file.display(), done >> 20, total.div_ceil(1 << 20))
}

impl Until {
    /// Why the render goes on: what its error is below, what it is to be below, and what else it waits for.
    fn describe(&self, wanted: f64) -> String {
        let (bound, wanted) = (percent(self.bound), percent(wanted));
        match (known_bound(self.bound).is_some(), self.lacks_light) {
            (false, _) => format!("error unknown, goal below {wanted} %"),
            (true, false) => format!("error below {bound} %, goal below {wanted} %"),
            (true, true) => format!("error below {bound} %, until light behind mirrors or glass is found"),
        }
    }
}

fn percent(share: f64) -> String {
    two_digits(100.0 * share, 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: Status =
        Status { samples_per_pixel: 125, paths_per_second: 1.416e6, relative_error: Some(0.0321), until: None };
    const MINUTE: Duration = Duration::from_secs(60);

    fn progress(goal: Goal) -> Progress {
        Progress::new(true, &Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 100, goal }, 0)
    }

    #[test]
    fn the_line_says_samples_speed_error_and_time_to_go() {
        let line = progress(Goal::Samples(600)).describe(&STATUS, MINUTE, 80 - BAR);
        assert_eq!(line, "125/500 spp  1.42 Mpaths/s  error 3.2 %  time 00:01:00  ETA 00:03:00");
        let mut timed = progress(Goal::Samples(0));
        timed.job.goal = Goal::Until { deadline: timed.start + Duration::from_secs(90), end: 600 };
        assert_eq!(
            timed.describe(&STATUS, MINUTE, 80),
            "125 spp  1.42 Mpaths/s  error 3.2 %  time 00:01:00  ETA 00:00:30"
        );
    }

    #[test]
    fn where_there_is_no_room_the_least_goes_first() {
        let progress = progress(Goal::Samples(600));
        for (columns, line) in [
            (68, "125/500 spp  1.42 Mpaths/s  error 3.2 %  time 00:01:00  ETA 00:03:00"),
            (67, "125/500 spp  error 3.2 %  time 00:01:00  ETA 00:03:00"),
            (52, "125/500 spp  error 3.2 %  ETA 00:03:00"),
            (37, "125/500 spp  ETA 00:03:00"),
            (24, "125/500 spp"),
            (0, "125/500 spp"),
        ] {
            assert_eq!(progress.describe(&STATUS, MINUTE, columns), line, "{columns}");
        }
    }

    /// A render until an error goes on while its bound is above that, or light is missing: never without a word of why.
    #[test]
    fn a_render_until_an_error_says_why_it_goes_on() {
        let goal = Goal::Noise { error: 0.05, deadline: None, end: 1 << 20, begun: 100, checks: 0 };
        let line = |until: Option<Until>| progress(goal).describe(&Status { until, ..STATUS }, MINUTE, 200);
        assert_eq!(line(None), "125 spp  1.42 Mpaths/s  until the error is below 5.0 %  time 00:01:00");
        let until = Until { bound: 0.0532, samples: Some(250), lacks_light: false };
        let expected =
            "125 of about 250 spp  1.42 Mpaths/s  error below 5.3 %, goal below 5.0 %  time 00:01:00  ETA 00:01:00";
        assert_eq!(line(Some(until)), expected);
        let lacking = line(Some(Until { bound: 0.04, lacks_light: true, ..until }));
        assert!(lacking.contains("error below 4.0 %, until light behind mirrors or glass is found"), "{lacking}");
        let unknown = line(Some(Until { bound: f64::INFINITY, samples: None, ..until }));
        let expected = "125 spp  1.42 Mpaths/s  error unknown, goal below 5.0 %  time 00:01:00";
        assert_eq!(unknown, expected);
    }

    #[test]
    fn unknown_numbers_are_left_out() {
        let nothing = Status { samples_per_pixel: 0, paths_per_second: 0.0, relative_error: None, until: None };
        assert_eq!(
            progress(Goal::Samples(600)).describe(&nothing, MINUTE, 80),
            "0/500 spp  0.00 Mpaths/s  time 00:01:00"
        );
    }

    #[test]
    fn goals_that_are_met_or_empty_do_no_harm() {
        let now = Goal::Until { deadline: Instant::now(), end: 600 };
        for progress in [Goal::Samples(100), Goal::Samples(50), now].map(progress) {
            let share = progress.share(&STATUS, MINUTE);
            assert!((0.0..=1.0).contains(&share), "{:?}: {share}", progress.job);
            progress.describe(&STATUS, MINUTE, 80);
            progress.describe(&STATUS, Duration::ZERO, 80);
        }
        assert_eq!(progress(Goal::Samples(200)).remaining(&STATUS, MINUTE), Some(Duration::ZERO));
    }

    #[test]
    fn reading_says_the_file_and_its_bytes() {
        assert_eq!(describe_file(Path::new("a/b.ply"), 12 << 20, (57 << 20) - 1), "reading a/b.ply  12/57 MiB");
        let long_ago = Instant::now().checked_sub(2 * MOMENT).unwrap();
        for quiet in [true, false] {
            let mut loading = Loading::new(quiet);
            loading.update(Path::new("a"), 0, 0);
            let is_hidden = |loading: &Loading| matches!(loading.display, None | Some(Display::Hidden));
            assert!(is_hidden(&loading), "nothing is shown before a moment is over");
            loading.start = long_ago;
            loading.update(Path::new("a"), 0, 0);
            assert_eq!(is_hidden(&loading), quiet);
        }
    }

    #[test]
    fn errors_have_two_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.00001, "0.0000"),
            (0.0321, "0.032"),
            (3.21, "3.2"),
            (32.1, "32"),
            (321.0, "321"),
            (9.99, "10.0"),
        ] {
            assert_eq!(two_digits(value, 4.0), text);
        }
    }

    #[test]
    fn a_quiet_one_and_one_without_terminal_take_every_call() {
        for quiet in [true, false] {
            let progress = Progress::new(quiet, &progress(Goal::Samples(600)).job, 0);
            progress.update(STATUS);
            progress.message("");
            progress.finish();
            progress.finish();
        }
    }
}
