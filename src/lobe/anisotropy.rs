//! KHR_materials_anisotropy: microfacets that are rougher along a direction than across it. Materials other than `Pbr` have it too.

use super::kind::{Gltf, Lobe, To, field};
use crate::material::declared::conductor::FIELDS;
use crate::material::{Pbr, Row, RowKind, Sets, Slot};
use crate::texture::{Texture, Use};

/// The direction, and the share of its strength, with the cosine and the sine by which it is turned.
pub const ANISOTROPY: &RowKind = &RowKind::new("anisotropy", &["strength", "cosine", "sine"], Sets::Own);

pub const LOBE: Lobe = Lobe {
    label: Some("anisotropy"),
    // The square of the strength.
    members: &[("anisotropy", "f32")],
    gltf: Some(Gltf {
        extension: "KHR_materials_anisotropy",
        fields: &[
            field("anisotropyStrength", "", To::Number(|pbr, strength| pbr.anisotropy = strength.clamp(0.0, 1.0))),
            field("anisotropyRotation", "", To::Number(|pbr, radians| pbr.anisotropy_rotation = radians.to_degrees())),
            field("", "anisotropyTexture", To::Map(|pbr| &mut pbr.anisotropy_texture, None)),
        ],
        has_direction: true,
    }),
    ..Lobe::new(&[ANISOTROPY], |pbr: &Pbr| rows(pbr.anisotropy, pbr.anisotropy_rotation, &pbr.anisotropy_texture))
};

/// The row of a strength from 0 to 1 and of a direction that is turned by degrees from u towards v.
pub fn rows<'a>(strength: f64, rotation: f64, texture: &'a Option<Texture>) -> Vec<Row<'a>> {
    // The direction of u, and all of the strength.
    static ALONG_U: Texture = Texture::Rgb(1.0, 0.5, 1.0);
    let texture = texture.as_ref().unwrap_or(&ALONG_U);
    let slot = Slot { field: &FIELDS.anisotropy_texture, usage: Use::Direction, texture };
    let (sine, cosine) = rotation.to_radians().sin_cos();
    let row = || Row::new(ANISOTROPY, slot, &[strength, cosine, sine]);
    (strength != 0.0).then(row).into_iter().collect()
}
