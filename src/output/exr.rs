//! OpenEXR files: writes the linear picture with its error estimate, and reads any file that holds R, G and B.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Layers, SpecificChannels};
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, Compression, LineOrder, Text};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::{ReadChannels, ReadLayers, read};

use crate::data::{CHANNELS, Rgb};
use crate::error::{Error, Result};
use crate::film::{Picture, UNKNOWN_VARIANCE};
use crate::output::atomic;

/// The file's `comments`, which explain the layers beside R, G and B.
const COMMENTS: &str = "R, G, B: linear radiance. variance: of the pixel's mean; 3.4028235e38 where unknown. \
    samples, rejected: camera samples of the pixel that went into the mean, and that were left out as not finite.";

/// Lossless and readable everywhere. Noise hardly compresses. All channels of 1200 x 675 noisy pixels, on 2 cores: 25.9
/// MB in 0.09 s without compression, 21.3 MB in 0.14 s by run lengths, 19.4 MB in 0.45 s by ZIP1, 19.0 MB in 0.70 s by
/// ZIP16, 18.3 MB in 0.51 s by PIZ.
const ENCODING: Encoding = Encoding {
    compression: Compression::RLE,
    blocks: Blocks::ScanLines,
    // A fixed line order makes the bytes independent of the threads that compress.
    line_order: LineOrder::Increasing,
};

/// The chromaticities of Rec. 709 and its white point D65 (ITU-R BT.709-6, items 1.3 and 1.4).
const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

/// A setting or a result in the file's header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Written as UTF-8.
    Text(String),
    /// Written as EXR's 32-bit integer, or as text if it needs more bits.
    Int(i64),
    /// Written as EXR's 64-bit float.
    Float(f64),
}

/// The channels of the variance of each pixel's mean.
const VARIANCES: Rgb<&str> = ["variance.R", "variance.G", "variance.B"];

/// Writes the picture as one part, row 0 on top: R, G, B and variance.R, .G, .B in 32-bit floats, samples.Y and
/// rejected.Y (Y, so that viewers show them as grey) in 32-bit unsigned integers. The file is a function of the
/// arguments, byte for byte.
///
/// Attribute names must not be empty, longer than 255 bytes, or reserved by the EXR standard.
pub fn write_exr(path: &Path, picture: &Picture, attributes: &[(String, Attribute)]) -> Result<()> {
    let width = picture.width as usize;
    let channels = SpecificChannels::build()
        .with_channel::<f32>(CHANNELS[0])
        .with_channel::<f32>(CHANNELS[1])
        .with_channel::<f32>(CHANNELS[2])
        .with_channel::<f32>(VARIANCES[0])
        .with_channel::<f32>(VARIANCES[1])
        .with_channel::<f32>(VARIANCES[2])
        .with_channel::<u32>("samples.Y")
        .with_channel::<u32>("rejected.Y")
        .with_pixel_fn(|Vec2(x, y): Vec2<usize>| {
            let pixel = y * width + x;
            let ([r, g, b], [vr, vg, vb]) = (picture.rgb[pixel], picture.variance[pixel]);
            (r, g, b, vr, vg, vb, picture.samples[pixel], picture.rejected[pixel])
        });
    let header = LayerAttributes {
        software_name: Some(text(concat!("gpu-rt ", env!("CARGO_PKG_VERSION")))),
        comments: Some(text(COMMENTS)),
        other: attributes.iter().map(|(name, value)| (text(name), value.to_exr())).collect(),
        ..LayerAttributes::default()
    };
    let mut image = Image::from_layer(Layer::new((width, picture.height as usize), header, ENCODING, channels));
    image.attributes.chromaticities = Some(REC_709);
    atomic::replace(path, |file| {
        image.write().to_unbuffered(&mut *file).map_err(to_io)?;
        sort_attributes(file)
    })
}

impl Attribute {
    fn to_exr(&self) -> AttributeValue {
        match self {
            Attribute::Text(value) => AttributeValue::Text(text(value)),
            Attribute::Int(value) => match i32::try_from(*value) {
                Ok(value) => AttributeValue::I32(value),
                Err(_) => AttributeValue::Text(text(&value.to_string())),
            },
            Attribute::Float(value) => AttributeValue::F64(*value),
        }
    }
}

/// EXR's text is bytes, by convention UTF-8. The crate's own conversion supports only Latin-1.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

