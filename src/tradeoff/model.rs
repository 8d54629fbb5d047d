//! The error model of a setting, relative MSE = bias² + c N^-p, and the comparison of settings by it.

use crate::data::Sampler;
use crate::metrics::estimate::Estimate;

/// Noise that falls as c N^-p, with the standard errors of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falling {
    /// c: the relative MSE of the noise with one sample, extrapolated.
    pub noise: f64,
    /// The exponent p, above 0: 1 for independent samples.
    pub exponent: f64,
    /// The ln N at which the fit is most certain, the standard error of the noise's logarithm there, and that of the exponent.
    pub middle: f64,
    pub error: f64,
    pub exponent_error: f64,
}

impl Falling {
    /// The relative MSE of the noise after this many samples.
    pub fn at(&self, samples: f64) -> f64 {
        self.noise * samples.powf(-self.exponent)
    }

    /// The number of samples at which the noise reaches a target, at least one.
    pub fn samples_to(&self, target: f64) -> f64 {
        (self.noise / target).powf(1.0 / self.exponent).max(1.0)
    }

    /// The relative standard error of [`Falling::at`].
    pub fn relative_error(&self, samples: f64) -> f64 {
        self.error.hypot(self.exponent_error * (samples.ln() - self.middle))
    }

    /// Half the width of the interval of the exponent, with 95 % confidence.
    pub fn exponent_half_width(&self) -> f64 {
        1.96 * self.exponent_error
    }

    /// No noise.
    pub const SILENT: Falling = Falling { noise: 0.0, exponent: 1.0, middle: 0.0, error: 0.0, exponent_error: 0.0 };
}

/// The error of a setting as a function of the number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// The relative MSE that remains with infinitely many samples; not below 0.
    pub squared_bias: f64,
    /// Its upper bound with 95 % confidence.
    pub squared_bias_upper: f64,
    pub noise: Falling,
    /// The seconds for one sample in every pixel.
    pub seconds: f64,
    /// The seconds of an image that do not depend on its samples: denoising.
    pub fixed_seconds: f64,
}

/// The range of plausible exponents. Sobol points reach at most 3, in smooth pixels.
const EXPONENTS: (f64, f64) = (0.8, 3.0);
/// The least plausible exponent of denoised images, whose error is mostly bias, which falls more slowly than noise.
pub const LEAST_OF_DENOISED: f64 = 0.1;
/// The prior of the exponent, with its standard error. Noise from rare bright paths is measured too poorly to determine
/// an exponent, and a wrong exponent is far off at many samples. The mean is that of independent samples; the standard
/// error is the gain of Sobol points on the scenes of this repository.
const USUAL: (f64, f64) = (1.0, 0.1);

impl Model {
    /// The relative MSE after this many samples.
    pub fn error(&self, samples: f64) -> f64 {
        self.squared_bias + self.noise.at(samples)
    }

    /// The seconds until the relative MSE reaches the target, at least those of one sample. None if the upper bound of the
    /// squared bias is not below the target.
    pub fn seconds_to(&self, target: f64) -> Option<f64> {
        let left = target - self.squared_bias_upper;
        (left > 0.0).then(|| self.seconds_of(self.noise.samples_to(left)))
    }

    /// The seconds of this many samples in every pixel.
    pub fn seconds_of(&self, samples: f64) -> f64 {
        self.fixed_seconds + self.seconds * samples
    }

    /// The relative standard error of [`Model::seconds_to`] by that of the noise: d ln N = (d ln c N^-p) / p.
    pub fn relative_error_to(&self, target: f64) -> f64 {
        let left = target - self.squared_bias_upper;
        if left > 0.0 { self.noise.relative_error(self.noise.samples_to(left)) / self.noise.exponent } else { 0.0 }
    }
}

/// Fits c and p of c N^-p to noises at numbers of samples, each weighted by its precision. With independent samples p is 1.
pub fn falling(levels: &[(u32, Estimate)], sampler: Sampler) -> Option<Falling> {
    fitted(levels, (!sampler.is_independent()).then_some(EXPONENTS))
}

