//! What a render does with its film does not show: the tiles that it is cut into, the snapshots of it, and where it is stopped.

use std::ops::Range;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use gpu_rt::data::{RUN_LENGTH, Sampler};
use gpu_rt::film::Film;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::plan::Plan;
use gpu_rt::render::{Next, Observer, following};
use gpu_rt::samples::Samples;
use gpu_rt::scene::Scene;

use crate::common::device;
use crate::common::render::{Outcome, render_job, render_onto};

const SIZE: (u32, u32) = (29, 21);

/// A scene with lights, glass and a sky, of which paths have many lengths.
fn cover() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.ron");
    Scene::load(&file).expect("it ships")
}

fn options(scatter: Scatter) -> RenderOptions {
    RenderOptions { scatter: Some(scatter), slots: Some(64), bounces: Some(3), ..RenderOptions::default() }
}

/// Renders samples with a film in tiles of so many pixels at most, or of as many as the device has room for.
fn render(
    options: &RenderOptions,
    size: (u32, u32),
    samples: Range<u32>,
    tile: Option<u32>,
    observer: &mut dyn Observer,
) -> (Film, Outcome, u32) {
    render_until(options, size, samples.start, Goal::Samples(samples.end), tile, observer)
}

fn render_until(
    options: &RenderOptions,
    size: (u32, u32),
    first_sample: u32,
    goal: Goal,
    tile: Option<u32>,
    observer: &mut dyn Observer,
) -> (Film, Outcome, u32) {
    let job = Job { size, max_depth: 20, seed: 3, first_sample, goal };
    let mut used = 0;
    let change = |plan: &mut Plan<'_>| {
        plan.tuning.tile = tile.unwrap_or(plan.tuning.tile);
        used = plan.tuning.tile;
    };
    let (film, outcome) = render_job(&cover(), options, &job, Sampler::Sobol, change, observer);
    assert_eq!(film.totals, outcome.totals);
    (film, outcome, used)
}

/// The film of samples that nothing interrupts.
fn full(options: &RenderOptions, samples: Range<u32>) -> Film {
    render(options, SIZE, samples, None, &mut ()).0
}

/// The usual options, with the sizes that the device suggests.
fn suggested() -> RenderOptions {
    RenderOptions { slots: None, bounces: None, ..options(Scatter::Fused) }
}

#[test]
fn tiles_do_not_show() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let options = options(scatter);
        for samples in [0..40, 3..21] {
            let full = full(&options, samples.clone());
            for tile in [800, 300, 97] {
                let tiled = render(&options, SIZE, samples.clone(), Some(tile), &mut ());
                assert!(tiled.0 == full, "{scatter:?}, {samples:?}, {tile}");
            }
        }
        // That films can differ at all is seen of other samples.
        assert!(full(&options, 0..48) != full(&options, 0..40));
    }
}

/// A film that one binding of a software driver does not hold is in tiles, without an option.
#[test]
fn a_film_beyond_a_binding_is_complete() {
    let size = (1300, 1000);
    let options = RenderOptions::default();
    let (film, _, tile) = render(&options, size, 0..1, None, &mut ());
    assert!(tile < 1_300_000 || !device::software().class().software, "{tile}");
    assert!(film.develop().samples.iter().all(|n| *n == 1));
    assert!(film == render(&options, size, 0..1, Some(500_000), &mut ()).0);
}

/// A time, an error that is reached, and one that is not.
pub fn goals() -> [Goal; 3] {
    let deadline = Instant::now() + Duration::from_millis(1500);
    let noise = |error, deadline, end| Goal::Noise { error, deadline, end, begun: 0, checks: 0 };
    [Goal::Until { deadline, end: 100 }, noise(0.05, None, 100), noise(1e-9, Some(deadline), 20)]
}

