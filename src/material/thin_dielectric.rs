//! A pane of clear solid that is too thin to bend light: a window, a bubble.

use super::boundary::glass_numbers;
use super::declared::ThinDielectric;
use super::declared::thin_dielectric::FIELDS;
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{INNER_REFLECTIONS, NORMAL, ROUGHNESS, varying};
use super::width::{ANY_WIDTH, Along, LobeWidth, widths_of_facets};
use crate::bitmap::Bitmaps;

pub const KIND: MaterialKind = MaterialKind {
    numbers: &["roughness", "contrast", "inner_reflections"],
    is_transmissive: true,
    is_pane: true,
    rows: &[ROUGHNESS, NORMAL, INNER_REFLECTIONS],
    ..MaterialKind::new("thin_dielectric", ANY_WIDTH)
};

impl ThinDielectric {
    pub fn model(&self) -> Model<'_> {
        let [_, contrast, _] = glass_numbers(self.ior);
        // Glass of index 1 reflects nothing.
        let has_inner = self.inner_reflections && self.ior != 1.0;
        let (roughness, varying) = varying(ROUGHNESS, &FIELDS.roughness, &self.roughness);
        let model = Model {
            widths: vec![LobeWidth::of_facets(roughness, 0.0)],
            rows: varying.into_iter().collect(),
            on_device: with_numbers([roughness, contrast, f64::from(u8::from(has_inner))]),
            ..Model::default()
        };
        let model = model.flagged(&FIELDS.inner_reflections, INNER_REFLECTIONS, has_inner);
        model.tinted(&self.transmittance).bumped(&self.normal, self.normal_scale)
    }

    pub fn widths(&self, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
        widths_of_facets(&self.roughness, Along::NONE, bitmaps)
    }
}
