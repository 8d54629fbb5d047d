//! Decodes the images that a scene names.

mod budget;
mod exr;
mod jpeg;
mod ktx2;
mod pack;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::assets::{Assets, Decoded, Stamp};
use super::file::{self, Reading};
use super::findings::Findings;
use super::gltf::{self, GltfError};
use super::gltf_path::{Part, split};
use super::model::Scene;
use super::types::*;
use crate::bitmap::Decoding;
use crate::error::Result;
use crate::guard::guarded;
use crate::source::ValuePath;
use budget::{Budget, Wanted};

/// The memory that a decoder may take for what comes before the pixels. A PNG's colour profile is the largest of it.
const HEADERS: u64 = 64 << 20;

/// Decodes every image of the scene once, in all ways that the scene uses. The keys are the paths as the scene file writes them. Errors
/// point at the `path` field.
pub fn load_all(scene: &Scene, reading: Reading, findings: &mut Findings, assets: &mut Assets) -> Bitmaps {
    let mut wanted: HashMap<String, BTreeSet<Decoding>> = HashMap::new();
    visit_images(scene, &mut |_, path, decoding, _, _| {
        wanted.entry(path.to_owned()).or_default().insert(decoding);
    });
    let mut loader = Loader {
        scene,
        reading,
        assets,
        wanted,
        budget: Budget::default(),
        bitmaps: Bitmaps::default(),
        found: HashSet::new(),
    };
    visit_images(scene, &mut |at, path, decoding, tint, usage| {
        findings.record(loader.load(at, path, decoding, tint, usage));
    });
    if let Background::Image { path, layout: SkyLayout::Octahedral, .. } = &scene.background
        && let Some(Bitmap { width, height, .. }) = loader.bitmaps.colours(path).filter(|own| own.width != own.height)
    {
        let top = scene.top();
        let background = top.field("background");
        let message =
            format!("{path}: expected a square, as its layout is Octahedral, found {width} by {height} texels");
        findings.refuse(background.variant("Image").field("path").error(&message));
    }
    loader.bitmaps
}

/// Visits the values of a scene that name images, each with its `path` field, how the file is decoded, and what the texels mean.
pub fn visit_images(scene: &Scene, visit: &mut dyn FnMut(&ValuePath, &str, Decoding, Colour, Use)) {
    let top = scene.top();
    if let Background::Image { path, tint, .. } = &scene.background {
        let background = top.field("background");
        let at = background.variant("Image");
        visit(&at.field("path"), path, Decoding::Colour, *tint, Use::Radiance);
    }
    let materials = top.field("materials");
    for (name, material) in &scene.materials {
        for slot in material.model().slots() {
            let Texture::Image { path, tint, .. } = slot.texture else { continue };
            let decoding = slot.texture.decoded().map_or(Decoding::Colour, |(_, decoding)| decoding);
            let at = materials.key(name);
            let at = at.variant(material.name());
            let at = at.field(slot.field.name);
            let at = at.variant(slot.texture.name());
            visit(&at.field("path"), path, decoding, *tint, slot.usage);
        }
    }
}

struct Loader<'a> {
    scene: &'a Scene,
    reading: Reading,
    assets: &'a mut Assets,
    /// How each file is to be decoded, by its path.
    wanted: HashMap<String, BTreeSet<Decoding>>,
    budget: Budget,
    bitmaps: Bitmaps,
    /// The paths of files that have been looked at, good or not.
    found: HashSet<String>,
}

impl Loader<'_> {
    fn load(&mut self, at: &ValuePath, path: &str, decoding: Decoding, tint: Colour, usage: Use) -> Result<()> {
        let file = self.scene.source.resolve(path);
        let (name, part) = split(&file);
        let broken = |GltfError { at: part, reason }| at.error_in(&name, &part, &reason);
        let wrong = |reason: String| {
            let part = part.map_or(String::new(), |part| part.to_json());
            broken(GltfError::new(part, reason))
        };
        let is_first = self.found.insert(path.to_owned());
        if let (true, Some(made)) = (is_first, self.scene.bitmaps.colours(path)) {
            // No file has it.
            let size = (made.width as usize, made.height as usize);
            self.budget.check(size, |_| made.bytes(), 0).map_err(wrong)?;
            self.budget.add(path, made);
            for decoding in self.wanted.remove(path).unwrap_or_default() {
                self.bitmaps.insert(path, decoding, made.clone());
            }
        } else if is_first {
            let files = self.assets.stamp_files(&file);
            match self.reading {
                Reading::IfThere => _ = file::find(&name, "image", file::LONGEST).map_err(wrong)?,
                Reading::Complete => {
                    let decodings = self.wanted.remove(path).unwrap_or_default();
                    for (decoding, bitmap) in
                        read(&file, files, &decodings, &self.budget, self.assets).map_err(broken)?
                    {
                        self.budget.add(path, &bitmap);
                        self.bitmaps.insert(path, decoding, bitmap);
                    }
                }
            }
        }
        self.bitmaps.get(path, decoding).map_or(Ok(()), |bitmap| usage.check_texels(bitmap, tint).map_err(wrong))
    }
}

