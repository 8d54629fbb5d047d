//! The statistics that other tests rest on: against known values, and with planted errors that each must find.

use crate::common::stats::*;

/// False-alarm rate of each statistical test here; the seeds are pinned.
const ALPHA: f64 = 1e-6;

fn assert_close(got: f64, expected: f64, relative: f64) {
    assert!((got - expected).abs() <= relative * expected.abs(), "{got:e} is not {expected:e}");
}

// Expected values below: mpmath 1.4, 30 digits.

#[test]
fn ln_gamma_agrees_with_known_values() {
    for (x, expected) in [
        (1e-3, 6.907_178_885_383_853),
        (0.5, 0.572_364_942_924_700_1),
        (2.5, 0.284_682_870_472_919_2),
        (10.0, 12.80182748008147),
        (100.25, 360.28455963776423),
        (5e5, 6_061_176.046_459_176),
    ] {
        assert_close(ln_gamma(x), expected, 1e-13);
    }
    assert!(ln_gamma(1.0).abs() < 1e-13);
}

#[test]
fn normal_tails_agree_with_known_values() {
    for (z, expected) in [
        (0.1, 0.920_344_325_445_942),
        (1.0, 0.3173105078629141),
        (-3.0, 0.002_699_796_063_260_189),
        (5.0, 5.733_031_437_583_878e-7),
        (10.0, 1.523_970_604_832_105e-23),
        (30.0, 9.813_427_854_296_374e-198),
    ] {
        assert_close(normal_two_sided(z), expected, 1e-12);
    }
    assert_eq!(normal_two_sided(0.0), 1.0);
    assert_eq!(normal_two_sided(f64::INFINITY), 0.0);
}

#[test]
fn chi_square_tails_agree_with_known_values() {
    for (x, degrees, expected) in [
        (0.1, 1.0, 0.751_829_634_045_849_2),
        (3.0, 2.0, 0.22313016014842983),
        (100.0, 50.0, 3.454_931_382_984_864e-5),
        (20.0, 50.0, 0.9999530506185732),
        (300.0, 100.0, 7.412_100_857_322_876e-22),
        (1010.0, 1000.0, 0.40603315094773596),
    ] {
        assert_close(chi_square_tail(x, degrees), expected, 1e-11);
    }
    assert_close(chi_square_tail(105000.0, 100000.0), 1.8950787187407721e-28, 1e-8);
}

#[test]
fn sidak_shares_the_false_alarms_out() {
    assert_close(sidak(0.01, 1), 0.01, 1e-14);
    assert_close(1.0 - (1.0 - sidak(0.01, 100)).powi(100), 0.01, 1e-10);
    assert_close(sidak(1e-6, 1_000_000), 1e-12, 1e-5);
}

fn normals(random: &mut Random, n: usize, mean: f64, deviation: f64) -> Vec<f64> {
    (0..n).map(|_| mean + deviation * random.normal()).collect()
}

#[test]
fn one_sample_t_accepts_the_truth_and_finds_one_percent() {
    // 100 000 values of deviation 0.3: 1 % is 10 standard errors.
    let values = normals(&mut Random(1), 100_000, 1.0, 0.3);
    assert!(one_sample_t(&values, 1.0).p > ALPHA);
    assert!(one_sample_t(&values, 1.01).p < ALPHA);
    assert!(one_sample_t(&values, 0.99).p < ALPHA);
}

#[test]
fn welch_t_accepts_equals_and_finds_one_percent() {
    let mut random = Random(2);
    let a = normals(&mut random, 200_000, 1.0, 0.3);
    let b = normals(&mut random, 100_000, 1.0, 0.1);
    assert!(welch_t(&a, &b).p > ALPHA);
    let biased: Vec<f64> = b.iter().map(|v| v * 1.01).collect();
    let found = welch_t(&a, &biased);
    assert!(found.p < ALPHA && found.difference < 0.0);
}

