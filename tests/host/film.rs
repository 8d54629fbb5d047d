//! The film: exact totals whatever the order, and an error estimate that is right on average.

use crate::common::film::{AddRuns, Run, Splat, to_fixed};
use crate::common::stats::{Random, one_sample_t};
use gpu_rt::aov::{Aovs, SceneSpace};
use gpu_rt::data::{ODD_RUN, Sampler};
use gpu_rt::film::{Film, Totals, UNKNOWN_VARIANCE};
use gpu_rt::output::exr::{read_exr, write_exr};

fn run(pixel: u32, sum: [f32; 3], accepted: u32) -> Run {
    Run { sum, pixel, counts: accepted, rays: 2 * accepted, squared_deviations: [0.0; 3] }
}

/// The run of these samples, alike in all channels.
fn run_of(pixel: u32, samples: &[f64]) -> Run {
    let sum: f64 = samples.iter().sum();
    let mean = sum / samples.len() as f64;
    let squared_deviations: f64 = samples.iter().map(|sample| (sample - mean).powi(2)).sum();
    Run { squared_deviations: [squared_deviations as f32; 3], ..run(pixel, [sum as f32; 3], samples.len() as u32) }
}

/// The run of a number: odd or even.
fn numbered(index: u32, record: Run) -> Run {
    if index % 2 == 1 { odd(record) } else { record }
}

fn odd(record: Run) -> Run {
    Run { counts: record.counts | ODD_RUN, ..record }
}

fn film(width: u32, height: u32, records: &[Run]) -> Film {
    let mut film = Film::new(width, height, 0).unwrap();
    film.add_runs(records);
    film
}

/// Runs of all sizes for 12 pixels, radiance over 12 decades, some samples rejected.
fn assorted_runs(seed: u64) -> Vec<Run> {
    let mut random = Random(seed);
    let mut value = || (10f64.powf(-8.0 + 12.0 * random.uniform())) as f32;
    let sums: Vec<[f32; 3]> = (0..5000).map(|_| [value(), value(), value()]).collect();
    sums.into_iter()
        .map(|sum| {
            let nan = random.below(2) as u32;
            let infinite = random.below(2) as u32;
            let accepted = random.below(7) as u32;
            let parity = if random.below(2) == 1 { ODD_RUN } else { 0 };
            let counts = accepted | nan << 8 | infinite << 16 | parity;
            let squared_deviations = [sum[1] * sum[2], sum[0] * sum[0], 0.0];
            Run { sum, pixel: random.below(12) as u32, counts, rays: random.below(100) as u32, squared_deviations }
        })
        .collect()
}

#[test]
fn any_order_any_split_and_any_parts_give_the_same_bits() {
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let of = |records: &[Run]| {
            let mut film = Film::with_sampler(4, 3, 0, sampler).unwrap();
            film.add_runs(records);
            film
        };
        let mut records = assorted_runs(1);
        let expected = of(&records);
        let f32_sum = |records: &[Run]| records.iter().map(|r| r.sum[0]).sum::<f32>();
        let f64_sum = |records: &[Run]| records.iter().map(|r| f64::from(r.sum[0]).powi(2)).sum::<f64>();
        let (expected_f32, expected_f64) = (f32_sum(&records), f64_sum(&records));
        let (mut f32_differs, mut f64_differs) = (false, false);
        let mut random = Random(2);
        for _ in 0..20 {
            random.shuffle(&mut records);
            let (mut split, mut rest) = (of(&[]), records.as_slice());
            while !rest.is_empty() {
                let (now, later) = rest.split_at(random.below(rest.len()) + 1);
                split.add_runs(now);
                rest = later;
            }
            assert!(split == expected && split.develop() == expected.develop());
            let mut parts = vec![Vec::new(); 5];
            records.iter().for_each(|record| parts[random.below(5)].push(*record));
            let mut joined = of(&[]);
            parts.iter().for_each(|part| joined.merge(&of(part)).unwrap());
            assert!(joined == expected);
            f32_differs |= f32_sum(&records) != expected_f32;
            f64_differs |= f64_sum(&records) != expected_f64;
        }
        assert!(f32_differs && f64_differs, "the shuffles must be able to show a sum that depends on the order");
    }
}

#[test]
fn films_of_different_images_do_not_merge() {
    let mut film = Film::new(4, 3, 0).unwrap();
    for other in [Film::new(3, 4, 0), Film::new(4, 3, 1), Film::new(4, 4, 0)] {
        let message = film.merge(&other.unwrap()).unwrap_err().to_string();
        assert!(message.contains("4 x 3"), "{message}");
    }
    let message = film_of_halves(12, &[]).merge(&self::film(12, 1, &[])).unwrap_err().to_string();
    assert!(message.contains("sobol") && message.contains("independent"), "{message}");
}

