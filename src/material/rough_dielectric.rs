//! A clear solid with a rough surface: frosted glass.

use super::boundary::{glass_numbers, widths_of_boundary};
use super::declared::RoughDielectric;
use super::declared::rough_dielectric::FIELDS;
use super::dielectric;
use super::model::{MaterialKind, Model};
use super::row::{NORMAL, ROUGHNESS, varying};
use super::width::{ANY_WIDTH, Along, LobeWidth, widths_of_roughness};
use crate::bitmap::Bitmaps;
use crate::data::{self, NO_TEXTURE};
use crate::lobe::anisotropy::{self, ANISOTROPY};
use crate::lobe::dispersion::DISPERSION;
use crate::texture::Colour;

pub const KIND: MaterialKind = MaterialKind {
    shader: "rough_dielectric",
    numbers: &["roughness", "outside", "inside"],
    second_part: &["ior"],
    widths: ANY_WIDTH,
    is_transmissive: true,
    is_pane: false,
    emits: false,
    rows: &[ROUGHNESS, NORMAL, ANISOTROPY, DISPERSION],
    has_lobes: false,
};

impl RoughDielectric {
    pub fn model(&self) -> Model<'_> {
        let [ior, outside, inside] = glass_numbers(self.ior);
        let (roughness, varying) = varying(ROUGHNESS, &FIELDS.roughness, &self.roughness);
        let model = Model {
            widths: widths_of_boundary(self.ior, roughness, 0.0),
            rows: varying.into_iter().collect(),
            on_device: data::Material {
                numbers: [roughness, outside, inside].map(|number| number as f32),
                ..data::Material::default()
            },
            second_part: Some(data::Material {
                numbers: [ior as f32, 0.0, 0.0],
                texture: NO_TEXTURE,
                ..data::Material::default()
            }),
            ..dielectric::glass(self.ior)
        };
        let model = model.dispersing(self.ior, self.dispersion).tinted(&self.transmittance).absorbing(self.absorption);
        let model = model.bumped(&self.normal, self.normal_scale);
        model.with_rows(anisotropy::rows(self.anisotropy, self.anisotropy_rotation, &self.anisotropy_texture))
    }

    pub fn widths(&self, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        widths_of_roughness(&self.roughness, along, bitmaps, |roughness, along| {
            widths_of_boundary(self.ior, roughness, along)
        })
    }

    /// Whether all of it is smooth.
    pub fn is_smooth(&self) -> bool {
        let is_smooth =
            |roughness: Colour| widths_of_boundary(self.ior, roughness.x, self.anisotropy) == [LobeWidth::Specular];
        self.roughness.plain().is_some_and(is_smooth) && (self.normal.is_none() || self.normal_scale == 0.0)
    }

    /// The clear glass that it is where it is smooth.
    pub fn as_smooth_glass(&self) -> Model<'_> {
        let glass = dielectric::glass(self.ior).tinted(&self.transmittance).absorbing(self.absorption);
        glass.dispersing(self.ior, self.dispersion)
    }
}
