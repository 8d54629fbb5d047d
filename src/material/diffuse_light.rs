//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::declared::DiffuseLight;
use super::declared::diffuse_light::FIELDS;
use super::model::{MaterialKind, Model, with_numbers};
use super::row::Slot;
use crate::texture::Use;

pub const KIND: MaterialKind =
    MaterialKind { numbers: &["two_sided"], emits: true, ..MaterialKind::new("diffuse_light", &[]) };

impl DiffuseLight {
    pub fn model(&self) -> Model<'_> {
        Model {
            slot: Some(Slot { field: &FIELDS.emit, usage: Use::Radiance, texture: &self.emit }),
            two_sided: Some(self.two_sided),
            on_device: with_numbers([f64::from(u8::from(self.two_sided)), 0.0, 0.0]),
            ..Model::default()
        }
    }
}