/// Fits c and p of c N^-p to the errors of denoised images, which may fall slowly.
pub fn falling_denoised(levels: &[(u32, Estimate)]) -> Option<Falling> {
    fitted(levels, Some((LEAST_OF_DENOISED, EXPONENTS.1)))
}

/// Fits c and p, with p in a range; without one it is 1.
fn fitted(levels: &[(u32, Estimate)], exponents: Option<(f64, f64)>) -> Option<Falling> {
    let known: Vec<(f64, f64, f64)> = levels
        .iter()
        .filter(|(_, noise)| noise.value > 0.0 && noise.error.is_finite())
        .map(|(samples, noise)| {
            // The standard error of the logarithm. At least a percent, because the model itself may be wrong by that.
            let error = (noise.error / noise.value).max(0.01);
            (f64::from(*samples).ln(), noise.value.ln(), 1.0 / (error * error))
        })
        .collect();
    if known.is_empty() {
        return None;
    }
    let weight: f64 = known.iter().map(|k| k.2).sum();
    let mean = |of: fn(&(f64, f64, f64)) -> f64| known.iter().map(|k| k.2 * of(k)).sum::<f64>() / weight;
    let (x, y) = (mean(|k| k.0), mean(|k| k.1));
    let before = 1.0 / (USUAL.1 * USUAL.1);
    let along = before + known.iter().map(|k| k.2 * (k.0 - x) * (k.0 - x)).sum::<f64>();
    let both: f64 = known.iter().map(|k| k.2 * (k.0 - x) * (k.1 - y)).sum();
    let (exponent, exponent_error) = match exponents {
        None => (1.0, 0.0),
        Some((least, most)) => (((before * USUAL.0 - both) / along).clamp(least, most), along.sqrt().recip()),
    };
    Some(Falling { noise: (y + exponent * x).exp(), exponent, middle: x, error: weight.sqrt().recip(), exponent_error })
}

/// The number of samples at which a figure falls to a target, at least one. `figures` has the figure at some numbers of samples.
/// Between them it is a straight line in logarithms; beyond them the line goes through the last two or the first two. None if the line
/// does not fall, or if the number is beyond [`FARTHEST`] times the last.
pub fn samples_to(figures: &[(u32, f64)], target: f64) -> Option<f64> {
    let points: Vec<(f64, f64)> = figures.iter().map(|(n, figure)| (f64::from(*n).ln(), figure.ln())).collect();
    let lines = points.windows(2);
    let line = lines.clone().find(|line| line[1].1 <= target.ln()).or_else(|| lines.clone().last())?;
    let slope = (line[1].1 - line[0].1) / (line[1].0 - line[0].0);
    let (farthest, at) = (points.last()?.0 + FARTHEST.ln(), line[0].0 + (target.ln() - line[0].1) / slope);
    // If the first figure is already below the target, a rising line does not matter.
    match slope < 0.0 {
        true => Some(at).filter(|at| *at <= farthest).map(|at| at.exp().max(1.0)),
        false => figures.iter().find(|(_, figure)| *figure <= target).map(|(n, _)| f64::from(*n)),
    }
}

/// Figures are extrapolated up to this many times the last number of samples.
const FARTHEST: f64 = 64.0;

/// The ranking of a setting among the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ranking {
    /// No other setting reaches all targets as soon.
    Front,
    /// Another setting reaches all targets as soon, and one of them sooner by more than the error of the measurement.
    Dominated,
    /// It reaches no target.
    NeverReaches,
    /// It is as fast as the defaults, within the error of the timings.
    AsDefaults,
}

/// Smaller ratios of seconds do not count as a difference, however certain the timings are. Of five settings that do
/// the same work, one or two were 7 to 12 % slower in half of the sweeps, from the first round to the last (llvmpipe):
/// the placement of memory has this effect.
const NO_DIFFERENCE: f64 = 1.15;

