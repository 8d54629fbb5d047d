//! Decodes OpenEXR: red, green and blue of the first part that has them.

use std::io::Cursor;
use std::sync::Arc;

use exr::prelude::{MetaData, ReadChannels, ReadLayers};

use super::Bitmap;
use super::budget::Budget;

pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The largest block of pixels that is decoded in several threads, each with a block of its own.
const LARGEST_PARALLEL_BLOCK: usize = 16 << 20;

pub fn decode(bytes: &[u8], budget: &Budget) -> Result<Bitmap, String> {
    let text = |error: exr::error::Error| error.to_string();
    // The sizes are checked first, because the crate allocates memory for all pixels before it reads them.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?;
    let mut largest_block = 0;
    for header in &meta.headers {
        let block = header.max_block_byte_size();
        largest_block = largest_block.max(block);
        // A block is in memory packed and unpacked, and once more where its bytes are sorted.
        let decoder = (bytes.len() as u64).saturating_add((block as u64).saturating_mul(3));
        budget.check((header.layer_size.width(), header.layer_size.height()), decoder)?;
    }
    let reader = exr::prelude::read()
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
        .all_attributes();
    let reader = if largest_block > LARGEST_PARALLEL_BLOCK { reader.non_parallel() } else { reader };
    let layer = reader.from_buffered(Cursor::new(bytes)).map_err(text)?.layer_data;
    Ok(Bitmap {
        width: layer.size.width() as u32,
        height: layer.size.height() as u32,
        texels: Arc::new(layer.channel_data.pixels.1),
    })
}
