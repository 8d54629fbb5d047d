//! Textures. Those that no file has as they are become images of their own.

use std::path::Path;

use glam::DVec2;

use super::params::Params;
use super::reader::{AS_THEY_ARE, Mapping, Reader};
use crate::bitmap::{Channel, Decoding, from_srgb};
use crate::error::Result;
use crate::printable::quote;
use crate::scene::gltf_path::has_ending;
use crate::scene::imported::Part;
use crate::scene::types::*;

/// The texture of a directive.
pub fn texture(kind: &str, is_colour: bool, params: &Params, reader: &mut Reader) -> Result<(Texture, Mapping)> {
    reader.mapping = None;
    let one = |name: &str, default: f64, reader: &mut Reader| part(params, name, default, is_colour, reader);
    let found = match kind {
        "constant" => one("value", 1.0, reader)?,
        "scale" => {
            let (texture, scale) = (one("tex", 1.0, reader)?, part(params, "scale", 1.0, false, reader)?);
            match scale.plain() {
                Some(scale) => texture.map(|colour| scale.x * colour),
                None => baked(params, is_colour, [texture, scale], |[colour, scale]| scale * colour, reader)?,
            }
        }
        "mix" => {
            let (a, b) = (one("tex1", 0.0, reader)?, one("tex2", 1.0, reader)?);
            let parts = [a, b, part(params, "amount", 0.5, false, reader)?];
            baked(params, is_colour, parts, |[a, b, amount]| a + amount * (b - a), reader)?
        }
        "checkerboard" => {
            if params.integer_or("dimension", 2)? != 2 {
                return Err(params.error_at("dimension", "expected 2: others are not read"));
            }
            let wrong = |name| move || params.error_at(name, "a texture in a checkerboard is not read");
            let mut plain = |name, default| one(name, default, reader)?.plain().ok_or_else(wrong(name));
            Texture::Checker { scale: 0.5, even: plain("tex1", 1.0)?, odd: plain("tex2", 0.0)?, uv: true }
        }
        "imagemap" => image_map(is_colour, params, reader)?,
        _ => {
            let message = "this texture is not read: expected constant, scale, mix, checkerboard or imagemap";
            return Err(params.error(message));
        }
    };
    let own = match kind {
        "imagemap" => Some(mapping(params)?),
        // Texture coordinates repeat at 1, where two squares have passed.
        "checkerboard" => Some(mapping(params)?.map(|part| 0.5 * part)),
        _ => None,
    };
    reader.end(params);
    Ok((found, own.or(reader.mapping.take()).unwrap_or(AS_THEY_ARE)))
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

/// A texture whose values are `of` those of others: where they are images, an image that no file has. pbrt takes `of` what it interpolates between texels,
/// which is the same unless an image is multiplied by the last one.
pub fn baked<const N: usize>(
    params: &Params,
    is_colour: bool,
    parts: [Texture; N],
    of: impl Fn([Colour; N]) -> Colour,
    reader: &mut Reader,
) -> Result<Texture> {
    let mut sources: [Part; N] = std::array::from_fn(|_| (None, Colour::ZERO));
    for (source, part) in sources.iter_mut().zip(&parts) {
        *source = match (part, part.plain()) {
            (_, Some(colour)) => (None, colour),
            (Texture::Image { path, tint, channel, .. }, _) => {
                let image = reader.made.image(path, channel.map_or(Decoding::Colour, Channel::decoding));
                (Some(image.map_err(|reason| params.error(format!("{path}: {reason}")))?), *tint)
            }
            _ => return Err(params.error("a checkerboard in it is not read")),
        };
    }
    let mut images = parts.iter().zip(&sources).filter_map(|(part, (image, _))| Some((part.wrap(), image.as_ref()?)));
    let Some((wrap, first)) = images.next() else { return Ok(of(sources.map(|(_, colour)| colour)).into()) };
    if images.clone().any(|(other, _)| other != wrap) {
        return Err(params.error("expected one wrap of all its images"));
    }
    if images.clone().any(|(_, other)| (other.width, other.height) != (first.width, first.height)) {
        reader.lose(params, "", "its images have different sizes: here all have that of the largest");
    }
    if images.next().is_some() && sources.last().is_some_and(|(image, _)| image.is_some()) {
        reader.lose(params, "", "its images are multiplied at texels here: between them it differs");
    }
    let path = reader.made.add_image(&sources, wrap, of).map_err(|reason| params.error(reason))?;
    Ok(Texture::Image { path, tint: Colour::ONE, channel: (!is_colour).then_some(Channel::R), uv_set: 0, wrap })
}

fn mapping(params: &Params) -> Result<Mapping> {
    if params.word("mapping")?.is_some_and(|mapping| mapping != "uv") {
        return Err(params.error_at("mapping", "expected uv: other mappings are not read"));
    }
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
