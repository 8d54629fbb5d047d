//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::declared::Lambertian;
use super::declared::lambertian::FIELDS;
use super::model::{MaterialKind, Model};
use super::row::{ALPHA, EMISSION, NORMAL, ONE_SIDED, Slot, VERTEX_ALPHA, VERTEX_COLOURS, VERTEX_EMISSION};
use super::width::LobeWidth;
use crate::texture::Use;

pub const KIND: MaterialKind = MaterialKind {
    rows: &[EMISSION, ALPHA, VERTEX_COLOURS, VERTEX_ALPHA, VERTEX_EMISSION, NORMAL, ONE_SIDED],
    ..MaterialKind::new("lambertian", &[LobeWidth::Wide])
};

impl Lambertian {
    pub fn model(&self) -> Model<'_> {
        let model = Model {
            slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: &self.albedo }),
            widths: vec![LobeWidth::Wide],
            ..Model::default()
        };
        let model = model.emissive(&self.emission, self.one_sided_emission);
        let model = model.cut_out(&self.alpha, self.alpha_cutoff, self.vertex_alpha);
        let model = model.flagged(&FIELDS.vertex_colors, VERTEX_COLOURS, self.vertex_colors);
        let model = model.flagged(&FIELDS.vertex_emission, VERTEX_EMISSION, self.vertex_emission);
        model.bumped(&self.normal, self.normal_scale).one_sided(self.one_sided)
    }
}
