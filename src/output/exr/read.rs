//! Reads the picture of any file that holds R, G and B, or a luminance alone.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::f16;

use super::attribute::{Attribute, DENOISER, REJECTED, SAMPLES, VARIANCES, decoded};
use crate::aov::{REST, group_of_layer};
use crate::chromaticities::{Conversion, to_rec_709};
use crate::data::{CHANNELS, Rgb};
use crate::error::{Error, Result};
use crate::film::UNKNOWN_VARIANCE;
use crate::guard::guarded;

/// The contents of a file. Values are unchanged, but for colours of other primaries than Rec. 709: other programs also write infinities, NaN
/// and negative numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrImage {
    pub width: u32,
    pub height: u32,
    /// Row 0 on top. Linear Rec. 709.
    pub rgb: Vec<Rgb<f32>>,
    /// The note for users about its colours, if they were not those of Rec. 709.
    pub colours: Option<String>,
    /// The variances of [`Picture::variance`]. Only files of gpu-rt have variances, samples and rejected samples.
    pub variance: Option<Vec<Rgb<f32>>>,
    pub samples: Option<Vec<u32>>,
    pub rejected: Option<Vec<u32>>,
    /// The texts and numbers in the header that are not part of the EXR standard, as text, sorted by name.
    pub attributes: Vec<(String, String)>,
}

impl ExrImage {
    /// The variances of the pixels, if all of them are known.
    pub fn known_variance(&self) -> Option<&[Rgb<f32>]> {
        let variance = self.variance.as_deref()?;
        variance.as_flattened().iter().all(|v| (0.0..UNKNOWN_VARIANCE).contains(v)).then_some(variance)
    }

    /// The denoiser, if `gpu-rt denoise` made the file.
    pub fn denoiser(&self) -> Option<&str> {
        let found = self.attributes.iter().find(|(name, _)| name == DENOISER);
        found.map(|(_, words)| words.as_str())
    }

    /// Whether its stated error is reliable, if this program rendered it and knew the error.
    pub fn reliable(&self) -> Option<bool> {
        let (_, text) = self.attributes.iter().find(|(name, _)| name == "gpu-rt:reliable")?;
        text.parse::<i64>().ok().map(|reliable| reliable != 0)
    }

    /// The seed of the render, if this program made the file. Images with the same seed share some noise.
    pub fn seed(&self) -> Option<u32> {
        let (_, text) = self.attributes.iter().find(|(name, _)| name == "gpu-rt:seed")?;
        text.parse().ok()
    }
}

/// An open file.
pub(super) type Opened = Reader<BufReader<File>>;

/// Opens a file and reads its header.
pub(super) fn open(path: &Path) -> std::result::Result<Opened, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    ::exr::block::read(BufReader::new(file), false).map_err(|error| error.to_string())
}

/// Hands out the rows of a part in full resolution, one channel at a time: the channel's index, the first pixel's column and row, and the bytes
/// of its samples in the machine's order.
pub(super) fn read_part(
    opened: Opened,
    part: usize,
    mut use_row: impl FnMut(usize, (usize, usize), &[u8]),
) -> std::result::Result<(), String> {
    let to_text = |error: ::exr::error::Error| error.to_string();
    let channels = match opened.headers().get(part) {
        Some(header) if !header.deep => header.channels.clone(),
        _ => return Err("it has no such part of flat pixels".to_string()),
    };
    let read = || -> std::result::Result<(), String> {
        let chunks = opened
            .filter_chunks(false, |_, _, block| block.layer == part && block.level == Vec2(0, 0))
            .map_err(to_text)?;
        let mut blocks = chunks.sequential_decompressor(false);
        while let Some(block) = blocks.decompress_next_block() {
            let block = block.map_err(to_text)?;
            for row in block.lines(&channels) {
                let Vec2(column, line) = row.location.position;
                use_row(row.location.channel, (column, line), row.value);
            }
        }
        Ok(())
    };
    guarded(read)?
}

