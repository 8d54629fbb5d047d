//! PNG files for the screen: exposure, tone mapping, sRGB, 8 bits.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::data::{Rgb, srgb};
use crate::error::{Error, Result};
use crate::output::{atomic, magma::magma};

/// Exposures beyond this, of either sign, make every f32 white or black.
const MAX_EXPOSURE: f64 = 300.0;

/// Writes a picture as an 8-bit sRGB PNG, brightened by 2^`exposure_ev`, tone-mapped by [`neutral`]. `rgb` tells the colour of a pixel, row 0 on
/// top. It takes up to 7 bytes of memory a pixel.
pub fn write_png(path: &Path, size: (u32, u32), rgb: &dyn Fn(usize) -> Rgb<f32>, exposure_ev: f64) -> Result<()> {
    if exposure_ev.is_nan() {
        return Err(Error::Usage("the exposure is not a number".into()));
    }
    let exposure = exposure_ev.clamp(-MAX_EXPOSURE, MAX_EXPOSURE).exp2();
    let pixels: Vec<_> = (0..size.0 as usize * size.1 as usize).map(|index| shown(rgb(index), exposure)).collect();
    let bytes = compress(size, &pixels);
    let bytes = bytes.map_err(|reason| failed(path, reason))?;
    atomic::write(path, &bytes)
}

/// Writes values of 0..1, with row 0 at the top, as a PNG in magma colours: from black through red to pale yellow.
pub fn write_heatmap(path: &Path, size: (u32, u32), values: &[f32]) -> Result<()> {
    let bytes = heatmap(size, values).map_err(|reason| failed(path, reason))?;
    atomic::write(path, &bytes)
}

/// The bytes that [`write_png`] writes with an exposure of 0. The error is a reason in words.
pub fn picture(size: (u32, u32), rgb: &[[f32; 3]]) -> std::result::Result<Vec<u8>, String> {
    compress(size, &rgb.iter().map(|rgb| shown(*rgb, 1.0)).collect::<Vec<_>>())
}

/// The bytes that [`write_heatmap`] writes. The error is a reason in words.
pub fn heatmap(size: (u32, u32), values: &[f32]) -> std::result::Result<Vec<u8>, String> {
    compress(size, &values.iter().map(|&value| magma(f64::from(value))).collect::<Vec<_>>())
}

fn shown(rgb: Rgb<f32>, exposure: f64) -> [u8; 3] {
    encode(rgb.map(|v| f64::from(v) * exposure))
}

fn failed(path: &Path, reason: String) -> Error {
    Error::File { path: path.to_owned(), action: "write", reason }
}

/// Encodes in memory, so that the encoder cannot hide an error of the disk. The PNG is small relative to the film.
fn compress((width, height): (u32, u32), pixels: &[[u8; 3]]) -> std::result::Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let written =
        PngEncoder::new(&mut bytes).write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8);
    written.map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Linear radiance to sRGB bytes for the screen.
fn encode(color: [f64; 3]) -> [u8; 3] {
    // `as` saturates.
    neutral(color).map(|v| (srgb(v) * 255.0).round() as u8)
}

