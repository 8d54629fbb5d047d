//! The noise of a setting and its bias against another one, both with standard errors, from images with several seeds.
//!
//! Every result is a mean over pairs of different replicates. The expected product of two replicates' differences from
//! the baseline is the squared bias: their noise is independent, so that nothing has to be subtracted (independent
//! halves). Pixels that lose light count even if others gain the same amount. The noise of one replicate is half the squared
//! difference of two.

use crate::metrics::error::mean_luminance;
use crate::metrics::estimate::Estimate;

/// An image of linear radiance, with row 0 at the top.
pub type Pixels = Vec<[f32; 3]>;

/// The fewest rounds for which standard errors can be estimated.
pub const FEWEST_ROUNDS: usize = 3;

/// The weights w = 1 / (r² + f) that make products of replicates relative to an image r. The floor f is 0.01 times the square of the image's
/// mean luminance, so that the unit of light does not matter; or the 0.01 of relMSE.
///
/// If r contained the multiplied images themselves, w would be small exactly where these are bright by chance, and
/// products with an expectation of 0 would get another one: paths that rarely find a light would hardly count when they
/// do. So the rounds are divided into five folds, and the w for two rounds is computed from an r without the folds of
/// these rounds.
#[derive(Clone, Debug)]
pub struct Weights {
    /// r of all rounds.
    pub image: Pixels,
    /// f of that r, in squared radiance.
    pub floor: f64,
    /// The w of each pair of folds, FOLDS times FOLDS, empty if no two rounds form the pair; or a single w for all pairs.
    of_folds: Vec<Vec<f64>>,
}

/// Five, because every fourth round has an additional block: with five folds, each fold gets its share of them.
const FOLDS: usize = 5;

impl Weights {
    /// Weights from an image that contains no replicate.
    pub fn of_image(image: Pixels, floor_of: impl Fn(&[[f32; 3]]) -> f64) -> Weights {
        let floor = floor_of(&image);
        Weights { of_folds: vec![inverse(&image, floor)], image, floor }
    }

    /// Weights from images with their rounds and numbers of samples. None if there are no images.
    pub fn of_rounds<'a>(
        images: impl Iterator<Item = (usize, u32, &'a Pixels)>,
        floor_of: impl Fn(&[[f32; 3]]) -> f64,
    ) -> Option<Weights> {
        let mut rounds = 0;
        let sums: [FoldSum; FOLDS] = sums_of_folds(images.inspect(|(round, ..)| rounds = rounds.max(round + 1)));
        let mean = |without: &[usize]| -> Option<Pixels> {
            let kept = || (0..FOLDS).filter(|fold| !without.contains(fold)).map(|fold| &sums[fold]);
            let total: f64 = kept().map(|(_, weight)| weight).sum();
            let pixels = kept().map(|(sum, _)| sum.len()).max().filter(|_| total > 0.0)?;
            let value = |at: usize, c: usize| kept().filter_map(|(sum, _)| sum.get(at)).map(|p| p[c]).sum::<f64>();
            Some((0..pixels).map(|at| std::array::from_fn(|c| (value(at, c) / total) as f32)).collect())
        };
        let image = mean(&[])?;
        let floor = floor_of(&image);
        let pairs = (0..FOLDS * FOLDS).map(|pair| [pair / FOLDS, pair % FOLDS]);
        // With two rounds no third is left for r. Nothing is estimated from fewer than three.
        let of_pair = |pair: [usize; 2]| {
            let second = pair[1] + if pair[0] == pair[1] { FOLDS } else { 0 };
            if pair[0].max(second) >= rounds {
                return Vec::new();
            }
            let kept = mean(&pair);
            let kept = kept.as_ref().unwrap_or(&image);
            inverse(kept, floor_of(kept))
        };
        Some(Weights { of_folds: pairs.map(of_pair).collect(), image, floor })
    }

    /// The w for products of images of two rounds.
    fn between(&self, a: usize, b: usize) -> &[f64] {
        match &self.of_folds[..] {
            [all] => all,
            folds => &folds[a % FOLDS * FOLDS + b % FOLDS],
        }
    }
}

/// The images of some rounds summed, each times its samples, and the sum of these.
pub(super) type FoldSum = (Vec<[f64; 3]>, f64);

