//! A pane of clear solid that is too thin to bend light: a window, a bubble.

use super::declared::ThinDielectric;
use super::declared::thin_dielectric::FIELDS;
use super::model::{ANY_LOBE, Along, ExtensionKind, Lobe, MaterialKind, Model, lobes_of_roughness, varying};
use super::{conductor, dielectric};
use crate::bitmap::Bitmaps;
use crate::data;

pub const KIND: MaterialKind = MaterialKind {
    shader: "thin_dielectric",
    lobes: ANY_LOBE,
    is_transmissive: true,
    is_pane: true,
    emits: false,
    extensions: &[ExtensionKind::Roughness, ExtensionKind::Normal],
    has_second_part: false,
};

impl ThinDielectric {
    pub fn model(&self) -> Model<'_> {
        let smooth = dielectric::glass(self.ior);
        let (roughness, extension) = varying(&FIELDS.roughness, ExtensionKind::Roughness, &self.roughness);
        let model = Model {
            lobes: vec![conductor::lobe(roughness, 0.0)],
            warning: None,
            extensions: extension.into_iter().collect(),
            on_device: data::Material { parameter: roughness as f32, ..smooth.on_device },
            ..smooth
        };
        model.tinted(&self.transmittance).bumped(&self.normal, self.normal_scale)
    }

    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        lobes_of_roughness(&self.roughness, Along::NONE, bitmaps, |roughness, _| vec![conductor::lobe(roughness, 0.0)])
    }
}