/// The attributes of a file's first part that this program can write, as they are.
pub fn read_attributes(path: &Path) -> Result<Vec<(String, Attribute)>> {
    let opened = open(path).map_err(Error::file(path, "read"))?;
    Ok(opened.headers().first().map_or(Vec::new(), attributes_of))
}

pub(super) fn attributes_of(header: &Header) -> Vec<(String, Attribute)> {
    let attributes = header.own_attributes.other.iter();
    attributes.filter_map(|(name, value)| Some((decoded(name), Attribute::of_exr(value)?))).collect()
}

/// Reads red, green and blue, in half or float, from the part or layer whose name says that it is the picture. A file without them may
/// have a luminance, Y, which is grey. Colours of other primaries, by the header's chromaticities, are converted to Rec. 709. The size is
/// that of the data window.
pub fn read_exr(path: &Path) -> Result<ExrImage> {
    read_rgb(path, find_rgb).map_err(Error::file(path, "read"))
}

/// Reads the layer of this name, as [`read_exr`] does: three channels, or one, which is grey. It has no variance. Several parts or layers may
/// precede the name.
pub fn read_layer(path: &Path, layer: &str) -> Result<ExrImage> {
    let read = read_rgb(path, |parts| find_layer(parts, layer));
    let image = read.map_err(Error::file(path, "read"))?;
    Ok(ExrImage { variance: None, ..image })
}

/// The groups of lights whose light the file has apart, and the names of their layers, in the order of the names. Nothing without a layer of the rest, as
/// in files of other programs: the groups do not add up to the image there.
pub fn light_layers(path: &Path) -> Result<Vec<(String, String)>> {
    let opened = open(path).map_err(Error::file(path, "read"))?;
    let of_part = |part: &Header| {
        let light = |channel: &ChannelDescription| {
            let name = channel.name.to_string();
            let (layer, _) = name.rsplit_once('.').filter(|(_, last)| *last == CHANNELS[0])?;
            triple(part, layer, &[CHANNELS])?;
            let group = group_of_layer(layer.rsplit('.').next()?)?;
            Some((group.to_string(), layer.to_string()))
        };
        part.channels.list.iter().filter_map(light).collect::<Vec<_>>()
    };
    let found = opened.headers().first().map_or(Vec::new(), of_part);
    Ok(if found.iter().any(|(group, _)| group == REST) { found } else { Vec::new() })
}

fn read_rgb(
    path: &Path,
    find: impl FnOnce(&[Header]) -> std::result::Result<RgbChannels, String>,
) -> std::result::Result<ExrImage, String> {
    let opened = open(path)?;
    let picture = find(opened.headers())?;
    let (part, header) = (picture.number, &opened.headers()[picture.number]);
    let number = |name: &str| plain(header, name).map(|(number, _)| number);
    let floats = |names: Rgb<&str>| -> Option<[usize; 3]> {
        let float = |name| float(header, name);
        Some([float(names[0])?, float(names[1])?, float(names[2])?])
    };
    let [r, g, b] = &picture.channels;
    let rgb = floats([r, g, b]).ok_or("its channels differ in size")?;
    let is_colour = SPELLINGS
        .iter()
        .any(|names| picture.channels.iter().zip(names).all(|(channel, name)| last_part(channel) == *name));
    let conversion = if is_colour { to_rec_709(header.shared_attributes.chromaticities) } else { Ok(None) };
    let colours = note_of_colours(&conversion);
    let conversion = conversion.unwrap_or_default();
    // The variances of other primaries would need the channels' covariance.
    let variance = floats(VARIANCES).filter(|_| conversion.is_none());
    let count = |name| number(name).filter(|number| header.channels.list[*number].sample_type == SampleType::U32);
    let counts = [count(SAMPLES), count(REJECTED)];
    let size = |length: usize| u32::try_from(length).map_err(|_| "its size is not supported".to_string());
    let mut attributes: Vec<(String, String)> =
        header.shared_attributes.other.iter().chain(&header.own_attributes.other).filter_map(describe).collect();
    attributes.sort();

    let (width, height) = (size(header.layer_size.0)?, size(header.layer_size.1)?);
    let ([rgb, variance], [samples, rejected]) = read_channels(opened, part, 32, [Some(rgb), variance], counts)?;
    let mut rgb = rgb.unwrap_or_default();
    if let Some(conversion) = conversion {
        rgb.iter_mut().for_each(|rgb| *rgb = conversion.convert(*rgb));
    }
    Ok(ExrImage { width, height, rgb, colours, variance, samples, rejected, attributes })
}

