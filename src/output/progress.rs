//! Progress on stderr: a bar on a terminal, now and then a plain line elsewhere. Nothing here touches stdout.

use std::io::Write;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{FormattedDuration, ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};

/// Time between lines where stderr is no terminal: few enough for the log of a long render.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// What takes less is over before a bar could be read.
const MOMENT: Duration = Duration::from_millis(500);
/// Length of the bar. Its unit is a share of the whole, since the whole may be samples or seconds.
const BAR_STEPS: u64 = 10_000;
/// Indicatif leaves the colour out where stderr is no terminal, and where NO_COLOR is set.
const TEMPLATE: &str = "{bar:24.cyan} {msg}";

/// When the render will be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// At `to` samples a pixel, `from` of which were there before (`--resume`).
    Samples { from: u64, to: u64 },
    /// After this time.
    Time(Duration),
    /// When the relative error is below this, or after the time.
    Error { below: f64, within: Option<Duration> },
}

/// Where the render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Samples a pixel so far, those from before included.
    pub samples_per_pixel: u64,
    pub paths_per_second: f64,
    /// As [`crate::film::Film::relative_error`].
    pub relative_error: Option<f64>,
}

/// Shows how far a render is. All methods may be called from any thread.
pub struct Progress {
    goal: Goal,
    start: Instant,
    display: Display,
}

enum Display {
    Hidden,
    Bar(ProgressBar),
    /// When the last line was printed.
    Lines(Mutex<Instant>),
}

impl Progress {
    /// The time runs from here. `quiet` shows nothing at all.
    pub fn new(quiet: bool, goal: Goal) -> Progress {
        let start = Instant::now();
        let display = if quiet { Display::Hidden } else { Display::for_stderr(start) };
        Progress { goal, start, display }
    }

    /// May be called as often as is convenient.
    pub fn update(&self, status: Status) {
        let elapsed = self.start.elapsed();
        self.display.show(self.goal.share(&status, elapsed), || describe(&self.goal, &status, elapsed));
    }

    /// Prints a line, above the bar; nothing where quiet.
    pub fn message(&self, text: &str) {
        match &self.display {
            Display::Hidden => {}
            Display::Bar(bar) => bar.suspend(|| print(text)),
            Display::Lines(_) => print(text),
        }
    }

    /// Takes the bar away. So does dropping, that an error's text stands on a line of its own.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

impl Display {
    fn for_stderr(now: Instant) -> Display {
        let target = ProgressDrawTarget::stderr();
        // Indicatif hides it where stderr is no terminal, or a dumb one.
        if target.is_hidden() {
            return Display::Lines(Mutex::new(now));
        }
        let style = ProgressStyle::with_template(TEMPLATE).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), target);
        Display::Bar(bar.with_style(style).with_finish(ProgressFinish::AndClear))
    }

    /// Shows what is done, 0 to 1, and in words.
    fn show(&self, share: f64, words: impl FnOnce() -> String) {
        match self {
            Display::Hidden => {}
            Display::Bar(bar) => {
                bar.set_position((share * BAR_STEPS as f64) as u64);
                bar.set_message(words());
            }
            Display::Lines(last) => {
                // A poisoned lock still holds a time.
                let mut last = last.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    print(&words());
                }
            }
        }
    }
}

/// Shows how far the reading of the scene's files is, or other work of a known length, if it takes longer than a moment. Dropping it takes
/// the bar away.
pub struct Loading {
    quiet: bool,
    start: Instant,
    /// None before the moment is over.
    display: Option<Display>,
}

impl Loading {
    /// The time runs from here. `quiet` shows nothing at all.
    pub fn new(quiet: bool) -> Loading {
        Loading { quiet, start: Instant::now(), display: None }
    }

    /// What is going on, and how much of it is done.
    pub fn show(&mut self, words: &str, share: f64) {
        if self.quiet || self.start.elapsed() < MOMENT {
            return;
        }
        let display = self.display.get_or_insert_with(|| Display::for_stderr(self.start));
        display.show(share, || words.to_string());
    }

    /// Prints a line, above the bar; nothing where quiet.
    pub fn message(&self, text: &str) {
        match &self.display {
            _ if self.quiet => {}
            Some(Display::Bar(bar)) => bar.suspend(|| print(text)),
            _ => print(text),
        }
    }

    /// `done` of the `whole` bytes of a file are read. May be called as often as is convenient.
    pub fn update(&mut self, file: &Path, done: u64, whole: u64) {
        if self.quiet || self.start.elapsed() < MOMENT {
            return;
        }
        let display = self.display.get_or_insert_with(|| Display::for_stderr(self.start));
        display.show(done as f64 / whole.max(1) as f64, || describe_file(file, done, whole));
    }
}

/// `reading meshes/dragon.ply  12/57 MiB`
fn describe_file(file: &Path, done: u64, whole: u64) -> String {
    format!("reading {}  {}/{} MiB", file.display(), done >> 20, whole.div_ceil(1 << 20))
}

