//! PNG files for the screen.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::data::Rgb;
use crate::error::{Error, Result};
use crate::output::{atomic, magma::magma, view_transform::ViewTransform};

/// Writes a picture as an 8-bit sRGB PNG. `rgb` returns the radiance of a pixel, row 0 on top. It takes up to 7 bytes of memory a pixel.
pub fn write_png(path: &Path, size: (u32, u32), rgb: &dyn Fn(usize) -> Rgb<f32>, view: &ViewTransform) -> Result<()> {
    let bytes = encode(size, rgb, view).map_err(Error::file(path, "write"))?;
    atomic::write(path, &bytes)
}

/// Writes values of 0..1, with row 0 at the top, as a PNG in magma colours: from black through red to pale yellow.
pub fn write_heatmap(path: &Path, size: (u32, u32), values: &[f32]) -> Result<()> {
    let bytes = heatmap(size, values).map_err(Error::file(path, "write"))?;
    atomic::write(path, &bytes)
}

/// The bytes that [`write_png`] writes by default. The error is a reason in words.
pub fn picture(size: (u32, u32), rgb: &[Rgb<f32>]) -> std::result::Result<Vec<u8>, String> {
    encode(size, &|index| rgb.get(index).copied().unwrap_or_default(), &ViewTransform::default())
}

/// The bytes that [`write_heatmap`] writes. The error is a reason in words.
pub fn heatmap(size: (u32, u32), values: &[f32]) -> std::result::Result<Vec<u8>, String> {
    compress(size, &values.iter().map(|&value| magma(f64::from(value))).collect::<Vec<_>>())
}

fn encode(
    size: (u32, u32),
    rgb: &dyn Fn(usize) -> Rgb<f32>,
    view: &ViewTransform,
) -> std::result::Result<Vec<u8>, String> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels: Vec<_> = positions.map(|(x, y)| view.bytes(rgb(y * width + x), (x, y))).collect();
    compress(size, &pixels)
}

/// The bytes of a PNG. Encodes in memory, so that the encoder cannot hide an error of the disk. The PNG is small relative to the film.
pub(super) fn compress((width, height): (u32, u32), pixels: &[[u8; 3]]) -> std::result::Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let written =
        PngEncoder::new(&mut bytes).write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8);
    written.map_err(|error| error.to_string())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::view_transform::Tonemap;

    #[test]
    fn the_file_holds_the_picture_row_0_on_top() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb = [[0.09, 0.045, 0.36], [0.0; 3], [100.0, 0.0, 0.0], [1.0, 0.5, 0.25], [0.2; 3], [f32::MAX; 3]];
        let view = ViewTransform { exposure: 1.0, tonemap: Tonemap::Neutral };
        write_png(&path, (3, 2), &|index| rgb[index], &view).unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (3, 2));
        for (i, pixel) in read.pixels().enumerate() {
            assert_eq!(pixel.0, view.bytes(rgb[i], (i % 3, i / 3)), "pixel {i}");
        }
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_png(&folder.path().join("a.png"), (0, 0), &|_| [0.0; 3], &ViewTransform::default()).is_err());
        assert!(!folder.path().join("a.png").exists());
    }
}
