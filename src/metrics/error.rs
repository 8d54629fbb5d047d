//! Mean square errors over pixels and channels, of linear radiance and of sRGB pictures. There is none if the images differ in size or
//! are empty. A NaN or infinite input makes an error of radiance so.

use crate::data::{luminance, srgb, unit};

/// A constant that keeps dark pixels from dominating the relative error, in squared radiance. docs/comparing.md defines
/// relMSE with it.
pub const RELATIVE_FLOOR: f64 = 0.01;

/// Mean square error: mean over pixels and channels of (a − b)².
pub fn mse(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    mean(a, b, |a, b| (a - b) * (a - b))
}

/// Relative mean square error of `a` against the reference `b`: mean over pixels and channels of (a − b)² / (b² + 0.01), untrimmed.
pub fn relmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    mean(a, b, |a, b| (a - b) * (a - b) / (b * b + RELATIVE_FLOOR))
}

/// The floor that makes errors relative to the image b, in squared radiance: 0.01 times the square of its mean luminance. The unit of light
/// does not matter to it, as it does to [`RELATIVE_FLOOR`], which an image without light has.
pub fn floor_of(b: &[[f32; 3]]) -> f64 {
    let mean = mean_luminance(b);
    RELATIVE_FLOOR * if mean == 0.0 { 1.0 } else { mean * mean }
}

/// The mean luminance of an image; 0 of one without pixels.
pub fn mean_luminance(image: &[[f32; 3]]) -> f64 {
    image.iter().map(|rgb| luminance(rgb.map(f64::from))).sum::<f64>() / image.len().max(1) as f64
}

/// The mean square error of `a` relative to the image `b`: mean over pixels and channels of (a − b)² / (b² + 0.01 b̄²), with b̄ the mean
/// luminance of b. The square of what `gpu-rt render` states as the relative error.
pub fn relative_mse(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    let floor = floor_of(b);
    mean(a, b, |a, b| (a - b) * (a - b) / (b * b + floor))
}

/// The relative mean square error without the 0.1 % of the pixels with the largest error (rounded down to whole
/// pixels). The few rare bright paths that dominate the untrimmed error do not count. It proves nothing, because errors
/// in few pixels do not count either. Nor does a NaN that is trimmed.
pub fn relmse_trimmed(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    if a.len() != b.len() || a.is_empty() {
        return None;
    }
    let of_pixel = |(a, b): (&[f32; 3], &[f32; 3])| relmse(&[*a], &[*b]);
    let mut errors: Vec<f64> = a.iter().zip(b).filter_map(of_pixel).collect();
    // In range, because only a thousandth of the pixels is trimmed.
    let kept = errors.len() - errors.len() / 1000;
    errors.select_nth_unstable_by(kept - 1, f64::total_cmp);
    Some(errors[..kept].iter().sum::<f64>() / kept as f64)
}

/// The peak signal-to-noise ratio in dB of both images, clamped to 0..1 and sRGB-encoded: 10 log10(1 / MSE), with a
/// peak of 1. Infinite if the encoded images are equal.
pub fn psnr(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    let shown = |v: f64| srgb(unit(v));
    mean(a, b, |a, b| (shown(a) - shown(b)).powi(2)).map(|error| -10.0 * error.log10())
}

/// The error of the noise of an image with these variances, relative to an image and a floor in squared radiance: the mean over pixels and
/// channels of v / (b² + floor).
pub fn relative_variance(variance: &[[f32; 3]], reference: &[[f32; 3]], floor: f64) -> Option<f64> {
    mean(variance, reference, |v, b| v / (b * b + floor))
}