fn to_io(error: ::exr::error::Error) -> io::Error {
    match error {
        ::exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

/// Sorts the header's attributes in place, because the crate keeps them in a hash map, whose order differs each time.
/// The header is a list of (name, 0, type, 0, size, value), and ends with an empty name (The OpenEXR file layout,
/// section "Header").
fn sort_attributes(file: &mut File) -> io::Result<()> {
    /// The magic number and the version come first.
    const HEADER: SeekFrom = SeekFrom::Start(8);
    file.seek(HEADER)?;
    let mut reader = BufReader::new(&mut *file);
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
    file.seek(HEADER)?;
    file.write_all(&attributes.concat())
}

/// The contents of a file. Values are unchanged: other programs also write infinities, NaN and negative numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrImage {
    pub width: u32,
    pub height: u32,
    /// Row 0 on top.
    pub rgb: Vec<Rgb<f32>>,
    /// As [`Picture::variance`]. Only files of gpu-rt have this and the next two.
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

    /// The seed of the render, if this program made the file. Images with the same seed share some noise.
    pub fn seed(&self) -> Option<u32> {
        let (_, text) = self.attributes.iter().find(|(name, _)| name == "gpu-rt:seed")?;
        text.parse().ok()
    }
}

type FlatLayer = Layer<AnyChannels<FlatSamples>>;

/// Reads red, green and blue, in half or float, from the part or layer whose name says that it is the picture. The size
/// is that of the data window.
pub fn read_exr(path: &Path) -> Result<ExrImage> {
    let failed = |reason: String| Error::File { path: path.to_owned(), action: "read", reason };
    let open = || File::open(path).map_err(|error| failed(error.to_string()));
    let header = MetaData::read_from_unbuffered(open()?, false).map_err(|error| failed(error.to_string()))?;
    check_memory(&header).map_err(failed)?;
    let image: Image<Layers<AnyChannels<FlatSamples>>> = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_unbuffered(open()?)
        .map_err(|error| failed(error.to_string()))?;
    let RgbPlace { part: layer, channels, .. } = find_rgb(&image.layer_data).map_err(failed)?;
    let size = |length: usize| u32::try_from(length).map_err(|_| failed("its size is not supported".into()));
    let mut attributes: Vec<(String, String)> =
        image.attributes.other.iter().chain(&layer.attributes.other).filter_map(describe).collect();
    attributes.sort();
    Ok(ExrImage {
        width: size(layer.size.0)?,
        height: size(layer.size.1)?,
        rgb: float_channels(layer, &channels).ok_or_else(|| failed("its channels differ in size".into()))?,
        variance: float_channels(layer, &VARIANCES),
        samples: count_channel(layer, "samples.Y"),
        rejected: count_channel(layer, "rejected.Y"),
        attributes,
    })
}

/// Checks that there is enough memory for the pixels. A damaged header may ask for more, and a failed allocation ends
/// the process. The pixels are in memory up to four times: packed, unpacked, by channel, and in the result.
fn check_memory(header: &MetaData) -> std::result::Result<(), String> {
    let bytes_of = |(Vec2(width, height), pixel): (Vec2<usize>, usize)| width.checked_mul(height)?.checked_mul(pixel);
    let sizes = header.headers.iter().map(|h| bytes_of((h.layer_size, h.channels.bytes_per_pixel)));
    let total = sizes.reduce(|a, b| a?.checked_add(b?)).flatten().unwrap_or(usize::MAX);
    let had = Vec::<u8>::new().try_reserve_exact(total.saturating_mul(4));
    had.map_err(|_| format!("its header claims {total} bytes of pixels, which is more than the memory"))
}

fn samples<'a>(layer: &'a FlatLayer, name: &str) -> Option<&'a FlatSamples> {
    let channel = layer.channel_data.list.iter().find(|channel| channel.name.as_slice() == name.as_bytes())?;
    // Subsampled channels have fewer samples than the layer has pixels.
    (channel.sample_data.len() == layer.size.0.checked_mul(layer.size.1)?).then_some(&channel.sample_data)
}

fn floats<'a>(layer: &'a FlatLayer, name: &str) -> Option<impl Iterator<Item = f32> + use<'a>> {
    let samples = samples(layer, name)?;
    (!matches!(samples, FlatSamples::U32(_))).then(|| samples.values_as_f32())
}

fn float_channels(layer: &FlatLayer, [r, g, b]: &[impl AsRef<str>; 3]) -> Option<Vec<Rgb<f32>>> {
    let (r, g, b) = (floats(layer, r.as_ref())?, floats(layer, g.as_ref())?, floats(layer, b.as_ref())?);
    Some(r.zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect())
}

