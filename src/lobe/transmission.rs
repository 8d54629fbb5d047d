//! KHR_materials_transmission: a share of glass in what is no metal, as a solid or as a pane.

use super::kind::Lobe;
use crate::material::declared::pbr::FIELDS;
use crate::material::{
    Along, Pbr, Row, RowKind, Sets, Slot, glass_numbers, is_zero, widths_of_boundary, widths_of_facets,
    widths_of_roughness,
};
use crate::texture::Use;

/// The share of glass, with its index of refraction, 0 of a pane, and its contrasts from outside and from inside (lib/fresnel).
pub const TRANSMISSION: &RowKind = &RowKind::new("transmission", &["ior", "outside", "inside"], Sets::Own);

pub const LOBE: Lobe = Lobe {
    label: Some("pbr transmission"),
    members: &[("transmission", "f32"), ("contrasts", "vec2<f32>"), ("ior", "f32")],
    is_layer: true,
    counts: |pbr| !pbr.is_all_metal(),
    widths: |pbr, bitmaps| {
        let along = Along::new(pbr.anisotropy, &pbr.anisotropy_texture);
        let of_solid = |roughness, along| widths_of_boundary(pbr.ior, roughness, along);
        match pbr.solid {
            true => widths_of_roughness(&pbr.roughness, along, bitmaps, of_solid),
            false => widths_of_facets(&pbr.roughness, along, bitmaps),
        }
    },
    ..Lobe::new(&[TRANSMISSION], rows)
};

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    let [ior, outside, inside] = glass_numbers(pbr.ior);
    let numbers = [if pbr.solid { ior } else { 0.0 }, outside, inside];
    let slot = Slot { field: &FIELDS.transmission, usage: Use::Share, texture: &pbr.transmission };
    (!is_zero(&pbr.transmission)).then(|| Row::new(TRANSMISSION, slot, &numbers)).into_iter().collect()
}