#[test]
fn values_without_spread_must_be_equal() {
    assert_eq!(one_sample_t(&[0.5; 10], 0.5).p, 1.0);
    assert_eq!(one_sample_t(&[0.5; 10], 0.5001).p, 0.0);
    assert_eq!(welch_t(&[0.5; 10], &[0.5; 4]).p, 1.0);
    assert_eq!(welch_t(&[0.5; 10], &[0.25; 4]).p, 0.0);
}

/// A p-value is uniform if nothing is wrong: few values of each must show it in the bulk.
#[test]
fn p_values_of_the_truth_are_uniform() {
    let mut random = Random(3);
    let mut one_sample = [0u64; 20];
    let mut welch = [0u64; 20];
    let mut chi = [0u64; 20];
    let rounds = 20_000;
    for _ in 0..rounds {
        let bin = |p: f64| ((p * 20.0) as usize).min(19);
        let a = normals(&mut random, 6, 2.0, 1.5);
        let b = normals(&mut random, 9, 2.0, 1.5);
        one_sample[bin(one_sample_t(&a, 2.0).p)] += 1;
        welch[bin(welch_t(&a, &b).p)] += 1;
        let mut counts = [0u64; 10];
        (0..2000).for_each(|_| counts[random.below(10)] += 1);
        chi[bin(chi_square(&counts, &[200.0; 10], 1))] += 1;
    }
    let expected = [f64::from(rounds) / 20.0; 20];
    for (name, bins) in [("one-sample", one_sample), ("Welch", welch), ("chi-square", chi)] {
        let p = chi_square(&bins, &expected, 1);
        assert!(p > ALPHA, "{name}: {bins:?}, p = {p:e}");
    }
}

/// A noisy image of 64 x 64 pixels: per pixel `runs` values of deviation 20 % around a reference; mean and variance of the mean.
struct Noisy {
    image: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
    reference: Vec<[f32; 3]>,
    reference_variance: Vec<[f32; 3]>,
}

fn noisy(seed: u64, runs: usize) -> Noisy {
    let mut random = Random(seed);
    let pixels = 64 * 64;
    let reference: Vec<[f32; 3]> = (0..pixels).map(|i| [1.0, 0.1, i as f32 / 100.0 + 0.01]).collect();
    let (mut image, mut variance) = (Vec::new(), Vec::new());
    for pixel in &reference {
        let results =
            pixel.map(|mean| mean_and_variance(&normals(&mut random, runs, f64::from(mean), 0.2 * f64::from(mean))));
        image.push(results.map(|(mean, _)| mean as f32));
        variance.push(results.map(|(_, variance)| (variance / runs as f64) as f32));
    }
    Noisy { image, variance, reference, reference_variance: vec![[0.0; 3]; pixels] }
}

impl Noisy {
    fn test(&self, degrees: f64) -> PixelTest {
        pixel_test(&self.image, &self.variance, &self.reference, &self.reference_variance, degrees, ALPHA)
    }
}

#[test]
fn pixel_test_accepts_the_truth() {
    for runs in [4, 16, 600] {
        let found = noisy(4, runs).test((runs - 1) as f64);
        assert!(found.passed, "{runs} runs: {found:?}");
    }
}

#[test]
fn pixel_test_with_few_runs_needs_students_distribution() {
    assert!(!noisy(4, 4).test(f64::INFINITY).passed, "the Z-test raises false alarms with 4 runs");
}

#[test]
fn pixel_test_takes_the_references_own_variance() {
    let mut noisy = noisy(5, 600);
    let mut random = Random(6);
    for (pixel, variance) in noisy.reference.iter_mut().zip(&mut noisy.reference_variance) {
        for channel in 0..3 {
            let deviation = 0.05 * pixel[channel];
            variance[channel] = deviation * deviation;
            pixel[channel] += deviation * random.normal() as f32;
        }
    }
    assert!(noisy.test(599.0).passed);
    noisy.reference_variance.fill([0.0; 3]);
    assert!(!noisy.test(599.0).passed, "the reference's noise must be found when it is denied");
}