/// A failure to report is not worth failing the render, nor a panic, as `eprintln` would have it.
fn print(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

impl Goal {
    /// What is done of what this process has to do, 0 to 1.
    fn share(&self, status: &Status, elapsed: Duration) -> f64 {
        let share = match *self {
            Goal::Samples { from, to } => {
                let (done, whole) = (status.samples_per_pixel.saturating_sub(from), to.saturating_sub(from));
                done as f64 / whole.max(1) as f64
            }
            Goal::Time(limit) => share_of_time(elapsed, limit),
            // The error falls with the root of the samples or faster.
            Goal::Error { below, within } => {
                let of_error = status.relative_error.map_or(0.0, |error| (below / error).powi(2));
                of_error.max(within.map_or(0.0, |limit| share_of_time(elapsed, limit)))
            }
        };
        share.min(1.0)
    }

    /// Time to go; for samples, at the speed so far. Unknown before anything is done.
    fn remaining(&self, status: &Status, elapsed: Duration) -> Option<Duration> {
        match *self {
            Goal::Time(limit) => Some(limit.saturating_sub(elapsed)),
            Goal::Samples { .. } | Goal::Error { .. } => {
                let share = self.share(status, elapsed);
                // Too long to be held in a duration is unknown too.
                Duration::try_from_secs_f64(elapsed.as_secs_f64() * (1.0 - share) / share).ok()
            }
        }
    }
}

/// `12/500 spp  1.42 Mpaths/s  error 3.2 %  ETA 00:01:23`
fn describe(goal: &Goal, status: &Status, elapsed: Duration) -> String {
    let done = status.samples_per_pixel;
    let samples = match goal {
        Goal::Samples { to, .. } => format!("{done}/{to} spp"),
        Goal::Time(_) => format!("{done} spp"),
        Goal::Error { below, .. } => format!("{done} spp until {} %", two_digits(100.0 * below)),
    };
    let speed = format!("{:.2} Mpaths/s", status.paths_per_second / 1e6);
    let error = status.relative_error.map(|error| format!("error {} %", two_digits(100.0 * error)));
    let remaining = goal.remaining(status, elapsed).map(|time| format!("ETA {}", FormattedDuration(time)));
    [Some(samples), Some(speed), error, remaining].into_iter().flatten().collect::<Vec<_>>().join("  ")
}

fn share_of_time(elapsed: Duration, limit: Duration) -> f64 {
    elapsed.as_secs_f64() / limit.as_secs_f64().max(f64::MIN_POSITIVE)
}

/// As many decimals as two significant digits need, 4 at most.
fn two_digits(value: f64) -> String {
    let decimals = if value > 0.0 { (1.0 - value.log10().floor()).clamp(0.0, 4.0) } else { 0.0 };
    format!("{value:.*}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: Status = Status { samples_per_pixel: 125, paths_per_second: 1.416e6, relative_error: Some(0.0321) };
    const MINUTE: Duration = Duration::from_secs(60);

    #[test]
    fn the_line_says_samples_speed_error_and_time_to_go() {
        let line = describe(&Goal::Samples { from: 0, to: 500 }, &STATUS, MINUTE);
        assert_eq!(line, "125/500 spp  1.42 Mpaths/s  error 3.2 %  ETA 00:03:00");
        let line = describe(&Goal::Time(Duration::from_secs(90)), &STATUS, MINUTE);
        assert_eq!(line, "125 spp  1.42 Mpaths/s  error 3.2 %  ETA 00:00:30");
    }

    #[test]
    fn what_is_not_known_is_left_out() {
        let nothing = Status { samples_per_pixel: 0, paths_per_second: 0.0, relative_error: None };
        assert_eq!(describe(&Goal::Samples { from: 0, to: 500 }, &nothing, MINUTE), "0/500 spp  0.00 Mpaths/s");
    }

    #[test]
    fn a_resumed_render_counts_its_own_samples() {
        let goal = Goal::Samples { from: 100, to: 200 };
        assert_eq!(goal.share(&STATUS, MINUTE), 0.25);
        assert_eq!(goal.remaining(&STATUS, MINUTE), Some(3 * MINUTE));
    }

    #[test]
    fn goals_that_are_met_or_empty_do_no_harm() {
        for goal in [Goal::Samples { from: 0, to: 0 }, Goal::Samples { from: 200, to: 100 }, Goal::Time(Duration::ZERO)]
        {
            let share = goal.share(&STATUS, MINUTE);
            assert!((0.0..=1.0).contains(&share), "{goal:?}: {share}");
            describe(&goal, &STATUS, MINUTE);
            describe(&goal, &STATUS, Duration::ZERO);
        }
        assert_eq!(Goal::Samples { from: 0, to: 100 }.remaining(&STATUS, MINUTE), Some(Duration::ZERO));
    }

    #[test]
    fn reading_says_the_file_and_its_bytes() {
        assert_eq!(describe_file(Path::new("a/b.ply"), 12 << 20, (57 << 20) - 1), "reading a/b.ply  12/57 MiB");
        let long_ago = Instant::now().checked_sub(2 * MOMENT).unwrap();
        for quiet in [true, false] {
            let mut loading = Loading::new(quiet);
            loading.update(Path::new("a"), 0, 0);
            assert!(loading.display.is_none(), "nothing is shown before a moment is over");
            loading.start = long_ago;
            loading.update(Path::new("a"), 0, 0);
            assert_eq!(loading.display.is_none(), quiet);
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
            assert_eq!(two_digits(value), text);
        }
    }

    #[test]
    fn a_quiet_one_and_one_without_terminal_take_every_call() {
        for quiet in [true, false] {
            let progress = Progress::new(quiet, Goal::Samples { from: 0, to: 500 });
            progress.update(STATUS);
            progress.message("");
            progress.finish();
            progress.finish();
        }
    }
}
