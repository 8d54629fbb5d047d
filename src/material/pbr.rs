//! The material of glTF 2.0: a matt body under a glossy layer, or a metal.

use super::conductor;
use super::declared::pbr::FIELDS;
use super::model::{ANY_LOBE, ExtensionKind, Lobe, MaterialKind, Model, Slot, varying};
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
    ],
    has_second_part: false,
};

pub fn model<'a>(base_color: &'a Texture, metallic: &'a Texture, roughness: &'a Texture, ior: f64) -> Model<'a> {
    let (metallic, varying_metallic) = varying(&FIELDS.metallic, ExtensionKind::Metallic, metallic);
    let (roughness, varying_roughness) = varying(&FIELDS.roughness, ExtensionKind::Roughness, roughness);
    // Where nothing says that all of it is a metal, it has a matt body too.
    let is_metal = metallic == 1.0 && varying_metallic.is_none();
    let lobes = if is_metal { vec![conductor::lobe(roughness)] } else { vec![Lobe::Wide, conductor::lobe(roughness)] };
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
