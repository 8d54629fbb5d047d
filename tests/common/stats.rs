//! Statistics for tests: tail probabilities, and the tests built on them. A p-value is the probability of a deviation at least as large
//! as the one seen if nothing were wrong; a test fails where it is below the false-alarm rate that the caller accepts.

use gpu_rt::metrics::student::two_sided;

pub use gpu_rt::metrics::student::ln_gamma;

/// Terms after which a continued fraction or series is taken as it is; they grow as the root of the degrees of freedom.
const MAX_TERMS: u32 = 100_000;

/// Continued fraction b0 + a1/(b1 + a2/(b2 + …)) by Lentz's method (Press et al., Numerical Recipes, 3rd edition, section 5.2).
fn continued_fraction(b0: f64, term: impl Fn(f64) -> (f64, f64)) -> f64 {
    const TINY: f64 = 1e-300;
    let off_zero = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut value = off_zero(b0);
    let (mut c, mut d) = (value, 0.0);
    for i in 1..=MAX_TERMS {
        let (a, b) = term(f64::from(i));
        d = 1.0 / off_zero(b + a * d);
        c = off_zero(b + a / c);
        value *= c * d;
        if (c * d - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

/// Upper regularised incomplete gamma function Q(a, x), a > 0, x ≥ 0 (Press et al., Numerical Recipes, 3rd edition, section 6.2: the
/// series 6.2.5 below x = a + 1, the continued fraction 6.2.7 above, so that the tail keeps its relative accuracy).
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for i in 1..=MAX_TERMS {
            term *= x / (a + f64::from(i));
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        1.0 - front * sum
    } else {
        front / continued_fraction(x + 1.0 - a, |i| (-i * (i - a), x + 2.0 * i + 1.0 - a))
    }
}

/// P(|Z| ≥ |z|) of a standard normal Z.
pub fn normal_two_sided(z: f64) -> f64 {
    gamma_q(0.5, z * z / 2.0)
}

/// P(|T| ≥ |t|) of Student's t; infinitely many degrees of freedom are the normal distribution.
pub fn student_two_sided(t: f64, degrees: f64) -> f64 {
    if degrees.is_infinite() { normal_two_sided(t) } else { two_sided(t, degrees) }
}

/// P(X ≥ x) of chi-square.
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    gamma_q(degrees / 2.0, x / 2.0)
}

/// Mean and unbiased variance of the values (two passes).
pub fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0))
}

/// The outcome of a t-test.
#[derive(Clone, Copy, Debug)]
pub struct TTest {
    /// Mean of the first sample less the second's, or less the expected value.
    pub difference: f64,
    pub t: f64,
    pub degrees: f64,
    /// Two-sided.
    pub p: f64,
}

fn t_test(difference: f64, variance: f64, degrees: f64) -> TTest {
    // Without any spread, only equality is no deviation.
    let t = if difference == 0.0 { 0.0 } else { difference / variance.sqrt() };
    let degrees = if variance == 0.0 { f64::INFINITY } else { degrees };
    TTest { difference, t, degrees, p: student_two_sided(t, degrees) }
}

/// Student's test that the values' expectation is `expected`. At least two values.
pub fn one_sample_t(values: &[f64], expected: f64) -> TTest {
    let n = values.len() as f64;
    let (mean, variance) = mean_and_variance(values);
    t_test(mean - expected, variance / n, n - 1.0)
}

/// Why two square images of the same seed have not one expectation, in tiles of 8 x 8 pixels and as a whole: Student's test that the pixels'
/// differences are none on the mean, a false alarm once in 1 / `alpha` times. What both have alike cancels, and pixels are independent.
pub fn same_expectation_paired(a: &[[f32; 3]], b: &[[f32; 3]], alpha: f64) -> Result<(), String> {
    const TILE: usize = 8;
    assert_eq!(a.len(), b.len());
    let side = a.len().isqrt();
    let starts = || (0..side).step_by(TILE);
    let tiles = starts().flat_map(|top| starts().map(move |left| (left, top, TILE)));
    let areas: Vec<(usize, usize, usize)> = tiles.chain([(0, 0, side)]).collect();
    let threshold = sidak(alpha, 3 * areas.len());
    for (left, top, size) in areas {
        for channel in 0..3 {
            let pixels = (top..top + size).flat_map(|y| (left..left + size).map(move |x| y * side + x));
            let differences: Vec<f64> = pixels.map(|i| f64::from(a[i][channel]) - f64::from(b[i][channel])).collect();
            let found = one_sample_t(&differences, 0.0);
            if size == side {
                println!("channel {channel}: {found:?}");
            }
            if found.p < threshold {
                return Err(format!("{size} x {size} pixels at ({left}, {top}), channel {channel}: {found:?}"));
            }
        }
    }
    Ok(())
}

/// Welch's test that two samples have one expectation, whatever their variances (Welch 1947). At least two values in each.
pub fn welch_t(a: &[f64], b: &[f64]) -> TTest {
    let (na, nb) = (a.len() as f64, b.len() as f64);
    let ((mean_a, var_a), (mean_b, var_b)) = (mean_and_variance(a), mean_and_variance(b));
    let (va, vb) = (var_a / na, var_b / nb);
    let degrees = (va + vb).powi(2) / (va * va / (na - 1.0) + vb * vb / (nb - 1.0));
    t_test(mean_a - mean_b, va + vb, degrees)
}