#[test]
fn pixel_test_finds_a_bias_of_one_percent() {
    // 40 000 runs of 20 % deviation: 1 % is 10 standard errors of a pixel. The image is drawn directly, being a mean of many.
    let mut noisy = noisy(7, 16);
    let mut random = Random(8);
    let error = 0.2 / 200.0;
    for pixel in 0..noisy.image.len() {
        noisy.image[pixel] = noisy.reference[pixel].map(|v| v * (1.0 + error * random.normal() as f32));
        noisy.variance[pixel] = noisy.reference[pixel].map(|v| (v * error) * (v * error));
    }
    assert!(noisy.test(39_999.0).passed);
    noisy.image.as_flattened_mut().iter_mut().for_each(|v| *v *= 1.01);
    assert!(!noisy.test(39_999.0).passed);
}

#[test]
fn pixel_test_finds_a_local_bias_where_it_is() {
    let mut noisy = noisy(9, 600);
    // One pixel, one channel, by 10 % = 12 standard errors; the mean of the image moves by 2e-5 of itself.
    noisy.image[1234][1] *= 1.1;
    let found = noisy.test(599.0);
    assert!(!found.passed);
    assert_eq!((found.pixel, found.channel), (1234, 1));
}

#[test]
fn pixel_test_fails_on_nan_and_allows_for_rounding_only() {
    let exact = vec![[0.0f32; 3]; 4];
    let reference = vec![[0.3f32; 3]; 4];
    let next = vec![[0.3f32.next_up(); 3]; 4];
    let test = |image: &[[f32; 3]]| pixel_test(image, &exact, &reference, &exact, 15.0, ALPHA).passed;
    assert!(test(&reference));
    assert!(test(&next));
    assert!(!test(&[[0.30001; 3]; 4]));
    assert!(!test(&[[f32::NAN; 3]; 4]));
}

/// Counts of 100 000 draws from cells of probability proportional to the weights.
fn draw(weights: &[f64], seed: u64) -> Vec<u64> {
    let total: f64 = weights.iter().sum();
    let mut random = Random(seed);
    let mut counts = vec![0; weights.len()];
    for _ in 0..100_000 {
        let mut u = random.uniform() * total;
        let cell = weights.iter().position(|w| {
            u -= w;
            u < 0.0
        });
        counts[cell.unwrap_or(0)] += 1;
    }
    counts
}

fn expectations(weights: &[f64]) -> Vec<f64> {
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total * 100_000.0).collect()
}

/// From cells of thousands to cells of a thousandth of a count.
fn weights() -> Vec<f64> {
    (0..60).map(|i| 0.75f64.powi(i)).collect()
}

#[test]
fn chi_square_accepts_the_truth_with_small_cells() {
    let p = chi_square(&draw(&weights(), 10), &expectations(&weights()), 1);
    assert!(p > ALPHA, "{p}");
}

#[test]
fn chi_square_finds_planted_errors() {
    // The decay is 1 % off: about 13 standard errors.
    let global: Vec<f64> = (0..60).map(|i| 0.7425f64.powi(i)).collect();
    assert!(chi_square(&draw(&global, 11), &expectations(&weights()), 1) < ALPHA);
    // One cell of 60 is 30 % off.
    let mut local = weights();
    local[8] *= 1.3;
    assert!(chi_square(&draw(&local, 12), &expectations(&weights()), 1) < ALPHA);
}

#[test]
fn chi_square_with_impossible_cells() {
    assert_eq!(chi_square(&[50, 50, 1], &[50.0, 50.0, 0.0], 1), 0.0);
    assert_eq!(chi_square(&[50, 50, 0], &[50.0, 50.0, 0.0], 1), 1.0);
    assert_eq!(chi_square(&[1, 2], &[1.0, 2.0], 1), 1.0, "too few to say anything");
    assert_eq!(chi_square(&[1, 2], &[f64::NAN, 2.0], 1), 0.0);
}
