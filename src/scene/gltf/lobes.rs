//! The lobes of a glTF material that the crate does not read: KHR_materials_clearcoat, _sheen, _anisotropy, _iridescence,
//! _diffuse_transmission and _dispersion; and GPU_RT_materials_multiscatter of the extension for Blender.

use gltf::json::extensions::texture;
use gltf::json::material::Material as Given;
use gltf::json::texture::Info;
use serde_json::Value;

use super::{GltfError, Result};
use crate::material::{MOST_DISPERSION, MOST_IOR, MOST_THICKNESS};
use crate::scene::types::Colour;

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";
const IRIDESCENCE: &str = "KHR_materials_iridescence";
const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
const DISPERSION: &str = "KHR_materials_dispersion";

const MULTISCATTER: &str = "GPU_RT_materials_multiscatter";

/// Names of fields.
type Names = &'static [&'static str];

/// The extensions that this file reads, with their numbers and their colours.
const READ: [(&str, Names, Names); 7] = [
    (CLEARCOAT, &["clearcoatFactor", "clearcoatRoughnessFactor"], &[]),
    (ANISOTROPY, &["anisotropyStrength", "anisotropyRotation"], &[]),
    (SHEEN, &["sheenRoughnessFactor"], &["sheenColorFactor"]),
    (
        IRIDESCENCE,
        &["iridescenceFactor", "iridescenceIor", "iridescenceThicknessMinimum", "iridescenceThicknessMaximum"],
        &[],
    ),
    (DIFFUSE_TRANSMISSION, &["diffuseTransmissionFactor"], &["diffuseTransmissionColorFactor"]),
    (DISPERSION, &["dispersion"], &[]),
    (MULTISCATTER, &[], &[]),
];

/// A texture of a lobe.
pub struct LobeTexture {
    extension: &'static str,
    name: &'static str,
    /// Where it stands in the JSON of its material.
    pub field: &'static str,
    /// Whether the factors leave anything of it.
    counts: fn(&Given) -> bool,
}

macro_rules! lobe_textures {
    ($($constant:ident: $extension:literal $name:literal if $counts:expr;)*) => {
        $(pub const $constant: LobeTexture = LobeTexture {
            extension: $extension,
            name: $name,
            field: concat!("extensions.", $extension, ".", $name),
            counts: $counts,
        };)*
        /// All of them, in the order of their sets of texture coordinates.
        pub const TEXTURES: &[LobeTexture] = &[$($constant),*];
    };
}
lobe_textures! {
    COAT_TEXTURE: "KHR_materials_clearcoat" "clearcoatTexture" if |given| coat(given) > 0.0;
    COAT_ROUGHNESS_TEXTURE: "KHR_materials_clearcoat" "clearcoatRoughnessTexture"
        if |given| coat(given) > 0.0 && coat_roughness(given) > 0.0;
    COAT_NORMAL_TEXTURE: "KHR_materials_clearcoat" "clearcoatNormalTexture" if |given| coat(given) > 0.0;
    SHEEN_TEXTURE: "KHR_materials_sheen" "sheenColorTexture" if |given| sheen(given) != Colour::ZERO;
    SHEEN_ROUGHNESS_TEXTURE: "KHR_materials_sheen" "sheenRoughnessTexture"
        if |given| sheen(given) != Colour::ZERO && sheen_roughness(given) > 0.0;
    ANISOTROPY_TEXTURE: "KHR_materials_anisotropy" "anisotropyTexture" if |given| anisotropy(given) > 0.0;
    IRIDESCENCE_TEXTURE: "KHR_materials_iridescence" "iridescenceTexture"
        if |given| iridescence(given) > 0.0;
    IRIDESCENCE_THICKNESS_TEXTURE: "KHR_materials_iridescence" "iridescenceThicknessTexture"
        if |given| iridescence(given) > 0.0;
    DIFFUSE_TRANSMISSION_TEXTURE: "KHR_materials_diffuse_transmission" "diffuseTransmissionTexture"
        if |given| diffuse_transmission(given) > 0.0;
    DIFFUSE_TRANSMISSION_COLOR_TEXTURE: "KHR_materials_diffuse_transmission"
        "diffuseTransmissionColorTexture" if |given| diffuse_transmission(given) > 0.0;
}

/// Whether an extension is read here.
pub fn is_read(extension: &str) -> bool {
    READ.iter().any(|(name, ..)| *name == extension)
}

fn extension<'a>(given: &'a Given, name: &str) -> Option<&'a Value> {
    given.extensions.as_ref()?.others.get(name)
}

fn number(given: &Given, of: &str, name: &str) -> Option<f64> {
    extension(given, of).and_then(|found| found.get(name)?.as_f64())
}

