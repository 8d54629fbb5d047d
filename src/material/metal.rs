//! A mirror, perfect or rough.

use super::declared::Metal;
use super::declared::metal::FIELDS;
use super::model::{ANY_LOBE, Lobe, MaterialKind, Model, Slot};
use crate::data;
use crate::texture::Use;

pub const KIND: MaterialKind = MaterialKind {
    shader: "metal",
    lobes: ANY_LOBE,
    is_transmissive: false,
    is_pane: false,
    emits: false,
    extensions: &[],
    has_second_part: false,
};

impl Metal {
    pub fn model(&self) -> Model<'_> {
        // One that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
        let fuzz = self.fuzz as f32;
        Model {
            slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: &self.albedo }),
            lobes: vec![if fuzz > 0.0 { Lobe::of_width(fuzz) } else { Lobe::Specular }],
            on_device: data::Material { parameter: fuzz, ..data::Material::default() },
            ..Model::default()
        }
    }
}
