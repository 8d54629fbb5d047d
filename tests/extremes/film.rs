//! The film after up to a billion samples, against exact sums of the very same samples.

use gpu_rt::data::RUN_LENGTH;
use gpu_rt::film::{Film, RunRecord};

use crate::stats::Random;
use crate::table::{Cell, MEAN_OF_SQUARES, RUNNING_SUM, Row};
use crate::vectors::U;

/// Samples that are made; they are added again and again, for a billion differences would show nothing that these do not.
const DISTINCT: usize = 1 << 20;
const MANY: u64 = 1_000_000_000;
const BEYOND_F32: u64 = (1 << 24) + 1;

/// The table's cells of the film.
pub fn cells() -> Vec<Cell> {
    let mut all = means();
    all.extend(worst_constant());
    all.extend(variances());
    all
}

/// Radiance as samples may have it: name, and a sample of it.
type Distribution = (&'static str, fn(&mut Random) -> f64);

const DISTRIBUTIONS: &[Distribution] = &[
    ("constant 0.3", |_| 0.3),
    ("uniform in 0..1", Random::uniform),
    ("1 in a million is 1e6, the others 0.5", |random| if random.below(1_000_000) == 0 { 1e6 } else { 0.5 }),
    ("log-uniform over 1e-6..1e3", |random| 10f64.powf(9.0 * random.uniform() - 6.0)),
    ("normal, mean 1, deviation 1e-5", |random| 1.0 + 1e-5 * random.normal()),
];

/// Runs of samples as the device sums them, one after the other in f32; the samples, in f32.
fn runs(samples: &[f32]) -> Vec<RunRecord> {
    let chunks = samples.chunks(RUN_LENGTH as usize);
    let record = |chunk: &[f32]| {
        let sum = chunk.iter().fold(0.0f32, |sum, x| sum + x);
        RunRecord { sum: [sum; 3], pixel: 0, counts: chunk.len() as u32, rays: chunk.len() as u32 }
    };
    chunks.map(record).collect()
}

fn samples(of: &Distribution) -> Vec<f32> {
    let mut random = Random(21);
    (0..DISTINCT).map(|_| of.1(&mut random) as f32).collect()
}

/// The relative error of a film's mean after `count` samples, of radiance in units of 2^exponent; and that of a running sum in f32.
fn mean_error(samples: &[f32], count: u64, exponent: i32) -> (f64, f64) {
    let records = runs(samples);
    let mut film = Film::new(1, 1, exponent).expect("a pixel fits");
    let (mut exact, mut running) = (0.0f64, 0.0f32);
    let of_all: f64 = samples.iter().map(|x| f64::from(*x)).sum();
    let (whole, rest) = (count / DISTINCT as u64, (count % DISTINCT as u64) as usize);
    for _ in 0..whole {
        film.add(&records);
        exact += of_all;
    }
    film.add(&runs(&samples[..rest]));
    exact += samples[..rest].iter().map(|x| f64::from(*x)).sum::<f64>();
    // A part of them is enough to see the sum in f32 stand still.
    for _ in 0..whole.min(64) {
        running = samples.iter().fold(running, |sum, x| sum + x);
    }
    let running_exact = of_all * whole.min(64) as f64;
    let expected = exact / count as f64 * 2f64.powi(exponent);
    let found = f64::from(film.develop().rgb[0][0]);
    ((found / expected - 1.0).abs(), (f64::from(running) / running_exact - 1.0).abs())
}

fn means() -> Vec<Cell> {
    let mut all = Vec::new();
    for of in DISTRIBUTIONS {
        let samples = samples(of);
        for (count, name) in [(BEYOND_F32, "2^24 + 1"), (MANY, "1e9")] {
            let (error, running) = mean_error(&samples, count, 0);
            let cell = Cell::new(
                Row::Samples,
                format!("{name}, {}", of.0),
                "Relative error of a pixel's mean",
                1e-7,
                "Asked for. Runs of 8 are summed in f32, off by 4e-8 on average; sums of runs are exact; the picture rounds by 6e-8 at most.",
            );
            let cell = cell.achieved(error);
            // 2^24 numbers near 1 are still added well.
            let lasts = count == BEYOND_F32 && of.0.starts_with("normal");
            all.push(if lasts { cell } else { cell.planted(RUNNING_SUM, running) });
        }
    }
    // Radiance of 1e20 and 1e-20, which the host takes to a unit near it.
    for exponent in [67, -67] {
        let samples = samples(&DISTRIBUTIONS[1]);
        let (error, _) = mean_error(&samples, MANY, exponent);
        all.push(
            Cell::new(
                Row::Samples,
                format!("1e9, uniform in 0..2^{exponent}"),
                "Relative error of a pixel's mean, of radiance far from 1",
                1e-7,
                "The unit is a power of two: the same digits.",
            )
            .achieved(error),
        );
    }
    all
}

/// Of all constants, the one whose runs f32 sums worst.
fn worst_constant() -> Vec<Cell> {
    let mut random = Random(22);
    let error = |x: f32| (f64::from(runs(&[x; 8])[0].sum[0]) / (8.0 * f64::from(x)) - 1.0).abs();
    let worst = (0..1_000_000).map(|_| error((1.0 + random.uniform()) as f32)).fold(0.0, f64::max);
    vec![
        Cell::new(
            Row::Samples,
            "any number, a million constants",
            "Relative error of a pixel whose samples are all equal",
            35.0 / 8.0 * U,
            "The partial sums 2 to 8 of 8 are rounded by u each: u (2 + 3 + … + 8) / 8. That is the worst of f32 within a run.",
        )
        .achieved(worst),
    ]
}

/// How far the variance of the mean is from that of the very samples, and a variance by E[x²] - E[x]² in f32.
fn variances() -> Vec<Cell> {
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
        .map(|exponent: f64| {
            let deviation = 10f64.powf(-exponent);
            let mut random = Random(23);
            // Never below zero, as radiance is.
            let samples: Vec<f32> =
                (0..DISTINCT).map(|_| (1.0 + deviation * (2.0 * random.uniform() - 1.0)) as f32).collect();
            let records = runs(&samples);
            let mut film = Film::new(1, 1, 0).expect("a pixel fits");
            film.add(&records);
            let found = f64::from(film.develop().variance[0][0]);
            // The same from the exact sums of the runs.
            let sums: Vec<f64> = samples.chunks(8).map(|run| run.iter().map(|x| f64::from(*x)).sum()).collect();
            let count = sums.len() as f64;
            let mean = sums.iter().sum::<f64>() / count;
            let of_sums = sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let expected = of_sums / count / 64.0;
            let (sum, squares) =
                samples.iter().fold((0.0f32, 0.0f32), |(sum, squares), x| (sum + x, squares + x * x));
            let naive = squares / DISTINCT as f32 - (sum / DISTINCT as f32).powi(2);
            let naive_error = (f64::from(naive) / (expected * DISTINCT as f64) - 1.0).abs();
            // The partial sums round by up to 2^-22, in [4, 8), as noise of variance 2^-44 / 12 and less. With r its share of the
            // deviation of a run, it adds r², and 2 r times a correlation that is 1 / sqrt(n) of n runs, five times by chance.
            let r = (7.0 * 2f64.powi(-44) / 12.0 / (8.0 * deviation * deviation / 3.0)).sqrt();
            let limit = 4.0 * U + r * r + 10.0 * r / count.sqrt();
            let cell = Cell::new(
                Row::Samples,
                format!("2^20, mean 1, spread 1e-{exponent}"),
                "Relative error of a pixel's variance",
                limit,
                "With r the rounding of the seven partial sums, 2^-22/sqrt(12) each at most, over the deviation of a run: r² + 10 r / sqrt(n) of n runs.",
            );
            cell.achieved((found / expected - 1.0).abs()).planted(MEAN_OF_SQUARES, naive_error)
        })
        .into()
}