/// The values of all pixels: of triples of channels, and of channels of whole numbers.
type Planes<const N: usize> = ([Option<Vec<Rgb<f32>>>; N], [Option<Vec<u32>>; 2]);

/// Reads triples of channels of a part as floats, and channels of whole numbers; nothing where there is no channel. Row 0 is on top. A triple that
/// names a channel three times is grey. `bytes` are those that each pixel may need.
pub(super) fn read_channels<const N: usize>(
    opened: Opened,
    part: usize,
    bytes: usize,
    triples: [Option<[usize; 3]>; N],
    counts: [Option<usize>; 2],
) -> std::result::Result<Planes<N>, String> {
    let header = &opened.headers()[part];
    let (width, pixels) = (header.layer_size.0, pixels_of(header, bytes)?);
    let types: Vec<SampleType> = header.channels.list.iter().map(|channel| channel.sample_type).collect();
    let mut images = triples.map(|triple| triple.map(|_| vec![[0.0; 3]; pixels]));
    let mut numbers = counts.map(|count| count.map(|_| vec![0; pixels]));
    read_part(opened, part, |channel, (column, line), bytes| {
        let first = line * width + column;
        for (of, values) in triples.iter().zip(&mut images) {
            if let (Some(of), Some(values)) = (of, values)
                && of.contains(&channel)
            {
                let values = values.iter_mut().skip(first);
                values.zip(as_floats(types[channel], bytes)).for_each(|(value, read)| {
                    value.iter_mut().zip(of).filter(|(_, number)| **number == channel).for_each(|(v, _)| *v = read);
                });
            }
        }
        for (of, values) in counts.iter().zip(&mut numbers) {
            if let (true, Some(values)) = (*of == Some(channel), values) {
                let values = values.iter_mut().skip(first);
                values.zip(bytes.as_chunks().0).for_each(|(value, read)| *value = u32::from_ne_bytes(*read));
            }
        }
    })?;
    Ok((images, numbers))
}

/// The note for users about a file whose colours are converted, or cannot be.
pub(super) fn note_of_colours(conversion: &std::result::Result<Option<Conversion>, String>) -> Option<String> {
    match conversion {
        Ok(conversion) => conversion.as_ref().map(Conversion::words),
        Err(reason) => Some(format!("{reason}: its colours are taken for Rec. 709")),
    }
}

/// The name of a channel without that of its layer.
fn last_part(channel: &str) -> &str {
    channel.rsplit('.').next().unwrap_or_default()
}

/// The pixels of a part, if there is memory for as many bytes of each. A damaged header may claim more, and a failed allocation ends the process.
pub(super) fn pixels_of(header: &Header, bytes: usize) -> std::result::Result<usize, String> {
    let pixels = header.layer_size.0.checked_mul(header.layer_size.1);
    let total = pixels.and_then(|pixels| pixels.checked_mul(bytes)).unwrap_or(usize::MAX);
    let had = Vec::<u8>::new().try_reserve_exact(total);
    had.map_err(|_| format!("its header claims {total} bytes of pixels, which is more than the memory"))?;
    Ok(pixels.unwrap_or(0))
}

fn as_floats(kind: SampleType, bytes: &[u8]) -> impl Iterator<Item = f32> {
    let (halves, words) = match kind {
        SampleType::F16 => (bytes.as_chunks().0, &[][..]),
        SampleType::F32 | SampleType::U32 => (&[][..], bytes.as_chunks().0),
    };
    let halves = halves.iter().map(|half| f16::from_ne_bytes(*half).to_f32());
    halves.chain(words.iter().map(|word| f32::from_ne_bytes(*word)))
}

