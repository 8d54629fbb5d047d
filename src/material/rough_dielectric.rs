//! A clear solid with a rough surface: frosted glass.

use super::{
    ABSORPTION, ANY_LOBE, ExtensionKind, LEAST_ROUGHNESS, Lobe, MaterialKind, Model, NORMAL, NORMAL_SCALE,
    TRANSMITTANCE, dielectric, varying,
};
use crate::data::{self, NO_TEXTURE};
use crate::source::Range;
use crate::source::form::{Field, Form, Takes};
use crate::texture::Texture;

const ROUGHNESS: Field = Field::new(
    "roughness",
    Takes::Varying(Range::SHARE),
    "0 is a `Dielectric`. It is the perceptual roughness of glTF: the α of the microfacets is its square. Below 1/1024 it counts as 0.",
)
.or("0");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "RoughDielectric",
        about: "A clear solid with a rough surface, such as frosted glass. It reflects and refracts by microfacets of GGX. Light that \
                microfacets would scatter more than once is lost.",
        fields: &[dielectric::IOR, ROUGHNESS, TRANSMITTANCE, ABSORPTION, NORMAL, NORMAL_SCALE],
        in_order: false,
        example: "RoughDielectric(ior: 1.5, roughness: 0.3)",
    },
    shader: "rough_dielectric",
    lobes: ANY_LOBE,
    is_transmissive: true,
    emits: false,
    extensions: &[ExtensionKind::Roughness, ExtensionKind::Normal],
    has_second_part: true,
};

/// Its lobes where it has this roughness: as is_rough_boundary, width_of_reflection and width_of_refraction from either side have them
/// (shaders/lib/microfacet).
pub fn lobes(ior: f64, roughness: f64) -> Vec<Lobe> {
    let alpha = (roughness as f32).powi(2);
    if alpha * dielectric::model(ior).on_device.contrast_outside.abs().min(1.0) < LEAST_ROUGHNESS.powi(2) {
        return vec![Lobe::Specular];
    }
    [2.0, 1.0 - 1.0 / ior, 1.0 - ior].map(|turn| Lobe::of_width(alpha * turn.abs() as f32)).to_vec()
}

pub fn model(ior: f64, roughness: &Texture) -> Model<'_> {
    let clear = dielectric::model(ior);
    let (roughness, number, extension) = varying(&ROUGHNESS, ExtensionKind::Roughness, roughness);
    let on_device = data::Material { parameter: roughness as f32, ..clear.on_device };
    Model {
        lobes: lobes(ior, roughness),
        numbers: clear.numbers.into_iter().chain(number).collect(),
        extensions: extension.into_iter().collect(),
        on_device,
        second_part: Some(data::Material {
            parameter: clear.on_device.parameter,
            texture: NO_TEXTURE,
            ..data::Material::default()
        }),
        ..clear
    }
}
