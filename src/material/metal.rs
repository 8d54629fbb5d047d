//! A mirror, perfect or rough.

use super::{MaterialKind, Model, Number, Scattering, Slot};
use crate::data;
use crate::source::form::{Form, NUMBER};
use crate::source::share;
use crate::texture::{TEXTURE, Texture};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Metal", fields: &[("albedo", TEXTURE), ("fuzz", NUMBER)], in_order: false },
    shader: "metal",
    scatters: &[Scattering::Spread, Scattering::OneWay],
    is_clear: false,
    emits: false,
};

pub fn model(albedo: &Texture, fuzz: f64) -> Model<'_> {
    let on_device = data::Material { parameter: fuzz as f32, ..data::Material::default() };
    Model {
        slot: Some(Slot::albedo(albedo)),
        // A fuzz that rounds to 0 in f32 makes a perfect mirror, because kernels read it as f32.
        scattering: if on_device.parameter > 0.0 { Scattering::Spread } else { Scattering::OneWay },
        two_sided: None,
        numbers: vec![Number { field: "fuzz", what: "a fuzz", value: fuzz, check: share, warning: None }],
        on_device,
    }
}
