//! Lights.

use std::f64::consts::PI;

use glam::DVec3;

use super::params::{Params, Spectrum};
use super::reader::{Area, Reader};
use crate::bitmap::Decoding;
use crate::data::luminance;
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::imported::surface::Medium;
use crate::scene::imported::tables;
use crate::scene::imported::transform::turns;
use crate::scene::types::{Background, Bitmap, Colour, Falloff, Object, SkyLayout};

/// The light of a parameter, or white without it, times its `scale` and that of the film. `total`: the name of the power or of the illuminance,
/// which may be given too, and its value for a light of 1.
fn emitted(params: &Params, name: &str, total: (&str, f64), reader: &Reader) -> Result<Colour> {
    let colour = match params.spectrum(name)? {
        None => Colour::ONE,
        Some(Spectrum::Rgb(colour) | Spectrum::Curve { light: colour, .. }) => colour,
        Some(Spectrum::Named(other)) => {
            let known = tables::row(tables::ILLUMINANTS, &other).and_then(|row| <[f64; 3]>::try_from(row).ok());
            let message = || format!("the spectrum {} is not read: give rgb or blackbody", quote(&other));
            Colour::from_array(known.ok_or_else(|| params.error_at(name, message()))?)
        }
    };
    let scale = params.number_or("scale", 1.0)? * reader.film.scale;
    let (name, of_one) = total;
    Ok(match params.number(name)?.filter(|total| *total > 0.0) {
        Some(_) if of_one == 0.0 => return Err(params.error_at(name, "expected an image that is not black")),
        Some(total) => colour * (scale * total / of_one),
        None => colour * scale,
    })
}

pub fn area(kind: &str, params: Params, reader: &mut Reader) -> Result<Area> {
    require(kind == "diffuse", || params.error("this area light is not read: expected diffuse"))?;
    let sides = if params.flag_or("twosided", false)? { 2.0 } else { 1.0 };
    let radiance = emitted(&params, "L", ("power", sides), reader)?;
    let is_power = params.number_or("power", 0.0)? > 0.0;
    require(!params.has("filename"), || params.error_at("filename", "an image of an area light is not read"))?;
    reader.end(&params);
    Ok(Area { radiance, is_two_sided: sides == 2.0, is_power, at: params.at })
}

pub fn light(kind: &str, params: &Params, reader: &mut Reader) -> Result<()> {
    let ctm = reader.state.ctm;
    let from = ctm.transform_point3(params.point_or("from", DVec3::ZERO)?);
    if kind == "goniometric" {
        params.ignore(&["filename"]);
        reader.lose(params, "", "its image is not used: it becomes a point light");
    }
    let object = match kind {
        "point" | "goniometric" => {
            let intensity = emitted(params, "I", ("power", 4.0 * PI), reader)?;
            Object::PointLight { at: from, intensity, light_group: None }
        }
        "spot" => {
            let towards = ctm.transform_point3(params.point_or("to", DVec3::Z)?);
            let outer = params.number_or("coneangle", 30.0)?;
            let inner = outer - params.number_or("conedeltaangle", 5.0)?;
            // The light falls by a half between both cones.
            let [full, none] = [inner, outer].map(|angle| 1.0 - angle.to_radians().cos());
            let intensity = emitted(params, "I", ("power", PI * (full + none)), reader)?;
            let (at, falloff) = (from, Falloff::Smooth);
            Object::SpotLight { at, towards, intensity, inner, outer, falloff, light_group: None }
        }
        "distant" => {
            let to = ctm.transform_point3(params.point_or("to", DVec3::Z)?);
            let irradiance = emitted(params, "L", ("illuminance", 1.0), reader)?;
            Object::DirectionalLight { direction: to - from, irradiance, light_group: None }
        }
        "infinite" => {
            if params.has("portal") {
                params.ignore(&["portal"]);
                reader.lose(params, "portal", "its light comes from beside its portal too");
            }
            let file = params.word("filename")?;
            let path = file.map(|file| reader.made.named(&reader.resolve(file, params.place_of("filename"))));
            let of_plane = match &path {
                Some(path) if params.has("illuminance") => {
                    let image = reader.made.image(path, Decoding::Colour);
                    illuminance(&image.map_err(|reason| params.error_at("filename", format!("{path}: {reason}")))?)
                }
                _ => PI,
            };
            let tint = emitted(params, "L", ("illuminance", of_plane), reader)?;
            let background = match path {
                None => Background::Solid(tint),
                Some(path) => {
                    let by =
                        turns(&ctm).ok_or_else(|| params.error("expected a transform that turns the sky alone"))?;
                    Background::Image { path, tint, by, layout: SkyLayout::Octahedral }
                }
            };
            reader.end(params);
            return reader.made.set_background(background, &params.title, &params.at);
        }
        _ => return Err(params.error("this light is not read: expected point, spot, distant or infinite")),
    };
    reader.end(params);
    reader.add_object(object, &params.at);
    Ok(())
}

/// The illuminance of an image on the plane of its own x and y, as pbrt counts it: half of what falls there.
fn illuminance(image: &Bitmap) -> f64 {
    let (width, height) = (image.width as usize, image.height as usize);
    let from_middle = |cell: usize, side: usize| ((2.0 * cell as f64 + 1.0) / side as f64 - 1.0).abs();
    let of_texel = |(index, texel): (usize, [f32; 3])| {
        let cos = 1.0 - (from_middle(index % width, width) + from_middle(index / width, height)).powi(2);
        cos.max(0.0) * luminance(texel.map(f64::from))
    };
    2.0 * PI / image.len() as f64 * image.texels().enumerate().map(of_texel).sum::<f64>()
}

/// The medium of a directive.
pub fn medium(params: &Params, reader: &mut Reader) -> Result<Medium> {
    let is_even = params.word("type")?.is_none_or(|kind| kind == "homogeneous");
    require(is_even, || params.error_at("type", "expected homogeneous: other media are not read"))?;
    let scale = params.number_or("scale", 1.0)?;
    let (Some(absorbed), Some(scattered)) = (params.colour("sigma_a")?, params.colour("sigma_s")?) else {
        return Err(params.error("expected sigma_a and sigma_s"));
    };
    let least = absorbed.min(scattered).min_element().min(scale);
    require(least >= 0.0, || params.error("expected sigma_a, sigma_s and a scale of 0 or more"))?;
    let extinction = absorbed + scattered;
    let share = |scattered: f64, all: f64| if all > 0.0 { scattered / all } else { 0.0 };
    let albedo = Colour::new(
        share(scattered.x, extinction.x),
        share(scattered.y, extinction.y),
        share(scattered.z, extinction.z),
    );
    let anisotropy = params.number_or("g", 0.0)?;
    reader.end(params);
    Ok(Medium { extinction: scale * extinction, albedo, anisotropy })
}