#[test]
fn sixteen_million_equal_samples_keep_their_mean() {
    // As the device does it: f32 sums of 8.
    let sum_of = |n: u32| (0..n).fold(0.0f32, |sum, _| sum + 0.3);
    let full = run(0, [sum_of(8); 3], 8);
    let runs = 1 << 21;
    let mut film = Film::new(1, 1, 0).unwrap();
    let block: Vec<_> = (0..1 << 12).map(|index| numbered(index, full)).collect();
    (0..runs >> 12).for_each(|_| film.add_runs(&block));
    film.add_runs(&[run(0, [0.3; 3], 1)]);
    let picture = film.develop();
    assert_eq!(picture.samples, [(1 << 24) + 1]);
    assert!((f64::from(picture.rgb[0][0]) / 0.3 - 1.0).abs() < 1e-7, "{:?}", picture.rgb);
    // Almost no variance, and what there is, is the rounding of the sums of 8.
    let error = f64::from(picture.variance[0][0]).sqrt() / 0.3;
    assert!(error < 1e-10, "{error}");
    // The negative control: one f32 sum of it all is 8.7 % low.
    let naive = (0..=1 << 24).fold(0.0f32, |sum, _| sum + 0.3) / 16_777_217.0;
    assert!((naive / 0.3 - 1.0).abs() > 0.05);
}

#[test]
fn equal_samples_have_no_variance() {
    let sum = [2.4, 1e-6, 8.0];
    let picture = film(1, 1, &(0..1000).map(|index| numbered(index, run(0, sum, 8))).collect::<Vec<_>>()).develop();
    assert_eq!(picture.variance, [[0.0; 3]]);
    // Runs of unequal size that agree: nothing but rounding may be left, never a negative number.
    let of = |n: u32| run(0, [0.25 * n as f32, 0.3 * n as f32, 1e2 * n as f32], n);
    let records: Vec<_> = (0..1000).map(|index| numbered(index, of(1 + index % 8))).collect();
    for variance in film(1, 1, &records).develop().variance[0] {
        assert!((0.0..1e-12).contains(&variance), "{variance:e}");
    }
}

#[test]
fn variance_follows_the_formula() {
    // 1, 3 and 2, 2, 5: W = 2 + 6 of 5 samples in 2 runs, v = 8 / (3 · 5).
    let records = [run_of(0, &[1.0, 3.0]), odd(run_of(0, &[2.0, 2.0, 5.0]))];
    let picture = film(1, 1, &records).develop();
    assert!((f64::from(picture.variance[0][0]) / (8.0 / 15.0) - 1.0).abs() < 1e-7);
    assert_eq!(picture.rgb[0], [2.6; 3]);
}

#[test]
fn a_small_variance_on_a_large_mean_is_not_lost() {
    // E[x²] − E[x]² in f32, even in f64, fails here: the deviation is 2^-20 of the mean.
    let deviation = 64.0 * 2f64.powi(-20);
    let samples = [64.0 - deviation, 64.0 + deviation].repeat(4);
    let records: Vec<_> = (0..1000).map(|index| numbered(index, run_of(0, &samples))).collect();
    let expected = deviation * deviation / 7000.0;
    let found = f64::from(film(1, 1, &records).develop().variance[0][0]);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} is not {expected}");
}

/// What is too small for the squares' fixed point has the variance of its halves, and no variance of 0: an image whose unit is a lamp 1e17 times
/// as bright. Each of 2000 pixels has its own of one degree of freedom, so that their mean is known to √(2/2000) = 3.2 %.
#[test]
fn a_variance_too_small_for_squares_is_not_lost() {
    let mut random = Random(14);
    for (unit, expected) in [(1.0, 1.0), (1e-17, 1.0), (1e-20, 1.0)] {
        let mut records = Vec::new();
        for pixel in 0..2000 {
            for index in 0..4 {
                let samples = [(); 8].map(|_| unit * (1.0 + random.uniform()));
                records.push(numbered(index, run_of(pixel, &samples)));
            }
        }
        let film = film(2000, 1, &records);
        let of_pixel = |v: &[f32; 3]| f64::from(v[0]) * 12.0 * 32.0 / (unit * unit);
        let found = match unit == 1.0 {
            true => film.develop().variance.iter().map(of_pixel).sum::<f64>() / 2000.0,
            // f32 holds no such squares; the relative error does.
            false => (film.relative_error().expect("there is light") / (1.0f64 / 12.0 / 32.0 / 2.26).sqrt()).powi(2),
        };
        assert!((found / expected - 1.0).abs() < 5.0 * 0.032, "{unit}: {found}");
    }
}

/// The pixels' variances over their true value. Samples are uniform in 0..1, runs have 1 to 8 of them.
fn variance_ratios(pixels: u32, runs: usize) -> Vec<f64> {
    let mut random = Random(5);
    let mut records = Vec::new();
    for pixel in 0..pixels {
        for index in 0..runs {
            let samples: Vec<f64> = (0..1 + random.below(8)).map(|_| random.uniform()).collect();
            records.push(numbered(index as u32, run_of(pixel, &samples)));
        }
    }
    let picture = film(pixels, 1, &records).develop();
    let samples = picture.samples.iter().map(|&n| f64::from(n));
    picture.variance.iter().zip(samples).flat_map(|(v, n)| v.map(|v| 12.0 * f64::from(v) * n)).collect()
}

