//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::{MaterialKind, Model, Scattering, Slot};
use crate::data;
use crate::source::form::Form;
use crate::texture::{TEXTURE, Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "DiffuseLight", fields: &[("emit", TEXTURE), ("two_sided", "true or false")], in_order: false },
    shader: "diffuse_light",
    scatters: &[],
    is_clear: false,
    emits: true,
};

pub fn model(emit: &Texture, two_sided: bool) -> Model<'_> {
    Model {
        slot: Some(Slot { field: "emit", usage: Use::Radiance, texture: emit }),
        scattering: Scattering::Nowhere,
        two_sided: Some(two_sided),
        numbers: Vec::new(),
        on_device: data::Material { parameter: f32::from(u8::from(two_sided)), ..data::Material::default() },
    }
}
