//! A mirror, perfect or rough.

use super::declared::Metal;
use super::declared::metal::FIELDS;
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{ONE_SIDED, Slot};
use super::width::{ANY_WIDTH, LobeWidth};
use crate::texture::Use;

pub const KIND: MaterialKind =
    MaterialKind { numbers: &["fuzz"], rows: &[ONE_SIDED], ..MaterialKind::new("metal", ANY_WIDTH) };

impl Metal {
    pub fn model(&self) -> Model<'_> {
        // One that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
        let fuzz = self.fuzz as f32;
        let model = Model {
            slot: Some(Slot { field: &FIELDS.albedo, usage: Use::Albedo, texture: &self.albedo }),
            widths: vec![if fuzz > 0.0 { LobeWidth::of_width(fuzz) } else { LobeWidth::Specular }],
            on_device: with_numbers([self.fuzz, 0.0, 0.0]),
            ..Model::default()
        };
        model.one_sided(self.one_sided)
    }
}
