//! The material of glTF 2.0: a matt body under a glossy layer, or a metal.

use super::declared::is_zero;
use super::declared::pbr::FIELDS;
use super::model::{ANY_LOBE, Along, ExtensionKind, Lobe, MaterialKind, Model, Slot, lobes_of_roughness, varying};
use super::{conductor, rough_dielectric};
use crate::bitmap::Bitmaps;
use crate::data;
use crate::texture::{Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "pbr",
    lobes: ANY_LOBE,
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[
        ExtensionKind::Emission,
        ExtensionKind::Alpha,
        ExtensionKind::VertexColours,
        ExtensionKind::VertexAlpha,
        ExtensionKind::Roughness,
        ExtensionKind::Metallic,
        ExtensionKind::Multiscatter,
        ExtensionKind::Normal,
        ExtensionKind::Specular,
        ExtensionKind::SpecularShare,
        ExtensionKind::Transmission,
        ExtensionKind::Coat,
        ExtensionKind::CoatRoughness,
        ExtensionKind::CoatNormal,
        ExtensionKind::Sheen,
        ExtensionKind::SheenRoughness,
        ExtensionKind::Anisotropy,
        ExtensionKind::Iridescence,
        ExtensionKind::IridescenceThickness,
        ExtensionKind::DiffuseTransmission,
        ExtensionKind::DiffuseTransmissionShare,
        ExtensionKind::Dispersion,
    ],
    has_second_part: false,
};

/// The parts of the material that decide its lobes.
pub struct Parts<'a> {
    pub metallic: &'a Texture,
    pub roughness: &'a Texture,
    pub along: Along,
    pub ior: f64,
    pub transmission: &'a Texture,
    pub is_solid: bool,
    pub coat: &'a Texture,
    pub coat_roughness: &'a Texture,
    pub sheen: &'a Texture,
}

/// Its lobes. Those of a roughness that varies are as narrow as its least number makes them, and wider.
pub fn lobes(parts: &Parts<'_>, bitmaps: &Bitmaps) -> Vec<Lobe> {
    let is = |texture: &Texture, number: f64| texture.plain().is_some_and(|grey| grey.x == number);
    let mut found = Vec::new();
    let has_base = !is(parts.transmission, 1.0) || !is(parts.metallic, 0.0);
    if has_base {
        // Where nothing says that all of it is a metal, it has a matt body too.
        found.extend((!is(parts.metallic, 1.0)).then_some(Lobe::Wide));
        let of_facets = |roughness: f64, along: f64| vec![conductor::lobe(roughness, along)];
        found.extend(lobes_of_roughness(parts.roughness, parts.along, bitmaps, of_facets));
    }
    if !is(parts.transmission, 0.0) && !is(parts.metallic, 1.0) {
        let of_glass = |roughness: f64, along: f64| match parts.is_solid {
            true => rough_dielectric::lobes(parts.ior, roughness, along),
            false => vec![conductor::lobe(roughness, along)],
        };
        found.extend(lobes_of_roughness(parts.roughness, parts.along, bitmaps, of_glass));
    }
    if !is(parts.coat, 0.0) {
        let of_coat = |roughness: f64, _| vec![conductor::lobe(roughness, 0.0)];
        found.extend(lobes_of_roughness(parts.coat_roughness, Along::NONE, bitmaps, of_coat));
    }
    found.extend((!is_zero(parts.sheen)).then_some(Lobe::Wide));
    [Lobe::Specular, Lobe::Narrow, Lobe::Wide].into_iter().filter(|lobe| found.contains(lobe)).collect()
}

pub fn model<'a>(base_color: &'a Texture, metallic: &'a Texture, roughness: &'a Texture, ior: f64) -> Model<'a> {
    let (metallic, varying_metallic) = varying(&FIELDS.metallic, ExtensionKind::Metallic, metallic);
    let (roughness, varying_roughness) = varying(&FIELDS.roughness, ExtensionKind::Roughness, roughness);
    // Where nothing says that all of it is a metal, it has a matt body too.
    let is_metal = metallic == 1.0 && varying_metallic.is_none();
    let lobes = if is_metal {
        vec![conductor::lobe(roughness, 0.0)]
    } else {
        vec![Lobe::Wide, conductor::lobe(roughness, 0.0)]
    };
    Model {
        slot: Some(Slot { field: &FIELDS.base_color, usage: Use::Albedo, texture: base_color }),
        lobes,
        two_sided: None,
        warning: None,
        lacks: None,
        extensions: varying_roughness.into_iter().chain(varying_metallic).collect(),
        absorption: None,
        on_device: data::Material {
            parameter: roughness as f32,
            // The reflectance of the layer for light straight on it, and the metallic share.
            contrast_outside: ((ior - 1.0) / (ior + 1.0)).powi(2) as f32,
            contrast_inside: metallic as f32,
            ..data::Material::default()
        },
        second_part: None,
    }
}
