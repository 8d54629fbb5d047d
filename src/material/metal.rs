//! A mirror, perfect or rough.

use super::declared::metal::FIELDS;
use super::model::{ANY_LOBE, Lobe, MaterialKind, Model, Slot};
use crate::data;
use crate::texture::{Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "metal",
    lobes: ANY_LOBE,
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[],
    has_second_part: false,
};

pub fn model(albedo: &Texture, fuzz: f64) -> Model<'_> {
    let on_device = data::Material { parameter: fuzz as f32, ..data::Material::default() };
    Model {
        slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: albedo }),
        // A fuzz that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
        lobes: vec![if on_device.parameter > 0.0 { Lobe::of_width(on_device.parameter) } else { Lobe::Specular }],
        two_sided: None,
        warning: None,
        lacks: None,
        extensions: Vec::new(),
        absorption: None,
        on_device,
        second_part: None,
    }
}
