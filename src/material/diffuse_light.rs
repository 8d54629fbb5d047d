//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::declared::diffuse_light::FIELDS;
use super::model::{MaterialKind, Model, Slot};
use crate::data;
use crate::texture::{Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    shader: "diffuse_light",
    lobes: &[],
    is_transmissive: false,
    is_pane: false,
    emits: true,
    extensions: &[],
    has_second_part: false,
};

pub fn model(emit: &Texture, two_sided: bool) -> Model<'_> {
    Model {
        slot: Some(Slot { field: &FIELDS.emit, usage: Use::Radiance, texture: emit }),
        lobes: Vec::new(),
        two_sided: Some(two_sided),
        warning: None,
        lacks: None,
        second_part: None,
        extensions: Vec::new(),
        absorption: None,
        on_device: data::Material { parameter: f32::from(u8::from(two_sided)), ..data::Material::default() },
    }
}