/// A channel with a sample for each pixel, and its number.
fn plain<'a>(header: &'a Header, name: &str) -> Option<(usize, &'a ChannelDescription)> {
    let mut channels = header.channels.list.iter().enumerate();
    let found = channels.find(|(_, channel)| channel.name.as_slice() == name.as_bytes());
    found.filter(|(_, channel)| channel.sampling == Vec2(1, 1) && !header.deep)
}

/// The number of a channel of floats.
pub(super) fn float(header: &Header, name: &str) -> Option<usize> {
    plain(header, name).filter(|(_, channel)| channel.sample_type != SampleType::U32).map(|(number, _)| number)
}

/// Common names of the layer that is the picture. The name of a view layer and a point can precede them.
const PICTURES: [&str; 8] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "c", "image"];
/// The names of red, green and blue.
const SPELLINGS: [Rgb<&str>; 3] = [CHANNELS, ["r", "g", "b"], ["red", "green", "blue"]];
/// The name of a luminance. With the chroma of the next names it is no grey.
const LUMINANCE: Rgb<&str> = ["Y"; 3];
const CHROMA: [&str; 2] = ["RY", "BY"];

/// Red, green and blue in a file.
pub(super) struct RgbChannels {
    /// The number of its part.
    pub number: usize,
    pub channels: Rgb<String>,
    /// The name of their layer, after the name of the part if both have one.
    layer: String,
    /// Whether the layer is all of the part.
    is_part: bool,
}

impl RgbChannels {
    /// The lower the rank, the more likely it is the picture.
    fn rank(&self) -> usize {
        let last = self.layer.rsplit('.').next().unwrap_or_default().to_lowercase();
        match (PICTURES.iter().position(|name| *name == last), self.is_part) {
            (_, true) if self.layer.is_empty() => 0,
            (Some(index), true) => 1 + index,
            (None, true) => UNNAMED_PART,
            (Some(index), false) => UNNAMED_PART + 1 + index,
            (None, false) => UNNAMED_LAYER,
        }
    }
}

const UNNAMED_PART: usize = 1 + PICTURES.len();
const UNNAMED_LAYER: usize = UNNAMED_PART + 1 + PICTURES.len();

/// Finds the red, green and blue of the picture. Channels without a layer's name come first; if several parts have
/// them, the part with a picture's name counts. Next come layers with a picture's name, and then a single layer of any
/// name. It is an error if several are possible.
pub(super) fn find_rgb(parts: &[Header]) -> std::result::Result<RgbChannels, String> {
    let named = |spellings: &[Rgb<&str>]| -> Vec<RgbChannels> {
        parts.iter().enumerate().flat_map(|(number, part)| rgb_in_part(number, part, spellings)).collect()
    };
    let mut found = named(&SPELLINGS);
    if found.is_empty() {
        found = named(&[LUMINANCE]);
    }
    found.sort_by_key(RgbChannels::rank);
    let alike = found.iter().filter(|rgb| rgb.rank() == found[0].rank()).count();
    if alike > 1 && [UNNAMED_PART, UNNAMED_LAYER].contains(&found[0].rank()) {
        let names: Vec<&str> = found.iter().map(|rgb| rgb.layer.as_str()).collect();
        return Err(format!(
            "which of its layers is the picture? It has {}; expected one of the names {}",
            names.join(", "),
            PICTURES.join(", ")
        ));
    }
    found.into_iter().next().ok_or_else(|| no_rgb(parts))
}

/// The channels that a layer may have, in the order in which they are looked for.
const OF_LAYER: [Rgb<&str>; 4] = [CHANNELS, ["X", "Y", "Z"], ["r", "g", "b"], ["red", "green", "blue"]];
/// The channels that it may have alone. They are grey.
const ALONE: [&str; 4] = ["Y", "Z", "X", "V"];

