//! A pane of clear solid that is too thin to bend light: a window, a bubble.

use super::conductor;
use super::declared::thin_dielectric::FIELDS;
use super::dielectric;
use super::model::{ANY_LOBE, ExtensionKind, MaterialKind, Model, varying};
use crate::data;
use crate::texture::Texture;

pub const KIND: MaterialKind = MaterialKind {
    shader: "thin_dielectric",
    lobes: ANY_LOBE,
    is_transmissive: true,
    is_pane: true,
    emits: false,
    extensions: &[ExtensionKind::Roughness, ExtensionKind::Normal],
    has_second_part: false,
};

pub fn model(ior: f64, roughness: &Texture) -> Model<'_> {
    let smooth = dielectric::model(ior);
    let (roughness, extension) = varying(&FIELDS.roughness, ExtensionKind::Roughness, roughness);
    Model {
        lobes: vec![conductor::lobe(roughness, 0.0)],
        warning: None,
        extensions: extension.into_iter().collect(),
        on_device: data::Material { parameter: roughness as f32, ..smooth.on_device },
        ..smooth
    }
}
