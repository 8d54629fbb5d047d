//! KHR_materials_clearcoat: a clear coat around all else, such as varnish, with a roughness and a normal map of its own.

use super::kind::{Gltf, Lobe, To, field};
use crate::bitmap::Channel;
use crate::material::declared::pbr::FIELDS;
use crate::material::{Along, Pbr, Row, RowKind, Sets, Slot, is_zero, varying, widths_of_facets};
use crate::texture::Use;

/// The share of the coat, with its roughness and its reflectance for light straight on it.
const COAT: &RowKind = &RowKind::new("coat", &["roughness", "f0"], Sets::Lobe);
const COAT_ROUGHNESS: &RowKind = &RowKind::new("coat_roughness", &[], Sets::Share("lobes.coat_roughness"));
/// The normal map. Shaders read its scale as `${normal.scale}`, so that it names no number.
const COAT_NORMAL: &RowKind = &RowKind::new("coat_normal", &[], Sets::Texel("coat_normal"));

pub const LOBE: Lobe = Lobe {
    label: Some("pbr coat"),
    members: &[("coat", "f32"), ("coat_roughness", "f32"), ("coat_f0", "f32")],
    is_layer: true,
    widths: |pbr, bitmaps| widths_of_facets(&pbr.coat_roughness, Along::NONE, bitmaps),
    gltf: Some(Gltf {
        extension: "KHR_materials_clearcoat",
        fields: &[
            field("clearcoatFactor", "clearcoatTexture", To::Share(Channel::R, |pbr| &mut pbr.coat)),
            field(
                "clearcoatRoughnessFactor",
                "clearcoatRoughnessTexture",
                To::Share(Channel::G, |pbr| &mut pbr.coat_roughness),
            ),
            field(
                "",
                "clearcoatNormalTexture",
                To::Map(|pbr| &mut pbr.coat_normal, Some(|pbr| &mut pbr.coat_normal_scale)),
            ),
        ],
        has_direction: false,
    }),
    ..Lobe::new(&[COAT, COAT_ROUGHNESS, COAT_NORMAL], rows)
};

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    if is_zero(&pbr.coat) {
        return Vec::new();
    }
    let (roughness, varying) = varying(COAT_ROUGHNESS, &FIELDS.coat_roughness, &pbr.coat_roughness);
    let f0 = ((pbr.coat_ior - 1.0) / (pbr.coat_ior + 1.0)).powi(2);
    let share = Slot { field: &FIELDS.coat, usage: Use::Share, texture: &pbr.coat };
    let slot = |texture| Slot { field: &FIELDS.coat_normal, usage: Use::Normal, texture };
    let normal = pbr.coat_normal.iter().map(|map| Row::new(COAT_NORMAL, slot(map), &[pbr.coat_normal_scale]));
    [Row::new(COAT, share, &[roughness, f0])].into_iter().chain(varying).chain(normal).collect()
}