/// The signed relative difference of the mean luminances: the mean of a − b over the mean of b. Infinite or NaN if the mean of b is 0.
pub fn mean_difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> Option<f64> {
    let mean = mean_luminance(b);
    (a.len() == b.len() && !a.is_empty()).then(|| (mean_luminance(a) - mean) / mean)
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
    fn trimming_takes_the_worst_thousandth() {
        let b = vec![[1.0f32; 3]; 2500];
        let mut a = b.clone();
        (a[7], a[1300], a[2400]) = ([1e6; 3], [2.0; 3], [f32::INFINITY; 3]);
        // Two pixels are trimmed, and one with an error of 1/1.01 is left.
        assert!(close(relmse_trimmed(&a, &b), 1.0 / 1.01 / 2498.0));
        // Below 1000 pixels nothing is trimmed.
        assert_eq!(relmse_trimmed(&a[1600..], &b[1600..]), Some(f64::INFINITY));
        assert!(close(relmse_trimmed(&A, &B), relmse(&A, &B).unwrap()));
    }

    #[test]
    fn psnr_is_of_what_a_screen_shows() {
        // sRGB of 0.214041 is 0.5, of 1 is 1: an MSE of 1/4.
        assert!(psnr(&[[0.214_041_14; 3]], &[[7.0; 3]]).is_some_and(|db| (db - 6.0206).abs() < 1e-4));
        assert_eq!(psnr(&[[3.0, -1.0, 0.5]], &[[1.0, 0.0, 0.5]]), Some(f64::INFINITY));
    }

    /// Twice as much light is the same relative error, and another relMSE.
    #[test]
    fn the_unit_of_light_changes_no_relative_error() {
        let times =
            |image: &[[f32; 3]], factor: f32| image.iter().map(|rgb| rgb.map(|v| v * factor)).collect::<Vec<_>>();
        let b = [[1.0, 1.0, 1.0], [0.0, 0.5, 0.75]];
        // The mean luminance of b is (1 + 0.7152 · 0.5 + 0.0722 · 0.75) / 2.
        let floor = 0.01 * (0.5 * (1.0 + 0.3576 + 0.05415f64)).powi(2);
        let terms = [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (0.0, 0.0), (0.0, 0.5), (0.5, 0.75)];
        let expected: f64 = terms.iter().map(|(d, b): &(f64, f64)| d * d / (b * b + floor)).sum::<f64>() / 6.0;
        assert!(close(relative_mse(&A, &b), expected), "{:?} {expected}", relative_mse(&A, &b));
        for factor in [2f32.powi(-40), 8.0, 2f32.powi(40)] {
            let (a, b) = (times(&A, factor), times(&b, factor));
            assert!(close(relative_mse(&a, &b), expected));
            assert!(!close(relmse(&a, &b), relmse(&A, &B).unwrap()));
        }
        let black = [[0.0; 3]; 2];
        assert_eq!(relative_mse(&A, &black), relmse(&A, &black));
    }

    #[test]
    fn the_difference_of_means_is_of_luminance() {
        // Twice as much red, and half as much blue: 2 · 0.2126 + 0.7152 + 0.5 · 0.0722, relative to 1.
        assert!(close(mean_difference(&[[2.0, 1.0, 0.5]; 3], &[[1.0; 3]; 3]), 0.1765));
        assert_eq!((mean_difference(&A, &B[..1]), mean_difference(&[], &[])), (None, None));
    }

    #[test]
    fn images_that_cannot_be_compared_have_no_error() {
        assert_eq!(mse(&A, &B[..1]), None);
        assert_eq!(relmse(&[], &[]), None);
        assert_eq!((relmse_trimmed(&[], &[]), psnr(&[], &[])), (None, None));
        assert_eq!((relmse_trimmed(&A, &B[..1]), psnr(&A, &B[..1])), (None, None));
    }

    #[test]
    fn large_values_do_not_overflow_and_a_nan_shows() {
        assert!(mse(&[[f32::MAX; 3]], &[[0.0; 3]]).is_some_and(f64::is_finite));
        assert!(relmse(&[[f32::NAN; 3]], &[[0.0; 3]]).is_some_and(f64::is_nan));
    }
}
