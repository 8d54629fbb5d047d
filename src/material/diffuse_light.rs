//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::{Emission, MaterialKind, Model, Paint, Scattering, Slot};
use crate::data;
use crate::error::Result;
use crate::source::Place;
use crate::source::form::Form;
use crate::texture::{TEXTURE, Texture, Use};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "DiffuseLight", fields: &[("emit", TEXTURE), ("two_sided", "true or false")], in_order: false },
    shader: "diffuse_light",
    scatters: &[],
    is_clear: false,
    emits: true,
};

pub struct DiffuseLight<'a> {
    pub emit: &'a Texture,
    pub two_sided: bool,
}

impl<'a> DiffuseLight<'a> {
    fn slot(&self) -> Slot<'a> {
        Slot { field: "emit", usage: Use::Radiance, texture: self.emit }
    }
}

impl<'a> Model<'a> for DiffuseLight<'a> {
    fn slots(&self) -> Vec<Slot<'a>> {
        vec![self.slot()]
    }

    fn check(&self, _: &Place) -> Result<()> {
        Ok(())
    }

    fn warning(&self, _: &Place) -> Option<String> {
        None
    }

    fn scattering(&self) -> Scattering {
        Scattering::Nowhere
    }

    fn emission(&self) -> Option<Emission<'a>> {
        Some(Emission { slot: self.slot(), two_sided: self.two_sided })
    }

    fn upload(&self, paint: &mut dyn FnMut(Slot<'a>) -> Paint) -> data::Material {
        let Paint { colour, texture } = paint(self.slot());
        data::Material { colour, texture, parameter: f32::from(u8::from(self.two_sided)), ..data::Material::default() }
    }
}
