//! Writes the picture of a render, and the state that it goes on from.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::exr::block::writer::ChunksWriter;
use ::exr::block::{BlockIndex, UncompressedBlock, enumerate_ordered_header_block_indices};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType};
use ::exr::meta::header::{Header, LayerAttributes};
use ::exr::meta::{BlockDescription, Headers};

use super::attribute::{Attribute, CHECKSUM, REJECTED, SAMPLES, STATE, VARIANCES, checksum, text, to_io};
use super::state::State;
use crate::aov::{Aov, ChannelNames};
use crate::chromaticities::REC_709;
use crate::data::CHANNELS;
use crate::error::Result;
use crate::film::{Film, Picture, PicturePixel};
use crate::job::Frame;
use crate::output::atomic;

/// The file's `comments`, which explain the layers beside R, G and B.
const COMMENTS: &str = "R, G, B: linear radiance. variance: of the pixel's mean; 3.4028235e38 where unknown. \
    samples, rejected: camera samples of the pixel that went into the mean, and that were left out as not finite.";
/// The end of the `comments` of a file with channels of `--aov`.
const COMMENTS_OF_AOVS: &str = " Z: distance along the camera's axis, mean over the samples that hit a surface; 3.4028235e38 without any. \
    N, P: in the world's axes. object, material, face0: numbers from 1; 0 is none. depth0, distance0, position0, normal0, uv0, face0, offset0: of \
    sample 0. motion: pixels to the next frame, x to the right, y down; 3.4028235e38 of what leaves the view.";
/// The name of the part that holds the picture, of a file with several parts. Blender takes the name for that of the pass, or of the view
/// layer that has passes.
const PART: &str = "Combined";
const BLENDER_PART: &str = "ViewLayer";
/// The `comments` of the part that holds the state.
const STATE_COMMENTS: &str = "What gpu-rt needs to go on with the render: the exact totals of each pixel. The bits of each half are a word \
    of 16 bits of an integer, the lowest word first; absent words are zero.";

/// Lossless and readable everywhere. Noise hardly compresses: megabytes of the pictures of three scenes, and the least seconds to write the
/// first, 1200 x 675 pixels, on 2 cores that others used too.
///
/// | | weekend, 64 samples | cornell, 64 | next-week, 16 | seconds |
/// |---|---|---|---|---|
/// | none | 25.9 | 11.5 | 20.5 | 0.24 |
/// | RLE | 20.0 | 8.7 | 16.8 | 0.32 |
/// | ZIP1 | 17.3 | 7.9 | 14.7 | 1.25 |
/// | ZIP16 | 17.1 | 7.8 | 14.6 | 2.6 |
/// | PIZ | 17.1 | 8.4 | 16.1 | 2.8 |
pub(super) const OF_PICTURE: Compression = Compression::ZIP1;
/// ZIP splits the bytes of halves into planes of their own, of which the upper ones are smooth and the lowest empty: 31.7 bytes a pixel of
/// scenes/weekend.ron at 256 samples. The same totals as 32-bit integers take 38.3.
const OF_STATE: Compression = Compression::ZIP16;

/// Writes the picture as one part, row 0 on top: R, G, B and variance.R, .G, .B in 32-bit floats, samples.Y and
/// rejected.Y (Y, so that viewers show them as grey) in 32-bit unsigned integers. The file is a function of the
/// arguments, byte for byte.
///
/// Attribute names must not be empty, longer than 255 bytes, or reserved by the EXR standard.
pub fn write_exr(path: &Path, picture: &Picture, attributes: &[(String, Attribute)]) -> Result<()> {
    let frame = Frame::full((picture.width, picture.height));
    let pixel = |index| picture.pixel(index);
    let contents = Contents::new(&pixel, None, false);
    write_parts(path, &frame, &contents, attributes, None, || Ok(()))
}

/// Writes what a film holds, as [`write_exr`] does. With a state, a second part holds what it takes to go on with the render. It takes no
/// memory to speak of. An old file is replaced only if it `may` be, which is checked last; if not, that is the error.
pub fn write_render(
    path: &Path,
    film: &Film,
    attributes: &[(String, Attribute)],
    state: Option<&State>,
    may: impl FnOnce() -> std::result::Result<(), String>,
) -> Result<()> {
    let part = state.map(|state| StatePart::new(film, state));
    let pixel = |index| film.developed(index);
    let contents = Contents::new(&pixel, Some(film), part.is_some());
    write_parts(path, &film.frame, &contents, attributes, part, may)
}

/// The word that a channel of the picture's part has for a pixel, by the pixel's index and its values.
type Value<'a> = Box<dyn Fn(usize, &PicturePixel) -> u32 + 'a>;

/// The picture's part.
struct Contents<'a> {
    part: &'static str,
    pixel: &'a dyn Fn(usize) -> PicturePixel,
    has_aovs: bool,
    /// By their names.
    channels: Vec<(String, SampleType, Value<'a>)>,
}

