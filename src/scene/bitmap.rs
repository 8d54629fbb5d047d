//! Decodes the images that a scene names into linear Rec. 709.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{MetaData, ReadChannels, ReadLayers};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::Scene;
use super::types::*;
use crate::error::Result;
use crate::source::Place;

/// The largest width or height of an image.
const LARGEST_SIDE: u32 = 16384;
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Decodes every image of the scene once. The keys are the paths as the scene file writes them. Errors point at the `path` field.
pub fn load_all(scene: &Scene) -> Result<Bitmaps> {
    let mut bitmaps = Bitmaps::new();
    let top = scene.top();
    if let Background::Image { path } = &scene.background {
        let background = top.field("background");
        let at = background.variant("Image");
        load(scene, &at.field("path"), path, Use::Radiance, &mut bitmaps)?;
    }
    let materials = top.field("materials");
    for (name, material) in &scene.materials {
        if let Some(slot) = material.model().slot
            && let Some(path) = slot.texture.image()
        {
            let at = materials.key(name);
            let at = at.variant(material.name());
            let at = at.field(slot.field);
            let at = at.variant(slot.texture.name());
            load(scene, &at.field("path"), path, slot.usage, &mut bitmaps)?;
        }
    }
    Ok(bitmaps)
}

fn load(scene: &Scene, at: &Place, path: &str, usage: Use, bitmaps: &mut Bitmaps) -> Result<()> {
    let file = scene.source.resolve(path);
    let wrong = |reason: String| at.error(format!("{}: {reason}", file.display()));
    if !bitmaps.contains_key(path) {
        bitmaps.insert(path.to_owned(), decode(&file).map_err(wrong)?);
    }
    match bitmaps.get(path) {
        Some(bitmap) => usage.check_texels(bitmap).map_err(wrong),
        None => Ok(()),
    }
}

/// Decodes one file. Images of floats, such as .exr and .hdr, are linear; all others are sRGB. Alpha is
/// ignored, and grey becomes a colour.
fn decode(path: &Path) -> std::result::Result<Bitmap, String> {
    let cannot = |reason: std::io::Error| format!("cannot read the image: {reason}");
    if !std::fs::metadata(path).map_err(cannot)?.is_file() {
        return Err("cannot read the image: it is not a file".to_owned());
    }
    let bytes = std::fs::read(path).map_err(cannot)?;
    let bitmap = if bytes.starts_with(&EXR_MAGIC) {
        decode_exr(&bytes)
    } else {
        decode_other(&bytes, ImageFormat::from_path(path).ok())
    };
    bitmap.map_err(|reason| format!("cannot decode the image: {reason}"))
}

fn decode_exr(bytes: &[u8]) -> std::result::Result<Bitmap, String> {
    let text = |error: exr::error::Error| error.to_string();
    // The sizes are checked first, because the crate allocates memory for all pixels before it reads them.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    for header in &meta.headers {
        fits(header.layer_size.width(), header.layer_size.height())?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0; 3]; size.area()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| {
                if let Some(texel) = texels.get_mut(at.y() * *width + at.x()) {
                    *texel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(text)?;
    let layer = image.layer_data;
    Ok(Bitmap {
        width: layer.size.width() as u32,
        height: layer.size.height() as u32,
        texels: layer.channel_data.pixels.1,
    })
}

fn decode_other(bytes: &[u8], by_name: Option<ImageFormat>) -> std::result::Result<Bitmap, String> {
    let text = |error: image::ImageError| error.to_string();
    let mut reader = ImageReader::new(Cursor::new(bytes));
    // The content identifies the format more reliably than the file's name, except for .tga, which has no magic number.
    let format = image::guess_format(bytes).ok().or(by_name);
    reader.set_format(format.ok_or("its format is not known")?);
    reader.limits(limits());
    let decoder = reader.into_decoder().map_err(text)?;
    let (width, height) = decoder.dimensions();
    fits(width as usize, height as usize)?;
    let image = DynamicImage::from_decoder(decoder).map_err(text)?;
    Ok(Bitmap { width, height, texels: linear(image) })
}

/// Limits the decoder to the memory that the largest image of four 32-bit channels needs.
fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(16 * u64::from(LARGEST_SIDE).pow(2));
    limits
}

fn fits(width: usize, height: usize) -> std::result::Result<(), String> {
    let sides = 1..=LARGEST_SIDE as usize;
    if sides.contains(&width) && sides.contains(&height) {
        return Ok(());
    }
    Err(format!("expected a width and height from 1 to {LARGEST_SIDE}, found {width} by {height}"))
}

/// The linear texels of a decoded image.
fn linear(image: DynamicImage) -> Vec<[f32; 3]> {
    match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            image.into_rgb32f().pixels().map(|pixel| pixel.0).collect()
        }
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => {
            let table: Vec<f32> = (0..=u8::MAX).map(|c| from_srgb(f64::from(c) / 255.0)).collect();
            let decoded = |c: u8| table.get(usize::from(c)).copied().unwrap_or_default();
            image.into_rgb8().pixels().map(|pixel| pixel.0.map(decoded)).collect()
        }
        _ => {
            let decoded = |c: u16| from_srgb(f64::from(c) / 65535.0);
            image.into_rgb16().pixels().map(|pixel| pixel.0.map(decoded)).collect()
        }
    }
}

/// The linear value of an sRGB code in 0..=1 (IEC 61966-2-1).
fn from_srgb(code: f64) -> f32 {
    let light = if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
    light as f32
}

#[cfg(test)]
mod tests {
    use super::from_srgb;

    #[test]
    fn decodes_srgb() {
        assert_eq!(from_srgb(0.0), 0.0);
        assert_eq!(from_srgb(1.0), 1.0);
        // Values of the standard, and the code at which its two parts join.
        assert!((f64::from(from_srgb(188.0 / 255.0)) - 0.502_886_5).abs() < 1e-6);
        assert!((f64::from(from_srgb(0.04045)) - 0.003_130_804_95).abs() < 1e-9);
    }
}