/// The ratio of seconds below which two settings count as equally fast: two standard errors of the ratio.
pub fn tie_ratio(a: f64, b: f64) -> f64 {
    (2.0 * a.hypot(b)).exp().max(NO_DIFFERENCE)
}

/// The times that rank a setting.
#[derive(Clone, Debug)]
pub struct Times {
    /// Seconds to each target, none if it does not reach the target.
    pub seconds: Vec<Option<f64>>,
    /// Their relative standard error.
    pub error: f64,
    /// Whether noise and bias are known, too. A setting with unknown noise or bias never dominates a setting with known ones.
    pub reliable: bool,
}

/// The ranking of each setting.
pub fn rankings(all: &[Times]) -> Vec<Ranking> {
    let time = |t: &Option<f64>| t.unwrap_or(f64::INFINITY);
    let beats = |a: &Times, b: &Times| {
        let pairs = || a.seconds.iter().map(time).zip(b.seconds.iter().map(time));
        let tie = tie_ratio(a.error, b.error);
        (a.reliable || !b.reliable)
            && pairs().all(|(a, b)| a <= b || (a / b) < tie)
            && pairs().any(|(a, b)| a * tie < b)
    };
    all.iter()
        .map(|own| match own.seconds.iter().all(Option::is_none) {
            true => Ranking::NeverReaches,
            false if all.iter().any(|other| beats(other, own)) => Ranking::Dominated,
            false => Ranking::Front,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURE: f64 = 1e-3;

    fn level(samples: u32, value: f64) -> (u32, Estimate) {
        (samples, Estimate { value, error: SURE * value, degrees: 7.0 })
    }

    #[test]
    fn a_falling_noise_is_found_again() {
        let levels = [4, 16, 64].map(|n: u32| level(n, 3.0 * f64::from(n).powf(-1.3)));
        let found = falling(&levels, Sampler::Sobol).unwrap();
        // The prior has a weight of 100, and three levels known to a percent have 38,000.
        assert!((found.noise / 3.0 - 1.0).abs() < 3e-3 && (found.exponent - 1.3).abs() < 1e-3, "{found:?}");
        assert!((found.at(16.0) / levels[1].1.value - 1.0).abs() < 1e-3 && found.relative_error(16.0) < 0.01);
        assert!((found.at(found.samples_to(1e-3)) / 1e-3 - 1.0).abs() < 1e-9);
        assert_eq!(falling(&levels[1..2], Sampler::Sobol).map(|found| found.exponent), Some(1.0));
        assert_eq!(falling(&[], Sampler::Sobol), None);
        // Independent samples have an exponent of 1, whatever the noise of the measurement.
        let independent = falling(&levels, Sampler::Independent).unwrap();
        assert_eq!((independent.exponent, independent.exponent_half_width()), (1.0, 0.0));
        assert!((independent.relative_error(1e6) / independent.error - 1.0).abs() < 1e-9);
        let model =
            Model { squared_bias: 0.0, squared_bias_upper: 0.0, noise: found, seconds: 1.0, fixed_seconds: 0.0 };
        assert!(model.relative_error_to(1e-6) > model.relative_error_to(1e-1) && found.exponent_half_width() > 0.0);
        // An uncertain level has little effect: two levels known to a percent have a weight of 9,600.
        let mut unsure = levels;
        unsure[2].1 = Estimate { value: 10.0 * unsure[2].1.value, error: 1e3, degrees: 2.0 };
        assert!((falling(&unsure, Sampler::Sobol).unwrap().exponent - 1.3).abs() < 4e-3);
    }

    /// An error of denoised images may fall as slowly as N^-0.5.
    #[test]
    fn errors_of_denoised_images_may_fall_slowly() {
        let levels = [4, 16, 64].map(|n: u32| level(n, 0.3 * f64::from(n).powf(-0.5)));
        assert!((falling_denoised(&levels).unwrap().exponent - 0.5).abs() < 0.01);
        assert!((falling(&levels, Sampler::Sobol).unwrap().exponent - 0.8).abs() < 1e-9);
    }

    #[test]
    fn figures_come_down_to_a_target() {
        let falls = [4u32, 16, 64].map(|n| (n, f64::from(n).powf(-0.5)));
        // Between two, before the first, beyond the last, and too far.
        for (target, samples) in [(0.2, 25.0), (0.25, 16.0), (0.8, 1.0 / 0.64), (5.0, 1.0), (0.05, 400.0)] {
            let found = samples_to(&falls, target).unwrap();
            assert!((found / samples - 1.0).abs() < 1e-9, "{target}: {found}");
        }
        assert_eq!(samples_to(&falls, 0.01), None);
        assert_eq!(samples_to(&[(4, 0.3), (16, 0.2), (64, 0.2)], 0.1), None);
        assert_eq!(samples_to(&[(4, 0.1), (16, 0.1), (64, 0.1)], 0.1), Some(4.0));
        assert_eq!((samples_to(&[], 0.1), samples_to(&falls[..1], 0.1)), (None, None));
    }

    /// Noise that is known to 30 % does not establish an exponent of 0.6, and the model reports a large error at many samples.
    #[test]
    fn an_exponent_by_chance_is_not_believed() {
        let rough = |(n, noise): (u32, Estimate)| (n, Estimate { error: 0.3 * noise.value, ..noise });
        let levels = [4, 16, 64].map(|n: u32| rough(level(n, f64::from(n).powf(-0.6))));
        let found = falling(&levels, Sampler::Sobol).unwrap();
        assert!((0.8..0.95).contains(&found.exponent), "{found:?}");
        let errors = [16.0, 1024.0].map(|samples| found.relative_error(samples));
        assert!((0.15..0.2).contains(&errors[0]) && errors[1] > 1.5 * errors[0], "{errors:?}");
    }

    #[test]
    fn seconds_to_a_target_know_of_the_bias() {
        let noise = Falling { noise: 0.8, ..Falling::SILENT };
        let model = Model { squared_bias: 1e-3, squared_bias_upper: 2e-3, noise, seconds: 0.5, fixed_seconds: 0.0 };
        let with_denoising = Model { fixed_seconds: 3.0, ..model };
        assert!((with_denoising.seconds_to(1e-2).unwrap() - 3.0 - 0.5 * 100.0).abs() < 1e-9);
        assert!((model.seconds_to(1e-2).unwrap() - 0.5 * 100.0).abs() < 1e-9);
        assert_eq!(model.seconds_to(2e-3), None);
        assert!((model.error(100.0) - 9e-3).abs() < 1e-12);
        // At least the time of one sample.
        assert_eq!(model.seconds_to(10.0), Some(0.5));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let all = [
            vec![Some(1.0), Some(10.0), Some(100.0)],
            // Sooner at the first target, never at the last.
            vec![Some(0.5), Some(6.0), None],
            // Later at all targets.
            vec![Some(2.0), Some(20.0), Some(200.0)],
            // As good as the first, within the error.
            vec![Some(1.01), Some(10.1), Some(101.0)],
            vec![None, None, None],
        ];
        let times = |error: f64| all.clone().map(|seconds| Times { seconds, error, reliable: true });
        let found = |error: f64| rankings(&times(error));
        use Ranking::*;
        assert_eq!(found(0.001), [Front, Front, Dominated, Front, NeverReaches]);
        // If timings are off by 30 %, a factor of two is no difference in time, but to reach a target or not is one.
        assert_eq!(found(0.3), [Front, Dominated, Front, Front, NeverReaches]);
        // The first and the fourth can dominate the third only if their noise and bias are known.
        let mut uncertain = times(0.001);
        (uncertain[0].reliable, uncertain[3].reliable) = (false, false);
        assert_eq!(rankings(&uncertain)[2], Front);
        uncertain[2].reliable = false;
        assert_eq!(rankings(&uncertain)[2], Dominated);
    }
}