/// The p-value below which one of `tests` independent ones must fall for a false-alarm rate of `alpha` in all (Šidák 1967).
pub fn sidak(alpha: f64, tests: usize) -> f64 {
    -((-alpha).ln_1p() / tests as f64).exp_m1()
}

/// The outcome of [`pixel_test`]: its worst pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelTest {
    pub passed: bool,
    pub pixel: usize,
    pub channel: usize,
    /// Deviation over its standard error.
    pub z: f64,
    pub p: f64,
    /// The p-value that the worst pixel must not fall below.
    pub threshold: f64,
}

/// Tests pixel by pixel that an image has the reference's expectation, with a false-alarm rate of `alpha` over all pixels and channels
/// (Šidák). `variance` and `reference_variance` are those of the means. An image whose variance comes from K runs a pixel is Student
/// distributed: say `degrees` = K − 1. With `f64::INFINITY` it is the Z-test, whose tails are right only for known variances or some
/// hundred runs. Skewed pixels (rare bright paths) need more. A pixel of no variance must agree but for rounding to f32.
pub fn pixel_test(
    image: &[[f32; 3]],
    variance: &[[f32; 3]],
    reference: &[[f32; 3]],
    reference_variance: &[[f32; 3]],
    degrees: f64,
    alpha: f64,
) -> PixelTest {
    assert!(!image.is_empty());
    assert!([variance.len(), reference.len(), reference_variance.len()] == [image.len(); 3], "images differ in size");
    let threshold = sidak(alpha, 3 * image.len());
    let mut worst = PixelTest { passed: true, pixel: 0, channel: 0, z: 0.0, p: 1.0, threshold };
    for pixel in 0..image.len() {
        for channel in 0..3 {
            let at = |values: &[[f32; 3]]| f64::from(values[pixel][channel]);
            let (a, b) = (at(image), at(reference));
            let (va, vb) = (at(variance), at(reference_variance));
            let rounding = f64::from(f32::EPSILON) * a.abs().max(b.abs());
            // Welch–Satterthwaite with the reference's variance taken as known: the share that is known adds degrees of freedom.
            let degrees = if va == 0.0 { f64::INFINITY } else { degrees * ((va + vb) / va).powi(2) };
            let z = if a == b { 0.0 } else { (a - b) / (va + vb + rounding * rounding).sqrt() };
            // A value that is not a number agrees with nothing.
            let p = if z.is_nan() { 0.0 } else { student_two_sided(z, degrees) };
            if p < worst.p {
                worst = PixelTest { passed: p >= threshold, pixel, channel, z, p, threshold };
            }
        }
    }
    worst
}

/// The cell of so many of a value from 0 to 1.
pub fn bin(x: f64, bins: usize) -> usize {
    ((x * bins as f64).max(0.0) as usize).min(bins - 1)
}

/// The p-value of points that are uniform in the unit square, by Pearson's test of so many cells.
pub fn uniform_in_cells((columns, rows): (usize, usize), points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut cells = vec![0u64; columns * rows];
    points.for_each(|(x, y)| cells[bin(x, columns) * rows + bin(y, rows)] += 1);
    let count: u64 = cells.iter().sum();
    chi_square(&cells, &vec![count as f64 / cells.len() as f64; cells.len()], 1)
}

/// Pearson's test that counts follow the expected ones. Cells of less than 5 expected are pooled, smallest first (Cochran's rule), as the
/// statistic is not chi-square distributed with them. Cells that cannot occur must be empty. Returns the
/// p-value; 1 where too few cells are left to say anything.
///
/// `constraints` is the number of parameters fitted to the counts, 1 where only the total was.
pub fn chi_square(observed: &[u64], expected: &[f64], constraints: usize) -> f64 {
    assert_eq!(observed.len(), expected.len());
    const SMALLEST: f64 = 5.0;
    let mut cells: Vec<(f64, f64)> = expected.iter().copied().zip(observed.iter().map(|&o| o as f64)).collect();
    if cells.iter().any(|&(e, o)| e.is_nan() || e < 0.0 || (e == 0.0 && o > 0.0)) {
        return 0.0;
    }
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pooled: Vec<(f64, f64)> = Vec::new();
    for (e, o) in cells {
        match pooled.last_mut() {
            Some(last) if last.0 < SMALLEST => *last = (last.0 + e, last.1 + o),
            _ => pooled.push((e, o)),
        }
    }
    // What is left over is too small for a cell of its own.
    if let Some((e, o)) = pooled.pop_if(|last| last.0 < SMALLEST) {
        match pooled.last_mut() {
            Some(last) => *last = (last.0 + e, last.1 + o),
            None => pooled.push((e, o)),
        }
    }
    if pooled.len() <= constraints {
        return 1.0;
    }
    let statistic = pooled.iter().map(|(e, o)| (o - e).powi(2) / e).sum();
    chi_square_tail(statistic, (pooled.len() - constraints) as f64)
}

/// Pinned random numbers for tests: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.uniform() * n as f64) as usize
    }

    /// Standard normal (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (2.0 * std::f64::consts::PI * self.uniform()).cos()
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}
