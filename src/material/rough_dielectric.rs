//! A clear solid with a rough surface: frosted glass.

use super::{LEAST_ROUGHNESS, MaterialKind, Model, Number, Scattering, dielectric};
use crate::data::{self, NO_TEXTURE};
use crate::source::Range;
use crate::source::form::{Field, Form, NO_UNIT, Takes};

const ROUGHNESS: Field = Field::new(
    "roughness",
    Takes::Number(Range::SHARE, NO_UNIT),
    "0 is a `Dielectric`. It is the perceptual roughness of glTF: the α of the microfacets is its square. Below 1/1024 it counts as 0.",
)
.or("0");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "RoughDielectric",
        about: "A clear solid with a rough surface, such as frosted glass. It reflects and refracts by microfacets of GGX. Light that \
                microfacets would scatter more than once is lost.",
        fields: &[dielectric::IOR, ROUGHNESS],
        in_order: false,
        example: "RoughDielectric(ior: 1.5, roughness: 0.3)",
    },
    shader: "rough_dielectric",
    scatters: &[Scattering::Spread, Scattering::OneWay],
    is_clear: true,
    emits: false,
    details: &[],
    has_second_part: true,
};

pub fn model(ior: f64, roughness: f64) -> Model<'static> {
    let clear = dielectric::model(ior);
    let on_device = data::Material { parameter: roughness as f32, ..clear.on_device };
    // As is_rough_boundary (shaders/lib/microfacet).
    let spread = on_device.parameter.powi(2) * on_device.contrast_outside.abs().min(1.0);
    Model {
        scattering: if spread >= LEAST_ROUGHNESS.powi(2) { Scattering::Spread } else { Scattering::OneWay },
        numbers: { clear.numbers.into_iter() }
            .chain([Number { field: &ROUGHNESS, value: roughness, warning: None }])
            .collect(),
        details: Vec::new(),
        on_device,
        second_part: Some(data::Material {
            parameter: clear.on_device.parameter,
            texture: NO_TEXTURE,
            ..data::Material::default()
        }),
        ..clear
    }
}
