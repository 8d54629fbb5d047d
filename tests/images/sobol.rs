//! Renders of Sobol points: what their error is, and how a render until an error ends. What they expect: tests/images/estimators.rs.

use std::path::Path;

use crate::common::held::{BULB, Held, Replicates};
use crate::common::kernel::Overlay;
use crate::common::render::{Change, Outcome, Request, Shot, render, render_job, scene};
use crate::common::rooms::{THINGS, room};
use crate::common::stats::one_sample_t;
use gpu_rt::data::{RUN_LENGTH, Sampler};
use gpu_rt::film::Film;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::RenderOptions;
use gpu_rt::render::{NOISE_LEVEL, level_after, samples_at_check};
use gpu_rt::samples::Samples;
use gpu_rt::scene::Scene;

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;

/// Over 48 seeds the pixels' stated variances are what their means vary by: their quotient, of the sums over all pixels, is known to 1 %.
/// Runs as replicates, as for independent samples, would overstate it.
#[test]
fn stated_variances_are_those_between_seeds() {
    const SEEDS: u32 = 48;
    let scene = room(THINGS[0].1);
    let ratios = |request: &dyn Fn(u32) -> Request| -> Vec<f64> {
        let shots: Vec<Shot> = (0..SEEDS).map(|seed| render(&scene, &request(seed))).collect();
        let values = |shot: &Shot, i: usize| f64::from(shot.picture.rgb.as_flattened()[i]);
        let count = shots[0].picture.rgb.len() * 3;
        let means: Vec<f64> =
            (0..count).map(|i| shots.iter().map(|shot| values(shot, i)).sum::<f64>() / f64::from(SEEDS)).collect();
        let between: f64 =
            shots.iter().map(|shot| (0..count).map(|i| (values(shot, i) - means[i]).powi(2)).sum::<f64>()).sum::<f64>()
                / f64::from(SEEDS - 1);
        let stated = |shot: &Shot| shot.picture.variance.as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>();
        shots.iter().map(|shot| stated(shot) / between).collect()
    };
    // What is between has an error of its own: 48 seeds of 256 independent pixels, of at most sqrt(2 / (47 · 256 · 0.3)) = 2.4 %, where
    // 0.3 allows for channels that go together and pixels that matter more.
    let mean = |ratios: &[f64]| ratios.iter().sum::<f64>() / ratios.len() as f64;
    for samples in [32, 64] {
        let found = mean(&ratios(&|seed| Request::spp(samples).sobol().seed(seed)));
        println!("{samples} samples, halves: {found}");
        assert!((found - 1.0).abs() < 0.12, "{samples} samples: {found}");
    }
    // Of three runs, 16 samples against 8: too much by a half at most.
    let found = mean(&ratios(&|seed| Request::spp(24).sobol().seed(seed)));
    println!("24 samples: {found}");
    assert!(found > 0.88 && found < 2.0 * 1.12, "{found}");
    // The planted error: runs as replicates, which are better together than they are apart.
    let as_runs = |seed| {
        let (film, _) = onto_film(&scene, Goal::Samples(64), Sampler::Sobol, seed, Sampler::Independent);
        film.error_estimate(0.5).expect("there is light").value.powi(2)
    };
    let as_halves = |seed| {
        let (film, _) = onto_film(&scene, Goal::Samples(64), Sampler::Sobol, seed, Sampler::Sobol);
        film.error_estimate(0.5).expect("there is light").value.powi(2)
    };
    let quotient = (0..8).map(as_runs).sum::<f64>() / (0..8).map(as_halves).sum::<f64>();
    println!("64 samples, runs for halves: {quotient}");
    assert!(quotient > 1.3, "{quotient}");
    let found = ratios(&|seed| Request::spp(64).seed(seed));
    assert!((mean(&found) - 1.0).abs() < 0.12 && one_sample_t(&found, 1.3).p < ALPHA, "independent: {found:?}");
}

