//! KHR_materials_diffuse_transmission: the matt body lets a share of the light that it scatters pass, as leaves and paper do.

use super::kind::{Gltf, Lobe, To, field};
use crate::bitmap::Channel;
use crate::material::declared::pbr::FIELDS;
use crate::material::{Pbr, Row, RowKind, Sets, Slot, is_zero, varying};
use crate::texture::Use;

/// The colour of the light that passes, with its share.
pub const DIFFUSE_TRANSMISSION: &RowKind = &RowKind::new("diffuse_transmission", &["share"], Sets::Lobe);
const SHARE: &RowKind = &RowKind::new("diffuse_transmission_share", &[], Sets::Share("lobes.through"));

pub const LOBE: Lobe = Lobe {
    label: Some("pbr diffuse transmission"),
    members: &[("colour_through", "vec3<f32>"), ("through", "f32")],
    counts: |pbr| !pbr.is_all_metal(),
    gltf: Some(Gltf {
        extension: "KHR_materials_diffuse_transmission",
        fields: &[
            field(
                "diffuseTransmissionFactor",
                "diffuseTransmissionTexture",
                To::Share(Channel::A, |pbr| &mut pbr.diffuse_transmission),
            ),
            field(
                "diffuseTransmissionColorFactor",
                "diffuseTransmissionColorTexture",
                To::Colour(1.0, |pbr| &mut pbr.diffuse_transmission_color),
            ),
        ],
        has_direction: false,
    }),
    ..Lobe::new(&[DIFFUSE_TRANSMISSION, SHARE], rows)
};

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    if is_zero(&pbr.diffuse_transmission) {
        return Vec::new();
    }
    let (share, varying) = varying(SHARE, &FIELDS.diffuse_transmission, &pbr.diffuse_transmission);
    let texture = &pbr.diffuse_transmission_color;
    let colour = Slot { field: &FIELDS.diffuse_transmission_color, usage: Use::Tint, texture };
    [Row::new(DIFFUSE_TRANSMISSION, colour, &[share])].into_iter().chain(varying).collect()
}
