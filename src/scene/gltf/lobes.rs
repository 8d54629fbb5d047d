//! The lobes of a glTF material that the crate does not read: KHR_materials_clearcoat, KHR_materials_sheen and KHR_materials_anisotropy.

use gltf::json::extensions::texture;
use gltf::json::material::Material as Given;
use gltf::json::texture::Info;
use serde_json::Value;

use super::{GltfError, Result};
use crate::scene::types::Colour;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// Names of fields.
type Names = &'static [&'static str];

/// The extensions that this file reads, with their numbers, their colours and their textures.
const READ: [(&str, Names, Names, Names); 3] = [
    (
        CLEARCOAT,
        &["clearcoatFactor", "clearcoatRoughnessFactor"],
        &[],
        &["clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"],
    ),
    (ANISOTROPY, &["anisotropyStrength", "anisotropyRotation"], &[], &["anisotropyTexture"]),
    (SHEEN, &["sheenRoughnessFactor"], &["sheenColorFactor"], &["sheenColorTexture", "sheenRoughnessTexture"]),
];

/// Whether an extension is read here.
pub fn is_read(extension: &str) -> bool {
    READ.iter().any(|(name, ..)| *name == extension)
}

/// Where a texture of a lobe stands in the JSON of its material.
pub fn field_of(texture: &str) -> &'static str {
    match texture {
        "clearcoatTexture" => "extensions.KHR_materials_clearcoat.clearcoatTexture",
        "clearcoatRoughnessTexture" => "extensions.KHR_materials_clearcoat.clearcoatRoughnessTexture",
        "clearcoatNormalTexture" => "extensions.KHR_materials_clearcoat.clearcoatNormalTexture",
        "anisotropyTexture" => "extensions.KHR_materials_anisotropy.anisotropyTexture",
        "sheenColorTexture" => "extensions.KHR_materials_sheen.sheenColorTexture",
        "sheenRoughnessTexture" => "extensions.KHR_materials_sheen.sheenRoughnessTexture",
        _ => "",
    }
}

fn extension<'a>(given: &'a Given, name: &str) -> Option<&'a Value> {
    given.extensions.as_ref()?.others.get(name)
}

fn number(given: &Given, of: &str, name: &str) -> f64 {
    let found = extension(given, of).and_then(|found| found.get(name)?.as_f64());
    found.unwrap_or(0.0).clamp(0.0, 1.0)
}

fn info(given: &Given, of: &str, name: &str) -> Option<Info> {
    info_of(extension(given, of)?.get(name)?).ok()
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
    for (name, numbers, colours, textures) in READ {
        let Some(found) = extension(given, name) else { continue };
        let wrong = |field: &str, expected: &str| {
            Err(GltfError::new(format!("{at}.extensions.{name}.{field}"), format!("expected {expected}")))
        };
        let fields =
            |fields: &'static [&'static str]| fields.iter().filter_map(|field| Some((*field, found.get(*field)?)));
        for (field, value) in fields(numbers) {
            if !value.is_number() {
                return wrong(field, "a number");
            }
        }
        for (field, value) in fields(colours) {
            let is_colour = value.as_array().is_some_and(|all| all.len() == 3 && all.iter().all(Value::is_number));
            if !is_colour {
                return wrong(field, "three numbers");
            }
        }
        for (field, value) in fields(textures) {
            if info_of(value).is_err() {
                return wrong(field, "a texture: an object with an index");
            }
        }
    }
    Ok(())
}

pub fn coat(given: &Given) -> f64 {
    number(given, CLEARCOAT, "clearcoatFactor")
}

pub fn coat_roughness(given: &Given) -> f64 {
    number(given, CLEARCOAT, "clearcoatRoughnessFactor")
}

/// The colour of the sheen, cut to 0..1.
pub fn sheen(given: &Given) -> Colour {
    let factor = extension(given, SHEEN).and_then(|found| found.get("sheenColorFactor")?.as_array());
    let channel = |c: usize| factor.and_then(|factor| factor.get(c)?.as_f64()).unwrap_or(0.0);
    Colour::new(channel(0), channel(1), channel(2)).clamp(Colour::ZERO, Colour::ONE)
}

pub fn sheen_roughness(given: &Given) -> f64 {
    number(given, SHEEN, "sheenRoughnessFactor")
}

pub fn anisotropy(given: &Given) -> f64 {
    number(given, ANISOTROPY, "anisotropyStrength")
}

/// Degrees.
pub fn anisotropy_rotation(given: &Given) -> f64 {
    let found = extension(given, ANISOTROPY).and_then(|found| found.get("anisotropyRotation")?.as_f64());
    found.unwrap_or(0.0).to_degrees()
}

/// Whether it has a lobe that only `Pbr` has, beside transmission.
pub fn has_lobes(given: &Given) -> bool {
    coat(given) > 0.0 || sheen(given) != Colour::ZERO
}

/// A texture of a lobe that the material has. A factor of 0 leaves nothing of one.
pub fn texture(given: &Given, name: &str) -> Option<Info> {
    let (of, is_there) = match name {
        "clearcoatTexture" | "clearcoatNormalTexture" => (CLEARCOAT, coat(given) > 0.0),
        "clearcoatRoughnessTexture" => (CLEARCOAT, coat(given) > 0.0 && coat_roughness(given) > 0.0),
        "anisotropyTexture" => (ANISOTROPY, anisotropy(given) > 0.0),
        "sheenColorTexture" => (SHEEN, sheen(given) != Colour::ZERO),
        "sheenRoughnessTexture" => (SHEEN, sheen(given) != Colour::ZERO && sheen_roughness(given) > 0.0),
        _ => return None,
    };
    info(given, of, name).filter(|_| is_there)
}

/// What the coat's normal map is multiplied by.
pub fn coat_normal_scale(given: &Given) -> f64 {
    let map = extension(given, CLEARCOAT).and_then(|found| found.get("clearcoatNormalTexture"));
    let scale = map.and_then(|map| map.get("scale")?.as_f64()).unwrap_or(1.0);
    scale.clamp(-1e3, 1e3)
}