/// A factor, cut to 0..1.
fn factor(given: &Given, of: &str, name: &str) -> f64 {
    number(given, of, name).unwrap_or(0.0).clamp(0.0, 1.0)
}

/// A colour, cut to 0..1.
fn colour(given: &Given, of: &str, name: &str, default: f64) -> Colour {
    let factor = extension(given, of).and_then(|found| found.get(name)?.as_array());
    let channel = |c: usize| factor.and_then(|factor| factor.get(c)?.as_f64()).unwrap_or(default);
    Colour::new(channel(0), channel(1), channel(2)).clamp(Colour::ZERO, Colour::ONE)
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
    for (name, numbers, colours) in READ {
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
        for texture in TEXTURES.iter().filter(|texture| texture.extension == name) {
            if found.get(texture.name).is_some_and(|value| info_of(value).is_err()) {
                return wrong(texture.name, "a texture: an object with an index");
            }
        }
    }
    Ok(())
}

pub fn coat(given: &Given) -> f64 {
    factor(given, CLEARCOAT, "clearcoatFactor")
}

pub fn coat_roughness(given: &Given) -> f64 {
    factor(given, CLEARCOAT, "clearcoatRoughnessFactor")
}

pub fn sheen(given: &Given) -> Colour {
    colour(given, SHEEN, "sheenColorFactor", 0.0)
}

pub fn sheen_roughness(given: &Given) -> f64 {
    factor(given, SHEEN, "sheenRoughnessFactor")
}

pub fn anisotropy(given: &Given) -> f64 {
    factor(given, ANISOTROPY, "anisotropyStrength")
}

/// Degrees; 0 where there is no anisotropy.
pub fn anisotropy_rotation(given: &Given) -> f64 {
    let rotation = number(given, ANISOTROPY, "anisotropyRotation").filter(|_| anisotropy(given) > 0.0);
    rotation.unwrap_or(0.0).to_degrees()
}

pub fn iridescence(given: &Given) -> f64 {
    factor(given, IRIDESCENCE, "iridescenceFactor")
}

/// A number of the film, or its default where there is no film.
fn number_of_film(given: &Given, name: &str, default: f64) -> f64 {
    number(given, IRIDESCENCE, name).filter(|_| iridescence(given) > 0.0).unwrap_or(default)
}

/// The index of refraction of the film, cut to its range.
pub fn iridescence_ior(given: &Given) -> f64 {
    number_of_film(given, "iridescenceIor", 1.3).clamp(1.0, MOST_IOR)
}

/// The least and the largest thickness of the film in nm, cut to their range.
pub fn iridescence_thickness(given: &Given) -> [f64; 2] {
    [("iridescenceThicknessMinimum", 100.0), ("iridescenceThicknessMaximum", 400.0)]
        .map(|(name, default)| number_of_film(given, name, default).clamp(0.0, MOST_THICKNESS))
}

pub fn diffuse_transmission(given: &Given) -> f64 {
    factor(given, DIFFUSE_TRANSMISSION, "diffuseTransmissionFactor")
}

pub fn diffuse_transmission_color(given: &Given) -> Colour {
    colour(given, DIFFUSE_TRANSMISSION, "diffuseTransmissionColorFactor", 1.0)
}

/// Whether it makes up for the light that its microfacets reflect more than once. No extension of glTF's own says that.
pub fn multiscatter(given: &Given) -> bool {
    extension(given, MULTISCATTER).is_some()
}

/// 20 over the Abbe number, cut to its range.
pub fn dispersion(given: &Given) -> f64 {
    number(given, DISPERSION, "dispersion").unwrap_or(0.0).clamp(0.0, MOST_DISPERSION)
}

/// Whether it has a lobe that only `Pbr` has, beside transmission.
pub fn has_lobes(given: &Given) -> bool {
    coat(given) > 0.0 || sheen(given) != Colour::ZERO || iridescence(given) > 0.0 || diffuse_transmission(given) > 0.0
}

/// A texture of a lobe that the material has.
pub fn texture(given: &Given, texture: &LobeTexture) -> Option<Info> {
    let info = info_of(extension(given, texture.extension)?.get(texture.name)?).ok();
    info.filter(|_| (texture.counts)(given))
}

/// What the coat's normal map is multiplied by.
pub fn coat_normal_scale(given: &Given) -> f64 {
    let map = extension(given, CLEARCOAT).and_then(|found| found.get("clearcoatNormalTexture"));
    let scale = map.and_then(|map| map.get("scale")?.as_f64()).unwrap_or(1.0);
    scale.clamp(-1e3, 1e3)
}