/// Khronos PBR Neutral tone mapper (github.com/KhronosGroup/ToneMapping, PBR_Neutral/README.md, "PBR Neutral
/// Specification", 2024): linear Rec. 709 of any brightness ≥ 0 to 0..1. Below its shoulder it subtracts the 4 % that a
/// dielectric's reflection of white adds to a base colour, so that the displayed colour is the base colour.
fn neutral(color: [f64; 3]) -> [f64; 3] {
    /// The Fresnel reflection at normal incidence that the colours are assumed to contain.
    const F90: f64 = 0.04;
    /// The brightness at which compression starts.
    const SHOULDER: f64 = 0.8 - F90;
    /// How fast highlights lose their colour.
    const DESATURATION: f64 = 0.15;

    let least = color[0].min(color[1]).min(color[2]);
    let offset = if least < 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = color.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak <= SHOULDER {
        return color;
    }
    let range = 1.0 - SHOULDER;
    let new_peak = 1.0 - range * range / (peak + range - SHOULDER);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|v| v * (new_peak / peak) * (1.0 - white) + new_peak * white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_agrees_with_known_values() {
        for (linear, byte) in
            [(0.0, 0.0), (0.003_130_8, 10.3147), (0.18, 117.6458), (0.214_041, 127.5), (0.5, 187.516), (1.0, 255.0)]
        {
            assert!((srgb(linear) * 255.0 - byte).abs() < 1e-3, "{linear}: {}", srgb(linear) * 255.0);
        }
    }

    #[test]
    fn neutral_agrees_with_the_specification() {
        assert_eq!(neutral([0.0; 3]), [0.0; 3]);
        // Below the shoulder, 4 % are subtracted, or x² · 6.25 of the least channel in dark colours.
        // Above the shoulder, the values are computed with the specification's formulas in mpmath.
        let cases = [
            ([0.5, 0.3, 0.18], [0.46, 0.26, 0.14]),
            ([0.5, 0.3, 0.04], [0.47, 0.27, 0.01]),
            ([5.0, 1.0, 0.5], [0.987_027_027_027_027, 0.488_269_822_908_046_4, 0.425_925_172_393_173_8]),
        ];
        for (color, expected) in cases {
            for (found, expected) in neutral(color).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{color:?}: {found}");
            }
        }
    }

    #[test]
    fn neutral_is_continuous_rising_and_below_one() {
        let grey = |v: f64| neutral([v; 3])[0];
        let mut last = 0.0;
        for i in 1..4000 {
            let value = grey(10f64.powf(f64::from(i) / 400.0 - 4.0));
            assert!(value > last && value < 1.0 && value - last < 0.01, "{i}: {value}");
            last = value;
        }
        assert!((neutral([0.799_999_999, 0.5, 0.5])[0] - neutral([0.800_000_001, 0.5, 0.5])[0]).abs() < 1e-8);
    }

    #[test]
    fn black_grey_and_very_bright() {
        assert_eq!(encode([0.0; 3]), [0; 3]);
        // Grey of 18 %: 14 % after the offset, sRGB 104.56.
        assert_eq!(encode([0.18; 3]), [105; 3]);
        assert_eq!(encode([f64::from(f32::MAX) * 2f64.powi(300); 3]), [255; 3]);
        // A very bright colour becomes white, not a clipped primary.
        assert_eq!(encode([1e6, 0.0, 0.0]), [255; 3]);
        assert_eq!(encode([1.0, 0.0, 0.0])[1], encode([1.0, 0.0, 0.0])[2]);
    }

    #[test]
    fn the_file_holds_the_exposed_picture_row_0_on_top() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb = [[0.09, 0.045, 0.36], [0.0; 3], [100.0, 0.0, 0.0], [1.0, 0.5, 0.25], [0.2; 3], [f32::MAX; 3]];
        for ev in [-2.5, 0.0, 1.0, 1e9, -1e9] {
            write_png(&path, (3, 2), &|index| rgb[index], ev).unwrap();
            let read = image::open(&path).unwrap().into_rgb8();
            assert_eq!(read.dimensions(), (3, 2));
            for (i, pixel) in read.pixels().enumerate() {
                let expected = encode(rgb[i].map(|v| f64::from(v) * ev.clamp(-300.0, 300.0).exp2()));
                assert_eq!(pixel.0, expected, "pixel {i} at {ev} EV");
            }
        }
        // One stop is twice the radiance.
        write_png(&path, (3, 2), &|index| rgb[index], 1.0).unwrap();
        assert_eq!(
            image::open(&path).unwrap().into_rgb8().get_pixel(0, 0).0,
            encode([0.18f32, 0.09, 0.72].map(f64::from))
        );
        assert!(write_png(&path, (3, 2), &|index| rgb[index], f64::NAN).is_err());
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_png(&folder.path().join("a.png"), (0, 0), &|_| [0.0; 3], 0.0).is_err());
        assert!(!folder.path().join("a.png").exists());
    }
}
