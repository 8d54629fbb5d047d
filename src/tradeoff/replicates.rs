//! What images by several seeds say of a setting: its noise, its bias against another setting, and how sure both are.
//!
//! Everything is a mean of products over pairs of replicates: of different ones the noise cancels in the mean, of one with itself it
//! stays. So the mean product of two different differences from the baseline is the square of the bias, with nothing to subtract
//! (independent halves), and pixels in which light is lost count even where others make up for it.

use crate::metrics::student;

/// An image: linear radiance, row 0 on top.
pub type Pixels = Vec<[f32; 3]>;

/// The probability of the intervals that are stated.
pub const CONFIDENCE: f64 = 0.95;

/// An estimate, its standard error, and how many degrees of freedom that has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub error: f64,
    pub degrees: f64,
}

impl Estimate {
    /// Half the width of the interval that holds the truth with [`CONFIDENCE`].
    pub fn half_width(&self) -> f64 {
        match self.error == 0.0 {
            true => 0.0,
            false => self.error * student::quantile(1.0 - CONFIDENCE, self.degrees),
        }
    }

    /// The end of a one-sided interval: what the truth is below with [`CONFIDENCE`].
    pub fn upper(&self) -> f64 {
        match self.error == 0.0 {
            true => self.value,
            false => self.value + self.error * student::quantile(2.0 * (1.0 - CONFIDENCE), self.degrees),
        }
    }

    /// The probability that noise alone brings a value at least as far from 0.
    pub fn p(&self) -> f64 {
        match (self.value == 0.0, self.error == 0.0) {
            (true, _) => 1.0,
            (false, true) => 0.0,
            (false, false) => student::two_sided(self.value / self.error, self.degrees),
        }
    }

    /// Mean of independent values, with the error of that mean.
    pub fn of_values(values: &[f64]) -> Option<Estimate> {
        let n = values.len() as f64;
        if values.len() < 2 {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Some(Estimate { value: mean, error: (squares / (n * (n - 1.0))).sqrt(), degrees: n - 1.0 })
    }
}

/// Mean over pixels and channels of a b / (r² + 0.01), r the reference: the measure in which relMSE is a square.
pub(super) fn product(a: &Pixels, b: &Pixels, reference: &Pixels) -> f64 {
    let terms = a.as_flattened().iter().zip(b.as_flattened()).zip(reference.as_flattened());
    let sum: f64 = terms
        .map(|((&a, &b), &r)| {
            f64::from(a) * f64::from(b) / (f64::from(r) * f64::from(r) + crate::metrics::error::RELATIVE_FLOOR)
        })
        .sum();
    sum / (3 * reference.len()) as f64
}

/// Value by value.
pub(super) fn difference(a: &Pixels, b: &Pixels) -> Pixels {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect()
}

/// The products of all pairs of replicates.
pub(super) struct Gram(Vec<Vec<f64>>);

impl Gram {
    pub(super) fn of(images: &[Pixels], reference: &Pixels) -> Gram {
        let row = |a| images.iter().map(|b| product(a, b, reference)).collect();
        Gram(images.iter().map(row).collect())
    }

    /// Of the replicates but one: the mean product with themselves, and with each other.
    fn means(&self, without: Option<usize>) -> (f64, f64) {
        let kept: Vec<usize> = (0..self.0.len()).filter(|i| Some(*i) != without).collect();
        let own: f64 = kept.iter().map(|&i| self.0[i][i]).sum();
        let all: f64 = kept.iter().map(|&i| kept.iter().map(|&j| self.0[i][j]).sum::<f64>()).sum();
        let n = kept.len() as f64;
        (own / n, (all - own) / (n * (n - 1.0)))
    }