/// What a goal came to: the film, the samples, and what was found of the noise.
fn until(scene: &Scene, goal: Goal, sampler: Sampler) -> (Film, Outcome) {
    onto_film(scene, goal, sampler, 4, sampler)
}

/// Renders with a seed onto a film that takes the samples to be placed by another sampler.
fn onto_film(scene: &Scene, goal: Goal, sampler: Sampler, seed: u32, of_film: Sampler) -> (Film, Outcome) {
    let size = (scene.image.width, scene.image.height);
    let options = RenderOptions { sampler, ..crate::common::render::plain() };
    let job = Job { size, max_depth: 10, seed, first_sample: 0, goal };
    render_job(scene, &options, &job, of_film, |_| {}, &mut ())
}

#[test]
fn a_render_until_an_error_is_that_of_its_samples() {
    use Sampler::{Independent, Sobol};
    let scene = room(THINGS[0].1);
    for (sampler, error) in [(Sobol, 0.05), (Independent, 0.06), (Sobol, 0.9)] {
        let (film, outcome) =
            until(&scene, Goal::Noise { error, deadline: None, end: 1 << 14, begun: 0, checks: 0 }, sampler);
        let noise = outcome.noise.expect("it was asked");
        let samples = outcome.samples.count() as u32;
        assert!(noise.reached && !outcome.interrupted && outcome.samples.range().start == 0);
        assert_eq!(samples, samples_at_check(noise.checks - 1));
        assert_eq!(samples == 16, error == 0.9, "{samples}");
        // The k-th check has 5 % / (k (k + 1)).
        assert_eq!(noise.level(), NOISE_LEVEL / f64::from(noise.checks * (noise.checks + 1)));
        assert!(film.error_estimate(noise.level()).expect("there is light").bound < error);
        let of_samples =
            render(&scene, &Request::spp(samples).seed(4).depth(10).with(|options| options.sampler = sampler));
        assert!(film == of_samples.film);
        // It did not end too late.
        if let Some(last) = noise.checks.checked_sub(2) {
            let request =
                Request::spp(samples_at_check(last)).seed(4).depth(10).with(|options| options.sampler = sampler);
            let before = render(&scene, &request);
            assert!(before.film.error_estimate(level_after(last)).expect("there is light").bound >= error);
        }
    }
    // The most samples, and the time, come first where they do. At least a run of each pixel is rendered.
    let (film, outcome) =
        until(&scene, Goal::Noise { error: 1e-4, deadline: None, end: 41, begun: 0, checks: 0 }, Sobol);
    assert!(!outcome.noise.expect("it was asked").reached && outcome.samples == Samples::from(0..41));
    assert!(film == render(&scene, &Request::spp(41).sobol().seed(4).depth(10)).film);
    let deadline = Some(std::time::Instant::now());
    let (film, outcome) =
        until(&scene, Goal::Noise { error: 1e-4, deadline, end: 1 << 20, begun: 0, checks: 0 }, Sobol);
    assert!(!outcome.noise.expect("it was asked").reached && outcome.samples == Samples::from(0..RUN_LENGTH));
    assert!(film == render(&scene, &Request::spp(RUN_LENGTH).sobol().seed(4).depth(10)).film);
}

