//! A perfectly diffuse surface: its reflected radiance is the same in all directions.

use super::{Emission, MaterialKind, Model, Paint, Scattering, Slot};
use crate::data;
use crate::error::Result;
use crate::source::Place;
use crate::source::form::Form;
use crate::texture::{TEXTURE, Texture};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Lambertian", fields: &[("albedo", TEXTURE)], in_order: false },
    shader: "lambertian",
    scatters: &[Scattering::Spread],
    is_clear: false,
    emits: false,
};

pub struct Lambertian<'a> {
    pub albedo: &'a Texture,
}

impl<'a> Model<'a> for Lambertian<'a> {
    fn slots(&self) -> Vec<Slot<'a>> {
        vec![Slot::albedo(self.albedo)]
    }

    fn check(&self, _: &Place) -> Result<()> {
        Ok(())
    }

    fn warning(&self, _: &Place) -> Option<String> {
        None
    }

    fn scattering(&self) -> Scattering {
        Scattering::Spread
    }

    fn emission(&self) -> Option<Emission<'a>> {
        None
    }

    fn upload(&self, paint: &mut dyn FnMut(Slot<'a>) -> Paint) -> data::Material {
        let Paint { colour, texture } = paint(Slot::albedo(self.albedo));
        data::Material { colour, texture, ..data::Material::default() }
    }
}
