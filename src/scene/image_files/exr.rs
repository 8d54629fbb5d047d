//! Decodes OpenEXR: red, green, blue and alpha of the first part that has colours. Colours of other primaries are converted to Rec. 709.

use std::io::Cursor;
use std::sync::Arc;

use exr::prelude::{MetaData, ReadChannels, ReadLayers};

use super::budget::Wanted;
use super::pack::of_channel;
use crate::bitmap::{Bitmap, Decoding, Format};
use crate::chromaticities::Conversion;
use crate::scene::assets::Decoded;

pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The largest block of pixels that is decoded in several threads, each with a block of its own.
const LARGEST_PARALLEL_BLOCK: usize = 16 << 20;

pub fn decode(bytes: &[u8], wanted: &Wanted) -> Result<Decoded, String> {
    let text = |error: exr::error::Error| error.to_string();
    // The sizes are checked first, because the crate allocates memory for all pixels before it reads them.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    let mut largest_block = 0;
    for header in &meta.headers {
        let block = header.max_block_byte_size();
        largest_block = largest_block.max(block);
        // A block is in memory packed and unpacked, and once more where its bytes are sorted.
        let decoder = (bytes.len() as u64).saturating_add((block as u64).saturating_mul(3));
        wanted.check((header.layer_size.width(), header.layer_size.height()), false, decoder)?;
    }
    let decodings: Vec<Decoding> = wanted.decodings.iter().copied().collect();
    let (count, ways) = (decodings.len(), decodings.clone());
    let reader = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            move |size, _| (size.width(), vec![vec![0; Format::Float.words(size.area())]; count]),
            move |(width, images), at, (r, g, b, a): (f32, f32, f32, f32)| {
                let start = Format::Float.words(at.y() * *width + at.x());
                for (words, decoding) in images.iter_mut().zip(&ways) {
                    let texel = match decoding {
                        Decoding::Colour | Decoding::Numbers => [r, g, b],
                        Decoding::Number(channel) => [of_channel([r, g, b, a], *channel); 3],
                    };
                    words.iter_mut().skip(start).zip(texel).for_each(|(word, value)| *word = value.to_bits());
                }
            },
        )
        .first_valid_layer()
        .all_attributes();
    let reader = if largest_block > LARGEST_PARALLEL_BLOCK { reader.non_parallel() } else { reader };
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(text)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let conversion = Conversion::of_file(image.attributes.chromaticities)?;
    let mut images = layer.channel_data.pixels.1;
    for (words, _) in images.iter_mut().zip(&decodings).filter(|(_, decoding)| **decoding == Decoding::Colour) {
        if let Some(conversion) = &conversion {
            convert(words, width, conversion)?;
        }
    }
    let (width, height) = (width as u32, height as u32);
    let bitmap = |words| Bitmap { width, height, format: Format::Float, words: Arc::new(words) };
    Ok(decodings.iter().copied().zip(images.into_iter().map(bitmap)).collect())
}

/// Converts texels to Rec. 709. Those that have a colour outside of it are refused, since no colour in a scene is negative.
fn convert(words: &mut [u32], width: usize, conversion: &Conversion) -> Result<(), String> {
    for (index, texel) in words.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let before = texel.map(f32::from_bits);
        let mut after = conversion.convert(before);
        if before.iter().all(|v| *v >= 0.0) {
            // A colour at the very edge is rounded to one outside.
            let rounding = 1e-6 * after.iter().fold(0.0, |most: f32, v| most.max(*v));
            after = after.map(|v| if (-rounding..0.0).contains(&v) { 0.0 } else { v });
            if after.iter().any(|v| *v < 0.0) {
                let ([r, g, b], (x, y)) = (after, (index % width, index / width));
                return Err(format!(
                    "{}, and texel ({x}, {y}) is outside of Rec. 709: ({r:?}, {g:?}, {b:?}): map its colours into Rec. 709 before",
                    conversion.words()
                ));
            }
        }
        *texel = after.map(f32::to_bits);
    }
    Ok(())
}