impl<'a> Contents<'a> {
    /// `film` has the channels of `--aov`. `named`: the file names its parts.
    fn new(pixel: &'a dyn Fn(usize) -> PicturePixel, film: Option<&'a Film>, named: bool) -> Contents<'a> {
        let aovs = film.map(|film| film.aovs().clone()).unwrap_or_default();
        let (part, layer) = match aovs.names {
            ChannelNames::Plain => (PART, String::new()),
            ChannelNames::Blender if named => (BLENDER_PART, format!("{PART}.")),
            ChannelNames::Blender => (BLENDER_PART, format!("{BLENDER_PART}.{PART}.")),
        };
        let before =
            if aovs.names == ChannelNames::Blender && !named { format!("{BLENDER_PART}.") } else { String::new() };
        let count = |name: &str, value: Value<'a>| (name.to_string(), SampleType::U32, value);
        let mut channels = vec![
            count(SAMPLES, Box::new(|_, pixel| pixel.samples)),
            count(REJECTED, Box::new(|_, pixel| pixel.rejected)),
        ];
        let mut float = |name: String, value: Value<'a>| channels.push((name, SampleType::F32, value));
        for (c, (colour, variance)) in CHANNELS.into_iter().zip(VARIANCES).enumerate() {
            float(format!("{layer}{colour}"), Box::new(move |_, pixel| pixel.rgb[c].to_bits()));
            float(variance.to_string(), Box::new(move |_, pixel| pixel.variance[c].to_bits()));
        }
        for (film, channel) in film.into_iter().flat_map(|film| aovs.channels().into_iter().map(move |aov| (film, aov)))
        {
            let kind = if channel.aov == Aov::Face0 { SampleType::U32 } else { SampleType::F32 };
            let name = match aovs.is_full_name(&channel) {
                true => channel.name.clone(),
                false => format!("{before}{}", channel.name),
            };
            channels.push((name, kind, Box::new(move |index, _| film.channel_word(index, &channel))));
        }
        channels.sort_by(|(a, ..), (b, ..)| a.cmp(b));
        Contents { part, pixel, has_aovs: !aovs.is_empty(), channels }
    }

    fn descriptions(&self) -> Vec<ChannelDescription> {
        self.channels.iter().map(|(name, kind, _)| ChannelDescription::named(name.as_str(), *kind)).collect()
    }

    /// A row: for each channel, all pixels.
    fn bytes(&self, row: std::ops::Range<usize>) -> Vec<u8> {
        let pixels: Vec<(usize, PicturePixel)> = row.map(|index| (index, (self.pixel)(index))).collect();
        let of_channel = |(_, _, value): &(_, _, Value<'a>)| {
            pixels.iter().flat_map(|(index, pixel)| value(*index, pixel).to_ne_bytes()).collect::<Vec<u8>>()
        };
        self.channels.iter().flat_map(of_channel).collect()
    }
}

/// The part that holds the state.
struct StatePart<'a> {
    film: &'a Film,
    /// The indices of its channels among a pixel's words: the words that any pixel has, by their names.
    words: Vec<usize>,
    channels: Vec<ChannelDescription>,
    about: String,
}

