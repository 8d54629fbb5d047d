//! The colours of error maps: magma, whose lightness rises evenly with the value (S. van der Walt and N. Smith, "A better default
//! colormap for matplotlib", SciPy 2015).

use crate::data::unit;

/// Polynomials of degree 6 that approximate the published table of 256 sRGB colours, constant terms first. The largest
/// error is 5 of 255 (M. Zucker, "matplotlib colormaps", 2019, in the public domain).
const POLYNOMIALS: [[f64; 3]; 7] = [
    [-0.002_136_485, -0.000_749_655, -0.005_386_128],
    [0.251_660_541, 0.677_523_244, 2.494_026_599],
    [8.353_717_279, -3.577_719_515, 0.314_467_903],
    [-27.668_733_086, 14.264_730_781, -13.649_213_188],
    [52.176_139_812, -27.943_606_072, 12.944_169_442],
    [-50.768_525_365, 29.046_582_821, 4.234_152_994],
    [18.655_705_066, -11.489_773_520, -5.601_961_509],
];

/// The sRGB bytes of a value, clamped to 0..1.
pub fn magma(value: f64) -> [u8; 3] {
    let t = unit(value);
    // `as` saturates.
    [0, 1, 2].map(|channel| {
        let sum = POLYNOMIALS.iter().rev().fold(0.0, |sum, powers| sum * t + powers[channel]);
        (sum * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_near_the_table() {
        // Entries 0, 64, 128, 191 and 255 of matplotlib's table.
        for (value, expected) in [
            (0.0, [0, 0, 4]),
            (64.0 / 255.0, [81, 18, 124]),
            (128.0 / 255.0, [183, 55, 121]),
            (191.0 / 255.0, [252, 135, 97]),
            (1.0, [252, 253, 191]),
        ] {
            for (found, expected) in magma(value).into_iter().zip(expected) {
                assert!(found.abs_diff(expected) <= 5, "{value}: {:?}", magma(value));
            }
        }
        assert_eq!([magma(-3.0), magma(f64::NAN), magma(9.0)], [magma(0.0), magma(0.0), magma(1.0)]);
    }

    #[test]
    fn lightness_rises() {
        let light = |i: i32| crate::data::luminance(magma(f64::from(i) / 255.0).map(|v| f64::from(v) / 255.0));
        assert!((4..255).all(|i| light(i + 1) >= light(i) - 0.004 && light(i) > light(i - 4)));
    }
}
