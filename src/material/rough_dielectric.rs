//! A clear solid with a rough surface: frosted glass.

use super::declared::RoughDielectric;
use super::declared::rough_dielectric::FIELDS;
use super::model::{
    ANY_LOBE, Along, ExtensionKind, LEAST_ROUGHNESS, Lobe, MaterialKind, Model, lobes_of_roughness, varying,
};
use super::{conductor, dielectric};
use crate::bitmap::Bitmaps;
use crate::data::{self, NO_TEXTURE};
use crate::texture::Colour;

pub const KIND: MaterialKind = MaterialKind {
    shader: "rough_dielectric",
    lobes: ANY_LOBE,
    is_transmissive: true,
    is_pane: false,
    emits: false,
    extensions: &[
        ExtensionKind::Roughness,
        ExtensionKind::Normal,
        ExtensionKind::Anisotropy,
        ExtensionKind::Dispersion,
    ],
    has_second_part: true,
};

/// Its lobes where it has this roughness: as is_rough_boundary, width_of_reflection and width_of_refraction from either side have them
/// (shaders/lib/microfacet).
pub fn lobes(ior: f64, roughness: f64, anisotropy: f64) -> Vec<Lobe> {
    let roughness = if anisotropy > 0.0 { (roughness as f32).max(LEAST_ROUGHNESS) } else { roughness as f32 };
    let alpha = roughness.powi(2);
    if alpha * dielectric::glass(ior).on_device.contrast_outside.abs().min(1.0) < LEAST_ROUGHNESS.powi(2) {
        return vec![Lobe::Specular];
    }
    let widest = conductor::widest_alpha(roughness, anisotropy);
    [2.0, 1.0 - 1.0 / ior, 1.0 - ior].map(|factor| Lobe::of_width(widest * factor.abs() as f32)).to_vec()
}

impl RoughDielectric {
    pub fn model(&self) -> Model<'_> {
        let smooth = dielectric::glass(self.ior);
        let (roughness, extension) = varying(&FIELDS.roughness, ExtensionKind::Roughness, &self.roughness);
        let model = Model {
            lobes: lobes(self.ior, roughness, 0.0),
            extensions: extension.into_iter().collect(),
            on_device: data::Material { parameter: roughness as f32, ..smooth.on_device },
            second_part: Some(data::Material {
                parameter: smooth.on_device.parameter,
                texture: NO_TEXTURE,
                ..data::Material::default()
            }),
            ..smooth
        };
        let model = model.dispersing(self.ior, self.dispersion).tinted(&self.transmittance).absorbing(self.absorption);
        let model = model.bumped(&self.normal, self.normal_scale);
        model.anisotropic(self.anisotropy, self.anisotropy_rotation, &self.anisotropy_texture)
    }

    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        lobes_of_roughness(&self.roughness, along, bitmaps, |roughness, along| lobes(self.ior, roughness, along))
    }

    /// Whether all of it is smooth.
    pub fn is_smooth(&self) -> bool {
        let is_smooth = |roughness: Colour| lobes(self.ior, roughness.x, self.anisotropy) == [Lobe::Specular];
        self.roughness.plain().is_some_and(is_smooth) && (self.normal.is_none() || self.normal_scale == 0.0)
    }

    /// The clear glass that it is where it is smooth.
    pub fn as_smooth_glass(&self) -> Model<'_> {
        let glass = dielectric::glass(self.ior).tinted(&self.transmittance).absorbing(self.absorption);
        glass.dispersing(self.ior, self.dispersion)
    }
}
