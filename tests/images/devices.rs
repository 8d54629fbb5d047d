//! Several devices that render one film: what they come to is what one of them does.

use std::path::Path;
use std::sync::Arc;

use gpu_rt::data::RUN_LENGTH;
use gpu_rt::film::{Accumulation, Film};
use gpu_rt::flatten::flatten;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::RenderOptions;
use gpu_rt::plan::Plan;
use gpu_rt::render::{Next, Observer, following};
use gpu_rt::samples::Samples;
use gpu_rt::scene::Scene;
use gpu_rt::session::Session;

use crate::common::device::software;
use crate::common::render::{Outcome, one_pixel, render_in};

const SIZE: (u32, u32) = (29, 21);

/// Renders onto a film with so many renderers, as on as many devices, each with other sizes.
fn render(
    devices: u32,
    first_sample: u32,
    goal: Goal,
    tile: Option<u32>,
    film: &mut Film,
    observer: &mut dyn Observer,
) -> Outcome {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.ron");
    let scene = Scene::load(&file).expect("it ships");
    let options =
        |device: u32| RenderOptions { slots: Some(64 << device), bounces: Some(3), ..RenderOptions::default() };
    let flat = flatten(&scene, SIZE, &options(0)).expect("the scene flattens");
    if film.totals.paths == 0 {
        let empty = Film::with_sampler(SIZE.0, SIZE.1, flat.radiance_exponent, options(0).sampler);
        *film = empty.expect("the film fits");
    }
    let job = Job { size: SIZE, max_depth: 20, seed: 3, first_sample, goal };
    let mut session = Session::on(vec![Arc::clone(software()); devices as usize]);
    session.show(flat, &options(0));
    let view = Arc::clone(&session.scene);
    let plan = |device: u32| {
        let mut plan = Plan::new(&view, &options(device), software().class(), &job).expect("the kernels link");
        plan.tuning.tile = tile.unwrap_or(plan.tuning.tile);
        plan
    };
    let plans: Vec<_> = (0..devices).map(plan).collect();
    session.compile_plans(&plans, &job, &mut ()).expect("the kernels compile and the buffers fit");
    render_in(&mut session, &job, film, observer)
}

fn by_one(end: u32) -> Film {
    let mut film = one_pixel();
    render(1, 0, Goal::Samples(end), None, &mut film, &mut ());
    film
}

/// Adds the samples up to an end that a film lacks.
fn fill(film: &mut Film, samples: &Samples, end: u32) {
    for gap in samples.missing(0..end).ranges() {
        render(1, gap.start, Goal::Samples(gap.end), None, film, &mut ());
    }
}

/// Each pixel has the samples of the outcome.
fn has_samples(film: &Film, samples: &Samples) {
    let count = samples.count() as u32;
    assert!(film.develop().samples.iter().all(|n| *n == count), "{samples:?}");
}

#[test]
fn devices_share_a_film() {
    let full = by_one(200);
    for (devices, tile) in [(2, None), (3, None), (3, Some(97))] {
        let mut film = one_pixel();
        let mut calls = 0;
        let mut observer = following(|_, _| {
            calls += 1;
            Next::GoOn
        });
        let outcome = render(devices, 0, Goal::Samples(200), tile, &mut film, &mut observer);
        assert!(film == full, "{devices} devices, {tile:?}");
        assert_eq!((outcome.totals, outcome.samples), (film.totals, Samples::from(0..200)));
        assert!(calls > 0);
    }
    // That films can differ at all is seen of other samples.
    assert!(by_one(192) != full);
}

/// A complete film that several devices show has exactly the samples that it states, and changes nothing.
#[test]
fn a_complete_film_of_devices_has_equal_samples_in_all_pixels() {
    for (devices, tile) in [(2, None), (3, Some(97))] {
        let (mut film, mut snapshots, mut calls) = (one_pixel(), Vec::new(), 0);
        let mut observer = following(|_, snapshot| {
            if let Some(snapshot) = snapshot.filter(|snapshot| snapshot.is_complete) {
                let Accumulation { film, samples, .. } = snapshot.film;
                has_samples(film, samples);
                snapshots.push((samples.clone(), film.clone()));
                return Next::GoOn;
            }
            calls += 1;
            if calls % 7 == 0 { Next::CompleteSnapshot } else { Next::GoOn }
        });
        render(devices, 0, Goal::Samples(200), tile, &mut film, &mut observer);
        assert!(film == by_one(200) && snapshots.len() > 2, "{} snapshots", snapshots.len());
        // What is missing of each is what the render had left.
        for (samples, mut film) in snapshots.into_iter().step_by(3) {
            fill(&mut film, &samples, 200);
            assert!(film == by_one(200), "{samples}");
        }
    }
}

/// Wherever several devices are stopped, each pixel has the samples of the outcome, in complete runs.
#[test]
fn devices_that_are_stopped_leave_equal_samples_in_all_pixels() {
    for stop in [1, 2, 5, 9, 20] {
        let (mut film, mut calls) = (one_pixel(), 0);
        let mut observer = following(|_, _| {
            calls += 1;
            if calls >= stop { Next::Stop } else { Next::GoOn }
        });
        let outcome = render(3, 0, Goal::Samples(4096), None, &mut film, &mut observer);
        assert!(outcome.interrupted && outcome.samples.count() < 4096, "{:?}", outcome.samples);
        has_samples(&film, &outcome.samples);
        let ends = outcome.samples.ranges().iter().flat_map(|range| [range.start, range.end]);
        assert!(ends.into_iter().all(|end| end.is_multiple_of(RUN_LENGTH)), "{:?}", outcome.samples);
        let end = outcome.samples.range().end;
        fill(&mut film, &outcome.samples, end);
        assert!(film == by_one(end), "{:?}", outcome.samples);
    }
}

#[test]
fn devices_reach_goals() {
    for goal in super::scheduling::goals() {
        let mut film = one_pixel();
        let outcome = render(2, 0, goal, None, &mut film, &mut ());
        assert_eq!(outcome.samples, Samples::from(outcome.samples.range()), "{goal:?}");
        assert!(film == by_one(outcome.samples.range().end), "{goal:?}: {:?}", outcome.samples);
    }
}
