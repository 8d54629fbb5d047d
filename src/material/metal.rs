//! A mirror, perfect or rough.

use super::{Emission, MaterialKind, Model, Paint, Scattering, Slot};
use crate::data;
use crate::error::Result;
use crate::source::form::{Form, NUMBER};
use crate::source::{Place, share};
use crate::texture::{TEXTURE, Texture};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Metal", fields: &[("albedo", TEXTURE), ("fuzz", NUMBER)], in_order: false },
    shader: "metal",
    scatters: &[Scattering::Spread, Scattering::OneWay],
    is_clear: false,
    emits: false,
};

pub struct Metal<'a> {
    pub albedo: &'a Texture,
    pub fuzz: f64,
}

impl<'a> Model<'a> for Metal<'a> {
    fn slots(&self) -> Vec<Slot<'a>> {
        vec![Slot::albedo(self.albedo)]
    }

    fn check(&self, at: &Place) -> Result<()> {
        share(&at.field("fuzz"), "a fuzz", self.fuzz)
    }

    fn warning(&self, _: &Place) -> Option<String> {
        None
    }

    /// A fuzz that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
    fn scattering(&self) -> Scattering {
        if self.fuzz as f32 > 0.0 { Scattering::Spread } else { Scattering::OneWay }
    }

    fn emission(&self) -> Option<Emission<'a>> {
        None
    }

    fn upload(&self, paint: &mut dyn FnMut(Slot<'a>) -> Paint) -> data::Material {
        let Paint { colour, texture } = paint(Slot::albedo(self.albedo));
        data::Material { colour, texture, parameter: self.fuzz as f32, ..data::Material::default() }
    }
}