#[test]
fn variance_is_unbiased() {
    // 30 000 pixels of 90 samples in 20 runs, alike in three channels: the standard error of the mean ratio is about 0.1 %.
    let ratios: Vec<f64> = variance_ratios(30_000, 20).into_iter().step_by(3).collect();
    let found = one_sample_t(&ratios, 1.0);
    assert!(found.p > 1e-6, "{found:?}");
    // The negative control: 1 % off, and dividing by N − 1 instead of N − K, must be found.
    let biased = |factor: f64| one_sample_t(&ratios.iter().map(|r| r * factor).collect::<Vec<_>>(), 1.0).p;
    assert!(biased(1.01) < 1e-6 && biased(0.99) < 1e-6);
    assert!(biased(70.0 / 89.0) < 1e-6);
}

/// 30,000 pixels with 16 uniform samples each, and 16 light paths a pixel, of which every other one reaches some pixel with a uniform splat. The
/// variance of a pixel's mean is 1/12/16 + 8/3/16². By independent samples it is known to 0.2 % on average, and by halves to 0.8 %.
#[test]
fn variance_with_light_paths_is_unbiased() {
    const PIXELS: u32 = 30_000;
    for (sampler, found_error) in [(Sampler::Independent, 0.02), (Sampler::Sobol, 0.08)] {
        let mut random = Random(21);
        let film = Film::with_sampler(PIXELS / 100, 100, 0, sampler).unwrap();
        let mut film = film.with_channels(&Aovs::default(), SceneSpace::default(), true).unwrap();
        let (mut runs, mut splats) = (Vec::new(), Vec::new());
        for number in 0..16 * PIXELS {
            let value = [random.uniform() as f32; 3];
            if random.below(2) == 0 {
                splats.push(Splat { pixel: random.below(PIXELS as usize) as u32, value, odd: number % 2 == 1 });
            }
        }
        for index in 0..2 * PIXELS {
            let samples = [(); 8].map(|_| random.uniform());
            runs.push(numbered(index, run_of(index / 2, &samples)));
        }
        film.add_runs(&runs);
        film.add_splats(&splats);
        film.add([], Totals { light_paths: [8 * u64::from(PIXELS); 2], ..Totals::default() });
        let picture = film.develop();
        let means: Vec<f64> = picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
        let found = one_sample_t(&means, 0.5 + 0.25);
        assert!(found.p > 1e-6, "{found:?}");
        let truth = 1.0 / 12.0 / 16.0 + 8.0 / 3.0 / 256.0;
        let ratios: Vec<f64> = picture.variance.iter().map(|variance| f64::from(variance[0]) / truth).collect();
        let found = one_sample_t(&ratios, 1.0);
        assert!(found.p > 1e-6, "{sampler:?}: {found:?}");
        let biased = |factor: f64| one_sample_t(&ratios.iter().map(|r| r * factor).collect::<Vec<_>>(), 1.0).p;
        assert!(biased(1.0 + found_error) < 1e-6 && biased(1.0 - found_error) < 1e-6);
    }
}

fn film_of_halves(width: u32, records: &[Run]) -> Film {
    let mut film = Film::with_sampler(width, 1, 0, Sampler::Sobol).unwrap();
    film.add_runs(records);
    film
}

#[test]
fn variance_of_halves_follows_the_formula() {
    // Even: means 1 and 3 of 8 each, so 2; odd: 1.5 of 4. v = (16 · 4 / 20²) · 0.5².
    let records = [run(0, [8.0; 3], 8), odd(run(0, [6.0; 3], 4)), run(0, [24.0; 3], 8)];
    let film = film_of_halves(1, &records);
    let picture = film.develop();
    assert_eq!((picture.rgb[0], picture.samples[0]), ([1.9; 3], 20));
    assert!((f64::from(picture.variance[0][0]) / (0.16 * 0.25) - 1.0).abs() < 1e-7);
    // The halves say nothing about the variance of independent samples.
    let runs = |records: &[Run]| self::film(1, 1, records).develop();
    let squared_deviations = records.map(|record| Run { squared_deviations: [2.0; 3], ..record });
    assert!(
        runs(&squared_deviations)
            == runs(&squared_deviations.map(|record| Run { counts: record.counts ^ ODD_RUN, ..record }))
    );
    assert_ne!(runs(&squared_deviations).variance, picture.variance);
    // One half alone shows nothing, and equal halves show no error.
    assert_eq!(film_of_halves(1, &[records[0], records[2]]).develop().variance, [[UNKNOWN_VARIANCE; 3]]);
    assert_eq!(film_of_halves(1, &[records[1], records[1]]).develop().variance, [[UNKNOWN_VARIANCE; 3]]);
    assert_eq!(film_of_halves(1, &[records[0], odd(run(0, [8.0; 3], 8))]).develop().variance, [[0.0; 3]]);
}

