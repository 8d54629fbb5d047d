//! KHR_materials_dispersion: glass has an index of refraction for each channel. Materials other than `Pbr` have it too.

use super::kind::{Gltf, Lobe, To, field};
use crate::material::declared::dielectric::FIELDS;
use crate::material::{MOST_DISPERSION, Row, RowKind, Sets};

/// The index of blue less that of green, which is that of green less that of red.
pub const DISPERSION: &RowKind = &RowKind::new("dispersion", &["spread"], Sets::Own);

pub const LOBE: Lobe = Lobe {
    label: Some("dispersion"),
    members: &[("dispersion", "f32")],
    counts: |pbr| !pbr.is_all_metal(),
    gltf: Some(Gltf {
        extension: "KHR_materials_dispersion",
        fields: &[field(
            "dispersion",
            "",
            To::Number(|pbr, dispersion| pbr.dispersion = dispersion.clamp(0.0, MOST_DISPERSION)),
        )],
        has_direction: false,
    }),
    ..Lobe::new(&[DISPERSION], |pbr| if pbr.has_inside() { rows(pbr.ior, pbr.dispersion) } else { Vec::new() })
};

/// The row of glass of this index. A `dispersion` is 20 over the Abbe number, and the indices of blue and red differ from that of green by
/// (ior - 1) / 40 of it.
pub fn rows<'a>(ior: f64, dispersion: f64) -> Vec<Row<'a>> {
    let spread = (ior - 1.0) / 40.0 * dispersion;
    let row = || Row::white(DISPERSION, &FIELDS.dispersion, &[spread]);
    (spread as f32 != 0.0).then(row).into_iter().collect()
}
