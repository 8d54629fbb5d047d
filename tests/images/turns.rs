//! What a render does with its film does not show: the tiles that it is cut into, the looks at it, and where it is stopped.

use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use gpu_rt::data::{RUN_LENGTH, Sampler};
use gpu_rt::film::Film;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::plan::Plan;
use gpu_rt::render::{Next, Outcome, Watch};
use gpu_rt::scene::Scene;

use crate::common::device;
use crate::common::render::render_job;

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
    watch: Watch<'_>,
) -> (Film, Outcome, u32) {
    render_until(options, size, samples.start, Goal::Samples(samples.end), tile, watch)
}

fn render_until(
    options: &RenderOptions,
    size: (u32, u32),
    first_sample: u32,
    goal: Goal,
    tile: Option<u32>,
    watch: Watch<'_>,
) -> (Film, Outcome, u32) {
    let job = Job { size, max_depth: 20, seed: 3, first_sample, goal };
    let mut used = 0;
    let change = |plan: &mut Plan<'_>| {
        plan.tuning.tile = tile.unwrap_or(plan.tuning.tile);
        used = plan.tuning.tile;
    };
    let (film, outcome) = render_job(&cover(), options, &job, Sampler::Sobol, change, watch);
    assert_eq!(film.totals(), outcome.totals);
    (film, outcome, used)
}

#[test]
fn tiles_do_not_show() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let options = options(scatter);
        for samples in [0..40, 3..21] {
            let whole = render(&options, SIZE, samples.clone(), None, &mut |_, _| Next::GoOn);
            for tile in [800, 300, 97] {
                let tiled = render(&options, SIZE, samples.clone(), Some(tile), &mut |_, _| Next::GoOn);
                assert!(tiled.0 == whole.0, "{scatter:?}, {samples:?}, {tile}");
                // The order of the paths does not matter to what is counted beside them, but for sums of f64.
                assert_eq!(tiled.1.too_deep.paths, whole.1.too_deep.paths);
            }
        }
        // That films can differ at all is seen of other samples.
        let other = render(&options, SIZE, 0..48, None, &mut |_, _| Next::GoOn);
        assert!(other.0 != render(&options, SIZE, 0..40, None, &mut |_, _| Next::GoOn).0);
    }
}

/// A film that one binding of a software driver does not hold is in tiles, without being told to.
#[test]
fn a_film_beyond_a_binding_is_whole() {
    let size = (1300, 1000);
    let options = RenderOptions::default();
    let (film, _, tile) = render(&options, size, 0..1, None, &mut |_, _| Next::GoOn);
    assert!(tile < 1_300_000 || !device::software().class().software, "{tile}");
    assert!(film.develop().samples.iter().all(|n| *n == 1));
    assert!(film == render(&options, size, 0..1, Some(500_000), &mut |_, _| Next::GoOn).0);
}

/// What `--time` renders to learn its pace is not in the film twice, and `--noise` goes on with the samples that it has looked at.
#[test]
fn pilots_and_goals_do_not_show() {
    let options = RenderOptions { slots: None, bounces: None, ..options(Scatter::Fused) };
    for tile in [None, Some(97)] {
        let deadline = Instant::now() + Duration::from_millis(1500);
        for goal in [
            Goal::Until { deadline, end: 100 },
            Goal::Noise { error: 0.05, deadline: None, end: 100 },
            Goal::Noise { error: 1e-9, deadline: Some(deadline), end: 20 },
        ] {
            let (film, outcome, _) = render_until(&options, SIZE, 0, goal, tile, &mut |_, _| Next::GoOn);
            assert!(!outcome.samples.is_empty() && film.totals() == outcome.totals);
            let whole = render(&options, SIZE, outcome.samples.clone(), None, &mut |_, _| Next::GoOn).0;
            assert!(film.develop().samples == whole.develop().samples, "{goal:?}: {:?}", outcome.samples);
            // Stretches end within a run at their end alone.
            assert!(film == whole, "{goal:?}: {:?}", outcome.samples);
        }
    }
}

/// A look shows the finished runs, and changes nothing.
#[test]
fn looks_do_not_show() {
    for tile in [None, Some(97)] {
        let options = options(Scatter::Fused);
        let whole = render(&options, SIZE, 0..40, None, &mut |_, _| Next::GoOn).0;
        let (mut looks, mut paths) = (0, 0);
        let looked = render(&options, SIZE, 0..40, tile, &mut |outcome, look| {
            if let Some(look) = look {
                let picture = look.film.develop();
                let seen: u64 = picture.samples.iter().map(|n| u64::from(*n)).sum();
                assert_eq!((look.film.totals(), seen), (outcome.totals, outcome.totals.paths));
                looks += 1;
                paths = paths.max(seen);
            }
            Next::Look
        });
        assert!(looked.0 == whole, "{tile:?}");
        assert!(looks > 10 && paths > 0, "{looks} looks, {paths} paths");
    }
}

/// A render that is stopped ends all runs that it has begun: a pixel has all samples up to where it says that it stopped, or a run less, and
/// those are the samples of a whole render. Submissions that are under way when it is stopped count too.
#[test]
fn what_is_stopped_has_whole_runs() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        for (tile, at) in [(None, 1), (None, 9), (None, 40), (Some(300), 30)] {
            let options = options(scatter);
            let mut calls = 0;
            let (film, outcome, tile) = render(&options, SIZE, 0..4096, tile, &mut |_, _| {
                calls += 1;
                if calls < at { Next::GoOn } else { Next::Stop }
            });
            let end = outcome.stopped_at.expect("it was stopped");
            assert!(outcome.interrupted && end < 4096 && outcome.samples == (0..end), "{outcome:?}");
            let samples = film.develop().samples;
            assert_eq!(samples.iter().max(), Some(&end), "{scatter:?}, {at}");
            assert_eq!(samples.iter().map(|n| u64::from(*n)).sum::<u64>(), film.totals().paths);
            let one_tile = tile >= SIZE.0 * SIZE.1;
            assert!(
                samples.iter().all(|n| n % RUN_LENGTH == 0 && (*n + RUN_LENGTH >= end || !one_tile)),
                "{samples:?}"
            );
            let whole = render(&options, SIZE, 0..end, None, &mut |_, _| Next::GoOn).0.develop();
            let stopped = film.develop();
            let all = |pixel: &usize| samples[*pixel] == end;
            for pixel in (0..samples.len()).filter(all) {
                assert_eq!((stopped.rgb[pixel], stopped.variance[pixel]), (whole.rgb[pixel], whole.variance[pixel]));
            }
        }
    }
}