/// An image that has been decoded before, or is now.
fn read(
    file: &Path,
    files: Vec<(PathBuf, Stamp)>,
    decodings: &BTreeSet<Decoding>,
    budget: &Budget,
    assets: &mut Assets,
) -> gltf::Result<Decoded> {
    let wanted = Wanted { decodings, budget };
    if let Some(decoded) = assets.bitmaps(file, &files, decodings) {
        let size = decoded.first().map_or((1, 1), |(_, bitmap)| (bitmap.width as usize, bitmap.height as usize));
        budget.check(size, |_| decoded.iter().map(|(_, bitmap)| bitmap.bytes()).sum(), 0)?;
        return Ok(decoded);
    }
    let decoded = match split(file) {
        (name, Some(part @ Part::Image(index))) => {
            let file = assets.gltf.open(&name, &mut |_, _, _| {})?;
            let bytes = file.image(index)?;
            decode(&bytes, None, &wanted).map_err(|reason| GltfError::new(part.to_json(), reason))?
        }
        (_, Some(_)) => return Err("expected an image, such as #images/0".to_owned().into()),
        (_, None) => {
            let bytes = file::read(file, "image", file::LONGEST)?;
            decode(&bytes, ImageFormat::from_path(file).ok(), &wanted)?
        }
    };
    assets.keep_bitmaps(file, files, decoded.clone());
    Ok(decoded)
}

/// The image of a file that a scene does not name, but is made from.
pub fn load(file: &Path, decoding: Decoding, assets: &mut Assets) -> std::result::Result<Bitmap, String> {
    let files = assets.stamp_files(file);
    let decoded = read(file, files, &BTreeSet::from([decoding]), &Budget::default(), assets);
    let decoded = decoded.map_err(|error| error.reason)?.pop();
    decoded.map(|(_, bitmap)| bitmap).ok_or_else(|| "it has no image".to_owned())
}

/// Decodes the bytes of a file, whose name may say its format. Images of floats, such as .exr and .hdr, are linear; the colours of all
/// others are sRGB.
fn decode(bytes: &[u8], by_name: Option<ImageFormat>, wanted: &Wanted) -> std::result::Result<Decoded, String> {
    let decoded = guarded(|| match bytes.starts_with(&exr::MAGIC) {
        true => exr::decode(bytes, wanted),
        false => {
            // The content identifies the format more reliably than the file's name, except for .tga, which has no magic number.
            let image = match image::guess_format(bytes).ok().or(by_name) {
                _ if bytes.starts_with(&ktx2::MAGIC) => ktx2::decode(bytes, wanted)?,
                Some(ImageFormat::Jpeg) => jpeg::decode(bytes, wanted)?,
                Some(format) => decode_with_image(bytes, format, wanted)?,
                None => return Err("its format is not known".to_owned()),
            };
            Ok(wanted.decodings.iter().map(|decoding| (*decoding, pack::bitmap(&image, *decoding))).collect())
        }
    });
    let mut decoded =
        decoded.and_then(|decoded| decoded).map_err(|reason| format!("cannot decode the image: {reason}"))?;
    decoded.iter_mut().filter(|(decoding, _)| *decoding == Decoding::Colour).for_each(|(_, bitmap)| bitmap.clean());
    Ok(decoded)
}

/// Decodes a file with the crate `image`.
fn decode_with_image(bytes: &[u8], format: ImageFormat, wanted: &Wanted) -> std::result::Result<DynamicImage, String> {
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
    let of_bytes = decoder.color_type().bytes_per_pixel() == decoder.color_type().channel_count();
    wanted.check((width as usize, height as usize), of_bytes, picture.saturating_add(bytes.len() as u64))?;
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
