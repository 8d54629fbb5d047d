//! Emitters that are no surfaces, and media.

use glam::{DAffine3, DMat3, DVec3};

use super::document::Node;
use super::properties::{Properties, unknown};
use super::reader::Reader;
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::imported::surface::Medium;
use crate::scene::imported::transform::turns;
use crate::scene::sky::SKY;
use crate::scene::types::{Background, Colour, Falloff, Object, SkyLayout};

/// Half a turn around y: their skies have +z in the middle, ours -z.
const HALF_TURN: DMat3 = DMat3::from_cols(DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z);

/// Adds a light, or sets the one around the scene.
pub fn emitter(node: &Node, reader: &mut Reader) -> Result<()> {
    let own = Properties::of(node);
    let kind = own.kind()?;
    own.ignore(&["sampling_weight"]);
    match kind {
        "constant" | "envmap" | "sky" | "sunsky" => {
            let found = background(kind, &own, reader)?;
            reader.made.set_background(found, &node.title(), &node.at)?;
        }
        _ => {
            let found = light(kind, &own)?;
            reader.made.add_object(found, &node.at);
        }
    }
    own.end(reader);
    Ok(())
}

fn background(kind: &str, own: &Properties, reader: &mut Reader) -> Result<Background> {
    let node = own.node;
    let to_world = own.transform("to_world")?;
    Ok(match kind {
        "constant" => Background::Solid(own.colour_or("radiance", 1.0)?),
        "envmap" => {
            let path = own.word("filename")?.ok_or_else(|| node.error("expected its filename"))?;
            own.ignore(&["mis_compensation"]);
            let tint = Colour::splat(own.number_or("scale", 1.0)?);
            let by = turns(&(to_world * DAffine3::from_mat3(HALF_TURN)));
            let by = by.ok_or_else(|| node.error("expected a to_world that turns the sky alone, without a scale"))?;
            let (path, layout) = (reader.path(path, node), SkyLayout::LatitudeLongitude);
            Background::Image { path, tint, by, layout }
        }
        _ => {
            own.take(|_| true);
            reader.lose(node, "it becomes a white and blue sky, without a sun: its radiance is another");
            SKY
        }
    })
}

fn light(kind: &str, own: &Properties) -> Result<Object> {
    let (node, to_world) = (own.node, own.transform("to_world")?);
    Ok(match kind {
        "point" => {
            let at = own.vector("position")?.unwrap_or(to_world.translation);
            Object::PointLight { at, intensity: own.colour_or("intensity", 1.0)?, light_group: None }
        }
        "directional" => {
            let direction = own.vector("direction")?.unwrap_or(to_world.matrix3.z_axis);
            Object::DirectionalLight { direction, irradiance: own.colour_or("irradiance", 1.0)?, light_group: None }
        }
        "spot" => {
            require(own.find("texture").is_none(), || node.error("a texture of a spot is not read"))?;
            let outer = own.number_or("cutoff_angle", 20.0)?;
            let inner = own.number_or("beam_width", 0.75 * outer)?;
            let (at, forward) = (to_world.translation, to_world.matrix3.z_axis.normalize_or_zero());
            require(forward != DVec3::ZERO, || node.error("expected a to_world with a direction"))?;
            let (towards, intensity) = (at + forward, own.colour_or("intensity", 1.0)?);
            let falloff = Falloff::Linear;
            Object::SpotLight { at, towards, intensity, inner, outer, falloff, light_group: None }
        }
        _ => return Err(unknown(node, "area, point, spot, directional, constant, envmap, sky, sunsky")),
    })
}

pub fn medium(node: &Node, reader: &mut Reader) -> Result<Medium> {
    let own = Properties::of(node);
    own.kind_among(&["homogeneous"])?;
    own.ignore(&["has_spectral_extinction", "sample_emitters"]);
    // Scenes before 2 may have absorption and scattering in place of their sum.
    let (absorption, scattering) = (own.colour_or("sigma_a", 0.0)?, own.colour_or("sigma_s", 0.0)?);
    let is_old = own.has("sigma_a") || own.has("sigma_s");
    let sum = if is_old { absorption + scattering } else { own.colour_or("sigma_t", 1.0)? };
    let extinction = sum * own.number_or("scale", 1.0)?;
    let albedo =
        if is_old { scattering / sum.max(Colour::splat(f64::MIN_POSITIVE)) } else { own.colour_or("albedo", 0.75)? };
    if extinction != Colour::splat(extinction.x) && albedo != Colour::ZERO {
        let found = extinction.to_array();
        let message = format!("expected one number for all channels, or an albedo of 0, found {found:?}");
        return Err(own.find("sigma_t").unwrap_or(node).error(message));
    }
    let mut anisotropy = 0.0;
    for phase in own.take(|child| child.tag == "phase") {
        let of_phase = Properties::of(phase);
        anisotropy = match of_phase.kind()? {
            "isotropic" => 0.0,
            "hg" => of_phase.number_or("g", 0.8)?,
            other => return Err(phase.error_at("type", format!("expected isotropic or hg, found {}", quote(other)))),
        };
        of_phase.end(reader);
    }
    own.end(reader);
    Ok(Medium { extinction, albedo, anisotropy })
}