    /// The jackknife over replicates (Efron and Stein, Annals of Statistics 9(3), 1981): its variance is never too small on the mean.
    pub(super) fn jackknife(&self, figure: fn((f64, f64)) -> f64) -> Option<Estimate> {
        let n = self.0.len();
        if n < super::sweep::FEWEST_ROUNDS {
            return None;
        }
        let without: Vec<f64> = (0..n).map(|i| figure(self.means(Some(i)))).collect();
        let mean = without.iter().sum::<f64>() / n as f64;
        let squares: f64 = without.iter().map(|v| (v - mean) * (v - mean)).sum();
        let variance = squares * (n - 1) as f64 / n as f64;
        Some(Estimate { value: figure(self.means(None)), error: variance.sqrt(), degrees: (n - 1) as f64 })
    }
}

/// The relMSE that one image has by its noise, from three replicates or more.
pub fn noise(images: &[Pixels], reference: &Pixels) -> Option<Estimate> {
    Gram::of(images, reference).jackknife(|(own, others)| own - others)
}

/// Mean over pixels and channels of the squared bias over r² + 0.01: what stays of relMSE however many samples are taken. From three
/// pairs or more of replicates of the setting and of the baseline. Below 0 by chance where there is none.
pub fn squared_bias(setting: &[Pixels], baseline: &[Pixels], reference: &Pixels) -> Option<Estimate> {
    let differences: Vec<Pixels> = setting.iter().zip(baseline).map(|(a, b)| difference(a, b)).collect();
    Gram::of(&differences, reference).jackknife(|(_, others)| others)
}

/// Signed bias of the mean over pixels and channels, relative to that of the reference. Pairs share their random numbers, so that
/// their noise cancels as far as the settings are alike.
pub fn signed_bias(setting: &[Pixels], baseline: &[Pixels], reference: &Pixels) -> Option<Estimate> {
    let mean = |image: &Pixels| image.as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>();
    let whole = mean(reference);
    let off = |(a, b)| match mean(a) - mean(b) {
        // Of black images too.
        0.0 => 0.0,
        off => off / whole,
    };
    let each: Vec<f64> = setting.iter().zip(baseline).map(off).collect();
    Estimate::of_values(&each).filter(|estimate| estimate.value.is_finite())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Noise of a standard deviation about a value, the same in every run of the test.
    pub(in crate::tradeoff) struct Random(pub u64);

    impl Random {
        fn normal(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                ((self.0 >> 33) as f64 + 0.5) / (1u64 << 31) as f64
            };
            (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
        }

        pub fn images(&mut self, count: usize, mean: f64, deviation: f64) -> Vec<Pixels> {
            (0..count)
                .map(|_| (0..400).map(|_| [0; 3].map(|_| (mean + deviation * self.normal()) as f32)).collect())
                .collect()
        }
    }

    const REFERENCE: f64 = 0.5;

    fn reference() -> Pixels {
        vec![[REFERENCE as f32; 3]; 400]
    }

    /// How often the interval of an estimate holds the truth.
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
        let truth = 0.01 / (REFERENCE * REFERENCE + 0.01);
        let share = coverage(|random| noise(&random.images(8, 0.5, 0.1), &reference()).unwrap(), truth);
        assert!(share >= 0.92, "{share}");
        assert!(noise(&Random(1).images(2, 0.5, 0.1), &reference()).is_none());
    }

    #[test]
    fn biases_are_found_and_noise_is_none() {
        let pairs = |random: &mut Random, bias: f64| {
            let (a, b) = (random.images(8, 0.5 + bias, 0.1), random.images(8, 0.5, 0.1));
            (signed_bias(&a, &b, &reference()).unwrap(), squared_bias(&a, &b, &reference()).unwrap())
        };
        for bias in [0.0, 0.02] {
            let share = coverage(|random| pairs(random, bias).0, bias / REFERENCE);
            assert!((0.92..=0.98).contains(&share), "signed, {bias}: {share}");
            let truth = bias * bias / (REFERENCE * REFERENCE + 0.01);
            let share = coverage(|random| pairs(random, bias).1, truth);
            assert!(share >= 0.92, "squared, {bias}: {share}");
        }
        let (signed, squared) = pairs(&mut Random(3), 0.02);
        // 14 standard errors, and 3.
        assert!(signed.p() < 1e-4 && squared.p() < 0.05, "{signed:?} {squared:?}");
    }

    #[test]
    fn what_is_lost_here_and_won_there_is_a_bias_too() {
        let mut random = Random(5);
        let baseline = random.images(8, 0.5, 0.01);
        let moved = |image: &Pixels| {
            let sign = |i: usize| if i.is_multiple_of(2) { 0.02 } else { -0.02 };
            image.iter().enumerate().map(|(i, p)| p.map(|v| v + sign(i))).collect()
        };
        let setting: Vec<Pixels> = baseline.iter().map(moved).collect();
        assert!(signed_bias(&setting, &baseline, &reference()).unwrap().value.abs() < 1e-6);
        let squared = squared_bias(&setting, &baseline, &reference()).unwrap();
        assert!((squared.value / (0.0004 / (REFERENCE * REFERENCE + 0.01)) - 1.0).abs() < 1e-4, "{squared:?}");
        assert!(squared.p() < 1e-6);
    }

    #[test]
    fn the_same_images_are_no_bias_without_doubt() {
        let images = Random(9).images(4, 0.5, 0.1);
        let found = [signed_bias(&images, &images, &reference()), squared_bias(&images, &images, &reference())];
        for estimate in found {
            assert_eq!(estimate, Some(Estimate { value: 0.0, error: 0.0, degrees: 3.0 }));
            assert_eq!(estimate.unwrap().p(), 1.0);
        }
    }
}