fn count_channel(layer: &FlatLayer, name: &str) -> Option<Vec<u32>> {
    match samples(layer, name)? {
        FlatSamples::U32(values) => Some(values.clone()),
        _ => None,
    }
}

/// Common names of the layer that is the picture. The name of a view layer and a point can precede them.
const PICTURES: [&str; 8] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "c", "image"];
/// The names of red, green and blue.
const SPELLINGS: [Rgb<&str>; 3] = [CHANNELS, ["r", "g", "b"], ["red", "green", "blue"]];

/// Red, green and blue in a file.
struct RgbPlace<'a> {
    part: &'a FlatLayer,
    channels: Rgb<String>,
    /// The name of their layer, after the name of the part if both have one.
    layer: String,
    /// Whether the layer is the whole part.
    is_part: bool,
}

impl RgbPlace<'_> {
    /// The lower the rank, the more likely it is the picture.
    fn rank(&self) -> usize {
        let last = self.layer.rsplit('.').next().unwrap_or_default().to_lowercase();
        match (PICTURES.iter().position(|name| *name == last), self.is_part) {
            (_, true) if self.layer.is_empty() => 0,
            (Some(place), true) => 1 + place,
            (None, true) => UNNAMED_PART,
            (Some(place), false) => UNNAMED_PART + 1 + place,
            (None, false) => UNNAMED_LAYER,
        }
    }
}

const UNNAMED_PART: usize = 1 + PICTURES.len();
const UNNAMED_LAYER: usize = UNNAMED_PART + 1 + PICTURES.len();

/// Finds the red, green and blue of the picture. Channels without a layer's name come first; if several parts have
/// them, the part with a picture's name counts. Next come layers with a picture's name, and then a single layer of any
/// name. It is an error if several are possible.
fn find_rgb(parts: &[FlatLayer]) -> std::result::Result<RgbPlace<'_>, String> {
    let mut places: Vec<RgbPlace<'_>> = parts.iter().flat_map(rgb_of_part).collect();
    places.sort_by_key(RgbPlace::rank);
    let alike = places.iter().filter(|place| place.rank() == places[0].rank()).count();
    if alike > 1 && [UNNAMED_PART, UNNAMED_LAYER].contains(&places[0].rank()) {
        let names: Vec<&str> = places.iter().map(|place| place.layer.as_str()).collect();
        return Err(format!(
            "which of its layers is the picture? It has {}; expected one of the names {}",
            names.join(", "),
            PICTURES.join(", ")
        ));
    }
    places.into_iter().next().ok_or_else(|| no_rgb(parts))
}

/// All triples of red, green and blue in a part, sorted by name.
fn rgb_of_part(part: &FlatLayer) -> Vec<RgbPlace<'_>> {
    let part_name =
        part.attributes.layer_name.as_ref().map(|name| String::from_utf8_lossy(name.as_slice()).into_owned());
    let names = part.channel_data.list.iter().map(|channel| channel.name.to_string());
    let place = |name: String| {
        let (prefix, red) = name.rsplit_once('.').map_or(("", name.as_str()), |(layer, last)| (layer, last));
        let names = SPELLINGS.iter().find(|names| names[0] == red)?;
        let channels =
            names.map(|channel| if prefix.is_empty() { channel.to_string() } else { format!("{prefix}.{channel}") });
        let layer = match (&part_name, prefix) {
            (None, _) => prefix.to_string(),
            (Some(part), "") => part.clone(),
            (Some(part), _) => format!("{part}.{prefix}"),
        };
        channels.iter().all(|name| floats(part, name).is_some()).then_some(RgbPlace {
            part,
            channels,
            layer,
            is_part: prefix.is_empty(),
        })
    };
    names.filter_map(place).collect()
}

fn no_rgb(layers: &[FlatLayer]) -> String {
    let names: Vec<String> =
        layers.iter().flat_map(|layer| layer.channel_data.list.iter().map(|c| c.name.to_string())).collect();
    format!(
        "expected channels R, G and B, in half or float and one for each pixel; it has {}",
        if names.is_empty() { "none".into() } else { names.join(", ") }
    )
}

