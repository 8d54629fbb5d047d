//! A metal with microfacets: its surface is smooth or rough, and it reflects by Fresnel's equations.

use super::declared::conductor::FIELDS;
use super::declared::{Conductor, Distribution};
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{BECKMANN, MULTISCATTER, NORMAL, ONE_SIDED, ROUGHNESS, Slot, varying};
use super::width::{ANY_WIDTH, Along, LobeWidth, widths_of_facets};
use crate::bitmap::Bitmaps;
use crate::data::{self, f32s};
use crate::lobe::anisotropy::{self, ANISOTROPY};
use crate::texture::{Colour, Use};

pub const KIND: MaterialKind = MaterialKind {
    numbers: &["roughness"],
    second_part: &["reflectance"],
    rows: &[ROUGHNESS, MULTISCATTER, NORMAL, ANISOTROPY, ONE_SIDED, BECKMANN],
    ..MaterialKind::new("conductor", ANY_WIDTH)
};

impl Conductor {
    pub fn model(&self) -> Model<'_> {
        let (roughness, varying) = varying(ROUGHNESS, &FIELDS.roughness, &self.roughness);
        let (albedo, eta, k) = (self.albedo.as_ref(), self.eta, self.k);
        let is_complete =
            albedo.is_some() && eta.is_none() && k.is_none() || albedo.is_none() && eta.is_some() && k.is_some();
        let compensates = (self.distribution == Distribution::Beckmann && self.multiscatter)
            .then_some("no multiscatter with Beckmann: it is that of Ggx");
        // 0 where it has an albedo.
        let reflectance = eta.map_or(0.0, |_| self.reflectance);
        let model = Model {
            slot: albedo.map(|texture| Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture }),
            widths: vec![LobeWidth::of_facets(roughness, 0.0)],
            lacks: (!is_complete).then_some("either an albedo, or both eta and k").or(compensates),
            rows: varying.into_iter().collect(),
            on_device: data::Material {
                // Instead of the albedo, which a slot writes over it. Less 1, because f32 would round an index near 1 by more than what it
                // reflects.
                colour: f32s(eta.map_or(Colour::ZERO, |eta| eta - 1.0)),
                ..with_numbers([roughness, 0.0, 0.0])
            },
            second_part: Some(data::Material {
                colour: f32s(k.unwrap_or_default()),
                texture: data::NO_TEXTURE,
                ..with_numbers([reflectance, 0.0, 0.0])
            }),
            ..Model::default()
        };
        let model = model
            .flagged(&FIELDS.multiscatter, MULTISCATTER, self.multiscatter)
            .bumped(&self.normal, self.normal_scale)
            .one_sided(self.one_sided)
            .distributed(self.distribution);
        model.with_rows(anisotropy::rows(self.anisotropy, self.anisotropy_rotation, &self.anisotropy_texture))
    }

    pub fn widths(&self, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        widths_of_facets(&self.roughness, along, bitmaps)
    }
}
