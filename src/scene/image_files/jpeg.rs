//! Decodes JPEG with the crate `zune-jpeg`, which `image` uses too. `image` makes it decode damaged files, which
//! would give a picture that is half grey.

use image::{DynamicImage, GrayImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::budget::Wanted;

pub fn decode(bytes: &[u8], wanted: &Wanted) -> Result<DynamicImage, String> {
    let text = |error: zune_jpeg::errors::DecodeErrors| format!("{error:?}");
    let options = DecoderOptions::default().set_strict_mode(true).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(text)?;
    let info = decoder.info().ok_or("it has no header")?;
    let is_grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let (colours, space) = if is_grey { (1, ColorSpace::Luma) } else { (3, ColorSpace::RGB) };
    // A progressive file keeps a coefficient of 16 bits for each component of a pixel.
    let size = (usize::from(info.width), usize::from(info.height));
    let per_pixel = colours + 2 * u64::from(info.components);
    wanted.check(size, true, bytes.len() as u64 + per_pixel * (size.0 * size.1) as u64)?;
    if !ends(bytes) {
        return Err("the file ends in the picture: it is not complete".to_owned());
    }
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let pixels = decoder.decode().map_err(text)?;
    let (width, height) = (u32::from(info.width), u32::from(info.height));
    let image = match is_grey {
        true => GrayImage::from_raw(width, height, pixels).map(DynamicImage::from),
        false => RgbImage::from_raw(width, height, pixels).map(DynamicImage::from),
    };
    image.ok_or_else(|| "it does not have the size that it declares".to_owned())
}

/// Whether a marker of the image's end follows the start of its first scan (ITU-T T.81, B.1.1.3). The decoder does not miss
/// the last rows of pixels.
fn ends(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let mut at = 2;
    // Segments: 0xff, a marker, and a length that includes its own two bytes. 0xff may also fill up.
    while let Some(&[0xff, marker, high, low]) = bytes.get(at..).and_then(|rest| rest.first_chunk()) {
        if marker == START_OF_SCAN {
            return bytes.get(at..).is_some_and(|scan| scan.array_windows().any(|pair| *pair == END_OF_IMAGE));
        }
        at += if marker == 0xff { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
    }
    false
}
