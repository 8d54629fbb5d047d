//! Textures. Those that no file has as they are become images of their own.

use std::path::Path;

use glam::DVec2;

use super::params::Params;
use super::reader::{AS_THEY_ARE, Mapping, Reader};
use crate::bitmap::{Channel, from_srgb};
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::gltf_path::has_ending;
use crate::scene::imported::Pattern;
use crate::scene::types::*;

/// The texture of a directive, with its mapping.
pub fn texture(kind: &str, is_colour: bool, params: &Params, reader: &mut Reader) -> Result<(Texture, Mapping)> {
    // Each texture that it is made of may have a mapping of its own.
    let inner = |name: &str, default: f64, is_colour: bool, reader: &mut Reader| {
        reader.mapping = None;
        let own = part(params, name, default, is_colour, reader)?;
        Ok((own, reader.mapping.take().unwrap_or(AS_THEY_ARE)))
    };
    let found = match kind {
        "constant" => inner("value", 1.0, is_colour, reader)?,
        "scale" => {
            let (own, scale) = (inner("tex", 1.0, is_colour, reader)?, inner("scale", 1.0, false, reader)?);
            match scale.0.plain() {
                Some(scale) => (own.0.map(|colour| scale.x * colour), own.1),
                None => made_of(params, is_colour, [own, scale], |[colour, scale]| scale * colour, reader)?,
            }
        }
        "mix" => {
            let (a, b) = (inner("tex1", 0.0, is_colour, reader)?, inner("tex2", 1.0, is_colour, reader)?);
            let parts = [a, b, inner("amount", 0.5, false, reader)?];
            made_of(params, is_colour, parts, |[a, b, amount]| a + amount * (b - a), reader)?
        }
        "checkerboard" => {
            let is_flat = params.integer_or("dimension", 2)? == 2;
            require(is_flat, || params.error_at("dimension", "expected 2: others are not read"))?;
            let (a, b) = (inner("tex1", 1.0, is_colour, reader)?, inner("tex2", 0.0, is_colour, reader)?);
            // Texture coordinates repeat at 1, where two squares have passed.
            let squares = mapping(params)?.map(|part| 0.5 * part);
            let is_b = Texture::Checker { scale: 0.5, even: Colour::ZERO, odd: Colour::ONE, uv: true };
            let of = |[a, b, is_b]: [Colour; 3]| a * (1.0 - is_b) + b * is_b;
            made_of(params, is_colour, [a, b, (is_b, squares)], of, reader)?
        }
        "imagemap" => (image_map(is_colour, params, reader)?, mapping(params)?),
        _ => {
            let message = "this texture is not read: expected constant, scale, mix, checkerboard or imagemap";
            return Err(params.error(message));
        }
    };
    reader.end(params);
    Ok(found)
}

/// The image of a file. A number is its alpha where that is not 1 everywhere, as pbrt has it, or the mean of its channels.
fn image_map(is_colour: bool, params: &Params, reader: &mut Reader) -> Result<Texture> {
    let file = params.word("filename")?.ok_or_else(|| params.error("expected its filename"))?;
    let path = reader.made.named(&reader.resolve(file, params.place_of("filename")));
    params.ignore(&["filter", "maxanisotropy"]);
    let wrap = match params.word("wrap")?.unwrap_or("repeat") {
        "repeat" => Wrap::Repeat,
        "clamp" => Wrap::Clamp,
        _ => return Err(params.error_at("wrap", "expected a wrap of repeat or clamp")),
    };
    let gamma = match params.word("encoding")?.unwrap_or("sRGB") {
        "sRGB" => None,
        "linear" => Some(1.0),
        other => {
            let gamma = other.strip_prefix("gamma ").and_then(|number| number.trim().parse::<f64>().ok());
            let gamma = gamma.filter(|gamma| *gamma > 0.0 && gamma.is_finite());
            let wrong = || params.error_at("encoding", "expected sRGB, linear, or gamma and a number above 0");
            Some(gamma.ok_or_else(wrong)?)
        }
    };
    let ends_in = |endings: &[&str]| has_ending(Path::new(file), endings);
    // Only a PNG has the encoding that the directive says: others are sRGB, or floats.
    let gamma = gamma.filter(|_| ends_in(&["png"]));
    let is_linear = gamma == Some(1.0) || ends_in(&["exr", "hdr", "pfm"]);
    let mut channel = gamma.map(|_| Channel::Rgb);
    let mut is_plain = is_linear || gamma.is_none();
    if !is_colour {
        let mut all = |channel: Channel, holds: fn([f32; 3]) -> bool| {
            let image = reader.made.image(&path, channel.decoding());
            let image = image.map_err(|reason| params.error_at("filename", format!("{path}: {reason}")));
            image.map(|image| image.texels().all(holds))
        };
        if ends_in(&["png", "exr"]) && !all(Channel::A, |[alpha, ..]| alpha == 1.0)? {
            channel = Some(Channel::A);
        } else if is_linear && all(Channel::Rgb, |[r, g, b]| r == g && g == b)? {
            channel = Some(Channel::R);
        }
        is_plain = is_linear && channel.is_some_and(|channel| channel != Channel::Rgb);
    }
    let (scale, inverts) = (params.number_or("scale", 1.0)?, params.flag_or("invert", false)?);
    let own = Texture::Image { path, tint: Colour::ONE, channel, uv_set: 0, wrap };
    if is_plain && !inverts {
        return Ok(own.map(|tint| scale * tint));
    }
    let linear = |code: f64| match gamma {
        Some(gamma) => code.powf(gamma),
        None if channel == Some(Channel::A) && !is_linear => from_srgb(code).into(),
        None => code,
    };
    let of = |[code]: [Colour; 1]| {
        let value = code.map(linear);
        let value = if is_colour { value } else { Colour::splat(value.element_sum() / 3.0) };
        if inverts { 1.0 - scale * value } else { value }
    };
    let own = baked(params, is_colour, [own], of, reader)?;
    Ok(if inverts { own } else { own.map(|tint| scale * tint) })
}

