//! KHR_materials_iridescence: a thin film on the base, as on soap bubbles and oil.

use super::kind::{Gltf, Lobe, To, field};
use crate::bitmap::Channel;
use crate::material::declared::pbr::FIELDS;
use crate::material::{MOST_IOR, MOST_THICKNESS, Pbr, Row, RowKind, Sets, Slot, is_zero};
use crate::texture::Use;

/// The share of the film, with its index of refraction and its thickness in nm.
const IRIDESCENCE: &RowKind = &RowKind::new("iridescence", &["ior", "thickness"], Sets::Lobe);
/// The thickness in nm where it varies, from the least to the most.
const IRIDESCENCE_THICKNESS: &RowKind = &RowKind::new("iridescence_thickness", &["least", "most"], Sets::Own);

pub const LOBE: Lobe = Lobe {
    label: Some("pbr film"),
    members: &[("film", "f32"), ("film_ior", "f32"), ("film_thickness", "f32")],
    // A film without a thickness is none (shaders/lobe/iridescence), and one of the index of air has no boundary.
    counts: |pbr| pbr.iridescence_ior as f32 != 1.0 && thicknesses(pbr).iter().any(|nm| *nm as f32 != 0.0),
    gltf: Some(Gltf {
        extension: "KHR_materials_iridescence",
        fields: &[
            field("iridescenceFactor", "iridescenceTexture", To::Share(Channel::R, |pbr| &mut pbr.iridescence)),
            field("iridescenceIor", "", To::Number(|pbr, ior| pbr.iridescence_ior = ior.clamp(1.0, MOST_IOR))),
            field(
                "iridescenceThicknessMinimum",
                "",
                To::Number(|pbr, nm| pbr.iridescence_thickness_min = nm.clamp(0.0, MOST_THICKNESS)),
            ),
            field(
                "iridescenceThicknessMaximum",
                "",
                To::Number(|pbr, nm| pbr.iridescence_thickness = nm.clamp(0.0, MOST_THICKNESS)),
            ),
            field(
                "",
                "iridescenceThicknessTexture",
                To::Share(Channel::G, |pbr| &mut pbr.iridescence_thickness_texture),
            ),
        ],
        has_direction: false,
    }),
    ..Lobe::new(&[IRIDESCENCE, IRIDESCENCE_THICKNESS], rows)
};

/// The thicknesses that it has: one, or the least and the most where it varies.
fn thicknesses(pbr: &Pbr) -> Vec<f64> {
    let (least, most) = (pbr.iridescence_thickness_min, pbr.iridescence_thickness);
    let one = pbr.iridescence_thickness_texture.plain().map(|share| least + share.x * (most - least));
    one.map_or(vec![least, most], |thickness| vec![thickness])
}

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    if is_zero(&pbr.iridescence) {
        return Vec::new();
    }
    let slot = Slot { field: &FIELDS.iridescence, usage: Use::Share, texture: &pbr.iridescence };
    let texture = &pbr.iridescence_thickness_texture;
    let of_thickness = Slot { field: &FIELDS.iridescence_thickness_texture, usage: Use::Share, texture };
    let thicknesses = thicknesses(pbr);
    let varying = of_thickness.is_textured().then(|| Row::new(IRIDESCENCE_THICKNESS, of_thickness, &thicknesses));
    let thickness = thicknesses.last().copied().unwrap_or_default();
    [Row::new(IRIDESCENCE, slot, &[pbr.iridescence_ior, thickness])].into_iter().chain(varying).collect()
}