/// A film of eight brightnesses b, and its true relative error: samples are uniform in 4 b..5 b, so that a pixel's own noise hardly
/// changes what it is divided by. With n samples the pixel's mean is off by e = 0.29/(4.5 √n), and v/I² by 3 e² of itself on average:
/// 0.08 % for 16 samples.
fn noisy_film(random: &mut Random, pixels: u32, runs: u32, sampler: Sampler) -> (Film, f64) {
    let mut film = Film::with_sampler(pixels, 1, 0, sampler).unwrap();
    let brightness = |pixel: u32| 0.25 * 1.5f64.powi((pixel * 8 / pixels) as i32);
    let (mut mean_of_all, mut means) = (0.0, Vec::new());
    for pixel in 0..pixels {
        let b = brightness(pixel);
        for index in 0..runs {
            let samples = [(); 8].map(|_| b * (4.0 + random.uniform()));
            film.add_runs(&[numbered(index, run_of(pixel, &samples))]);
        }
        mean_of_all += 4.5 * b / f64::from(pixels);
        means.push(4.5 * b);
    }
    let truth = error_against(&film, &means, 0.01 * mean_of_all * mean_of_all);
    (film, truth)
}

/// The root of the mean of (I - R)² / (R² + floor), R the mean that a pixel's channels have.
fn error_against(film: &Film, means: &[f64], floor: f64) -> f64 {
    let image = film.develop().rgb;
    let terms = image
        .iter()
        .zip(means)
        .flat_map(|(rgb, mean)| rgb.map(|value| (f64::from(value) - mean).powi(2) / (mean * mean + floor)));
    (terms.sum::<f64>() / (3 * means.len()) as f64).sqrt()
}

/// Of 2000 films each the true error is below the bound in 95 % but for five deviations of 0.5 %, which happen by chance in 6 of 10 million
/// cases, and a percent for the approximations (Satterthwaite, and degrees of freedom that are estimated themselves). The mean of
/// 2000 squares, each known to sqrt(2/ν) with ν of 40 or more, has a deviation of 0.5 %: four of them.
#[test]
fn the_true_error_is_below_its_bound_as_often_as_said() {
    const FILMS: usize = 2000;
    let mut random = Random(10);
    for (pixels, runs, sampler) in [(256, 2, Sampler::Sobol), (255, 4, Sampler::Independent), (64, 8, Sampler::Sobol)] {
        let (mut below, mut below_value, mut stated, mut true_squares) = (0, 0, 0.0, 0.0);
        for _ in 0..FILMS {
            let (film, truth) = noisy_film(&mut random, pixels, runs, sampler);
            let found = film.error_estimate(0.05).expect("there is light");
            below += usize::from(truth <= found.bound);
            below_value += usize::from(truth <= found.value);
            stated += found.value.powi(2);
            true_squares += truth.powi(2);
            assert!(found.reliable || pixels < 255, "{found:?}");
        }
        let (covered, ratio) = (below as f64 / FILMS as f64, stated / true_squares);
        println!("{pixels} pixels, {runs} runs, {sampler:?}: covered {covered}, squares by {ratio}");
        // Of independent samples the estimate is taken to be known as by two halves, which is on the safe side.
        let most = if sampler == Sampler::Independent { 1.0 } else { 0.985 };
        assert!((0.915..=most).contains(&covered), "{sampler:?}: {covered}");
        assert!((ratio - 1.0).abs() < 0.02, "{sampler:?}: {ratio}");
        // The estimate itself is no bound.
        assert!((0.35..0.65).contains(&(below_value as f64 / FILMS as f64)));
    }
}

/// All pixels are alike, samples of 1 but for one in 64 of 9, so that the true error is known: in x = v/(I² + f) both v and I rise with
/// the share of bright samples. 256 samples of a pixel have 4 bright ones on average, so that the estimate
/// alone is too low.
#[test]
fn the_bound_is_corrected_for_what_goes_together_with_the_mean() {
    const FILMS: usize = 400;
    const RUNS: u32 = 32;
    const SHARE: f64 = 1.0 / 64.0;
    let mut random = Random(13);
    let mean = 1.0 + 8.0 * SHARE;
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let (mut below, mut below_uncorrected) = (0, 0);
        for _ in 0..FILMS {
            let mut film = Film::with_sampler(256, 1, 0, sampler).unwrap();
            for pixel in 0..256 {
                for index in 0..RUNS {
                    let samples = [(); 8].map(|_| if random.uniform() < SHARE { 9.0 } else { 1.0 });
                    film.add_runs(&[numbered(index, run_of(pixel, &samples))]);
                }
            }
            let truth = error_against(&film, &[mean; 256], 0.01 * mean * mean);
            let found = film.error_estimate(0.05).expect("there is light");
            below += usize::from(truth <= found.bound);
            // The planted error: the estimate for the bound.
            below_uncorrected += usize::from(truth <= found.value);
        }
        let share = |count: usize| count as f64 / FILMS as f64;
        println!("{sampler:?}: covered {}, uncorrected {}", share(below), share(below_uncorrected));
        // 95 % of 400 has a deviation of 1.1 %.
        assert!(share(below) >= 0.9, "{}", share(below));
        assert!(share(below_uncorrected) < 0.8);
    }
}