/// A texture whose values are `of` those of others, which have one mapping.
pub fn baked<const N: usize>(
    params: &Params,
    is_colour: bool,
    parts: [Texture; N],
    of: impl Fn([Colour; N]) -> Colour,
    reader: &mut Reader,
) -> Result<Texture> {
    let (found, _) = made_of(params, is_colour, parts.map(|part| (part, AS_THEY_ARE)), of, reader)?;
    Ok(found)
}

/// A texture whose values are `of` those of others, with its mapping. Where they are images, or differ in their mappings, it is an image that no file has.
/// pbrt interpolates between texels first, and then takes `of`. That is the same unless the last texture or squares multiply an image.
fn made_of<const N: usize>(
    params: &Params,
    is_colour: bool,
    parts: [(Texture, Mapping); N],
    of: impl Fn([Colour; N]) -> Colour,
    reader: &mut Reader,
) -> Result<(Texture, Mapping)> {
    let varying = parts.iter().filter(|(part, _)| part.needs_uv());
    let (images, squares): (Vec<_>, Vec<_>) = varying.partition(|(part, _)| part.decoded().is_some());
    let varying: Vec<&(Texture, Mapping)> = images.iter().chain(&squares).copied().collect();
    let mappings: Vec<Mapping> = varying.iter().map(|(_, own)| *own).collect();
    let (images, has_squares) = (images.len(), !squares.is_empty());
    let first = mappings.first().copied().unwrap_or(AS_THEY_ARE);
    if images == 0 && mappings.iter().all(|own| *own == first) {
        let colours = |is_odd: bool| parts.each_ref().map(|(part, _)| of_square(part, is_odd));
        let (even, odd) = (of(colours(false)), of(colours(true)));
        let squares = Texture::Checker { scale: 0.5, even, odd, uv: true };
        return Ok((if has_squares { squares } else { even.into() }, first));
    }
    let wrap = varying.first().map_or(Wrap::Repeat, |(part, _)| part.wrap());
    let repeats = |(part, own): &&(Texture, Mapping)| part.wrap() == wrap && (wrap == Wrap::Repeat || *own == first);
    let wraps = "expected one wrap of all its images: repeat, if they are in a checkerboard or of different mappings";
    require(varying.iter().all(repeats), || params.error(wraps))?;
    let wrong = "expected a uscale and a vscale whose ratio to those of its textures is a number such as 8, 1/2 or 3/2, in parts of 1/16 at least";
    let over = common(&mappings).ok_or_else(|| params.error(wrong))?;
    let mut sources = parts.map(|(texture, own)| {
        let scale = (own[0] / over[0]).round();
        Pattern { texture, bitmap: None, mapping: [scale, own[1] - scale * over[1]] }
    });
    for part in &mut sources {
        if let Some((path, decoding)) = part.texture.decoded() {
            let image = reader.made.image(path, decoding);
            part.bitmap = Some(image.map_err(|reason| params.error(format!("{path}: {reason}")))?);
        }
    }
    let mut texels = sources.iter().filter_map(|part| Some((part.texels()?, part.mapping[1])));
    let largest = texels.next();
    if texels.any(|own| Some(own) != largest) {
        reader.lose(params, "", "its images have different sizes or shifts: here all have the texels of one");
    }
    if has_squares {
        reader.lose(params, "", "the edges of its squares are a texel wide here");
    }
    if images > 1 && sources.last().is_some_and(|part| part.bitmap.is_some()) {
        reader.lose(params, "", "its images are multiplied at texels here: between them it differs");
    }
    let path = reader.made.add_image(&sources, of).map_err(|reason| params.error(reason))?;
    let channel = (!is_colour).then_some(Channel::R);
    Ok((Texture::Image { path, tint: Colour::ONE, channel, uv_set: 0, wrap }, over))
}