/// What `--time` renders to learn its pace is not in the film twice, and `--noise` goes on with the samples that it has checked.
#[test]
fn pace_probes_and_goals_do_not_show() {
    let options = suggested();
    for tile in [None, Some(97)] {
        for goal in goals() {
            let (film, outcome, _) = render_until(&options, SIZE, 0, goal, tile, &mut ());
            assert!(!outcome.samples.is_empty() && film.totals == outcome.totals);
            let full = full(&options, outcome.samples.range());
            assert!(film.develop().samples == full.develop().samples, "{goal:?}: {:?}", outcome.samples);
            // Stretches end within a run at their end alone.
            assert!(film == full, "{goal:?}: {:?}", outcome.samples);
        }
    }
}

/// A render of which a run of each pixel takes longer than two seconds ends within one if there is no time for all of it, or if it is stopped
/// before its pace is known. It is a render of those samples all the same.
#[test]
fn a_slow_render_ends_at_any_sample() {
    let options = suggested();
    let until = |time: Duration, wait: Duration, stops: bool| {
        let goal = Goal::Until { deadline: Instant::now() + time, end: 4096 };
        let mut observer = following(|_, _| {
            sleep(wait);
            if stops { Next::Stop } else { Next::GoOn }
        });
        let (film, outcome, _) = render_until(&options, SIZE, 0, goal, None, &mut observer);
        let samples = outcome.samples.range();
        assert!(film == full(&options, samples.clone()), "{samples:?}");
        samples.end
    };
    let (slow, fast) = (Duration::from_millis(400), Duration::ZERO);
    assert_eq!(until(Duration::ZERO, slow, false), 1);
    assert_eq!(until(Duration::from_secs(60), slow, true), 1);
    assert_eq!(until(Duration::ZERO, fast, false), RUN_LENGTH);
    let end = until(Duration::from_secs(60), fast, true);
    assert!(end.is_multiple_of(RUN_LENGTH) && end < 4096, "{end}");
}

/// A snapshot shows the finished runs, and changes nothing.
#[test]
fn snapshots_do_not_show() {
    for tile in [None, Some(97)] {
        let options = options(Scatter::Fused);
        let full = full(&options, 0..40);
        let (mut snapshots, mut paths) = (0, 0);
        let mut observer = following(|outcome, snapshot| {
            if let Some(snapshot) = snapshot {
                let film = &snapshot.film.film;
                let picture = film.develop();
                let seen: u64 = picture.samples.iter().map(|n| u64::from(*n)).sum();
                assert_eq!((film.totals, seen), (outcome.totals, outcome.totals.paths));
                snapshots += 1;
                paths = paths.max(seen);
            }
            Next::Snapshot
        });
        let observed = render(&options, SIZE, 0..40, tile, &mut observer);
        assert!(observed.0 == full, "{tile:?}");
        assert!(snapshots > 10 && paths > 0, "{snapshots} snapshots, {paths} paths");
    }
}

/// A render that is stopped ends the block of samples that it has begun: the film is that of a render of the samples that it says it has.
/// Submissions that are under way when it is stopped count too. What goes on from there gives the image of a render that was not stopped.
#[test]
fn a_stopped_render_has_a_complete_film() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        for (tile, at) in [(None, 1), (None, 9), (None, 40), (Some(300), 1), (Some(300), 30)] {
            let options = options(scatter);
            for start in [0, 13] {
                let mut calls = 0;
                let mut observer = following(|_, _| {
                    calls += 1;
                    if calls < at { Next::GoOn } else { Next::Stop }
                });
                let (film, outcome, _) = render(&options, SIZE, start..4096, tile, &mut observer);
                let end = outcome.samples.range().end;
                assert!(outcome.interrupted && outcome.samples.range().start == start && end < 4096, "{outcome:?}");
                assert!(end > start && end.is_multiple_of(RUN_LENGTH), "{outcome:?}");
                assert!(film == full(&options, start..end), "{scatter:?}, {at}");
                let more = end + 20;
                let rest = render(&options, SIZE, end..more, tile, &mut ()).0;
                let mut joined = film;
                joined.merge(&rest).expect("they are of one image");
                assert!(joined == full(&options, start..more));
            }
        }
    }
}

