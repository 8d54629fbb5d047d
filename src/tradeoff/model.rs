//! How the error of a setting falls with time: relMSE = bias² + c N^-p, and what that says of settings beside each other.

use super::replicates::Estimate;

/// The error of a setting by its number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// relMSE that stays; not below 0.
    pub squared_bias: f64,
    /// The most that it may be, with 95 % confidence.
    pub squared_bias_upper: f64,
    /// relMSE by noise with one sample, extrapolated.
    pub noise: f64,
    /// The exponent p, above 0: 1 for independent samples.
    pub exponent: f64,
    /// Seconds of a sample a pixel.
    pub seconds: f64,
}

/// The range that an exponent is believed in: Sobol's points have at most 3 of a smooth pixel.
const EXPONENTS: (f64, f64) = (0.8, 3.0);

impl Model {
    /// relMSE with so many samples.
    pub fn error(&self, samples: f64) -> f64 {
        self.squared_bias + self.noise * samples.powf(-self.exponent)
    }

    /// Seconds until relMSE is at the target, at least those of one sample. None where the bias may be as large as that, with all that
    /// is known of it.
    pub fn seconds_to(&self, target: f64) -> Option<f64> {
        let left = target - self.squared_bias_upper;
        (left > 0.0).then(|| self.seconds * (self.noise / left).powf(1.0 / self.exponent).max(1.0))
    }
}

/// c and p of c N^-p through noises at numbers of samples, each weighed by how sure it is.
///
/// With one level p is 1.
pub fn falling(levels: &[(u32, Estimate)]) -> Option<(f64, f64)> {
    let known: Vec<(f64, f64, f64)> = levels
        .iter()
        .filter(|(_, noise)| noise.value > 0.0 && noise.error.is_finite())
        .map(|(samples, noise)| {
            // Of the logarithm; not below a percent, which is what the model itself may be wrong by.
            let error = (noise.error / noise.value).max(0.01);
            (f64::from(*samples).ln(), noise.value.ln(), 1.0 / (error * error))
        })
        .collect();
    let weight: f64 = known.iter().map(|k| k.2).sum();
    let mean = |of: fn(&(f64, f64, f64)) -> f64| known.iter().map(|k| k.2 * of(k)).sum::<f64>() / weight;
    let (x, y) = (mean(|k| k.0), mean(|k| k.1));
    let along: f64 = known.iter().map(|k| k.2 * (k.0 - x) * (k.0 - x)).sum();
    let both: f64 = known.iter().map(|k| k.2 * (k.0 - x) * (k.1 - y)).sum();
    let exponent = match known.len() {
        0 => return None,
        1 => 1.0,
        _ => (-both / along).clamp(EXPONENTS.0, EXPONENTS.1),
    };
    Some(((y + exponent * x).exp(), exponent))
}

/// What a setting is beside the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// No other setting reaches every target at least as soon.
    Front,
    /// Another does, and one of them sooner by more than the measurement's doubt.
    Dominated,
    /// No target is reached.
    NeverReaches,
}

/// Ratios of seconds nearer to 1 than this are no difference: what interleaved timings of the same thing come to on a shared machine.
pub const DOUBT: f64 = 1.05;

/// Where each setting stands, by its seconds to the targets; none is what it does not reach.
pub fn standings(seconds: &[Vec<Option<f64>>]) -> Vec<Standing> {
    let time = |t: &Option<f64>| t.unwrap_or(f64::INFINITY);
    let beats = |a: &[Option<f64>], b: &[Option<f64>]| {
        let pairs = || a.iter().map(time).zip(b.iter().map(time));
        pairs().all(|(a, b)| a <= b || (a / b) < DOUBT) && pairs().any(|(a, b)| a * DOUBT < b)
    };
    seconds
        .iter()
        .map(|own| match own.iter().all(Option::is_none) {
            true => Standing::NeverReaches,
            false if seconds.iter().any(|other| beats(other, own)) => Standing::Dominated,
            false => Standing::Front,
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
        let (noise, exponent) = falling(&levels).unwrap();
        assert!((noise - 3.0).abs() < 1e-9 && (exponent - 1.3).abs() < 1e-9, "{noise} {exponent}");
        assert_eq!(falling(&levels[1..2]).map(|(_, p)| p), Some(1.0));
        assert_eq!(falling(&[]), None);
        // What is unsure counts little.
        let mut unsure = levels;
        unsure[2].1 = Estimate { value: 10.0 * unsure[2].1.value, error: 1e3, degrees: 2.0 };
        assert!((falling(&unsure).unwrap().1 - 1.3).abs() < 1e-3);
    }

    #[test]
    fn seconds_to_a_target_know_of_the_bias() {
        let model = Model { squared_bias: 1e-3, squared_bias_upper: 2e-3, noise: 0.8, exponent: 1.0, seconds: 0.5 };
        assert!((model.seconds_to(1e-2).unwrap() - 0.5 * 100.0).abs() < 1e-9);
        assert_eq!(model.seconds_to(2e-3), None);
        assert!((model.error(100.0) - 9e-3).abs() < 1e-12);
        // A sample is the least.
        assert_eq!(model.seconds_to(10.0), Some(0.5));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let found = standings(&[
            vec![Some(1.0), Some(10.0), Some(100.0)],
            // Sooner at first, never at last.
            vec![Some(0.5), Some(6.0), None],
            // Later everywhere.
            vec![Some(2.0), Some(20.0), Some(200.0)],
            // As good as the first, within the doubt.
            vec![Some(1.01), Some(10.1), Some(101.0)],
            vec![None, None, None],
        ]);
        use Standing::*;
        assert_eq!(found, [Front, Front, Dominated, Front, NeverReaches]);
    }
}
