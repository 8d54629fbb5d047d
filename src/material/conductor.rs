//! A metal with microfacets: its surface is smooth or rough, and it reflects by Fresnel's equations.

use super::declared::Conductor;
use super::declared::conductor::FIELDS;
use super::model::{
    ANY_LOBE, Along, ExtensionKind, LEAST_ROUGHNESS, Lobe, MaterialKind, Model, Slot, lobes_of_roughness, varying,
};
use crate::bitmap::Bitmaps;
use crate::data::{self, f32s};
use crate::texture::{Colour, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "conductor",
    lobes: ANY_LOBE,
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[
        ExtensionKind::Roughness,
        ExtensionKind::Multiscatter,
        ExtensionKind::Normal,
        ExtensionKind::Anisotropy,
    ],
    has_second_part: true,
};

/// The largest alpha of microfacets of this roughness and anisotropy, as widest_alpha (shaders/lobe/anisotropy).
pub fn widest_alpha(roughness: f32, anisotropy: f64) -> f32 {
    let alpha = roughness * roughness;
    let along = (anisotropy as f32).powi(2);
    alpha + along * (1.0 - alpha)
}

/// The lobe that its microfacets reflect where it has this roughness and anisotropy, as width_of_reflection (shaders/lib/microfacet).
pub fn lobe(roughness: f64, anisotropy: f64) -> Lobe {
    let roughness = if anisotropy > 0.0 { (roughness as f32).max(LEAST_ROUGHNESS) } else { roughness as f32 };
    let width = 2.0 * widest_alpha(roughness, anisotropy);
    if roughness < LEAST_ROUGHNESS { Lobe::Specular } else { Lobe::of_width(width) }
}

impl Conductor {
    pub fn model(&self) -> Model<'_> {
        let (roughness, extension) = varying(&FIELDS.roughness, ExtensionKind::Roughness, &self.roughness);
        let (albedo, eta, k) = (self.albedo.as_ref(), self.eta, self.k);
        let is_complete =
            albedo.is_some() && eta.is_none() && k.is_none() || albedo.is_none() && eta.is_some() && k.is_some();
        let is_measured = f32::from(u8::from(eta.is_some()));
        let model = Model {
            slot: albedo.map(|texture| Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture }),
            lobes: vec![lobe(roughness, 0.0)],
            lacks: (!is_complete).then_some("either an albedo, or both eta and k"),
            extensions: extension.into_iter().collect(),
            on_device: data::Material {
                // Instead of the albedo, which a slot writes over it. Less 1, because f32 would round an index near 1 by more than what it
                // reflects.
                colour: f32s(eta.map_or(Colour::ZERO, |eta| eta - 1.0)),
                parameter: roughness as f32,
                ..data::Material::default()
            },
            second_part: Some(data::Material {
                colour: f32s(k.unwrap_or_default()),
                parameter: is_measured,
                texture: data::NO_TEXTURE,
                ..data::Material::default()
            }),
            ..Model::default()
        };
        let model = model.scattering_many_times(self.multiscatter).bumped(&self.normal, self.normal_scale);
        model.anisotropic(self.anisotropy, self.anisotropy_rotation, &self.anisotropy_texture)
    }

    pub fn lobes(&self, bitmaps: &Bitmaps) -> Vec<Lobe> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        lobes_of_roughness(&self.roughness, along, bitmaps, |roughness, along| vec![lobe(roughness, along)])
    }
}
