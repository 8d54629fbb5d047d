//! A clear solid: glass, water.

use super::{Emission, MaterialKind, Model, Paint, Scattering, Slot};
use crate::data::{self, NO_TEXTURE};
use crate::error::Result;
use crate::source::form::{Form, NUMBER};
use crate::source::{Place, length};

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Dielectric", fields: &[("ior", NUMBER)], in_order: false },
    shader: "dielectric",
    scatters: &[Scattering::OneWay],
    is_clear: true,
    emits: false,
};

/// A refractive index within this of 1, and not 1, shows nowhere but at grazing incidence: rays are bent by |n - 1| tan θ.
const NEAR_ONE: f64 = 1e-6;

pub struct Dielectric {
    pub ior: f64,
}

impl<'a> Model<'a> for Dielectric {
    fn slots(&self) -> Vec<Slot<'a>> {
        Vec::new()
    }

    fn check(&self, at: &Place) -> Result<()> {
        length(&at.field("ior"), "an ior", self.ior)
    }

    fn warning(&self, at: &Place) -> Option<String> {
        let ior = self.ior;
        // The nearest f64 to a decimal near 1, and with it the difference, is off by half a unit at 1.
        let near = ior != 1.0 && (ior - 1.0).abs() <= NEAR_ONE + f64::EPSILON;
        // Up to about sqrt(2 |n - 1|) from grazing incidence, where total reflection begins.
        let grazing = (2.0 * NEAR_ONE).sqrt().to_degrees();
        let message = format!(
            "an ior of {ior} is within {NEAR_ONE:e} of 1: but for rays within {grazing:.2} degrees of its surface it reflects nothing and bends \
             nothing that an image would show: write 1 or a larger difference"
        );
        near.then(|| at.field("ior").warning(&message))
    }

    fn scattering(&self) -> Scattering {
        Scattering::OneWay
    }

    fn emission(&self) -> Option<Emission<'a>> {
        None
    }

    fn upload(&self, _: &mut dyn FnMut(Slot<'a>) -> Paint) -> data::Material {
        let (ior, inside) = (self.ior, 1.0 / self.ior);
        data::Material {
            parameter: ior as f32,
            contrast_outside: ((ior - 1.0) * (ior + 1.0)) as f32,
            contrast_inside: ((inside - 1.0) * (inside + 1.0)) as f32,
            texture: NO_TEXTURE,
            ..data::Material::default()
        }
    }
}