/// Two scenes in which few pixels hold the noise: a bulb smaller than a pixel, and the shipped marbles in so small an image that a lamp's edge does.
/// (`make test-long` has all scenes, and more seeds.) With a bound by halves alone, as many as four of ten images are off by more.
#[test]
fn bounds_hold_where_few_pixels_hold_the_noise() {
    let marble = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/marble.ron");
    let marble = Scene::load(&marble).expect("it ships");
    let request = |(width, height)| Request::default().mis().sobol().size(width, height).roulette();
    let by_halves =
        Overlay::new(&[("lib/squared_deviation", "deviation * (deviation * (n / (n + 1.0)))", "vec3<f32>(0.0)")]);
    for (name, scene, size) in [("bulb", scene(BULB), (16, 16)), ("marble", marble, (32, 18))] {
        let replicates = |change: &Change<'_>| Replicates::new(&scene, &request(size), change, 80, &[16, 64]);
        let found = replicates(&Change::default());
        let held = found.held();
        held.iter().for_each(|held| println!("{name}: {held}"));
        assert!(held.iter().all(Held::holds), "{name}: {held:?}");
        let (wrong, ended) = found.noise_is_wrong(0.3);
        println!("{name}: --noise 0.3 ends for {ended} of seeds, and is wrong for {wrong}");
        assert!(wrong <= 0.1 && ended > 0.1, "{name}: {wrong} of {ended}");
        // The planted error: runs that do not say how their samples are spread.
        let planted = replicates(&Change { library: Some(&by_halves), ..Change::default() }).held();
        planted.iter().for_each(|held| println!("{name}, by halves alone: {held}"));
        assert!(!planted.iter().all(Held::holds), "{name}: {planted:?}");
    }
}

/// A lamp of radiance 1 is seen, and another of 1e17 shines in a closed box of its own: in its unit the squares of what is seen are below 2^-96, the
/// resolution of the film. The stated error is the one without the box, by halves instead of samples: of 256 pixels, each of one degree of freedom,
/// it is known to 1/√(2 · 256 · 0.3) = 8 %, where 0.3 allows for pixels that matter more.
#[test]
fn a_lamp_far_brighter_than_what_is_seen_hides_no_error() {
    let lit = |hidden: &str| {
        scene(&format!(
            "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 1, 4), look_at: (0, 0.5, 0), vertical_fov: 40),
            background: Solid((0, 0, 0)),
            materials: {{ \"white\": Lambertian(albedo: Rgb(0.6, 0.6, 0.6)), \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)),
                \"far\": DiffuseLight(emit: Rgb(1e17, 1e17, 1e17)) }},
            objects: [
                Quad(corner: (-2, 0, 2), u: (4, 0, 0), v: (0, 0, -4), material: \"white\"),
                Sphere(center: (0, 2, 0), radius: 0.8, material: \"lamp\"), {hidden}
            ])"
        ))
    };
    let closed = "Sphere(center: (9, 0, 0), radius: 0.5, material: \"white\"), Sphere(center: (9, 0, 0), radius: 0.1, material: \"far\"),";
    let (alone, beside) = (lit(""), lit(closed));
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let error = |scene: &Scene| {
            let shot = render(scene, &Request::spp(64).depth(4).with(|options| options.sampler = sampler));
            shot.film.error_estimate(NOISE_LEVEL).expect("there is light")
        };
        let (alone, beside) = (error(&alone), error(&beside));
        println!("{sampler:?}: {alone:?} {beside:?}");
        assert!((beside.value / alone.value - 1.0).abs() < 0.4 && beside.bound > beside.value, "{alone:?} {beside:?}");
    }
}

/// A render until an error checks often, so that it takes at most half as many samples again as the first number at which its bound is low enough,
/// and a quarter from 64 on; all checks together have 5 %; and both halves of a pixel have the same samples at each.
#[test]
fn checks_come_often_and_share_their_probability() {
    let checks: Vec<u32> = (0..40).map(samples_at_check).collect();
    assert_eq!(checks[..12], [16, 32, 48, 64, 80, 96, 112, 128, 160, 192, 224, 256]);
    assert!(checks.windows(2).all(|pair| pair[0] < pair[1] && (pair[0] < 64 || 4 * pair[1] <= 5 * pair[0])));
    assert!(checks.iter().all(|samples| samples.is_multiple_of(16)));
    let all: f64 = (0..1_000_000).map(level_after).sum();
    assert!(all < NOISE_LEVEL && all > 0.999 * NOISE_LEVEL, "{all}");
    // They never end, and no number of them is too large.
    assert!(
        samples_at_check(1000) == u32::MAX && samples_at_check(u32::MAX) == u32::MAX && level_after(u32::MAX) > 0.0
    );
}
