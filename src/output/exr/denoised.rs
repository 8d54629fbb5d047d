//! Reads the picture and the layers that a denoiser needs from an EXR, and writes the denoised image.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use ::exr::math::Vec2;
use ::exr::meta::attribute::LineOrder;
use ::exr::meta::header::{Header, LayerAttributes};

use super::attribute::{Attribute, DENOISER, attribute, decoded, text, to_io};
use super::read::{
    attributes_of, find_rgb, float, light_layers, note_of_colours, open, read_channels, read_layer, triple,
};
use super::write::{OF_PICTURE, sort_attributes};
use crate::aov::MATTE_ATTRIBUTES;
use crate::chromaticities::{REC_709, to_rec_709};
use crate::data::{CHANNELS, Rgb};
use crate::denoise::Noisy;
use crate::error::{Error, Result};
use crate::output::atomic;

/// A picture, the layers that help to denoise it, and its header.
pub struct NoisyFile {
    pub image: Noisy,
    /// The layers of groups of lights, by their names.
    pub lights: Vec<(String, Vec<Rgb<f32>>)>,
    /// The note for users about its colours, if they were not those of Rec. 709.
    pub colours: Option<String>,
    header: Header,
}

/// Names of the layers with the albedo and with the normal, the likeliest first: this program's, those of others, and Blender's. The
/// names of other layers and points can precede them.
const ALBEDOS: [&str; 3] = ["albedo", "denoising albedo", "diffcol"];
const NORMALS: [&str; 3] = ["n", "normal", "denoising normal"];
const COMPONENTS: [Rgb<&str>; 2] = [CHANNELS, ["X", "Y", "Z"]];

const BIASES: &str = "gpu-rt:biases";
/// The attributes that are true of the image with its noise only: those of its error.
const OF_NOISE: [&str; 7] = [
    "gpu-rt:relative_error",
    "gpu-rt:relative_error_bound",
    "gpu-rt:relative_error_confidence",
    "gpu-rt:relative_error_excludes",
    "gpu-rt:reliable",
    "gpu-rt:noise",
    "gpu-rt:noise_reached",
];
const COMMENTS: &str = "R, G, B: linear radiance, denoised. Denoising biases the result, and its error is not known.";

/// Whether an attribute is true of the image by itself, with another error and without mattes.
pub fn of_image_alone(name: &str) -> bool {
    !OF_NOISE.contains(&name) && !name.starts_with(MATTE_ATTRIBUTES)
}

impl NoisyFile {
    /// The denoiser that has denoised it already.
    pub fn denoiser(&self) -> Option<String> {
        attribute(&attributes_of(&self.header), DENOISER).map(|value| match value {
            Attribute::Text(words) => words.clone(),
            _ => "unknown".to_string(),
        })
    }
}

/// Reads the picture that [`read_exr`](super::read_exr) reads, and what the same part has of albedo and normal. Colours are those of Rec. 709.
pub fn read_noisy(path: &Path) -> Result<NoisyFile> {
    let noisy = read(path).map_err(Error::file(path, "read"))?;
    let light = |(_, layer): (String, String)| read_layer(path, &layer).map(|image| (layer, image.rgb));
    Ok(NoisyFile { lights: light_layers(path)?.into_iter().map(light).collect::<Result<_>>()?, ..noisy })
}

fn read(path: &Path) -> std::result::Result<NoisyFile, String> {
    let opened = open(path)?;
    let picture = find_rgb(opened.headers())?;
    let (part, mut header) = (picture.number, opened.headers()[picture.number].clone());
    let wanted = [Some(picture.channels), layer(&header, &ALBEDOS), layer(&header, &NORMALS)];
    let numbers = |names: Rgb<String>| -> Option<[usize; 3]> {
        let [r, g, b] = names.map(|name| float(&header, &name));
        Some([r?, g?, b?])
    };
    let wanted = wanted.map(|names| names.and_then(numbers));
    let Vec2(width, height) = header.layer_size;
    let ([mut rgb, mut albedo, normal], _) = read_channels(opened, part, 72, wanted, [None; 2])?;
    let conversion = to_rec_709(header.shared_attributes.chromaticities);
    let colours = note_of_colours(&conversion);
    if let Ok(Some(conversion)) = conversion {
        let of_colours = [&mut rgb, &mut albedo].into_iter().flatten().flatten();
        of_colours.for_each(|rgb| *rgb = conversion.convert(*rgb));
        header.shared_attributes.chromaticities = Some(REC_709);
    }
    let side = |length: usize| u32::try_from(length).map_err(|_| "its size is not supported".to_string());
    let (size, rgb) = ((side(width)?, side(height)?), rgb.ok_or("its channels differ in size")?);
    Ok(NoisyFile { image: Noisy { size, rgb, albedo, normal }, lights: Vec::new(), colours, header })
}

/// The channels of the layer with the likeliest of some names.
fn layer(header: &Header, names: &[&str]) -> Option<Rgb<String>> {
    let channels = || header.channels.list.iter().map(|channel| channel.name.to_string());
    let of_name = |name: &&str| {
        let is_named = |layer: &str| layer.rsplit('.').next().is_some_and(|last| last.to_lowercase() == **name);
        channels().find_map(|channel| {
            let (layer, _) = channel.rsplit_once('.').filter(|(layer, _)| is_named(layer))?;
            triple(header, layer, &COMPONENTS)
        })
    };
    names.iter().find_map(of_name)
}

/// Writes the denoised picture of a file: red, green and blue, and the layers of groups of lights. The header is that of the file as far as it is still
/// true, with the denoiser's name. It has neither variance nor state, so that nothing takes it for a render.
pub fn write_denoised(
    path: &Path,
    noisy: &NoisyFile,
    rgb: &[Rgb<f32>],
    lights: &[Vec<Rgb<f32>>],
    denoiser: &str,
) -> Result<()> {
    let mut own = LayerAttributes {
        layer_name: None,
        software_name: Some(text(concat!("gpu-rt ", env!("CARGO_PKG_VERSION")))),
        comments: Some(text(COMMENTS)),
        ..noisy.header.own_attributes.clone()
    };
    own.other.retain(|name, _| of_image_alone(&decoded(name)));
    let before = match own.other.get(&text(BIASES)).and_then(Attribute::of_exr) {
        Some(Attribute::Text(before)) => format!("{before}, "),
        _ => String::new(),
    };
    for (name, value) in [(BIASES, format!("{before}denoise")), (DENOISER, denoiser.to_string())] {
        own.other.insert(text(name), Attribute::Text(value).to_exr());
    }
    let channels = |(before, image): (String, &[Rgb<f32>])| {
        let of = |c: usize| FlatSamples::F32(image.iter().map(|rgb| rgb[c]).collect());
        [0, 1, 2].map(|c| AnyChannel::new(format!("{before}{}", CHANNELS[c]).as_str(), of(c)))
    };
    let layers = noisy.lights.iter().zip(lights).map(|((layer, _), image)| (format!("{layer}."), image.as_slice()));
    let all = std::iter::once((String::new(), rgb)).chain(layers).flat_map(channels);
    let encoding = Encoding { compression: OF_PICTURE, line_order: LineOrder::Increasing, ..Encoding::UNCOMPRESSED };
    let layer = Layer::new(noisy.header.layer_size, own, encoding, AnyChannels::sort(all.collect()));
    let image = Image { attributes: noisy.header.shared_attributes.clone(), layer_data: layer };
    let write = |file: &mut File| {
        image.write().to_buffered(BufWriter::new(&mut *file)).map_err(to_io)?;
        sort_attributes(file, 1)
    };
    atomic::replace(path, write)
}