impl<'a> StatePart<'a> {
    fn new(film: &'a Film, state: &State) -> StatePart<'a> {
        let (used, checksum) = survey(film);
        let names = film.word_names();
        let mut words: Vec<usize> = (0..names.len()).filter(|word| used[*word] != 0).collect();
        if words.is_empty() {
            // A part has at least one channel.
            words.push(0);
        }
        words.sort_by(|a, b| names[*a].cmp(&names[*b]));
        let channel = |word: &usize| ChannelDescription::named(names[*word].as_str(), SampleType::F16);
        let channels = words.iter().map(channel).collect();
        StatePart { film, channels, words, about: state.describe(checksum) }
    }

    /// The bytes of the state of these pixels, one channel after another.
    fn bytes(&self, row: std::ops::Range<usize>) -> Vec<u8> {
        let pixels: Vec<Vec<u16>> = row.map(|index| self.film.words(index)).collect();
        let channel = |word: &usize| pixels.iter().flat_map(|words| words[*word].to_ne_bytes()).collect::<Vec<u8>>();
        self.words.iter().flat_map(channel).collect()
    }
}

/// Which bits any pixel's words have, and the checksum of all words.
fn survey(film: &Film) -> (Vec<u16>, u32) {
    let count = film.word_names().len();
    let (mut used, mut words) = (vec![0; count], vec![0; count]);
    let mut checksum = crc32fast::Hasher::new();
    for index in 0..film.width() as usize * film.height() as usize {
        film.put_words(index, &mut words);
        used.iter_mut().zip(&words).for_each(|(used, word)| *used |= word);
        words.iter_mut().for_each(|word| *word = word.to_le());
        checksum.update(bytemuck::cast_slice(&words));
    }
    (used, checksum.finalize())
}

fn write_parts(
    path: &Path,
    Frame { part, full }: &Frame,
    contents: &Contents<'_>,
    attributes: &[(String, Attribute)],
    state: Option<StatePart<'_>>,
    may: impl FnOnce() -> std::result::Result<(), String>,
) -> Result<()> {
    let size = (part.width as usize, part.height as usize);
    let comments = format!("{COMMENTS}{}", if contents.has_aovs { COMMENTS_OF_AOVS } else { "" });
    let own = LayerAttributes {
        // A file with several parts names them.
        layer_name: state.is_some().then(|| text(contents.part)),
        software_name: Some(text(concat!("gpu-rt ", env!("CARGO_PKG_VERSION")))),
        comments: Some(text(&comments)),
        other: attributes.iter().map(|(name, value)| (text(name), value.to_exr())).collect(),
        ..LayerAttributes::default()
    };
    let header = |channels: &[ChannelDescription], own, compression| {
        let mut header = Header::new(text(""), size, channels.into())
            .with_attributes(own)
            // A fixed line order makes the bytes independent of the threads that compress.
            .with_encoding(compression, BlockDescription::ScanLines, LineOrder::Increasing);
        header.shared_attributes.chromaticities = Some(REC_709);
        // The pixels of a part keep their position in the full image, for programs that put parts together.
        header.shared_attributes.display_window = IntegerBounds::from_dimensions((full.0 as usize, full.1 as usize));
        header.own_attributes.layer_position = Vec2(part.left as i32, part.top as i32);
        header
    };
    let of_state = state.as_ref().map(|state| {
        let about = [(STATE, state.about.clone()), (CHECKSUM, checksum(&state.about, &own))];
        let own = LayerAttributes {
            layer_name: Some(text(STATE)),
            comments: Some(text(STATE_COMMENTS)),
            other: about.into_iter().map(|(name, value)| (text(name), Attribute::Text(value).to_exr())).collect(),
            ..LayerAttributes::default()
        };
        header(&state.channels, own, OF_STATE)
    });
    let mut headers: Headers = Headers::new();
    headers.push(header(&contents.descriptions(), own, OF_PICTURE));
    headers.extend(of_state);
    let parts = headers.len();
    let data = |block: &BlockIndex| {
        let Vec2(columns, rows) = block.pixel_size;
        let Vec2(first_column, first_row) = block.pixel_position;
        let rows = (first_row..first_row + rows).map(|row| row * size.0 + first_column);
        let rows = rows.map(|first| first..first + columns);
        match (&state, block.layer) {
            (Some(state), 1) => rows.flat_map(|row| state.bytes(row)).collect(),
            _ => rows.flat_map(|row| contents.bytes(row)).collect(),
        }
    };
    let write = |file: &mut File| {
        ::exr::block::write(BufWriter::new(&mut *file), headers, true, |mut meta, chunks| {
            // They are written, and the compressor copies the headers for each block.
            meta.headers.iter_mut().for_each(|header| header.own_attributes.other.clear());
            let blocks = enumerate_ordered_header_block_indices(&meta.headers);
            let blocks = blocks.map(|(number, index)| (number, UncompressedBlock { index, data: data(&index) }));
            compress(&meta, chunks, blocks)
        })
        .map_err(to_io)?;
        sort_attributes(file, parts)
    };
    atomic::replace_if(path, write, may)
}

fn compress<W: Write + Seek>(
    meta: &::exr::meta::MetaData,
    chunks: &mut ::exr::block::writer::ChunkWriter<W>,
    blocks: impl Iterator<Item = (usize, UncompressedBlock)>,
) -> ::exr::error::UnitResult {
    match chunks.parallel_blocks_compressor(meta) {
        Some(mut compressor) => {
            for (number, block) in blocks {
                compressor.add_block_to_compression_queue(number, block)?;
            }
        }
        None => {
            let mut compressor = chunks.sequential_blocks_compressor(meta);
            for (number, block) in blocks {
                compressor.compress_block(number, block)?;
            }
        }
    }
    Ok(())
}

/// Sorts the attributes of each part's header in place, because the crate keeps them in a hash map, whose order differs each time.
/// A header is a list of (name, 0, type, 0, size, value), and ends with an empty name (The OpenEXR file layout,
/// section "Header").
pub(super) fn sort_attributes(file: &mut File, parts: usize) -> io::Result<()> {
    /// The magic number and the version come first.
    const HEADERS: SeekFrom = SeekFrom::Start(8);
    file.seek(HEADERS)?;
    let mut reader = BufReader::new(&mut *file);
    let mut headers = Vec::new();
    for _ in 0..parts {
        let mut attributes = Vec::new();
        loop {
            let mut attribute = Vec::new();
            reader.read_until(0, &mut attribute)?;
            if attribute.len() <= 1 {
                break;
            }
            reader.read_until(0, &mut attribute)?;
            let mut size = [0; 4];
            reader.read_exact(&mut size)?;
            attribute.extend(size);
            reader.by_ref().take(u32::from_le_bytes(size).into()).read_to_end(&mut attribute)?;
            attributes.push(attribute);
        }
        attributes.sort();
        headers.extend(attributes.concat());
        headers.push(0);
    }
    file.seek(HEADERS)?;
    file.write_all(&headers)
}
