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

/// A refractive index within this of 1, but not 1, is visible only at grazing incidence: rays are bent by |n - 1| tan θ.
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
        // f64 rounds a decimal near 1 by up to half of its epsilon, and the difference from 1 is off by as much.
        let near = ior != 1.0 && (ior - 1.0).abs() <= NEAR_ONE + f64::EPSILON;
        // Total reflection begins about sqrt(2 |n - 1|) from grazing incidence.
        let grazing = (2.0 * NEAR_ONE).sqrt().to_degrees();
        let message = format!(
            "an ior of {ior} is within {NEAR_ONE:e} of 1: its reflection and refraction are visible only in rays within {grazing:.2} degrees of \
             the surface: write 1, or an ior that differs more from 1"
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
