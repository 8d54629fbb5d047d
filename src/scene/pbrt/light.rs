//! Lights.

use glam::DVec3;

use super::params::{Params, Spectrum};
use super::reader::{Area, Medium, Reader};
use crate::error::Result;
use crate::printable::quote;
use crate::scene::types::{Background, Colour, Falloff, Object};

/// The light of a parameter, times its `scale` and that of the film. Without it, that of the colour space's white.
fn emitted(params: &Params, name: &str, reader: &Reader) -> Result<Colour> {
    let colour = match params.spectrum(name)? {
        None => Colour::ONE,
        Some(Spectrum::Rgb(colour) | Spectrum::Curve { light: colour, .. }) => colour,
        Some(Spectrum::Named(name)) if ["stdillum-D65", "illum-D65"].contains(&name.as_str()) => Colour::ONE,
        Some(Spectrum::Named(other)) => {
            return Err(
                params.error_at(name, format!("the spectrum {} is not read: give rgb or blackbody", quote(&other)))
            );
        }
    };
    for name in ["power", "illuminance"] {
        if params.has(name) {
            return Err(params.error_at(name, format!("{name} is not read: give the light its scale")));
        }
    }
    Ok(colour * (params.number_or("scale", 1.0)? * reader.film.scale))
}

pub fn area(kind: &str, params: Params, reader: &mut Reader) -> Result<Area> {
    if kind != "diffuse" {
        return Err(params.error("this area light is not read: expected diffuse"));
    }
    let radiance = emitted(&params, "L", reader)?;
    if params.has("filename") {
        return Err(params.error_at("filename", "an image of an area light is not read"));
    }
    let is_two_sided = params.flag_or("twosided", false)?;
    reader.end(&params);
    Ok(Area { radiance, is_two_sided, at: params.at })
}

pub fn light(kind: &str, params: &Params, reader: &mut Reader) -> Result<()> {
    let ctm = reader.state.ctm;
    let from = ctm.transform_point3(params.point_or("from", DVec3::ZERO)?);
    let object = match kind {
        "point" => Object::PointLight { at: from, intensity: emitted(params, "I", reader)? },
        "spot" => {
            let towards = ctm.transform_point3(params.point_or("to", DVec3::Z)?);
            let outer = params.number_or("coneangle", 30.0)?;
            let inner = outer - params.number_or("conedeltaangle", 5.0)?;
            let intensity = emitted(params, "I", reader)?;
            Object::SpotLight { at: from, towards, intensity, inner, outer, falloff: Falloff::Smooth }
        }
        "distant" => {
            let to = ctm.transform_point3(params.point_or("to", DVec3::Z)?);
            Object::DirectionalLight { direction: to - from, irradiance: emitted(params, "L", reader)? }
        }
        "infinite" => {
            if reader.background.is_some() {
                return Err(params.error("expected one infinite light, found another"));
            }
            if params.has("filename") {
                let message = "an image of an infinite light is not read, as it is not in latitude and longitude";
                return Err(params.error_at("filename", message));
            }
            reader.places.insert("background".to_owned(), params.at.location());
            reader.background = Some(Background::Solid(emitted(params, "L", reader)?));
            reader.end(params);
            return Ok(());
        }
        _ => return Err(params.error("this light is not read: expected point, spot, distant or infinite")),
    };
    reader.end(params);
    reader.add_object(object, &params.at);
    Ok(())
}

/// The medium of a directive.
pub fn medium(params: &Params, reader: &mut Reader) -> Result<Medium> {
    if params.word("type")?.unwrap_or("homogeneous") != "homogeneous" {
        return Err(params.error_at("type", "expected homogeneous: other media are not read"));
    }
    let scale = params.number_or("scale", 1.0)?;
    let (Some(absorbed), Some(scattered)) = (params.colour("sigma_a")?, params.colour("sigma_s")?) else {
        return Err(params.error("expected sigma_a and sigma_s"));
    };
    if absorbed.min_element().min(scattered.min_element()) < 0.0 || scale < 0.0 {
        return Err(params.error("expected sigma_a, sigma_s and a scale of 0 or more"));
    }
    let extinction = absorbed + scattered;
    let share = |scattered: f64, all: f64| if all > 0.0 { scattered / all } else { 0.0 };
    let albedo = Colour::new(
        share(scattered.x, extinction.x),
        share(scattered.y, extinction.y),
        share(scattered.z, extinction.z),
    );
    let anisotropy = params.number_or("g", 0.0)?;
    reader.end(params);
    Ok(Medium { extinction: scale * extinction, albedo, anisotropy, at: params.at.clone() })
}
