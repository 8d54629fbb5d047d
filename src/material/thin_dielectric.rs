//! A pane of clear solid that is too thin to bend light: a window, a bubble.

use super::dielectric;
use super::{
    ANY_LOBE, ExtensionKind, MOST_IOR, MaterialKind, Model, NORMAL, NORMAL_SCALE, Number, TRANSMITTANCE, conductor,
    varying,
};
use crate::data;
use crate::source::form::{Field, Form, Takes};
use crate::source::{NO_UNIT, Range};
use crate::texture::Texture;

const IOR: Field = Field::new(
    "ior",
    Takes::Number(Range::from_to(1.0, MOST_IOR), NO_UNIT),
    "Index of refraction, of which the reflectance follows.",
)
.or("1.5");
const ROUGHNESS: Field = Field::new(
    "roughness",
    Takes::Varying(Range::SHARE),
    "0 is clear. It is the perceptual roughness of glTF: the α of the microfacets is its square. Below 1/1024 it counts as 0.",
)
.or("0");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "ThinDielectric",
        about: "A pane that is thin: one surface stands for both of its sides, and what passes is not bent. It reflects as one surface \
                does, as glTF has it for transmission without a volume. A rough pane spreads what passes as it spreads what it reflects.",
        fields: &[IOR, ROUGHNESS, TRANSMITTANCE, NORMAL, NORMAL_SCALE],
        in_order: false,
        example: "ThinDielectric(transmittance: Rgb(0.6, 0.9, 0.7))",
    },
    shader: "thin_dielectric",
    lobes: ANY_LOBE,
    is_transmissive: true,
    emits: false,
    extensions: &[ExtensionKind::Roughness, ExtensionKind::Normal],
    has_second_part: false,
};

pub fn model(ior: f64, roughness: &Texture) -> Model<'_> {
    let clear = dielectric::model(ior);
    let (roughness, number, extension) = varying(&ROUGHNESS, ExtensionKind::Roughness, roughness);
    Model {
        lobes: vec![conductor::lobe(roughness)],
        numbers: [Number { field: &IOR, value: ior, warning: None }].into_iter().chain(number).collect(),
        extensions: extension.into_iter().collect(),
        on_device: data::Material { parameter: roughness as f32, ..clear.on_device },
        ..clear
    }
}
