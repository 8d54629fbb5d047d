//! The view transform from linear radiance to a screen: exposure, a curve, and 8 bits. docs/pictures.md compares the curves.

use clap::ValueEnum;

use crate::data::{Rgb, product, srgb};

/// Exposures beyond this, of either sign, make every f32 white or black.
const MAX_EXPOSURE: f64 = 300.0;
/// More than any f32 at the largest exposure. What is infinite becomes this, so that every formula below stays finite.
const BRIGHTEST: f64 = 1e150;

/// A curve from radiance to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Tonemap {
    #[default]
    Soft,
    Srgb,
    Neutral,
    Filmic,
}

impl Tonemap {
    /// Linear Rec. 709 for the screen, of linear Rec. 709 of 0 and more. What is not from 0 to 1 is clipped later.
    fn compress(self, colour: Rgb<f64>) -> Rgb<f64> {
        match self {
            Tonemap::Soft => soft(colour),
            Tonemap::Srgb => colour,
            Tonemap::Neutral => neutral(colour),
            Tonemap::Filmic => filmic(colour),
        }
    }
}

/// How a picture is made of radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewTransform {
    /// In stops.
    pub exposure: f64,
    pub tonemap: Tonemap,
}

impl ViewTransform {
    /// The bytes of a pixel. What is below zero or not a number is black.
    pub fn bytes(&self, colour: Rgb<f32>, (x, y): (usize, usize)) -> [u8; 3] {
        let exposure = self.exposure.clamp(-MAX_EXPOSURE, MAX_EXPOSURE).exp2();
        let exposed = colour.map(|v| f64::from(v) * exposure);
        let exposed = exposed.map(|v| if v > 0.0 { v.min(BRIGHTEST) } else { 0.0 });
        let threshold = threshold(x, y);
        // `as` cuts off the fraction.
        self.tonemap.compress(exposed).map(|v| (255.0 * srgb(v) + threshold) as u8)
    }
}

/// The dither that is added to a value before its fraction is cut off: from 0 to 1, and evenly distributed over any few pixels, so that their mean
/// is that of the values. Whole values stay as they are: black is black, and white is white. All channels add the same, so that grey is grey.
///
/// Interleaved gradient noise (J. Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014 course
/// "Advances in Real-Time Rendering in Games").
fn threshold(x: usize, y: usize) -> f64 {
    let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
    (52.982_918_9 * (0.067_110_56 * x + 0.005_837_15 * y).fract()).fract()
}

