//! How far an image is from another: mean square errors over pixels and channels of linear radiance.

/// What keeps dark pixels from ruling the relative error; in radiance squared (design.md, section 2).
const RELATIVE_FLOOR: f64 = 0.01;

/// Mean square error: mean over pixels and channels of (a − b)².
///
/// Nothing where the images differ in size or are empty. A NaN or infinite input makes the result so.
pub fn mse(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    mean(a, b, |a, b| (a - b) * (a - b))
}

/// Relative mean square error of `a` against the reference `b`: mean over pixels and channels of (a − b)² / (b² + 0.01), untrimmed.
///
/// Nothing where the images differ in size or are empty. A NaN or infinite input makes the result so.
pub fn relmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    mean(a, b, |a, b| (a - b) * (a - b) / (b * b + RELATIVE_FLOOR))
}

/// The relMSE that a picture of these variances has by its noise: mean over pixels and channels of v / (b² + 0.01).
///
/// Nothing where the images differ in size or are empty.
pub fn relative_variance(variance: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<f64> {
    mean(variance, reference, |v, b| v / (b * b + RELATIVE_FLOOR))
}

/// Signed difference of the means: that of a − b over that of b, over pixels and channels.
///
/// Nothing where the images differ in size or are empty; infinite or NaN where b is black on the mean.
pub fn mean_difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    Some(mean(a, b, |a, b| a - b)? / mean(b, b, |b, _| b)?)
}

fn mean(a: &[[f32; 3]], b: &[[f32; 3]], error: impl Fn(f64, f64) -> f64) -> Option<f64> {
    if a.len() != b.len() || a.is_empty() {
        return None;
    }
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    let total: f64 = pairs.map(|(&a, &b)| error(f64::from(a), f64::from(b))).sum();
    Some(total / (3 * a.len()) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f32; 3]; 2] = [[1.0, 2.0, 3.0], [0.0, 0.5, 0.25]];
    const B: [[f32; 3]; 2] = [[1.0, 1.0, 1.0], [0.0, 0.0, 0.75]];

    fn close(a: Option<f64>, b: f64) -> bool {
        a.is_some_and(|a| (a - b).abs() < 1e-12 * b.abs())
    }

    #[test]
    fn mse_is_the_mean_over_pixels_and_channels() {
        assert!(close(mse(&A, &B), (1.0 + 4.0 + 0.25 + 0.25) / 6.0));
        assert_eq!(mse(&A, &A), Some(0.0));
    }

    #[test]
    fn relmse_divides_by_the_reference() {
        let expected = (1.0 / 1.01 + 4.0 / 1.01 + 0.25 / 0.01 + 0.25 / (0.5625 + 0.01)) / 6.0;
        assert!(close(relmse(&A, &B), expected));
        assert!(!close(relmse(&B, &A), expected), "the second image is the reference");
    }

    #[test]
    fn images_that_cannot_be_compared_have_no_error() {
        assert_eq!(mse(&A, &B[..1]), None);
        assert_eq!(relmse(&[], &[]), None);
    }

    #[test]
    fn large_values_do_not_overflow_and_a_nan_shows() {
        assert!(mse(&[[f32::MAX; 3]], &[[0.0; 3]]).is_some_and(f64::is_finite));
        assert!(relmse(&[[f32::NAN; 3]], &[[0.0; 3]]).is_some_and(f64::is_nan));
    }
}