/// The sums of images with their rounds and numbers of samples; the rounds are dealt to the folds in turn. A fold without images has no pixels.
pub(super) fn sums_of_folds<'a, const N: usize>(
    images: impl Iterator<Item = (usize, u32, &'a Pixels)>,
) -> [FoldSum; N] {
    let mut sums: [FoldSum; N] = std::array::from_fn(|_| (Vec::new(), 0.0));
    for (round, samples, image) in images {
        let (sum, weight) = &mut sums[round % N];
        let n = f64::from(samples);
        sum.resize(image.len(), [0.0; 3]);
        sum.iter_mut().zip(image).for_each(|(sum, p)| (0..3).for_each(|c| sum[c] += n * f64::from(p[c])));
        *weight += n;
    }
    sums
}

/// In f64, because in f32 the weights of bright scenes would be subnormal, and those of dark ones infinite.
fn inverse(image: &Pixels, floor: f64) -> Vec<f64> {
    image.as_flattened().iter().map(|&r| 1.0 / (f64::from(r) * f64::from(r) + floor)).collect()
}

/// The mean over pixels and channels of w a b: an inner product whose squared norm is the relative MSE.
fn product(a: &[f32], b: &[f32], weights: &[f64]) -> f64 {
    let terms = a.iter().zip(b).zip(weights);
    let sum: f64 = terms.map(|((&a, &b), &w)| f64::from(a) * f64::from(b) * w).sum();
    sum / weights.len() as f64
}

/// The relative MSE of an image against another.
pub(super) fn distance(a: &Pixels, b: &Pixels, weights: &Weights) -> f64 {
    let off = difference(a, b);
    product(off.as_flattened(), off.as_flattened(), &inverse(&weights.image, weights.floor))
}

/// The difference of two images, value by value.
pub(super) fn difference(a: &Pixels, b: &Pixels) -> Pixels {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect()
}

/// A number for every pair of replicates, for their mean. Each row belongs to a replicate and pairs it with the earlier ones.
struct Pairs(Vec<Vec<f64>>);

impl Pairs {
    fn new(count: usize, figure: impl Fn(usize, usize) -> f64) -> Pairs {
        Pairs((0..count).map(|a| (0..a).map(|b| figure(a, b)).collect()).collect())
    }

    /// The mean, optionally without one of the replicates.
    fn mean(&self, without: Option<usize>) -> f64 {
        let kept = |of: usize| Some(of) != without;
        let row = |(a, row): (usize, &Vec<f64>)| -> f64 {
            let figures = row.iter().enumerate().filter(|(b, _)| kept(a) && kept(*b));
            figures.map(|(_, figure)| figure).sum()
        };
        let n = (self.0.len() - usize::from(without.is_some())) as f64;
        self.0.iter().enumerate().map(row).sum::<f64>() / (0.5 * n * (n - 1.0))
    }

    /// The jackknife over replicates (Efron and Stein, Annals of Statistics 9(3), 1981). The expectation of its
    /// variance is never too small.
    fn jackknife(&self) -> Option<Estimate> {
        let n = self.0.len();
        if n < FEWEST_ROUNDS {
            return None;
        }
        let without: Vec<f64> = (0..n).map(|i| self.mean(Some(i))).collect();
        let mean = without.iter().sum::<f64>() / n as f64;
        let squares: f64 = without.iter().map(|v| (v - mean) * (v - mean)).sum();
        let variance = squares * (n - 1) as f64 / n as f64;
        Some(Estimate { value: self.mean(None), error: variance.sqrt(), degrees: (n - 1) as f64 })
    }
}

/// The relative MSE of one image's noise: half that of two images against each other. Needs three replicates, which are
/// `apart` rounds from each other.
pub fn noise(images: &[Pixels], weights: &Weights, apart: usize) -> Option<Estimate> {
    let of_pair = |a: usize, b: usize| {
        let off = difference(&images[a], &images[b]);
        0.5 * product(off.as_flattened(), off.as_flattened(), weights.between(a * apart, b * apart))
    };
    Pairs::new(images.len(), of_pair).jackknife()
}

/// The mean over pixels and channels of the squared expectation of differences, divided by r² + f. Needs the
/// differences of three rounds, which are `apart` rounds from each other. If there is no difference, it may be below 0 by chance.
pub(super) fn squared_mean(differences: &[Pixels], weights: &Weights, apart: usize) -> Option<Estimate> {
    let of_pair = |a: usize, b: usize| {
        let weights = weights.between(a * apart, b * apart);
        product(differences[a].as_flattened(), differences[b].as_flattened(), weights)
    };
    Pairs::new(differences.len(), of_pair).jackknife()
}