fn describe((name, value): (&Text, &AttributeValue)) -> Option<(String, String)> {
    let decode = |text: &Text| String::from_utf8_lossy(text.as_slice()).into_owned();
    let value = match value {
        AttributeValue::Text(value) => decode(value),
        AttributeValue::I32(value) => value.to_string(),
        // `{:?}` gives the shortest text that parses to the same number.
        AttributeValue::F32(value) => format!("{value:?}"),
        AttributeValue::F64(value) => format!("{value:?}"),
        _ => return None,
    };
    Some((decode(name), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All kinds of values that a film can produce, over the whole range of f32.
    fn picture() -> Picture {
        let count = 7 * 5;
        let value = |i: usize| f32::from_bits((i as u32).wrapping_mul(0x0123_4567) & 0x7f7f_ffff);
        Picture {
            width: 7,
            height: 5,
            rgb: (0..count).map(|i| [value(i), value(i + 100), value(i + 200)]).collect(),
            variance: (0..count).map(|i| [value(i + 300), 0.0, UNKNOWN_VARIANCE]).collect(),
            samples: (0..count as u32).map(|i| u32::MAX - i).collect(),
            rejected: (0..count as u32).collect(),
        }
    }

    fn attributes() -> Vec<(String, Attribute)> {
        vec![
            ("scene".into(), Attribute::Text("Küche 場景.ron".into())),
            ("empty".into(), Attribute::Text(String::new())),
            ("max_depth".into(), Attribute::Int(50)),
            ("seed".into(), Attribute::Int(i64::MIN)),
            ("seconds".into(), Attribute::Float(0.1 + 0.2)),
            ("a name that is longer than 31 bytes".into(), Attribute::Float(1e-300)),
        ]
    }

    #[test]
    fn what_is_written_is_read_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = picture();
        write_exr(&path, &picture, &attributes()).unwrap();
        let read = read_exr(&path).unwrap();
        assert_eq!((read.width, read.height), (7, 5));
        assert_eq!(read.rgb, picture.rgb);
        assert_eq!(read.variance, Some(picture.variance));
        assert_eq!(read.samples, Some(picture.samples));
        assert_eq!(read.rejected, Some(picture.rejected));
        let expected = [
            ("a name that is longer than 31 bytes", "1e-300"),
            ("empty", ""),
            ("max_depth", "50"),
            ("scene", "Küche 場景.ron"),
            ("seconds", "0.30000000000000004"),
            ("seed", "-9223372036854775808"),
        ];
        assert_eq!(read.attributes, expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut tall = Picture { width: 64, height: 300, ..Picture::default() };
        tall.rgb = (0..64 * 300).map(|i| [i as f32, 1.0 / i as f32, 0.5].map(|v| v.min(1e9))).collect();
        tall.variance = tall.rgb.clone();
        tall.samples = vec![8; 64 * 300];
        tall.rejected = vec![0; 64 * 300];
        let bytes = || {
            write_exr(&path, &tall, &attributes()).unwrap();
            std::fs::read(&path).unwrap()
        };
        let first = bytes();
        for _ in 0..5 {
            assert!(bytes() == first);
        }
    }

    #[test]
    fn rows_run_from_top_to_bottom() {
        // Row 0 is also first in the file, with y growing downwards: other readers show it at the top.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &picture(), &[]).unwrap();
        let header = &MetaData::read_from_file(&path, true).unwrap().headers[0];
        assert_eq!(header.line_order, LineOrder::Increasing);
        assert_eq!(header.data_window(), header.shared_attributes.display_window);
        assert_eq!(header.own_attributes.layer_position, Vec2(0, 0));
    }

    fn write_channels(path: &Path, layers: Vec<Vec<(&str, FlatSamples)>>) {
        use ::exr::image::AnyChannel;
        let layer = |(i, channels): (usize, Vec<(&str, FlatSamples)>)| {
            let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
            let name = LayerAttributes::named(format!("part {i}").as_str());
            Layer::new((2, 1), name, Encoding::UNCOMPRESSED, AnyChannels::sort(list))
        };
        let layer_data: Layers<_> = layers.into_iter().enumerate().map(layer).collect();
        let attributes = ::exr::meta::header::ImageAttributes::with_size((2, 1));
        Image { attributes, layer_data }.write().to_file(path).unwrap();
    }

    #[test]
    fn files_of_others_are_read() {
        use ::exr::prelude::f16;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let half = |a: f32, b: f32| FlatSamples::F16(vec![f16::from_f32(a), f16::from_f32(b)]);
        let float = |a: f32, b: f32| FlatSamples::F32(vec![a, b]);
        let expected = [[1.0, 3.0, 5.0], [2.0, 4.0, f32::INFINITY]];

        write_channels(
            &path,
            vec![vec![
                ("R", half(1.0, 2.0)),
                ("G", float(3.0, 4.0)),
                ("B", half(5.0, f32::INFINITY)),
                ("A", half(1.0, 1.0)),
            ]],
        );
        let read = read_exr(&path).unwrap();
        assert_eq!(read.rgb, expected);
        assert_eq!((read.variance, read.samples, read.rejected), (None, None, None));

        // The picture is in the second part, after one of depth; then in a named layer.
        let rgb = |prefix: &'static [&'static str; 3]| {
            vec![(prefix[0], float(1.0, 2.0)), (prefix[1], float(3.0, 4.0)), (prefix[2], float(5.0, f32::INFINITY))]
        };
        write_channels(&path, vec![vec![("Z", float(0.0, 0.0))], rgb(&["R", "G", "B"])]);
        assert_eq!(read_exr(&path).unwrap().rgb, expected);
        write_channels(&path, vec![rgb(&["a.b.R", "a.b.G", "a.b.B"])]);
        assert_eq!(read_exr(&path).unwrap().rgb, expected);

        for names in [&["r", "g", "b"], &["Main.red", "Main.green", "Main.blue"]] {
            write_channels(&path, vec![rgb(names)]);
            assert_eq!(read_exr(&path).unwrap().rgb, expected, "{names:?}");
        }

        // Other layers are present, in any order of names; then the picture is ambiguous.
        let other = |names: &'static [&'static str; 3]| names.map(|name| (name, float(7.0, 7.0))).to_vec();
        for (picture, names) in [
            (rgb(&["R", "G", "B"]), &["A.R", "A.G", "A.B"]),
            (rgb(&["beauty.R", "beauty.G", "beauty.B"]), &["albedo.R", "albedo.G", "albedo.B"]),
            (rgb(&["C.R", "C.G", "C.B"]), &["A.R", "A.G", "A.B"]),
            (rgb(&["View.Combined.R", "View.Combined.G", "View.Combined.B"]), &["View.AO.R", "View.AO.G", "View.AO.B"]),
        ] {
            write_channels(&path, vec![[picture, other(names)].concat()]);
            assert_eq!(read_exr(&path).unwrap().rgb, expected, "{names:?}");
        }
        write_channels(&path, vec![[other(&["N.R", "N.G", "N.B"]), other(&["A.R", "A.G", "A.B"])].concat()]);
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(
            message.contains("which of its layers is the picture? It has part 0.A, part 0.N; expected"),
            "{message}"
        );
        write_channels(&path, vec![other(&["R", "G", "B"]), other(&["R", "G", "B"])]);
        assert!(read_exr(&path).unwrap_err().to_string().contains("It has part 0, part 1; expected"));

        write_channels(&path, vec![vec![("Y", half(1.0, 2.0)), ("R", FlatSamples::U32(vec![1, 2]))]]);
        let message = read_exr(&path).unwrap_err().to_string();
        assert!(
            message.contains("a.exr: cannot read: expected channels R, G and B") && message.contains("it has R, Y"),
            "{message}"
        );
    }

    #[test]
    fn damaged_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr: cannot read: "));
        assert!(read_exr(folder.path()).is_err());
        write_exr(&path, &picture(), &attributes()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let broken = folder.path().join("broken.exr");
        for length in (0..bytes.len()).step_by(7) {
            std::fs::write(&broken, &bytes[..length]).unwrap();
            assert!(read_exr(&broken).is_err(), "{length} of {} bytes", bytes.len());
        }
        // A header that asks for 2^62 bytes.
        let window = bytes.windows(11).position(|w| w == b"dataWindow\0").unwrap() + "dataWindow\0box2i\0".len() + 4;
        let mut huge = bytes.clone();
        huge[window..window + 16]
            .copy_from_slice(&[0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0x3f, 0xff, 0xff, 0xff, 0x3f]);
        std::fs::write(&broken, &huge).unwrap();
        assert!(read_exr(&broken).is_err());
    }

    #[test]
    fn attributes_that_cannot_be_written_are_errors_and_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for name in ["", "channels", "compression", &"x".repeat(256)] {
            assert!(write_exr(&path, &picture(), &[(name.into(), Attribute::Int(1))]).is_err(), "{name}");
        }
        assert!(!path.exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