/// The default: colours up to a brightness of 0.8 as they are. Above, the brightest channel approaches 1 by the shoulder of [`neutral`], and
/// colours fade to white with their hue: they are mixed in Oklab (B. Ottosson, "A perceptual color space for image processing", 2020), where a
/// line to white has one hue, and so have all multiples of a colour. Mixed in linear light, an orange lamp turns pink, and a blue one violet.
fn soft(colour: Rgb<f64>) -> Rgb<f64> {
    const SHOULDER: f64 = 0.8;
    /// How fast lights lose their colour: a peak of 21 is half white. Chosen by eye, on saturated lamps of 1 to 1000.
    const DESATURATION: f64 = 0.05;
    /// Rec. 709 to the responses of cones by Oklab, the second row divided by its sum of 1 - 1e-10, and back. Mixtures of the cube roots of
    /// these are those of Oklab's coordinates, which are linear in them.
    const TO_CONES: [Rgb<f64>; 3] = [
        [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
        [0.211_903_498_221_190_37, 0.680_699_545_168_07, 0.107_396_956_610_739_7],
        [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
    ];
    const FROM_CONES: [Rgb<f64>; 3] = [
        [4.076_741_661_347_994, -3.307_711_590_077_422, 0.230_969_928_729_427_76],
        [-1.268_438_004_092_176, 2.609_757_400_402_395_3, -0.341_319_396_310_219_5],
        [-0.004_196_086_541_837_2, -0.703_418_614_389_107_5, 1.707_614_700_930_944_5],
    ];
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak <= SHOULDER {
        return colour;
    }
    let (new_peak, white) = shoulder(peak, SHOULDER, DESATURATION);
    let roots = product(&TO_CONES, colour.map(|v| v * (new_peak / peak))).map(f64::cbrt);
    let mixed = product(&FROM_CONES, roots.map(|root| (root + (new_peak.cbrt() - root) * white).powi(3)));
    let mixed_peak = mixed[0].max(mixed[1]).max(mixed[2]);
    mixed.map(|v| v * (new_peak / mixed_peak))
}

/// Khronos PBR Neutral tone mapper (github.com/KhronosGroup/ToneMapping, PBR_Neutral/README.md, "PBR Neutral
/// Specification", 2024): linear Rec. 709 of any brightness ≥ 0 to 0..1. Below its shoulder it subtracts the share of white
/// light that a dielectric reflects, so that the displayed colour is the base colour of the material.
fn neutral(colour: Rgb<f64>) -> Rgb<f64> {
    const F90: f64 = 0.04;
    /// The brightness at which compression starts.
    const SHOULDER: f64 = 0.8 - F90;
    /// How fast highlights lose their colour.
    const DESATURATION: f64 = 0.15;

    let least = colour[0].min(colour[1]).min(colour[2]);
    let offset = if least < 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let colour = colour.map(|v| v - offset);
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak <= SHOULDER {
        return colour;
    }
    let (new_peak, white) = shoulder(peak, SHOULDER, DESATURATION);
    colour.map(|v| v * (new_peak / peak) * (1.0 - white) + new_peak * white)
}

/// The compressed peak of a colour above the shoulder of PBR Neutral, and the share of white in it.
fn shoulder(peak: f64, start: f64, desaturation: f64) -> (f64, f64) {
    let range = 1.0 - start;
    let new_peak = 1.0 - range * range / (peak + range - start);
    (new_peak, 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0))
}

/// The film curve of the Academy Color Encoding System, RRT and ODT in one, as S. Hill fitted it in 2016
/// (github.com/TheRealMJP/BakingLab, BakingLab/ACES.hlsl): linear Rec. 709 of any brightness to about 0..1.
fn filmic(colour: Rgb<f64>) -> Rgb<f64> {
    /// Rec. 709 to the primaries of the curve, AP1 with RRT's saturation.
    const IN: [Rgb<f64>; 3] = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    /// Back, with ODT's saturation.
    const OUT: [Rgb<f64>; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve = |v: f64| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951_0) + 0.238_081);
    product(&OUT, product(&IN, colour).map(curve))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The codes that are shown without a dither.
    fn codes(tonemap: Tonemap, colour: Rgb<f64>) -> Rgb<f64> {
        tonemap.compress(colour).map(|v| 255.0 * srgb(v.clamp(0.0, 1.0)))
    }

    #[test]
    fn srgb_agrees_with_known_values() {
        for (linear, code) in
            [(0.0, 0.0), (0.003_130_8, 10.3147), (0.18, 117.6458), (0.214_041, 127.5), (0.5, 187.516), (1.0, 255.0)]
        {
            let found = codes(Tonemap::Srgb, [linear; 3])[0];
            assert!((found - code).abs() < 1e-3, "{linear}: {found}");
        }
    }

    /// Below the shoulder of `neutral`, 4 % are subtracted, or x² · 6.25 of the least channel in dark colours. Above it, the values are computed
    /// with the specification's formulas in mpmath. Those of `filmic` are by the published code, in Python's floats.
    #[test]
    fn neutral_and_filmic_agree_with_what_is_published() {
        assert_eq!(neutral([0.0; 3]), [0.0; 3]);
        type Case = (fn(Rgb<f64>) -> Rgb<f64>, f64, Rgb<f64>, Rgb<f64>);
        let cases: [Case; 6] = [
            (neutral, 1e-14, [0.5, 0.3, 0.18], [0.46, 0.26, 0.14]),
            (neutral, 1e-14, [0.5, 0.3, 0.04], [0.47, 0.27, 0.01]),
            (
                neutral,
                1e-14,
                [5.0, 1.0, 0.5],
                [0.987_027_027_027_027, 0.488_269_822_908_046_4, 0.425_925_172_393_173_8],
            ),
            (filmic, 1e-12, [0.18; 3], [0.105_591_247_228_930_51, 0.105_591_247_228_930_57, 0.105_590_191_316_458_25]),
            (
                filmic,
                1e-12,
                [5.0, 1.0, 0.5],
                [1.019_079_531_132_495_6, 0.679_927_877_746_419_6, 0.476_660_108_374_171_7],
            ),
            (
                filmic,
                1e-12,
                [0.02, 0.03, 0.5],
                [-0.007_890_484_822_141_7, 0.006_139_906_733_382_7, 0.340_680_887_458_506_5],
            ),
        ];
        for (curve, tolerance, colour, expected) in cases {
            for (found, expected) in curve(colour).into_iter().zip(expected) {
                assert!((found - expected).abs() < tolerance, "{colour:?}: {found}");
            }
        }
    }

    /// The default leaves what is below its shoulder alone, also in the dark.
    #[test]
    fn soft_is_srgb_below_its_shoulder() {
        for colour in [[0.0; 3], [1e-6, 1e-3, 0.01], [0.02, 0.01, 0.03], [0.8, 0.5, 0.1]] {
            assert_eq!(Tonemap::Soft.compress(colour), colour);
        }
        // 1 - 0.2² / (1 + 0.2 - 0.8)
        assert!((Tonemap::Soft.compress([1.0; 3])[1] - 0.9).abs() < 1e-14);
    }

    #[test]
    fn curves_rise_without_a_jump_from_black_to_white() {
        for tonemap in Tonemap::value_variants() {
            let grey = |v: f64| codes(*tonemap, [v; 3])[0];
            assert_eq!(grey(0.0), 0.0, "{tonemap:?}");
            let mut last = 0.0;
            for i in 0..4000 {
                let value = grey(10f64.powf(f64::from(i) / 400.0 - 4.0));
                assert!(value >= last && value <= 255.0 && value - last < 1.0, "{tonemap:?} {i}: {value}");
                last = value;
            }
            assert!(last > 254.999, "{tonemap:?}: {last}");
            let codes_at = |peak: f64| codes(*tonemap, [peak, 0.5, 0.1]);
            let jumps = codes_at(0.8 - 1e-9).into_iter().zip(codes_at(0.8 + 1e-9)).map(|(a, b)| (a - b).abs());
            assert!(jumps.fold(0.0, f64::max) < 1e-5, "{tonemap:?}");
        }
    }

    /// The angle in Oklab, by Ottosson's own second matrix.
    fn hue(colour: Rgb<f64>) -> f64 {
        let cones = [
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ];
        let roots = product(&cones, colour).map(f64::cbrt);
        let axes = [
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ];
        let [a, b] = axes.map(|row: Rgb<f64>| row[0] * roots[0] + row[1] * roots[1] + row[2] * roots[2]);
        b.atan2(a).to_degrees()
    }

    /// Lamps of 1 to 1000 have the hue of dim ones. In linear light, as by `neutral`, the orange one turns pink.
    #[test]
    fn soft_keeps_the_hue_of_lamps() {
        let lamps = [
            [1.0, 0.33, 0.08],
            [0.05, 0.1, 1.0],
            [0.06, 1.0, 0.08],
            [1.0, 0.06, 0.04],
            [1.0, 0.06, 0.8],
            [1.0, 0.83, 0.05],
        ];
        let turned = |curve: fn(Rgb<f64>) -> Rgb<f64>, lamp: Rgb<f64>, brightness: f64| {
            let shown = curve(lamp.map(|v| v * brightness)).map(|v| v.clamp(0.0, 1.0));
            let turned = (hue(shown) - hue(lamp)).abs();
            turned.min(360.0 - turned)
        };
        for lamp in lamps {
            for brightness in [1.0, 3.0, 10.0, 30.0, 100.0, 1000.0] {
                let turned = turned(soft, lamp, brightness);
                assert!(turned < 0.1, "{lamp:?} x {brightness}: {turned} degrees");
            }
        }
        assert!(turned(neutral, lamps[0], 10.0) > 10.0 && turned(neutral, lamps[1], 10.0) > 10.0);
        // The codes of an ember, as the eye saw and chose them.
        let shown = codes(Tonemap::Soft, [6.0, 2.0, 0.5]).map(f64::round);
        assert_eq!(shown, [254.0, 175.0, 119.0]);
    }

    /// A lamp of one colour fades until it is white, but for clipped sRGB.
    #[test]
    fn bright_colours_fade_to_white() {
        for tonemap in [Tonemap::Soft, Tonemap::Neutral] {
            let orange = |brightness: f64| codes(tonemap, [brightness, brightness * 0.4, brightness * 0.1]);
            let difference = |[r, g, b]: Rgb<f64>| {
                assert!(r >= g && g >= b, "{tonemap:?}: {r} {g} {b}");
                r - b
            };
            let differences = [1.0, 4.0, 16.0, 64.0, 1e6].map(|brightness| difference(orange(brightness)));
            assert!(differences.is_sorted_by(|a, b| a > b) && differences[4] < 0.1, "{tonemap:?}: {differences:?}");
        }
        let far = codes(Tonemap::Filmic, [1e6, 0.0, 0.0]);
        assert!(far.iter().all(|v| *v > 240.0), "{far:?}");
    }

    #[test]
    fn pixels_of_any_value_have_bytes() {
        for tonemap in Tonemap::value_variants() {
            for exposure in [-1e9, -2.5, 0.0, 1.0, 1e9] {
                let view = ViewTransform { exposure, tonemap: *tonemap };
                for black in [0.0, -0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
                    assert_eq!(view.bytes([black; 3], (3, 5)), [0; 3], "{black} {view:?}");
                }
                assert_eq!(view.bytes([f32::INFINITY; 3], (3, 5)), [255; 3], "{view:?}");
                let [r, g, b] = view.bytes([f32::INFINITY, 0.5, f32::NAN], (3, 5));
                assert!(r >= g && g >= b, "{view:?}: {r} {g} {b}");
            }
        }
    }

    #[test]
    fn a_stop_is_twice_the_radiance() {
        for tonemap in Tonemap::value_variants() {
            let view = |exposure| ViewTransform { exposure, tonemap: *tonemap };
            let colour = [0.09, 0.045, 0.36];
            assert_eq!(view(1.0).bytes(colour, (7, 7)), view(0.0).bytes(colour.map(|v| 2.0 * v), (7, 7)));
            assert_ne!(view(1.0).bytes(colour, (7, 7)), view(0.0).bytes(colour, (7, 7)));
        }
    }

    /// Over 16 x 16 pixels the mean of the bytes is the value to 0.03 codes, wherever the patch lies. Rounding alone is off by up to 0.5.
    #[test]
    fn a_patch_has_the_mean_of_its_values() {
        let view = ViewTransform { exposure: 0.0, tonemap: Tonemap::Srgb };
        for i in 0..200u16 {
            let value = 0.003 + f32::from(i) * 0.001_37;
            let code = 255.0 * srgb(f64::from(value));
            let (left, top) = (usize::from(i) * 31, usize::from(i) * 97);
            let patch = (0..256).map(|i| (left + i % 16, top + i / 16));
            let mean = patch.map(|position| f64::from(view.bytes([value; 3], position)[1])).sum::<f64>() / 256.0;
            assert!((mean - code).abs() < 0.03, "{value}: {mean}, expected {code}");
        }
    }

    /// A gradient of two codes over 1024 columns: no column is of one code where the value lies between two, and grey stays grey.
    #[test]
    fn a_gradient_has_no_bands() {
        let view = ViewTransform { exposure: 0.0, tonemap: Tonemap::Soft };
        for x in 0..1024 {
            let value = 0.100 + 0.0045 * x as f32 / 1024.0;
            let code = 255.0 * srgb(f64::from(value));
            let column: Vec<[u8; 3]> = (0..64).map(|y| view.bytes([value; 3], (x, y))).collect();
            assert!(column.iter().all(|[r, g, b]| r == g && g == b));
            let mean = column.iter().map(|[r, ..]| f64::from(*r)).sum::<f64>() / 64.0;
            assert!((mean - code).abs() < 0.2, "{x}: {mean}, expected {code}");
        }
    }

    /// Bytes that a picture had come back: an image of 8 bits as a texture is shown as it is.
    #[test]
    fn integer_codes_stay() {
        let view = ViewTransform { exposure: 0.0, tonemap: Tonemap::Srgb };
        let linear = |code: u8| {
            let v = f64::from(code) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        for code in 0..=255 {
            for i in 0..64 {
                let found = view.bytes([linear(code) as f32; 3], (i % 8, i / 8))[0];
                // f32 moves a value by 1e-5 codes.
                assert!(found == code || threshold(i % 8, i / 8) < 1e-4 || threshold(i % 8, i / 8) > 1.0 - 1e-4);
            }
        }
    }
}