/// Finds the layer of this name: the name of its channels up to the last point, or of a channel without a point. The names of parts and
/// of outer layers may precede it.
fn find_layer(parts: &[Header], layer: &str) -> std::result::Result<RgbChannels, String> {
    let mut there = BTreeSet::new();
    for (number, part) in parts.iter().enumerate() {
        let part_name = part.own_attributes.layer_name.as_ref().map(decoded).unwrap_or_default();
        for name in part.channels.list.iter().map(|channel| channel.name.to_string()) {
            let prefix = name.rsplit_once('.').map_or(name.as_str(), |(prefix, _)| prefix);
            let is_requested = [prefix, &format!("{part_name}.{prefix}")]
                .into_iter()
                .any(|known| known == layer || known.ends_with(&format!(".{layer}")));
            let mut alone = ALONE.map(|last| format!("{prefix}.{last}")).into_iter().chain([prefix.to_string()]);
            let grey = || alone.find(|name| float(part, name).is_some()).map(|name| [name.clone(), name.clone(), name]);
            if let Some(channels) = triple(part, prefix, &OF_LAYER).or_else(grey).filter(|_| is_requested) {
                return Ok(RgbChannels { number, channels, layer: layer.to_string(), is_part: false });
            }
            there.insert(prefix.to_string());
        }
    }
    Err(format!("it has no layer {layer}; it has {}", there.into_iter().collect::<Vec<_>>().join(", ")))
}

/// The three channels of a layer, by the first of some spellings of which the part has all.
pub(super) fn triple(part: &Header, layer: &str, spellings: &[Rgb<&str>]) -> Option<Rgb<String>> {
    let mut all = spellings.iter().map(|names| names.map(|name| format!("{layer}.{name}")));
    all.find(|channels| channels.iter().all(|name| float(part, name).is_some()))
}

/// All triples of channels with such names in a part, sorted by name.
fn rgb_in_part(number: usize, part: &Header, spellings: &[Rgb<&str>]) -> Vec<RgbChannels> {
    let part_name = part.own_attributes.layer_name.as_ref().map(decoded);
    let names = part.channels.list.iter().map(|channel| channel.name.to_string());
    let rgb = |name: String| {
        let (prefix, red) = name.rsplit_once('.').map_or(("", name.as_str()), |(layer, last)| (layer, last));
        let names = spellings.iter().find(|names| names[0] == red)?;
        let full_name =
            |channel: &str| if prefix.is_empty() { channel.to_string() } else { format!("{prefix}.{channel}") };
        let channels = names.map(full_name);
        let has = |name| part.channels.list.iter().any(|channel| channel.name.to_string() == full_name(name));
        if *names == LUMINANCE && CHROMA.into_iter().any(has) {
            return None;
        }
        let layer = match (&part_name, prefix) {
            (None, _) => prefix.to_string(),
            (Some(part), "") => part.clone(),
            (Some(part), _) => format!("{part}.{prefix}"),
        };
        channels.iter().all(|name| float(part, name).is_some()).then_some(RgbChannels {
            number,
            channels,
            layer,
            is_part: prefix.is_empty(),
        })
    };
    names.filter_map(rgb).collect()
}

fn no_rgb(parts: &[Header]) -> String {
    let names: Vec<String> =
        parts.iter().flat_map(|part| part.channels.list.iter().map(|channel| channel.name.to_string())).collect();
    format!(
        "expected channels R, G and B, or Y alone, in half or float and one for each pixel; it has {}",
        if names.is_empty() { "none".into() } else { names.join(", ") }
    )
}

fn describe(
    (name, value): (&::exr::meta::attribute::Text, &::exr::meta::attribute::AttributeValue),
) -> Option<(String, String)> {
    let value = match (value, Attribute::of_exr(value)?) {
        // `{:?}` gives the shortest text that parses to the same number.
        (::exr::meta::attribute::AttributeValue::F32(value), _) => format!("{value:?}"),
        (_, Attribute::Float(value)) => format!("{value:?}"),
        (_, Attribute::Int(value)) => value.to_string(),
        (_, Attribute::Text(value)) => value,
    };
    Some((decoded(name), value))
}
