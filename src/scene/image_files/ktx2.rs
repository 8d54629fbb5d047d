//! Decodes textures of Basis Universal in KTX2 with the crate `basisu`.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::{DynamicImage, RgbaImage};

use super::budget::Wanted;

/// The first bytes of a file (KTX File Format Specification 2.0, section 3.1).
pub const MAGIC: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

pub fn decode(bytes: &[u8], wanted: &Wanted) -> Result<DynamicImage, String> {
    let text = |error: basisu::Error| format!("{error:?}");
    let texture = Transcoder::new(bytes).map_err(|_| "expected a KTX2 file of Basis Universal that is complete")?;
    let (width, height) = texture.base_dimensions();
    // A block of 4 by 4 texels has 16 bytes, and 64 as texels.
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    wanted.check(
        (width as usize, height as usize),
        true,
        blocks.saturating_mul(80).saturating_add(bytes.len() as u64),
    )?;
    // The decoder takes as much memory as the first level claims to have (section 3.9.3).
    let claimed = bytes.get(96..104).and_then(|length| length.try_into().ok()).map_or(0, u64::from_le_bytes);
    if claimed > 16 * blocks {
        return Err(format!("expected at most {} bytes of blocks, found {claimed}", 16 * blocks));
    }
    let texels = texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(text)?;
    let image = RgbaImage::from_raw(width, height, texels).map(DynamicImage::from);
    image.ok_or_else(|| "it does not have the size that it declares".to_owned())
}
