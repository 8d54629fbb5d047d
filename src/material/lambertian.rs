//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::declared::lambertian::FIELDS;
use super::model::{ExtensionKind, Lobe, MaterialKind, Model, Slot};
use crate::data;
use crate::texture::{Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "lambertian",
    lobes: &[Lobe::Wide],
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[
        ExtensionKind::Emission,
        ExtensionKind::Alpha,
        ExtensionKind::VertexColours,
        ExtensionKind::VertexAlpha,
        ExtensionKind::VertexEmission,
        ExtensionKind::Normal,
    ],
    has_second_part: false,
};

pub fn model(albedo: &Texture) -> Model<'_> {
    Model {
        slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: albedo }),
        lobes: vec![Lobe::Wide],
        two_sided: None,
        warning: None,
        lacks: None,
        second_part: None,
        extensions: Vec::new(),
        absorption: None,
        on_device: data::Material::default(),
    }
}
