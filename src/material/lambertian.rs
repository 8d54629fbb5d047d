//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::declared::Lambertian;
use super::declared::lambertian::FIELDS;
use super::model::{ExtensionKind, Lobe, MaterialKind, Model, Slot};
use crate::texture::Use;

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

impl Lambertian {
    pub fn model(&self) -> Model<'_> {
        let model = Model {
            slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: &self.albedo }),
            lobes: vec![Lobe::Wide],
            ..Model::default()
        };
        let model = model.emissive(&self.emission).cut_out(&self.alpha, self.alpha_cutoff, self.vertex_alpha);
        let model = model.coloured_by_vertices(self.vertex_colors).emissive_by_vertices(self.vertex_emission);
        model.bumped(&self.normal, self.normal_scale)
    }
}
