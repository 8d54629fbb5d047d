//! Decodes the images that a scene names into linear Rec. 709.

mod budget;
mod exr;
mod jpeg;

use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageFormat, ImageReader, Limits, Pixel};

use super::Scene;
use super::assets::{Assets, Stamp};
use super::file::{self, Reading};
use super::findings::Findings;
use super::gltf::{self, Broken, Part};
use super::types::*;
use crate::error::Result;
use crate::guard::guarded;
use crate::source::Place;
use budget::Budget;

/// The memory that a decoder may take for what comes before the pixels. A PNG's colour profile is the largest of it.
const HEADERS: u64 = 64 << 20;

/// Decodes every image of the scene once. The keys are the paths as the scene file writes them. Errors point at the `path` field.
pub fn load_all(scene: &Scene, reading: Reading, findings: &mut Findings, assets: &mut Assets) -> Bitmaps {
    let mut loader =
        Loader { scene, reading, assets, budget: Budget::default(), bitmaps: Bitmaps::new(), found: HashSet::new() };
    let top = scene.top();
    if let Background::Image { path } = &scene.background {
        let background = top.field("background");
        let at = background.variant("Image");
        findings.note(loader.load(&at.field("path"), path, Colour::ONE, Use::Radiance));
    }
    let materials = top.field("materials");
    for (name, material) in &scene.materials {
        for slot in material.model().slots() {
            let Texture::Image { path, tint } = slot.texture else { continue };
            let at = materials.key(name);
            let at = at.variant(material.name());
            let at = at.field(slot.field.name);
            let at = at.variant(slot.texture.name());
            findings.note(loader.load(&at.field("path"), path, *tint, slot.usage));
        }
    }
    loader.bitmaps
}

struct Loader<'a> {
    scene: &'a Scene,
    reading: Reading,
    assets: &'a mut Assets,
    budget: Budget,
    bitmaps: Bitmaps,
    /// The paths of files that have been looked at, good or not.
    found: HashSet<String>,
}

impl Loader<'_> {
    fn load(&mut self, at: &Place, path: &str, tint: Colour, usage: Use) -> Result<()> {
        let file = self.scene.source.resolve(path);
        let (name, part) = gltf::split(&file);
        let broken = |Broken { at: part, reason }| at.error_in(&name, &part, &reason);
        let wrong = |reason: String| {
            let part = part.map_or(String::new(), |part| part.to_json());
            broken(Broken::new(part, reason))
        };
        if self.found.insert(path.to_owned()) {
            let files = self.assets.note(&file);
            match self.reading {
                Reading::IfThere => _ = file::find(&name, "image", file::LONGEST).map_err(wrong)?,
                Reading::Whole => {
                    let bitmap = self.read(&file, files).map_err(broken)?;
                    self.budget.add(bitmap.texels.len());
                    self.bitmaps.insert(path.to_owned(), bitmap);
                }
            }
        }
        self.bitmaps.get(path).map_or(Ok(()), |bitmap| usage.check_texels(bitmap, tint).map_err(wrong))
    }
}

impl Loader<'_> {
    /// An image that has been decoded before, or is now.
    fn read(&mut self, file: &Path, files: Vec<(PathBuf, Stamp)>) -> gltf::Result<Bitmap> {
        if let Some(bitmap) = self.assets.bitmap(file, &files) {
            self.budget.check((bitmap.width as usize, bitmap.height as usize), 0)?;
            return Ok(bitmap);
        }
        let bitmap = match gltf::split(file) {
            (name, Some(part @ Part::Image(index))) => {
                let file = self.assets.gltf.open(&name, &mut |_, _, _| {})?;
                let bytes = file.image(index)?;
                decode(&bytes, None, &self.budget).map_err(|reason| Broken::new(part.to_json(), reason))?
            }
            (_, Some(_)) => return Err("expected an image, such as #images/0".to_owned().into()),
            (_, None) => {
                let bytes = file::read(file, "image", file::LONGEST)?;
                decode(&bytes, ImageFormat::from_path(file).ok(), &self.budget)?
            }
        };
        self.assets.keep_bitmap(file, files, bitmap.clone());
        Ok(bitmap)
    }
}

/// The mean of an image's codes, each from 0 to 1: of numbers that are no colours.
pub fn mean_code(bytes: &[u8]) -> std::result::Result<[f64; 3], String> {
    let bitmap = decode(bytes, None, &Budget::default())?;
    let mut sums = [0.0; 3];
    for texel in bitmap.texels.iter() {
        sums.iter_mut().zip(texel).for_each(|(sum, light)| *sum += to_srgb(f64::from(*light)));
    }
    Ok(sums.map(|sum| sum / bitmap.texels.len().max(1) as f64))
}

/// Decodes the bytes of a file, whose name may say its format. Images of floats, such as .exr and .hdr, are linear; all others are sRGB. Alpha is
/// ignored, and grey becomes a colour.
fn decode(bytes: &[u8], by_name: Option<ImageFormat>, budget: &Budget) -> std::result::Result<Bitmap, String> {
    let bitmap = guarded(|| match bytes.starts_with(&exr::MAGIC) {
        true => exr::decode(bytes, budget),
        false => decode_other(bytes, by_name, budget),
    });
    bitmap.and_then(|bitmap| bitmap).map_err(|reason| format!("cannot decode the image: {reason}"))
}

