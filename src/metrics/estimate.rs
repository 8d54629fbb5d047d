//! An estimate with its standard error, and its confidence interval and p-value by Student's t.

use super::student;

/// The confidence level of all reported intervals.
pub const CONFIDENCE: f64 = 0.95;
/// A difference with a p-value below this counts as more than noise.
pub const LEVEL: f64 = 0.01;

/// An estimate, its standard error, and the degrees of freedom of that error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    /// Infinite if it is unknown.
    pub error: f64,
    pub degrees: f64,
}

impl Estimate {
    /// The mean of independent values, with its standard error.
    pub fn of_values(values: &[f64]) -> Option<Estimate> {
        let n = values.len() as f64;
        if values.len() < 2 {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Some(Estimate { value: mean, error: (squares / (n * (n - 1.0))).sqrt(), degrees: n - 1.0 })
    }

    /// Half the width of the interval that contains the true value with [`CONFIDENCE`].
    pub fn half_width(&self) -> f64 {
        self.error_times_quantile(1.0 - CONFIDENCE)
    }

    /// The upper end of a one-sided interval: the true value is below this with [`CONFIDENCE`]. The true value is not
    /// negative, so that a negative estimate counts as 0.
    pub fn upper(&self) -> f64 {
        self.value.max(0.0) + self.error_times_quantile(2.0 * (1.0 - CONFIDENCE))
    }

    fn error_times_quantile(&self, p: f64) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error * student::quantile(p, self.degrees) }
    }

    /// The estimate moved towards 0 by `slack`.
    pub fn beyond(&self, slack: f64) -> Estimate {
        Estimate { value: self.value.signum() * (self.value.abs() - slack).max(0.0), ..*self }
    }

    /// The p-value: the probability that noise alone gives a value at least as far from 0.
    pub fn p(&self) -> f64 {
        match (self.value == 0.0, self.error == 0.0) {
            (true, _) => 1.0,
            (false, true) => 0.0,
            (false, false) => student::two_sided(self.value / self.error, self.degrees),
        }
    }
}

/// A lower bound of the degrees of freedom of a sum of variances, from Σ v and Σ v², if each v is an estimate with at
/// least one degree of freedom. E v² is then at least 3/2 of the variance of v, and the sum has at least 2 (E Σ v)² /
/// Var Σ v = 3 (Σ v)² / Σ v² − 2 degrees of freedom (Satterthwaite, Biometrics Bulletin 2(6), 1946).
pub fn degrees_of_sum(sum: f64, squares: f64) -> f64 {
    if squares > 0.0 { (3.0 * sum * sum / squares - 2.0).max(1.0) } else { f64::INFINITY }
}

/// Corrects the p-value of one of several tests, which has this share of the false alarms. After the correction, the
/// probability that any test's p-value is below x is at most x, if the tests are independent or positively correlated
/// (Šidák, JASA 62(318), 1967, with weights).
pub(super) fn corrected(p: f64, share: f64) -> f64 {
    // 1 − (1 − p)^(1/share)
    -((-p).ln_1p() / share).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_end_of_a_square_is_not_below_0() {
        let found = Estimate { value: -3.0, error: 1.0, degrees: 7.0 };
        assert!((found.upper() - 1.8946).abs() < 1e-3, "{}", found.upper());
        assert_eq!(Estimate { error: 0.0, ..found }.upper(), 0.0);
    }
}
