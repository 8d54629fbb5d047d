//! Student's t distribution: tails and quantiles.

/// The limit on the degrees of freedom. More would not change the tails noticeably.
const MOST_DEGREES: f64 = 1e6;

/// P(|T| ≥ |t|) for any degrees of freedom > 0. The relative error is about 1e-12 in the tails.
pub fn two_sided(t: f64, degrees: f64) -> f64 {
    let degrees = degrees.min(MOST_DEGREES);
    let t2 = t * t;
    // x and 1 − x are both computed directly, because either may be small. (Abramowitz and Stegun, 26.7.1 with 26.5.27.)
    if t2.is_infinite() {
        return 0.0;
    }
    beta_share(degrees / 2.0, 0.5, degrees / (degrees + t2), t2 / (degrees + t2))
}

/// The t ≥ 0 with P(|T| ≥ t) = p, 0 < p < 1, with a relative error of about 1e-12.
pub fn quantile(p: f64, degrees: f64) -> f64 {
    // Bisection of log t, because the tail probability falls with t.
    let (mut low, mut high) = (-70.0_f64, 350.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match two_sided(middle.exp(), degrees) > p {
            true => low = middle,
            false => high = middle,
        }
    }
    (0.5 * (low + high)).exp()
}

/// The regularised incomplete beta function I_x(a, b), with y = 1 − x, by its continued fraction (Press et al.,
/// Numerical Recipes, 3rd edition, section 6.4).
fn beta_share(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return 1.0;
    }
    // The fraction converges fast only below the mean.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_share(b, a, y, x);
    }
    let front = (a * x.ln() + b * y.ln() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b)).exp() / a;
    front * beta_fraction(a, b, x)
}

/// The continued fraction of I_x(a, b), by Lentz's method.
fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    const MOST_TERMS: u32 = 100_000;
    let off_zero = |x: f64| if x.abs() < 1e-300 { 1e-300 } else { x };
    let (mut c, mut d) = (1.0, 1.0 / off_zero(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = d;
    for m in 1..=MOST_TERMS {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = value;
        for term in [even, odd] {
            d = 1.0 / off_zero(1.0 + term * d);
            c = off_zero(1.0 + term / c);
            value *= c * d;
        }
        if (value - before).abs() <= f64::EPSILON * value.abs() {
            break;
        }
    }
    value
}

/// The natural logarithm of the gamma function, x > 0, by Stirling's series (Abramowitz and Stegun, 6.1.41) above 10,
/// the recurrence below.
pub fn ln_gamma(mut x: f64) -> f64 {
    let mut product = 1.0;
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = 1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y * (1.0 / 1680.0 - y / 1188.0)));
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series / x - f64::ln(product)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64, relative: f64) {
        assert!((found - expected).abs() <= relative * expected.abs(), "{found}, expected {expected}");
    }

    #[test]
    fn tails_of_one_and_two_degrees_have_closed_forms() {
        for i in -30..=60 {
            let t = 10f64.powf(f64::from(i) / 10.0);
            close(two_sided(t, 1.0), 2.0 * (1.0 / t).atan() / std::f64::consts::PI, 1e-12);
            // 1 − t/√(2 + t²), written without the difference.
            let root = (2.0 + t * t).sqrt();
            close(two_sided(-t, 2.0), 2.0 / (root * (root + t)), 1e-11);
        }
        assert_eq!([two_sided(0.0, 3.0), two_sided(f64::INFINITY, 3.0), two_sided(1e200, 1.0)], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn quantiles_agree_with_the_tables() {
        for (degrees, t) in [(1.0, 12.706_204_736), (2.0, 4.302_652_730), (10.0, 2.228_138_852), (30.0, 2.042_272_456)]
        {
            close(quantile(0.05, degrees), t, 1e-9);
        }
        close(quantile(0.05, f64::INFINITY), 1.959_963_985, 3e-6);
        close(quantile(1e-9, 1.0), 2e9 / std::f64::consts::PI, 1e-9);
        for degrees in [1.0, 2.5, 63.0, 4e5] {
            for p in [0.9, 0.3, 1e-3, 1e-12] {
                close(two_sided(quantile(p, degrees), degrees), p, 1e-8);
            }
        }
    }
}
