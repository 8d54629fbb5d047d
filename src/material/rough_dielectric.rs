//! A clear solid with a rough surface: frosted glass.

use super::boundary::{glass_numbers, widths_of_boundary};
use super::declared::RoughDielectric;
use super::declared::rough_dielectric::FIELDS;
use super::dielectric;
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{BECKMANN, NORMAL, ROUGHNESS, varying};
use super::width::{ANY_WIDTH, Along, LobeWidth, widths_of_roughness};
use crate::bitmap::Bitmaps;
use crate::data::{self, NO_TEXTURE};
use crate::lobe::anisotropy::{self, ANISOTROPY};
use crate::lobe::dispersion::DISPERSION;
use crate::texture::Colour;

pub const KIND: MaterialKind = MaterialKind {
    numbers: &["roughness", "outside", "inside"],
    second_part: &["ior"],
    is_transmissive: true,
    rows: &[ROUGHNESS, NORMAL, ANISOTROPY, DISPERSION, BECKMANN],
    ..MaterialKind::new("rough_dielectric", ANY_WIDTH)
};

impl RoughDielectric {
    pub fn model(&self) -> Model<'_> {
        let [ior, outside, inside] = glass_numbers(self.ior);
        let (roughness, varying) = varying(ROUGHNESS, &FIELDS.roughness, &self.roughness);
        let glass = self.as_smooth_glass();
        let model = Model {
            widths: widths_of_boundary(self.ior, roughness, 0.0),
            rows: varying.into_iter().chain(glass.rows).collect(),
            on_device: data::Material { colour: glass.on_device.colour, ..with_numbers([roughness, outside, inside]) },
            second_part: Some(data::Material { texture: NO_TEXTURE, ..with_numbers([ior, 0.0, 0.0]) }),
            ..glass
        };
        let model = model.bumped(&self.normal, self.normal_scale).distributed(self.distribution);
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
        dielectric::glass(self.ior, &self.transmittance, self.absorption, self.dispersion)
    }
}