/// One pixel of many holds most of the noise: a bulb that `share` of its samples meet, before smooth ones. Where its halves agree by chance, as
/// they do in a fifth of films, a bound by halves alone has lost it; the variance of its samples shows it.
#[test]
fn a_pixel_that_holds_the_noise_is_not_lost_by_chance() {
    const FILMS: usize = 1000;
    let mut random = Random(15);
    for (share, runs) in [(0.2, 4), (0.05, 16), (0.5, 2)] {
        for sampler in [Sampler::Sobol, Sampler::Independent] {
            let (mut below, mut below_halves, mut unseen, mut ratios) = (0, 0, 0, Vec::new());
            for _ in 0..FILMS {
                let films = [true, false].map(|_| Film::with_sampler(256, 1, 0, sampler).unwrap());
                let [mut film, mut of_halves] = films;
                for pixel in 0..256 {
                    for index in 0..runs {
                        let samples = [(); 8].map(|_| match pixel {
                            100 if random.uniform() < share => 40.0,
                            100 => 1.0,
                            _ => 1.0 + 0.02 * random.normal(),
                        });
                        let record = numbered(index, run_of(pixel, &samples));
                        film.add_runs(&[record]);
                        of_halves.add_runs(&[Run { squared_deviations: [0.0; 3], ..record }]);
                    }
                }
                let means: Vec<f64> =
                    (0..256).map(|pixel| if pixel == 100 { 1.0 + 39.0 * share } else { 1.0 }).collect();
                let mean = means.iter().sum::<f64>() / 256.0;
                let truth = error_against(&film, &means, 0.01 * mean * mean);
                let found = film.error_estimate(0.05).expect("there is light");
                unseen += usize::from(found.reliable && truth > found.bound);
                below += usize::from(truth <= found.bound);
                below_halves += usize::from(truth <= of_halves.error_estimate(0.05).expect("there is light").bound);
                ratios.push(found.bound / truth);
            }
            ratios.sort_by(f64::total_cmp);
            let covered = |count: usize| count as f64 / FILMS as f64;
            println!(
                "{share} of {} samples, {sampler:?}: covered {}, by halves alone {}, median bound/error {:.2}",
                8 * runs,
                covered(below),
                covered(below_halves),
                ratios[FILMS / 2]
            );
            // 95 % of 1000 has a deviation of 0.7 %: four of them.
            assert!(covered(below) >= 0.92, "{}", covered(below));
            assert!(covered(below_halves) < 0.9, "{}", covered(below_halves));
            // No film can show what no sample has hit: 1.4 films of a thousand at most; nine have a chance of 1e-5.
            assert!(unseen <= 8, "{unseen} films are called reliable and are not");
        }
    }
}

/// One sample of 4096 is 200 times as bright as the others, and meets one pixel of 64. The pixel's error is relative to light that it should not
/// have. Its neighbours show that, unless they are as bright, which is planted.
#[test]
fn a_lone_bright_sample_counts_with_the_light_around_it() {
    const FILMS: usize = 100;
    const SIZE: u32 = 48;
    let mut random = Random(16);
    let mean = 1.0 + 199.0 / 4096.0;
    let (mut below, mut below_together) = (0, 0);
    for _ in 0..FILMS {
        let mut pixels: Vec<[[f64; 8]; 8]> = (0..SIZE * SIZE)
            .map(|_| {
                [(); 8].map(|_| {
                    [(); 8].map(|_| if random.uniform() * 4096.0 < 1.0 { 200.0 } else { 1.0 + 0.1 * random.normal() })
                })
            })
            .collect();
        let holds = |pixels: &[[[f64; 8]; 8]]| {
            let mut film = Film::with_sampler(SIZE, SIZE, 0, Sampler::Sobol).unwrap();
            for (pixel, runs) in (0..).zip(pixels) {
                let runs: Vec<Run> =
                    (0..).zip(runs).map(|(index, samples)| numbered(index, run_of(pixel, samples))).collect();
                film.add_runs(&runs);
            }
            let truth = error_against(&film, &vec![mean; pixels.len()], 0.01 * mean * mean);
            usize::from(truth <= film.error_estimate(0.05).expect("there is light").bound)
        };
        below += holds(&pixels);
        let brightness = |runs: &[[f64; 8]; 8]| runs.as_flattened().iter().sum::<f64>();
        pixels.sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
        below_together += holds(&pixels);
    }
    let covered = |count: usize| count as f64 / FILMS as f64;
    println!("covered {}, with all bright pixels together {}", covered(below), covered(below_together));
    // 95 % of 100 has a deviation of 2.2 %: four of them.
    assert!(covered(below) >= 0.86, "{}", covered(below));
    assert!(covered(below_together) < 0.8, "{}", covered(below_together));
}