/// The colour of a texture in a square.
fn of_square(texture: &Texture, is_odd: bool) -> Colour {
    match texture {
        Texture::Checker { odd, .. } if is_odd => *odd,
        Texture::Checker { even, .. } => *even,
        other => other.plain().unwrap_or_default(),
    }
}

/// The mapping of an image that holds each of these textures a whole number of times. It begins where the first one does.
fn common(all: &[Mapping]) -> Option<Mapping> {
    let mut found = AS_THEY_ARE;
    let first = all.first()?;
    for axis in 0..2 {
        let least = all.iter().map(|own| own[0][axis]).min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let is_whole = |ratio: f64| (ratio - ratio.round()).abs() <= 1e-6;
        let fits = |scale: &f64| all.iter().all(|own| is_whole(own[0][axis] / scale));
        let scale = (1..=16).map(|parts| least / f64::from(parts)).find(fits)?;
        (found[0][axis], found[1][axis]) = (scale, first[1][axis] / (first[0][axis] / scale).round());
    }
    Some(found)
}

fn mapping(params: &Params) -> Result<Mapping> {
    let is_uv = params.word("mapping")?.is_none_or(|mapping| mapping == "uv");
    require(is_uv, || params.error_at("mapping", "expected uv: other mappings are not read"))?;
    let both = |u: &str, v: &str, usual| Ok(DVec2::new(params.number_or(u, usual)?, params.number_or(v, usual)?));
    Ok([both("uscale", "vscale", 1.0)?, both("udelta", "vdelta", 0.0)?])
}

/// A number from 0 to 1 that may be a texture.
pub fn number_or(params: &Params, name: &str, default: f64, reader: &mut Reader) -> Result<Texture> {
    up_to_1(params, name, default, false, reader)
}

/// A colour from 0 to 1 that may be a texture.
pub fn texture_or(params: &Params, name: &str, default: f64, reader: &mut Reader) -> Result<Texture> {
    up_to_1(params, name, default, true, reader)
}

/// Cuts what an image has above 1 where it is multiplied, as pbrt does.
fn up_to_1(params: &Params, name: &str, default: f64, is_colour: bool, reader: &mut Reader) -> Result<Texture> {
    let own = part(params, name, default, is_colour, reader)?;
    let Texture::Image { path, tint, .. } = &own else { return Ok(own) };
    match tint.max_element() > 1.0 || reader.made.images.colours(path).is_some_and(|image| image.brightest(*tint) > 1.0)
    {
        true => baked(params, is_colour, [own], |[colour]| colour.min(Colour::ONE), reader),
        false => Ok(own),
    }
}

/// A number or a colour that may be a texture.
fn part(params: &Params, name: &str, default: f64, is_colour: bool, reader: &mut Reader) -> Result<Texture> {
    let Some(texture) = params.texture(name)? else {
        return Ok(match is_colour {
            true => params.colour(name)?.unwrap_or(Colour::splat(default)).into(),
            false => Texture::grey(params.number_or(name, default)?),
        });
    };
    let kind = if is_colour { "spectrum" } else { "float" };
    let missing = || params.error_at(name, format!("there is no {kind} texture {} above", quote(texture)));
    let (found, mapping) = reader.textures.get(&(is_colour, texture.to_owned())).cloned().ok_or_else(missing)?;
    if found.needs_uv() && !reader.has_mapping(mapping) {
        return Err(params.error_at(name, "expected one mapping of all textures of a surface, found another"));
    }
    Ok(found)
}
