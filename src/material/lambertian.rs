//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::{MaterialKind, Model, Scattering, Slot};
use crate::data;
use crate::source::form::Form;
use crate::texture::{TEXTURE, Texture};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Lambertian", fields: &[("albedo", TEXTURE)], in_order: false },
    shader: "lambertian",
    scatters: &[Scattering::Spread],
    is_clear: false,
    emits: false,
};

pub fn model(albedo: &Texture) -> Model<'_> {
    Model {
        slot: Some(Slot::albedo(albedo)),
        scattering: Scattering::Spread,
        two_sided: None,
        numbers: Vec::new(),
        on_device: data::Material::default(),
    }
}
