//! The film after up to a billion samples, against exact sums of the very same samples.

use gpu_rt::data::{ODD_RUN, RUN_LENGTH, Settings};
use gpu_rt::film::Film;
use gpu_rt::options::Scatter;

use crate::common::film::{AddRuns, Run};
use crate::common::kernel::{Fault, Kernel, Overlay, Setup};
use crate::common::render::{Request, render_planted, scene};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::U;
use crate::table::{Cell, MEAN_OF_SQUARES, RUNNING_SUM};

/// Samples that are made; they are added again and again, for a billion differences would show nothing that these do not.
const DISTINCT: usize = 1 << 20;
const MANY: u64 = 1_000_000_000;
const BEYOND_F32: u64 = (1 << 24) + 1;
const RUNNING_SUM_OF_A_PART: &str = "running sum in f32, of the first 2^26";

/// Radiance as samples may have it: name, and a sample of it.
type Distribution = (&'static str, fn(&mut Random) -> f64);

const DISTRIBUTIONS: &[Distribution] = &[
    ("constant 0.3", |_| 0.3),
    ("uniform in 0..1", Random::uniform),
    ("1 in a million is 1e6, the others 0.5", |random| if random.below(1_000_000) == 0 { 1e6 } else { 0.5 }),
    ("log-uniform over 1e-6..1e3", |random| 10f64.powf(9.0 * random.uniform() - 6.0)),
    ("normal, mean 1, deviation 1e-5", |random| 1.0 + 1e-5 * random.normal()),
];

/// What forgets what it loses to rounding: a left fold in f32.
const PLAIN: &[Fault<'_>] = &[("lib/compensated", "barrier(sum - before.sum, zero) - added", "vec3<f32>(0.0)")];
const PLAIN_NAME: &str = "plain sums of runs";

/// Runs of samples as the device sums them, by the function that renders.
fn runs(replaced: &[Fault<'_>], samples: &[f32]) -> Vec<Run> {
    let kernel = Kernel::replacing("test/run_sum", replaced);
    let length = RUN_LENGTH as usize;
    let settings = [kernel.settings(&Settings::default())];
    let sums = kernel.run_with::<f32, [f32; 2]>(samples, samples.len().div_ceil(length), &settings);
    let record = |(index, (chunk, [sum, squared_deviations])): (usize, (&[f32], [f32; 2]))| Run {
        sum: [sum; 3],
        pixel: 0,
        counts: chunk.len() as u32 | if index % 2 == 1 { ODD_RUN } else { 0 },
        rays: chunk.len() as u32,
        squared_deviations: [squared_deviations; 3],
    };
    samples.chunks(length).zip(sums).enumerate().map(record).collect()
}

rows! {
    /// What a row of samples comes to in f32 without any care, sums and sums of squares, after a multiple of 2^15 of them.
    struct Running { sum: f32, squares: f32, count: u32, padding: u32 }
}

/// Adds up each row in a kernel of its own, again from its start where it ends.
fn running(rows: &[Vec<f32>], count: usize) -> Vec<Running> {
    const STEPS: usize = 1 << 15;
    let samples = DISTINCT.to_string();
    let setup = Setup { values: &[("samples", samples.as_str())], ..Setup::default() };
    let found = Kernel::with("test/running_sums", &setup).run_again::<f32, Running>(
        &rows.concat(),
        rows.len(),
        &[],
        count / STEPS,
    );
    assert!(found.iter().all(|row| row.count as usize == count), "{found:?}");
    found
}

fn samples(of: &Distribution) -> Vec<f32> {
    let mut random = Random(21);
    (0..DISTINCT).map(|_| of.1(&mut random) as f32).collect()
}

/// The relative error of a film's mean after `count` samples, of radiance in units of 2^exponent.
fn mean_error(samples: &[f32], count: u64, exponent: i32) -> f64 {
    let records = runs(&[], samples);
    let (mut film, mut part) =
        (Film::new(1, 1, exponent).expect("a pixel fits"), Film::new(1, 1, exponent).expect("a pixel fits"));
    let mut exact = 0.0f64;
    let of_all: f64 = samples.iter().map(|x| f64::from(*x)).sum();
    let (full, rest) = (count / DISTINCT as u64, (count % DISTINCT as u64) as usize);
    // Films that are joined are as if one had got all runs (tests/host/film.rs).
    part.add_runs(&records);
    for _ in 0..full {
        film.merge(&part).expect("they are of one image");
        exact += of_all;
    }
    film.add_runs(&runs(&[], &samples[..rest]));
    exact += samples[..rest].iter().map(|x| f64::from(*x)).sum::<f64>();
    let expected = exact / count as f64 * 2f64.powi(exponent);
    (f64::from(film.develop().rgb[0][0]) / expected - 1.0).abs()
}

pub fn means() -> Vec<Cell> {
    let samples: Vec<Vec<f32>> = DISTRIBUTIONS.iter().map(samples).collect();
    let mut all = Vec::new();
    // To see a sum in f32 stand still, a part of 1e9 is enough.
    for (count, name, part, form) in
        [(BEYOND_F32, "2^24 + 1", 1 << 24, RUNNING_SUM), (MANY, "1e9", 1 << 26, RUNNING_SUM_OF_A_PART)]
    {
        let running = running(&samples, part);
        for ((of, samples), running) in DISTRIBUTIONS.iter().zip(&samples).zip(running) {
            let cell = Cell::new(
                format!("{name}, {}", of.0),
                "Relative error of a pixel's mean, with runs summed by a kernel",
                1e-7,
                "the required accuracy. A run's sum is off by at most 6e-8. It is exact if its samples are equal; otherwise its \
                 errors are random and average out over many runs. Sums of runs are exact. The image is rounded by at most 6e-8.",
            )
            .achieved(mean_error(samples, count, 0));
            let exact = samples.iter().map(|x| f64::from(*x)).sum::<f64>() * (part / DISTINCT) as f64;
            // 2^24 numbers near 1 are still added well.
            let lasts = count == BEYOND_F32 && of.0.starts_with("normal");
            let planted = (f64::from(running.sum) / exact - 1.0).abs();
            all.push(if lasts { cell } else { cell.planted(form, planted) });
        }
    }
    // Radiance of 1e20 and 1e-20, which the host takes to a unit near it.
    for exponent in [67, -67] {
        all.push(
            Cell::new(
                format!("1e9, uniform in 0..2^{exponent}"),
                "Relative error of a pixel's mean, with a radiance far from 1",
                1e-7,
                "the unit is a power of two, so the digits are the same.",
            )
            .achieved(mean_error(&samples[1], MANY, exponent)),
        );
    }
    all
}

/// A constant that sums of f32 are worst for: 3, 5, 6 and 7 times it are rounded the same way.
const WORST: f64 = 0.8000009059906006;

pub fn constants() -> Vec<Cell> {
    let mut random = Random(22);
    let of_runs: Vec<f32> = (0..1_000_000).map(|_| (1.0 + random.uniform()) as f32).collect();
    let samples: Vec<f32> = of_runs.iter().flat_map(|x| [*x; RUN_LENGTH as usize]).collect();
    let worst = |replaced| {
        let sums = runs(replaced, &samples);
        let error = |(run, x): (&Run, &f32)| (f64::from(run.sum[0]) / (8.0 * f64::from(*x)) - 1.0).abs();
        sums.iter().zip(&of_runs).map(error).fold(0.0, f64::max)
    };
    let of_render = |library: &Overlay, scatter: Option<Scatter>| {
        let text = format!(
            "Scene(image: (width: 1, height: 1), background: Solid(({WORST:?}, {WORST:?}, {WORST:?})),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40), materials: {{ \"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
             objects: [Sphere(center: (0, 0, 9), radius: 1, material: \"m\")])"
        );
        let shot = render_planted(
            &scene(&text),
            &Request::spp(BEYOND_F32 as u32).with(|options| options.scatter = scatter),
            library,
        );
        shot.picture.rgb[0].map(|x| (f64::from(x) / WORST - 1.0).abs()).into_iter().fold(0.0, f64::max)
    };
    let mut all = vec![
        Cell::new(
            "8, a million constants",
            "Relative error of a run whose samples are all equal, summed by a kernel",
            0.0,
            "none, because f32 represents eight times a number exactly, and the sum of a run is off by less than the distance to \
             the next float.",
        )
        .achieved(worst(&[]))
        .planted(PLAIN_NAME, worst(PLAIN)),
    ];
    for (name, scatter) in [("one kernel", Scatter::Fused), ("a kernel a stage", Scatter::Linked)] {
        let cell = Cell::new(
            format!("2^24 + 1, a sky of {WORST}; {name}"),
            "Relative error of a rendered pixel whose samples are all equal",
            1e-7,
            "none, as required. All runs have eight samples, except the last, which has one.",
        )
        .achieved(of_render(&Overlay::new(&[]), Some(scatter)));
        all.push(cell.planted(PLAIN_NAME, of_render(&Overlay::new(PLAIN), Some(scatter))));
    }
    all
}

/// How far the variance of the mean is from that of the very samples, and a variance by E[x²] - E[x]² in f32.
pub fn variances() -> Vec<Cell> {
    let deviations = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|exponent: f64| (exponent, 10f64.powf(-exponent)));
    // Never below zero, as radiance is.
    let samples = deviations.map(|(_, deviation)| -> Vec<f32> {
        let mut random = Random(23);
        (0..DISTINCT).map(|_| (1.0 + deviation * (2.0 * random.uniform() - 1.0)) as f32).collect()
    });
    let naive = running(&samples, DISTINCT);
    let mut all = Vec::new();
    for (((exponent, deviation), samples), naive) in deviations.into_iter().zip(&samples).zip(naive) {
        let mut film = Film::new(1, 1, 0).expect("a pixel fits");
        film.add_runs(&runs(&[], samples));
        let found = f64::from(film.develop().variance[0][0]);
        // In f64.
        let squared_deviations = |run: &[f32]| {
            let mean = run.iter().map(|x| f64::from(*x)).sum::<f64>() / run.len() as f64;
            run.iter().map(|x| (f64::from(*x) - mean).powi(2)).sum::<f64>()
        };
        let count = samples.chunks(8).len() as f64;
        let expected = samples.chunks(8).map(squared_deviations).sum::<f64>() / (7.0 * count * samples.len() as f64);
        let in_f32 = naive.squares / DISTINCT as f32 - (naive.sum / DISTINCT as f32).powi(2);
        let naive_error = (f64::from(in_f32) / (expected * DISTINCT as f64) - 1.0).abs();
        // The rounding of a mean is noise of variance 2^-44 / 3 and less: it adds r², and 2 r times a correlation of 1 / sqrt(n), five times by
        // chance. Then come the roundings of seven squares and their sum.
        let r = (2f64.powi(-44) / 3.0 / (deviation * deviation / 3.0)).sqrt();
        let limit = 8.0 * U + r * r + 10.0 * r / (samples.len() as f64).sqrt();
        let cell = Cell::new(
            format!("2^20, mean 1, spread 1e-{exponent}"),
            "Relative error of a pixel's variance",
            limit,
            "r² + 10 r / sqrt(n) for n samples, where r is the rounding of a mean within a run, at most 2^-22/sqrt(3), divided by \
             the deviation of a sample.",
        );
        all.push(cell.achieved((found / expected - 1.0).abs()).planted(MEAN_OF_SQUARES, naive_error));
    }
    all
}
