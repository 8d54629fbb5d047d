//! A clear solid with a rough surface: frosted glass.

use super::declared::rough_dielectric::FIELDS;
use super::model::{ANY_LOBE, ExtensionKind, LEAST_ROUGHNESS, Lobe, MaterialKind, Model, varying};
use super::{conductor, dielectric};
use crate::data::{self, NO_TEXTURE};
use crate::texture::Texture;

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
    if alpha * dielectric::model(ior).on_device.contrast_outside.abs().min(1.0) < LEAST_ROUGHNESS.powi(2) {
        return vec![Lobe::Specular];
    }
    let widest = conductor::widest_alpha(roughness, anisotropy);
    [2.0, 1.0 - 1.0 / ior, 1.0 - ior].map(|factor| Lobe::of_width(widest * factor.abs() as f32)).to_vec()
}

pub fn model(ior: f64, roughness: &Texture) -> Model<'_> {
    let smooth = dielectric::model(ior);
    let (roughness, extension) = varying(&FIELDS.roughness, ExtensionKind::Roughness, roughness);
    let on_device = data::Material { parameter: roughness as f32, ..smooth.on_device };
    Model {
        lobes: lobes(ior, roughness, 0.0),
        extensions: extension.into_iter().collect(),
        on_device,
        second_part: Some(data::Material {
            parameter: smooth.on_device.parameter,
            texture: NO_TEXTURE,
            ..data::Material::default()
        }),
        ..smooth
    }
}
