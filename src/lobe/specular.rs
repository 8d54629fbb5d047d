//! KHR_materials_specular: the layer of glTF's material reflects a share, and in a colour straight on.

use super::kind::Lobe;
use crate::material::declared::pbr::FIELDS;
use crate::material::{Pbr, Row, RowKind, Sets, Slot, is_white, is_zero};
use crate::texture::Use;

/// The colour multiplies what the layer reflects of light straight on it, and the share what it reflects at all angles.
const SPECULAR: &RowKind = &RowKind::new("specular", &["share"], Sets::Own);
/// The share, where it varies.
const SPECULAR_SHARE: &RowKind = &RowKind::new("specular_share", &[], Sets::Own);

/// Kernels read the layer as such if it is not plain, and below a film.
pub const LOBE: Lobe = Lobe {
    counts: |pbr| !is_plain(pbr) || (super::iridescence::LOBE.counts)(pbr),
    ..Lobe::new(&[SPECULAR, SPECULAR_SHARE], rows)
};

fn is_plain(pbr: &Pbr) -> bool {
    is_white(&pbr.specular) && is_white(&pbr.specular_color)
}

fn rows(pbr: &Pbr) -> Vec<Row<'_>> {
    if is_plain(pbr) && is_zero(&pbr.iridescence) {
        return Vec::new();
    }
    let colour = Slot { field: &FIELDS.specular_color, usage: Use::Tint, texture: &pbr.specular_color };
    let of_share = Slot { field: &FIELDS.specular, usage: Use::Share, texture: &pbr.specular };
    let share = pbr.specular.plain().map_or(1.0, |share| share.x);
    let varying = of_share.is_textured().then(|| Row::new(SPECULAR_SHARE, of_share, &[]));
    [Row::new(SPECULAR, colour, &[share])].into_iter().chain(varying).collect()
}
