//! A mirror, perfect or rough.

use super::{ANY_LOBE, Lobe, MaterialKind, Model, Number, Slot};
use crate::data;
use crate::source::form::{Field, Form, Takes};
use crate::source::{NO_UNIT, Range};
use crate::texture::{Texture, Use};

const ALBEDO: Field = Field::new("albedo", Takes::Texture(Use::Albedo.range()), "The reflected share of light.");
const FUZZ: Field = Field::new(
    "fuzz",
    Takes::Number(Range::SHARE, NO_UNIT),
    "Roughness. A random vector of at most this length is added to the reflected direction, which has the length 1.",
)
.or("0");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "Metal",
        about: "A mirror, perfect or rough. It has no Fresnel term. Rays that would go below the surface are absorbed.",
        fields: &[ALBEDO, FUZZ],
        in_order: false,
        example: "Metal(albedo: Rgb(0.8, 0.6, 0.2), fuzz: 0.1)",
    },
    shader: "metal",
    lobes: ANY_LOBE,
    is_transmissive: false,
    emits: false,
    extensions: &[],
    has_second_part: false,
};

pub fn model(albedo: &Texture, fuzz: f64) -> Model<'_> {
    let on_device = data::Material { parameter: fuzz as f32, ..data::Material::default() };
    Model {
        slot: Some(Slot { field: &ALBEDO, usage: Use::Albedo, texture: albedo }),
        // A fuzz that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
        lobes: vec![if on_device.parameter > 0.0 { Lobe::of_width(on_device.parameter) } else { Lobe::Specular }],
        two_sided: None,
        numbers: vec![Number { field: &FUZZ, value: fuzz, warning: None }],
        colours: Vec::new(),
        lacks: None,
        extensions: Vec::new(),
        absorption: None,
        on_device,
        second_part: None,
    }
}
