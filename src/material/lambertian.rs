//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::{
    ALPHA, ALPHA_CUTOFF, EMISSION, ExtensionKind, Lobe, MaterialKind, Model, NORMAL, NORMAL_SCALE, Slot, VERTEX_ALPHA,
    VERTEX_COLORS,
};
use crate::data;
use crate::source::form::{Field, Form, Takes};
use crate::texture::{Texture, Use};

const ALBEDO: Field = Field::new("albedo", Takes::Texture(Use::Albedo.range()), "The reflected share of light.");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "Lambertian",
        about: "A matt surface: it looks equally bright from all directions.",
        fields: &[ALBEDO, EMISSION, ALPHA, ALPHA_CUTOFF, VERTEX_COLORS, VERTEX_ALPHA, NORMAL, NORMAL_SCALE],
        in_order: false,
        example: "Lambertian(albedo: Rgb(0.7, 0.3, 0.2))",
    },
    shader: "lambertian",
    lobes: &[Lobe::Wide],
    is_transmissive: false,
    emits: false,
    extensions: &[
        ExtensionKind::Emission,
        ExtensionKind::Alpha,
        ExtensionKind::VertexColours,
        ExtensionKind::VertexAlpha,
        ExtensionKind::Normal,
    ],
    has_second_part: false,
};

pub fn model(albedo: &Texture) -> Model<'_> {
    Model {
        slot: Some(Slot { field: &ALBEDO, usage: Use::Albedo, texture: albedo }),
        lobes: vec![Lobe::Wide],
        two_sided: None,
        numbers: Vec::new(),
        colours: Vec::new(),
        lacks: None,
        second_part: None,
        extensions: Vec::new(),
        absorption: None,
        on_device: data::Material::default(),
    }
}
