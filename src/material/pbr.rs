//! The material of glTF 2.0: a matt body under a glossy layer, or a metal.

use super::declared::pbr::FIELDS;
use super::declared::{Pbr, is_zero};
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{
    ALPHA, EMISSION, METALLIC, MULTISCATTER, NORMAL, ONE_SIDED, ROUGHNESS, Slot, VERTEX_ALPHA, VERTEX_COLOURS, varying,
};
use super::width::{ANY_WIDTH, Along, LobeWidth, widths_of_facets};
use crate::bitmap::Bitmaps;
use crate::lobe::{LOBES, Lobe};
use crate::texture::Use;

pub const KIND: MaterialKind = MaterialKind {
    // f0 is the reflectance of the layer for light straight on it.
    numbers: &["roughness", "f0", "metallic"],
    rows: &[EMISSION, ALPHA, VERTEX_COLOURS, VERTEX_ALPHA, ROUGHNESS, METALLIC, MULTISCATTER, NORMAL, ONE_SIDED],
    has_lobes: true,
    ..MaterialKind::new("pbr", ANY_WIDTH)
};

impl Pbr {
    pub fn model(&self) -> Model<'_> {
        self.with_lobes(|_| true)
    }

    /// The material with those of its lobes that change anything.
    pub fn model_on_device(&self) -> Model<'_> {
        self.with_lobes(|lobe| (lobe.counts)(self))
    }

    fn with_lobes(&self, counts: impl Fn(&Lobe) -> bool) -> Model<'_> {
        let model = self.base().emissive(&self.emission, self.one_sided_emission);
        let model = model.cut_out(&self.alpha, self.alpha_cutoff, self.vertex_alpha);
        let model = model.flagged(&FIELDS.vertex_colors, VERTEX_COLOURS, self.vertex_colors);
        let model = model.flagged(&FIELDS.multiscatter, MULTISCATTER, self.multiscatter);
        let model = model.bumped(&self.normal, self.normal_scale).one_sided(self.one_sided);
        let lobes = LOBES.iter().filter(|lobe| counts(lobe));
        let model = lobes.fold(model, |model, lobe| model.with_rows((lobe.rows_of)(self)));
        let lacks = (self.absorption.is_some() && !self.has_inside())
            .then_some("no absorption without `solid: true` and a transmission: it is of the inside of a body");
        let disperses_nothing = (self.dispersion != 0.0 && !self.has_inside())
            .then_some("no dispersion without `solid: true` and a transmission: it is of light that a body bends");
        let passes = !is_zero(&self.transmission) || !is_zero(&self.diffuse_transmission);
        let blocks = (self.one_sided && passes).then_some(
            "no transmission and no diffuse_transmission with `one_sided: true`, whose back lets nothing pass",
        );
        Model { lacks: lacks.or(disperses_nothing).or(blocks), absorption: self.absorption, ..model }
    }

    /// The widths of its lobes. Those of a roughness that varies are as narrow as its least number makes them, and wider.
    pub fn widths(&self, bitmaps: &Bitmaps) -> Vec<LobeWidth> {
        let along = Along::new(self.anisotropy, &self.anisotropy_texture);
        let is_all_glass = self.transmission.plain().is_some_and(|share| share.x == 1.0)
            && self.metallic.plain().is_some_and(|metallic| metallic.x == 0.0);
        let mut found = Vec::new();
        if !is_all_glass {
            // Where nothing says that all of it is a metal, it has a matt body too.
            found.extend((!self.is_all_metal()).then_some(LobeWidth::Wide));
            found.extend(widths_of_facets(&self.roughness, along, bitmaps));
        }
        let lobes = LOBES.iter().filter(|lobe| (lobe.counts)(self) && !(lobe.rows_of)(self).is_empty());
        found.extend(lobes.flat_map(|lobe| (lobe.widths)(self, bitmaps)));
        [LobeWidth::Specular, LobeWidth::Narrow, LobeWidth::Wide]
            .into_iter()
            .filter(|width| found.contains(width))
            .collect()
    }

    /// The material without its lobes.
    fn base(&self) -> Model<'_> {
        let (metallic, varying_metallic) = varying(METALLIC, &FIELDS.metallic, &self.metallic);
        let (roughness, varying_roughness) = varying(ROUGHNESS, &FIELDS.roughness, &self.roughness);
        let body = (!self.is_all_metal()).then_some(LobeWidth::Wide);
        let f0 = ((self.ior - 1.0) / (self.ior + 1.0)).powi(2);
        Model {
            slot: Some(Slot { field: &FIELDS.base_color, usage: Use::Albedo, texture: &self.base_color }),
            widths: body.into_iter().chain([LobeWidth::of_facets(roughness, 0.0)]).collect(),
            rows: varying_roughness.into_iter().chain(varying_metallic).collect(),
            on_device: with_numbers([roughness, f0, metallic]),
            ..Model::default()
        }
    }
}
