//! Decodes OpenEXR: red, green, blue and alpha of the first part that has colours, within the display window. Colours of other
//! primaries are converted to Rec. 709.

use std::io::Cursor;

use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;
use exr::prelude::{MetaData, ReadChannels, ReadLayers};

use super::budget::Wanted;
use super::pack::of_channel;
use crate::bitmap::{Bitmap, Decoding, Format};
use crate::chromaticities::to_rec_709;
use crate::scene::assets::Decoded;

pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The largest block of pixels that is decoded in several threads, each with a block of its own.
const LARGEST_PARALLEL_BLOCK: usize = 16 << 20;

/// The channels that an error names at most.
const MOST_NAMED: usize = 8;

pub fn decode(bytes: &[u8], wanted: &Wanted) -> Result<Decoded, String> {
    let text = |error: exr::error::Error| match error.to_string() {
        // The newest methods of compression are not known.
        words if words.contains("compression") => format!("{words}: save it with ZIP compression"),
        words => words,
    };
    // The sizes are checked first, because the crate allocates memory for all pixels before it reads them.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    let named =
        |header: &Header| header.channels.list.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>();
    let parts: Vec<Vec<String>> = meta.headers.iter().map(named).collect();
    if !parts.iter().any(|names| ["R", "G", "B"].iter().all(|channel| names.iter().any(|name| name == channel))) {
        let (names, more) = (parts.concat(), parts.concat().len().saturating_sub(MOST_NAMED));
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let names = names[..names.len().min(MOST_NAMED)].join(", ");
        let names = crate::printable::one_line(&names);
        return Err(format!(
            "expected the channels R, G and B, found {names}{more}: save it as RGB, without layers and without luminance and chroma"
        ));
    }
    let mut largest_block = 0;
    for header in &meta.headers {
        let block = header.max_block_byte_size();
        largest_block = largest_block.max(block);
        // A block is in memory packed and unpacked, and once more where its bytes are sorted.
        let decoder = (bytes.len() as u64).saturating_add((block as u64).saturating_mul(3));
        for size in [header.layer_size, header.shared_attributes.display_window.size] {
            wanted.check((size.width(), size.height()), false, decoder)?;
        }
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
    let conversion = to_rec_709(image.attributes.chromaticities)?;
    let data = IntegerBounds::new(layer.attributes.layer_position, layer.size);
    let window = image.attributes.display_window;
    let decoded = decodings.iter().zip(layer.channel_data.pixels.1).map(|(decoding, mut words)| {
        if let Some(conversion) = conversion.as_ref().filter(|_| *decoding == Decoding::Colour) {
            for texel in words.as_chunks_mut::<3>().0 {
                *texel = conversion.convert(texel.map(f32::from_bits)).map(f32::to_bits);
            }
        }
        let words = in_window(words, data, window);
        (*decoding, Bitmap::new(window.size.width() as u32, window.size.height() as u32, Format::Float, words))
    });
    Ok(decoded.collect())
}

/// The texels of the display window, which is the picture. Where the file has none, it is black.
fn in_window(words: Vec<u32>, data: IntegerBounds, window: IntegerBounds) -> Vec<u32> {
    if data == window {
        return words;
    }
    let offset = |axis: fn(Vec2<i32>) -> i32| i64::from(axis(data.position)) - i64::from(axis(window.position));
    let (right, down) = (offset(|at| at.0), offset(|at| at.1));
    let columns = right.max(0)..(right + data.size.0 as i64).min(window.size.0 as i64);
    let mut picture = vec![0; Format::Float.words(window.size.area())];
    if columns.is_empty() {
        return picture;
    }
    let length = Format::Float.words((columns.end - columns.start) as usize);
    for y in down.max(0)..(down + data.size.1 as i64).min(window.size.1 as i64) {
        let to = Format::Float.words(y as usize * window.size.0 + columns.start as usize);
        let from = Format::Float.words((y - down) as usize * data.size.0 + (columns.start - right) as usize);
        picture[to..to + length].copy_from_slice(&words[from..from + length]);
    }
    picture
}