fn decode_other(bytes: &[u8], by_name: Option<ImageFormat>, budget: &Budget) -> std::result::Result<Bitmap, String> {
    // The content identifies the format more reliably than the file's name, except for .tga, which has no magic number.
    let format = image::guess_format(bytes).ok().or(by_name).ok_or("its format is not known")?;
    let image = match format {
        ImageFormat::Jpeg => jpeg::decode(bytes, budget)?,
        _ => decode_with_image(bytes, format, budget)?,
    };
    Ok(Bitmap { width: image.width(), height: image.height(), texels: Arc::new(linear(image)) })
}

/// Decodes a file with the crate `image`.
fn decode_with_image(bytes: &[u8], format: ImageFormat, budget: &Budget) -> std::result::Result<DynamicImage, String> {
    let text = |error: image::ImageError| error.to_string();
    let at_most = |bytes: u64| {
        let mut limits = Limits::default();
        limits.max_alloc = Some(bytes);
        limits
    };
    if format == ImageFormat::WebP {
        check_riff(bytes)?;
    }
    let mut reader = ImageReader::new(Cursor::new(bytes));
    reader.set_format(format);
    reader.limits(at_most(HEADERS));
    let mut decoder = reader.into_decoder().map_err(text)?;
    // The times that a decoder has the picture in memory.
    let times = match format {
        ImageFormat::Tiff => 2,
        ImageFormat::WebP => 3,
        _ => 1,
    };
    let picture = decoder.total_bytes().saturating_mul(times);
    let (width, height) = decoder.dimensions();
    budget.check((width as usize, height as usize), picture.saturating_add(bytes.len() as u64))?;
    decoder.set_limits(at_most(picture.saturating_add(HEADERS))).map_err(text)?;
    DynamicImage::from_decoder(decoder).map_err(text)
}

/// Checks that a WebP file has the length that it declares (RFC 9649, 2.4). The decoder takes what is missing for zeros.
fn check_riff(bytes: &[u8]) -> std::result::Result<(), String> {
    let declared = bytes.get(4..8).and_then(|size| size.try_into().ok()).map_or(0, u32::from_le_bytes);
    let declared = u64::from(declared) + 8;
    match bytes.len() as u64 >= declared {
        true => Ok(()),
        false => Err(format!("expected {declared} bytes, found {}: it is not complete", bytes.len())),
    }
}

/// The linear texels of a decoded image.
fn linear(image: DynamicImage) -> Vec<[f32; 3]> {
    let table: Vec<f32> = (0..=u8::MAX).map(|c| from_srgb(f64::from(c) / 255.0)).collect();
    let of_8_bits = |c: u8| table.get(usize::from(c)).copied().unwrap_or_default();
    let of_16_bits = |c: u16| from_srgb(f64::from(c) / 65535.0);
    let of_float = |c: f32| c;
    match image {
        DynamicImage::ImageLuma8(image) => texels(&image, of_8_bits),
        DynamicImage::ImageLumaA8(image) => texels(&image, of_8_bits),
        DynamicImage::ImageRgb8(image) => texels(&image, of_8_bits),
        DynamicImage::ImageRgba8(image) => texels(&image, of_8_bits),
        DynamicImage::ImageLuma16(image) => texels(&image, of_16_bits),
        DynamicImage::ImageLumaA16(image) => texels(&image, of_16_bits),
        DynamicImage::ImageRgb16(image) => texels(&image, of_16_bits),
        DynamicImage::ImageRgba16(image) => texels(&image, of_16_bits),
        DynamicImage::ImageRgb32F(image) => texels(&image, of_float),
        DynamicImage::ImageRgba32F(image) => texels(&image, of_float),
        // The crate may add kinds.
        other => texels(&other.into_rgb32f(), of_float),
    }
}

/// Pixels one by one, because the crate would convert an image into a copy.
fn texels<P: Pixel>(image: &ImageBuffer<P, Vec<P::Subpixel>>, decoded: impl Fn(P::Subpixel) -> f32) -> Vec<[f32; 3]> {
    image.pixels().map(|pixel| pixel.to_rgb().0.map(&decoded)).collect()
}

/// The linear value of an sRGB code in 0..=1 (IEC 61966-2-1).
fn from_srgb(code: f64) -> f32 {
    let light = if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
    light as f32
}

/// The sRGB code of a linear value in 0..=1.
fn to_srgb(light: f64) -> f64 {
    if light <= 0.003_130_804_95 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::{from_srgb, to_srgb};

    #[test]
    fn codes_come_back() {
        for code in 0..=255u8 {
            let code = f64::from(code) / 255.0;
            assert!((to_srgb(f64::from(from_srgb(code))) - code).abs() < 1e-6);
        }
    }

    #[test]
    fn decodes_srgb() {
        assert_eq!(from_srgb(0.0), 0.0);
        assert_eq!(from_srgb(1.0), 1.0);
        // Values of the standard, and the code at which its two parts join.
        assert!((f64::from(from_srgb(188.0 / 255.0)) - 0.502_886_5).abs() < 1e-6);
        assert!((f64::from(from_srgb(0.04045)) - 0.003_130_804_95).abs() < 1e-9);
    }
}