/// The squared bias of the pixels: the relative MSE that remains with infinitely many samples. Needs three pairs of
/// replicates of the setting and of the baseline, which are `apart` rounds from each other.
pub fn squared_bias(setting: &[Pixels], baseline: &[Pixels], weights: &Weights, apart: usize) -> Option<Estimate> {
    let differences: Vec<Pixels> = setting.iter().zip(baseline).map(|(a, b)| difference(a, b)).collect();
    squared_mean(&differences, weights, apart)
}

/// The signed bias of the mean luminance, relative to that of the reference. Pairs share their random numbers, so that
/// noise that the two settings have in common cancels.
pub fn signed_bias(setting: &[Pixels], baseline: &[Pixels], reference: &Pixels) -> Option<Estimate> {
    let mean = mean_luminance(reference);
    let off = |(a, b): (&Pixels, &Pixels)| match mean_luminance(a) - mean_luminance(b) {
        // Two black images have no bias.
        0.0 => 0.0,
        off => off / mean,
    };
    let each: Vec<f64> = setting.iter().zip(baseline).map(off).collect();
    Estimate::of_values(&each).filter(|estimate| estimate.value.is_finite())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::metrics::error::floor_of;

    /// Noise of a standard deviation about a value, the same in every run of the test.
    pub(in crate::tradeoff) struct Random(pub u64);

    impl Random {
        pub fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 33) as f64 + 0.5) / (1u64 << 31) as f64
        }

        fn normal(&mut self) -> f64 {
            (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
        }

        pub fn images(&mut self, count: usize, mean: f64, deviation: f64) -> Vec<Pixels> {
            (0..count)
                .map(|_| (0..400).map(|_| [0; 3].map(|_| (mean + deviation * self.normal()) as f32)).collect())
                .collect()
        }
    }

    const REFERENCE: f64 = 0.5;
    const FLOOR: f64 = 0.01 * REFERENCE * REFERENCE;

    fn mean() -> Pixels {
        vec![[REFERENCE as f32; 3]; 400]
    }

    fn reference() -> Weights {
        Weights::of_image(mean(), floor_of)
    }

    /// The number of times that the interval of an estimate holds the truth.
    fn coverage(of: impl Fn(&mut Random) -> Estimate, truth: f64) -> f64 {
        let mut random = Random(17);
        let held = (0..400).filter(|_| {
            let found = of(&mut random);
            (found.value - truth).abs() <= found.half_width()
        });
        held.count() as f64 / 400.0
    }

    #[test]
    fn noise_is_that_of_one_image() {
        let truth = 0.01 / (REFERENCE * REFERENCE + FLOOR);
        let share = coverage(|random| noise(&random.images(8, 0.5, 0.1), &reference(), 1).unwrap(), truth);
        assert!(share >= 0.92, "{share}");
        assert!(noise(&Random(1).images(2, 0.5, 0.1), &reference(), 1).is_none());
    }

    #[test]
    fn biases_are_found_and_noise_is_none() {
        let pairs = |random: &mut Random, bias: f64| {
            let (a, b) = (random.images(8, 0.5 + bias, 0.1), random.images(8, 0.5, 0.1));
            (signed_bias(&a, &b, &mean()).unwrap(), squared_bias(&a, &b, &reference(), 1).unwrap())
        };
        for bias in [0.0, 0.02] {
            let share = coverage(|random| pairs(random, bias).0, bias / REFERENCE);
            assert!((0.92..=0.98).contains(&share), "signed, {bias}: {share}");
            let truth = bias * bias / (REFERENCE * REFERENCE + FLOOR);
            let share = coverage(|random| pairs(random, bias).1, truth);
            assert!(share >= 0.92, "squared, {bias}: {share}");
        }
        let (signed, squared) = pairs(&mut Random(3), 0.02);
        // 14 standard errors, and 3.
        assert!(signed.p() < 1e-4 && squared.p() < 0.05, "{signed:?} {squared:?}");
    }

    /// The bias of the mean is that of its luminance, as in `compare`: all of red is 21 % of the light.
    #[test]
    fn a_bias_of_the_mean_is_one_of_the_luminance() {
        let images = |red: f32| vec![vec![[red, 1.0, 1.0]; 4]; 3];
        let bias = signed_bias(&images(0.0), &images(1.0), &images(1.0)[0]).expect("three pairs");
        assert!((bias.value + 0.2126).abs() < 1e-9, "{bias:?}");
    }

    #[test]
    fn opposite_differences_of_two_pixels_are_a_bias() {
        let mut random = Random(5);
        let baseline = random.images(8, 0.5, 0.01);
        let moved = |image: &Pixels| {
            let sign = |i: usize| if i.is_multiple_of(2) { 0.02 } else { -0.02 };
            image.iter().enumerate().map(|(i, p)| p.map(|v| v + sign(i))).collect()
        };
        let setting: Vec<Pixels> = baseline.iter().map(moved).collect();
        assert!(signed_bias(&setting, &baseline, &mean()).unwrap().value.abs() < 1e-6);
        let squared = squared_bias(&setting, &baseline, &reference(), 1).unwrap();
        assert!((squared.value / (0.0004 / (REFERENCE * REFERENCE + FLOOR)) - 1.0).abs() < 1e-4, "{squared:?}");
        assert!(squared.p() < 1e-6);
    }

    #[test]
    fn the_same_images_have_no_bias_and_no_error() {
        let images = Random(9).images(4, 0.5, 0.1);
        let found = [signed_bias(&images, &images, &mean()), squared_bias(&images, &images, &reference(), 1)];
        for estimate in found {
            assert_eq!(estimate, Some(Estimate { value: 0.0, error: 0.0, degrees: 3.0 }));
            assert_eq!(estimate.unwrap().p(), 1.0);
        }
    }

    /// Images that are dark except for a few bright pixels, as from paths that find a light once in thousands of times.
    /// Their expectation equals that of the other images; weighted by an image that contains themselves, they would
    /// seem darker.
    #[test]
    fn rare_bright_pixels_are_no_bias() {
        const VALUE: f64 = 0.2;
        let weights_of = |all: &[Pixels]| {
            Weights::of_rounds(all.iter().enumerate().map(|(i, image)| (i, 16, image)), floor_of).unwrap()
        };
        let (mut apart, mut together) = (0, 0);
        for seed in 0..200 {
            let mut random = Random(1000 + seed);
            let baseline = random.images(8, VALUE, 0.05);
            // One pixel of 8 has eight times the value, and the others are 0.
            let mut rare = || {
                let uniform = random.images(1, 0.0, 1.0).remove(0);
                // A normal variate is above 1.1503 with a probability of 1/8.
                uniform.iter().map(|p| [if p[0] > 1.1503 { (8.0 * VALUE) as f32 } else { 0.0 }; 3]).collect::<Pixels>()
            };
            let setting: Vec<Pixels> = (0..8).map(|_| rare()).collect();
            let alarm = |weights: &Weights| {
                let found = squared_bias(&setting, &baseline, weights, 1).unwrap();
                found.value > 0.0 && found.p() < 0.05
            };
            apart += u32::from(alarm(&weights_of(&baseline)));
            let joined: Vec<Pixels> = baseline
                .iter()
                .zip(&setting)
                .map(|(a, b)| a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]))).collect())
                .collect();
            let mean = weights_of(&joined).image;
            together += u32::from(alarm(&Weights::of_image(mean, floor_of)));
        }
        // The expected number is 2.5 % of 200 = 5; more than 14 occur once in 3,000 times.
        assert!(apart <= 14 && together > 100, "{apart}, and weighed by themselves {together}");
    }

    #[test]
    fn no_pair_is_weighed_by_its_own_rounds() {
        let image = |value: f32| -> Pixels { vec![[value; 3]] };
        for count in [3usize, 7, 12] {
            let all: Vec<Pixels> = (0..count).map(|i| image(2f32.powi(i as i32))).collect();
            let weights =
                |all: &[Pixels]| Weights::of_rounds(all.iter().enumerate().map(|(i, p)| (i, 4, p)), floor_of).unwrap();
            let usual = weights(&all);
            for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
                let mut other = all.clone();
                (other[a], other[b]) = (image(1e6), image(1e6));
                assert_eq!(weights(&other).between(a, b), usual.between(a, b), "{count}: {a} {b}");
                assert!(weights(&other).image != usual.image);
            }
        }
        assert!(Weights::of_rounds(std::iter::empty(), floor_of).is_none());
    }
}
