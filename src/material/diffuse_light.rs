//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::declared::DiffuseLight;
use super::declared::diffuse_light::FIELDS;
use super::model::{MaterialKind, Model};
use super::row::Slot;
use crate::data;
use crate::texture::Use;

pub const KIND: MaterialKind = MaterialKind {
    shader: "diffuse_light",
    numbers: &["two_sided"],
    second_part: &[],
    widths: &[],
    is_transmissive: false,
    is_pane: false,
    emits: true,
    rows: &[],
    has_lobes: false,
};

impl DiffuseLight {
    pub fn model(&self) -> Model<'_> {
        Model {
            slot: Some(Slot { field: &FIELDS.emit, usage: Use::Radiance, texture: &self.emit }),
            two_sided: Some(self.two_sided),
            on_device: data::Material {
                numbers: [f32::from(u8::from(self.two_sided)), 0.0, 0.0],
                ..data::Material::default()
            },
            ..Model::default()
        }
    }
}
