//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::declared::DiffuseLight;
use super::declared::diffuse_light::FIELDS;
use super::model::{MaterialKind, Model, Slot};
use crate::data;
use crate::texture::Use;

pub const KIND: MaterialKind = MaterialKind {
    shader: "diffuse_light",
    lobes: &[],
    is_transmissive: false,
    is_pane: false,
    emits: true,
    extensions: &[],
    has_second_part: false,
};

impl DiffuseLight {
    pub fn model(&self) -> Model<'_> {
        Model {
            slot: Some(Slot { field: &FIELDS.emit, usage: Use::Radiance, texture: &self.emit }),
            two_sided: Some(self.two_sided),
            on_device: data::Material { parameter: f32::from(u8::from(self.two_sided)), ..data::Material::default() },
            ..Model::default()
        }
    }
}
