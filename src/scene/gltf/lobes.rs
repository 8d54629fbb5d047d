//! The extensions of a glTF material that the crate does not read: those that the lobes name (src/lobe), and GPU_RT_materials_multiscatter of
//! the extension for Blender.

use gltf::json::extensions::texture;
use gltf::json::material::Material as Given;
use gltf::json::texture::Info;
use serde_json::Value;

use super::{GltfError, Result};
use crate::lobe::{Gltf, GltfField, LOBES, Lobe, To};
use crate::material::Material;
use crate::scene::types::Colour;

/// It makes up for the light that its microfacets reflect more than once. No extension of glTF's own says that.
const MULTISCATTER: &str = "GPU_RT_materials_multiscatter";

fn all() -> impl Iterator<Item = (&'static Lobe, &'static Gltf)> {
    LOBES.iter().filter_map(|lobe| Some((*lobe, lobe.gltf.as_ref()?)))
}

/// Whether an extension is read here.
pub fn is_read(extension: &str) -> bool {
    extension == MULTISCATTER || all().any(|(_, own)| own.extension == extension)
}

fn extension<'a>(given: &'a Given, name: &str) -> Option<&'a Value> {
    given.extensions.as_ref()?.others.get(name)
}

pub fn multiscatter(given: &Given) -> bool {
    extension(given, MULTISCATTER).is_some()
}

/// Where a field of a lobe stands in the JSON of its material.
pub fn place(of: &Gltf, name: &str) -> String {
    format!("extensions.{}.{name}", of.extension)
}

/// A texture, of which the crate reads KHR_texture_transform only if it knows its place.
fn info_of(value: &Value) -> serde_json::Result<Info> {
    let mut info: Info = serde_json::from_value(value.clone())?;
    let transform = value.get("extensions").and_then(|found| found.get("KHR_texture_transform"));
    if let Some(transform) = transform {
        let texture_transform = Some(serde_json::from_value(transform.clone())?);
        info.extensions = Some(texture::Info { texture_transform, others: Default::default() });
    }
    Ok(info)
}

/// Refuses what is of a wrong type; `at` is the path of the material.
pub fn check(given: &Given, at: &str) -> Result<()> {
    for (_, own) in all() {
        let Some(found) = extension(given, own.extension) else { continue };
        for field in own.fields {
            let is_colour =
                |value: &Value| value.as_array().is_some_and(|all| all.len() == 3 && all.iter().all(Value::is_number));
            let (is_right, expected) = match (&field.to, found.get(field.factor)) {
                (_, None) => (true, ""),
                (To::Colour(..), Some(value)) => (is_colour(value), "three numbers"),
                (_, Some(value)) => (value.is_number(), "a number"),
            };
            let wrong = |name: &str, expected: &str| {
                Err(GltfError::new(format!("{at}.{}", place(own, name)), format!("expected {expected}")))
            };
            if !is_right {
                return wrong(field.factor, expected);
            }
            if found.get(field.texture).is_some_and(|value| info_of(value).is_err()) {
                return wrong(field.texture, "a texture: an object with an index");
            }
        }
    }
    Ok(())
}

/// A number, if the file gives it.
pub fn number(given: &Given, of: &Gltf, name: &str) -> Option<f64> {
    extension(given, of.extension)?.get(name)?.as_f64()
}

/// The factor of a share, cut to 0..1.
pub fn share(given: &Given, of: &Gltf, name: &str) -> f64 {
    let default = if name.is_empty() { 1.0 } else { 0.0 };
    number(given, of, name).unwrap_or(default).clamp(0.0, 1.0)
}

/// A colour, cut to 0..1.
pub fn colour(given: &Given, of: &Gltf, name: &str, default: f64) -> Colour {
    let factor = extension(given, of.extension).and_then(|found| found.get(name)?.as_array());
    let channel = |c: usize| factor.and_then(|factor| factor.get(c)?.as_f64()).unwrap_or(default);
    Colour::new(channel(0), channel(1), channel(2)).clamp(Colour::ZERO, Colour::ONE)
}

/// Whether the factor of a field leaves anything of it.
fn is_left(given: &Given, of: &Gltf, field: &GltfField) -> bool {
    match field.to {
        To::Share(..) => share(given, of, field.factor) > 0.0,
        To::Colour(default, _) => colour(given, of, field.factor, default) != Colour::ZERO,
        To::Number(_) => number(given, of, field.factor).is_some_and(|number| number > 0.0),
        To::Map(..) => true,
    }
}

/// The lobes that a material has.
pub fn present(given: &Given) -> impl Iterator<Item = (&'static Lobe, &'static Gltf)> {
    all().filter(|(_, own)| own.fields.first().is_some_and(|field| is_left(given, own, field)))
}

/// Whether it has a lobe of this name.
pub fn has(given: &Given, name: &str) -> bool {
    present(given).any(|(lobe, _)| lobe.name() == name)
}

/// Whether it has a lobe that only `Pbr` has, beside transmission.
pub fn has_own_lobes(given: &Given) -> bool {
    let others_have =
        |lobe: &Lobe| Material::KINDS.iter().any(|kind| lobe.rows.iter().any(|row| kind.rows.contains(row)));
    present(given).any(|(lobe, _)| !others_have(lobe))
}

/// The texture of a field of a lobe that the material has.
pub fn texture(given: &Given, of: &Gltf, field: &GltfField) -> Option<Info> {
    let info = info_of(extension(given, of.extension)?.get(field.texture)?).ok();
    info.filter(|_| is_left(given, of, field))
}

/// The textures of the lobes that it has, with their places.
pub fn textures(given: &Given) -> impl Iterator<Item = (String, Info)> {
    let of_field = move |own: &'static Gltf| {
        move |field: &'static GltfField| Some((place(own, field.texture), texture(given, own, field)?))
    };
    present(given).flat_map(move |(_, own)| own.fields.iter().filter_map(of_field(own)))
}

/// Whether a lobe has directions or normals in the frame of the texture coordinates.
pub fn needs_tangents(given: &Given) -> bool {
    let is_map =
        |own: &Gltf, field: &GltfField| matches!(field.to, To::Map(..)) && texture(given, own, field).is_some();
    present(given).any(|(_, own)| own.has_direction || own.fields.iter().any(|field| is_map(own, field)))
}

/// What the normal map of a field is multiplied by.
pub fn scale(given: &Given, of: &Gltf, field: &GltfField) -> f64 {
    let map = extension(given, of.extension).and_then(|found| found.get(field.texture));
    let scale = map.and_then(|map| map.get("scale")?.as_f64()).unwrap_or(1.0);
    scale.clamp(-1e3, 1e3)
}