/// A film that is shown as complete has the samples of the outcome, and no part of a run beyond them.
#[test]
fn a_complete_film_has_equal_samples_in_all_pixels() {
    let options = options(Scatter::Fused);
    let each: Vec<Film> = (1..=5).map(|runs| full(&options, 0..RUN_LENGTH * runs)).collect();
    for tile in [None, Some(97)] {
        let (mut calls, mut seen) = (0, Vec::new());
        let mut observer = following(|_, snapshot| {
            if let Some(snapshot) = snapshot.filter(|snapshot| snapshot.is_complete) {
                let end = snapshot.film.samples.range().end;
                seen.push(end);
                assert!(
                    end.is_multiple_of(RUN_LENGTH) && snapshot.film.film == each[(end / RUN_LENGTH) as usize - 1],
                    "{end}"
                );
            }
            // A snapshot of runs under way in between must not matter.
            calls += 1;
            if calls % 3 == 0 { Next::Snapshot } else { Next::CompleteSnapshot }
        });
        let observed = render(&options, SIZE, 0..40, tile, &mut observer);
        assert!(observed.0 == each[4] && seen == [8, 16, 24, 32, 40], "{tile:?}: {seen:?}");
    }
}

/// Renders until a deadline or an error go on with a film that has samples. What learns the pace leaves no trace.
#[test]
fn goals_go_on_with_a_film() {
    let options = suggested();
    let scene = cover();
    for tile in [None, Some(97)] {
        let deadline = |seconds: u64| Instant::now() + Duration::from_millis(seconds);
        for goal in [
            Goal::Until { deadline: deadline(1000), end: 100 },
            Goal::Until { deadline: deadline(0), end: 100 },
            Goal::Noise { error: 1e-9, deadline: Some(deadline(1000)), end: 100, begun: 0, checks: 1 },
            Goal::Noise { error: 1e-9, deadline: None, end: 40, begun: 0, checks: 1 },
        ] {
            let mut film = full(&options, 0..24);
            let job = Job { size: SIZE, max_depth: 20, seed: 3, first_sample: 24, goal };
            let change = |plan: &mut Plan<'_>| plan.tuning.tile = tile.unwrap_or(plan.tuning.tile);
            let outcome =
                render_onto(&scene, &options, &job, &mut film, change, &mut following(|_, _| Next::CompleteSnapshot));
            let mut samples = Samples::from(0..24);
            samples.join(&outcome.samples);
            assert!(samples.ranges().len() == 1 && outcome.samples.overlap(&(0..24).into()).is_none(), "{samples}");
            let full = full(&options, samples.range());
            assert!(film == full, "{tile:?}, {goal:?}: {:?}", outcome.samples);
        }
    }
}

/// A resumed render until an error checks it where the interrupted one would have, with the probability that was left.
#[test]
fn a_resumed_render_has_the_checks_of_one_render() {
    let options = suggested();
    let noise = |begun, checks| Goal::Noise { error: 0.06, deadline: None, end: 4096, begun, checks };
    let (full, uninterrupted, _) = render_until(&options, SIZE, 0, noise(0, 0), None, &mut ());
    let found = uninterrupted.noise.expect("the error was checked");
    assert!(found.reached && found.checks > 2 && found.checks < 8, "{found:?}");
    for stop in [8, 16, 24, 40, 64] {
        let goal = Goal::Noise { error: 0.06, deadline: None, end: stop, begun: 0, checks: 0 };
        let (mut film, outcome, _) = render_until(&options, SIZE, 0, goal, None, &mut ());
        // The render with so few samples has checked its end, which an interrupted one has not.
        let checks = outcome.noise.expect("the error was checked").checks - 1;
        let job = Job { size: SIZE, max_depth: 20, seed: 3, first_sample: stop, goal: noise(0, checks) };
        let outcome = render_onto(&cover(), &options, &job, &mut film, |_| {}, &mut ());
        assert_eq!(
            (outcome.noise, outcome.samples.range().end),
            (Some(found), uninterrupted.samples.range().end),
            "{stop}"
        );
        assert!(film == full, "{stop}");
    }
}