/// Each pixel shows its error as well as any, but the error is relative to the very path that made it.
#[test]
fn many_rare_bright_paths_are_unreliable() {
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let film = |bright_halves: &[bool]| {
            let (mut film, _) = noisy_film(&mut Random(12), 1024, 4, sampler);
            for pixel in (0..1024).step_by(3) {
                for &is_odd in bright_halves {
                    // A path in one half; the light of all samples in both.
                    let bright = match bright_halves {
                        [_] => run_of(pixel, &[1e3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
                        _ => run_of(pixel, &[125.0; 8]),
                    };
                    film.add_runs(&[numbered(u32::from(is_odd), bright)]);
                }
            }
            film.error_estimate(0.05).expect("it has halves")
        };
        let usual = film(&[]);
        assert!(usual.reliable && usual.against_better < 1.5 * usual.value, "{usual:?}");
        let fireflies = film(&[false]);
        assert!(!fireflies.reliable && fireflies.bound > fireflies.against_better, "{fireflies:?}");
        assert!(fireflies.against_better > 5.0 * fireflies.value, "{fireflies:?}");
        // As bright in both halves, pixels are bright and nothing is rare.
        let bright = film(&[false, true]);
        assert!(bright.reliable || sampler == Sampler::Independent, "{bright:?}");
        assert!(bright.against_better < 1.5 * bright.value, "{bright:?}");
    }
}

#[test]
fn few_pixels_that_make_the_error_are_unreliable() {
    let mut random = Random(11);
    let (mut film, _) = noisy_film(&mut random, 1024, 4, Sampler::Sobol);
    let usual = film.error_estimate(0.05).unwrap();
    assert!(usual.reliable && usual.bound < 1.1 * usual.value, "{usual:?}");
    // More confidence, a higher bound; even chances, none to speak of beside what halves know of the pixels' own light.
    let bound = |level| film.error_estimate(level).unwrap().bound;
    assert!(bound(1e-6) > bound(0.01) && bound(0.01) > usual.bound);
    assert!(bound(0.5) < 1.01 * usual.value.max(usual.against_better));
    // Three fireflies.
    for pixel in [100, 500, 900] {
        film.add_runs(&[run(pixel, [1e3; 3], 8)]);
    }
    let found = film.error_estimate(0.05).unwrap();
    assert!(!found.reliable && found.bound > 1.5 * found.value, "{found:?}");
    // A single pixel shows its error, but not the error of that.
    let one = film_of_halves(1, &[run(0, [1.0; 3], 8), odd(run(0, [3.0; 3], 8))]).error_estimate(0.05).unwrap();
    assert!(one.value > 0.0 && one.bound > 10.0 * one.value && !one.reliable, "{one:?}");
    let runs = [1.0, 3.0, 2.0, 4.0].map(|s| run(0, [s; 3], 8));
    let one = self::film(1, 1, &[runs[0], odd(runs[1]), runs[2], odd(runs[3])]).error_estimate(0.05).unwrap();
    assert!(one.value > 0.0 && one.bound > 2.0 * one.value && !one.reliable, "{one:?}");
    // Halves that agree by chance show nothing, but samples do.
    let samples = run_of(0, &[0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let one = film_of_halves(1, &[samples, odd(samples)]).error_estimate(0.05).unwrap();
    assert!(one.value == 0.0 && one.bound > 0.5 && !one.reliable, "{one:?}");
    // No error at all is known exactly.
    let exact =
        film_of_halves(4, &(0..4).flat_map(|p| [run(p, [1.0; 3], 8), odd(run(p, [1.0; 3], 8))]).collect::<Vec<_>>());
    let exact = exact.error_estimate(0.05).unwrap();
    assert!(exact.value == 0.0 && exact.bound == 0.0 && exact.reliable, "{exact:?}");
}

#[test]
fn unknown_variance_is_distinguished_from_none() {
    let records = [run(1, [0.5; 3], 8), run(2, [0.5; 3], 8), odd(run(2, [0.5; 3], 8))];
    let picture = film(3, 1, &records).develop();
    assert_eq!(picture.variance, [[UNKNOWN_VARIANCE; 3], [UNKNOWN_VARIANCE; 3], [0.0; 3]]);
    assert_eq!(picture.rgb[0], [0.0; 3]);
    assert!(UNKNOWN_VARIANCE.is_finite());
}

#[test]
fn rejected_samples_are_counted_by_reason_and_leave_the_mean_alone() {
    let records = [
        Run { counts: 6 | 2 << 8, rays: 10, ..run(0, [6.0; 3], 0) },
        Run { counts: 4 | 1 << 8 | 3 << 16, rays: 20, ..run(0, [4.0; 3], 0) },
        // All rejected: the sum says nothing, and the run is none of the replicates.
        Run { counts: 8 << 16, rays: 30, ..run(1, [f32::NAN; 3], 0) },
    ];
    let film = film(2, 1, &records);
    let picture = film.develop();
    assert_eq!(picture.rgb, [[1.0; 3], [0.0; 3]]);
    assert_eq!(picture.samples, [10, 0]);
    assert_eq!(picture.rejected, [6, 8]);
    let totals = film.totals;
    assert_eq!((totals.paths, totals.rays), (24, 60));
    assert_eq!((totals.rejected.nan, totals.rejected.infinite, totals.rejected.refused), (3, 11, 0));
    assert_eq!(totals.rejected.total(), 14);
}

#[test]
fn sums_that_cannot_be_are_refused_and_corrupt_nothing() {
    let good = [run(0, [1.0; 3], 8), run(1, [2.0; 3], 8), odd(run(1, [3.0; 3], 8))];
    let expected = film(2, 1, &good).develop();
    let bad = [
        run(0, [f32::NAN, 1.0, 1.0], 8),
        run(0, [1.0, -1e-30, 1.0], 8),
        run(0, [1.0, f32::NEG_INFINITY, 1.0], 8),
        Run { squared_deviations: [0.0, f32::NAN, 0.0], ..run(0, [1.0; 3], 8) },
        Run { squared_deviations: [-1e-30, 0.0, 0.0], ..run(0, [1.0; 3], 8) },
    ];
    for record in bad {
        let mut film = film(2, 1, &good);
        film.add_runs(&[record]);
        let picture = film.develop();
        assert_eq!(
            (&picture.rgb, &picture.variance, &picture.samples),
            (&expected.rgb, &expected.variance, &expected.samples)
        );
        assert_eq!(film.totals.rejected.refused, 8, "{record:?}");
        assert_eq!(film.totals.paths, 32);
        assert_eq!(picture.rejected[0], 8);
    }
    // A pixel outside the image is left out.
    let mut outside = film(2, 1, &good);
    outside.add_runs(&[Run { rays: 0, ..run(2, [1.0; 3], 8) }, run(u32::MAX, [1.0; 3], 8)]);
    assert!(outside.develop() == film(2, 1, &good).develop());
    // Finite samples whose f32 sum overflows are infinite, not refused.
    let mut film = film(2, 1, &good);
    film.add_runs(&[run(0, [1.0, f32::INFINITY, 1.0], 8)]);
    assert_eq!((film.totals.rejected.infinite, film.totals.rejected.refused), (8, 0));
    assert_eq!(film.develop().rgb, expected.rgb);
}

#[test]
fn large_and_small_values_keep_their_precision() {
    for value in [2f32.powi(-40), 1e-9, 0.3, 1.0, 2000.0] {
        let samples = [0.5, 1.5].repeat(4).iter().map(|f| f * f64::from(value)).collect::<Vec<_>>();
        let records: Vec<_> = (0..64).map(|index| numbered(index, run_of(0, &samples))).collect();
        let picture = film(1, 1, &records).develop();
        assert!((picture.rgb[0][0] / value - 1.0).abs() < 1e-6, "{value}");
        let expected = 0.25 * f64::from(value).powi(2) / 448.0;
        assert!(
            (f64::from(picture.variance[0][0]) / expected - 1.0).abs() < 1e-4,
            "{value}: {}",
            picture.variance[0][0]
        );
    }
}

#[test]
fn totals_saturate_to_unknown_in_any_order() {
    // Squares overflow first: the mean is still right.
    let mut records = vec![Run { squared_deviations: [1e12; 3], ..run(0, [1e6; 3], 8) }; 10];
    records.extend(vec![odd(run(0, [8.0; 3], 8)); 10]);
    let bright = film(1, 1, &records);
    let picture = bright.develop();
    assert!((picture.rgb[0][0] - 1e7 / 160.0 - 0.5).abs() < 0.01);
    assert_eq!(picture.variance[0], [UNKNOWN_VARIANCE; 3]);
    assert_eq!(bright.relative_error(), None);
    // Then the sums: finite, and the same in any order.
    records.extend(vec![run(0, [f32::MAX; 3], 8); 3]);
    let expected = film(1, 1, &records);
    Random(6).shuffle(&mut records);
    assert!(film(1, 1, &records) == expected);
    let picture = expected.develop();
    assert!(picture.rgb[0][0].is_finite() && picture.rgb[0][0] > 1e9);
    assert_eq!(picture.variance[0], [UNKNOWN_VARIANCE; 3]);
}

#[test]
fn the_exponent_scales_the_picture_and_never_the_relative_error() {
    let records = [run(0, [4.0; 3], 8), odd(run(0, [8.0; 3], 8))];
    let unit = film(1, 1, &records);
    let (mean, variance) = (unit.develop().rgb[0][0], unit.develop().variance[0][0]);
    for exponent in [-40, -1, 3, 40] {
        let mut film = Film::new(1, 1, exponent).unwrap();
        film.add_runs(&records);
        let picture = film.develop();
        assert_eq!(picture.rgb[0][0], mean * 2f32.powi(exponent));
        assert_eq!(picture.variance[0][0], variance * 2f32.powi(2 * exponent));
        assert_eq!(film.relative_error(), unit.relative_error());
    }
    // What f32 cannot hold: never infinite, and a variance never turns into certainty.
    for (exponent, value, error) in [(300, f32::MAX, f32::MAX), (-300, 0.0, f32::MIN_POSITIVE)] {
        let mut film = Film::new(1, 1, exponent).unwrap();
        film.add_runs(&records);
        assert_eq!((film.develop().rgb[0], film.develop().variance[0]), ([value; 3], [error; 3]));
    }
    assert!(Film::new(1, 1, 301).is_err() && Film::new(1, 1, i32::MIN).is_err());
}

#[test]
fn relative_error_follows_the_formula() {
    let sums = [[4.0f32, 8.0, 2.0], [6.0, 8.0, 4.0], [0.5, 0.0, 1.0], [0.25, 0.0, 3.0]];
    let records: Vec<_> = sums.iter().enumerate().map(|(i, s)| numbered(i as u32, run(i as u32 / 2, *s, 8))).collect();
    let film = film(2, 1, &records);
    let picture = film.develop();
    let luminance = |p: &[f32; 3]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    let mean = picture.rgb.iter().map(luminance).sum::<f64>() / 2.0;
    let terms = picture.rgb.as_flattened().iter().zip(picture.variance.as_flattened());
    let total: f64 = terms.map(|(&i, &v)| f64::from(v) / (f64::from(i).powi(2) + 0.01 * mean * mean)).sum();
    let found = film.relative_error().unwrap();
    assert!((found / (total / 6.0).sqrt() - 1.0).abs() < 1e-6, "{found}");
}

#[test]
fn relative_error_is_unknown_until_each_pixel_has_two_runs() {
    let mut film = film(2, 1, &[run(0, [1.0; 3], 8), odd(run(0, [3.0; 3], 8)), run(1, [1.0; 3], 8)]);
    assert_eq!(film.relative_error(), None);
    film.add_runs(&[odd(run(1, [3.0; 3], 8))]);
    assert!(film.relative_error().is_some());
}

#[test]
fn a_broken_pixel_does_not_hide_the_error_of_the_others() {
    let film =
        film(2, 1, &[run(0, [1.0; 3], 8), odd(run(0, [3.0; 3], 8)), Run { counts: 8 << 8, ..run(1, [0.0; 3], 0) }]);
    assert!(film.relative_error().is_some());
}

#[test]
fn a_black_image_has_no_relative_error() {
    assert_eq!(film(1, 1, &[run(0, [0.0; 3], 8); 2]).relative_error(), None);
    assert_eq!(Film::new(1, 1, 0).unwrap().relative_error(), None);
}

#[test]
fn images_that_cannot_be_held_are_errors() {
    for (width, height) in [(0, 1), (1, 0), (u32::MAX, u32::MAX)] {
        let message = Film::new(width, height, 0).unwrap_err().to_string();
        assert!(message.contains(&format!("{width} x {height}")), "{message}");
    }
}

#[test]
fn fixed_point_is_exact_and_rounds_to_nearest() {
    let exp2 = |exponent: i32| 2f64.powi(exponent);
    assert_eq!(to_fixed(0.0, 88), Some(0));
    assert_eq!(to_fixed(-0.0, 88), Some(0));
    assert_eq!(to_fixed(1.0, 88), Some(1 << 88));
    let mantissa = i128::from(0.3f32.to_bits() & 0x7f_ffff | 0x80_0000);
    assert_eq!(to_fixed(f64::from(0.3f32), 88), Some(mantissa << (88 - 25)));
    assert_eq!(to_fixed(exp2(-88), 88), Some(1));
    assert_eq!(to_fixed(exp2(-89), 88), Some(1));
    assert_eq!(to_fixed(exp2(-89) * 0.999, 88), Some(0));
    assert_eq!(to_fixed(exp2(-88) * 2.5, 88), Some(3));
    assert_eq!(to_fixed(exp2(-88) * 2.4, 88), Some(2));
    assert_eq!(to_fixed(exp2(38), 88), Some(1 << 126));
    assert_eq!(to_fixed(exp2(39), 88), None);
    assert_eq!(to_fixed(-exp2(-88) * 2.5, 88), Some(-3));
    assert_eq!(to_fixed(f64::from(f32::MAX), 88), None);
    assert_eq!(to_fixed(f64::MIN_POSITIVE, 88), Some(0));
    assert_eq!(to_fixed(f64::from_bits(1), 88), Some(0));
}

#[test]
fn nothing_that_is_not_finite_is_written_whatever_the_film_got() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for exponent in [-300, 0, 300] {
        let mut film = Film::new(4, 2, exponent).unwrap();
        for (pixel, value) in
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX, 1e-45, 0.0].into_iter().enumerate()
        {
            let record =
                Run { sum: [1.0, value, 1.0], pixel: pixel as u32, counts: 4, rays: 0, squared_deviations: [0.0; 3] };
            film.add_runs(&[record; 9]);
        }
        write_exr(&path, &film.develop(), &[]).unwrap();
        let read = read_exr(&path).unwrap();
        let variance = read.variance.unwrap();
        assert!(read.rgb.as_flattened().iter().chain(variance.as_flattened()).all(|v| v.is_finite() && *v >= 0.0));
        assert_eq!(read.rejected.unwrap(), [36, 36, 36, 36, 0, 0, 0, 0]);
    }
}
