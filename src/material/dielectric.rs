//! A clear solid: glass, water.

use super::{MaterialKind, Model, Number, Scattering};
use crate::data;
use crate::source::form::{Form, NUMBER};
use crate::source::length;

pub const KIND: MaterialKind = MaterialKind {
    form: Form { name: "Dielectric", fields: &[("ior", NUMBER)], in_order: false },
    shader: "dielectric",
    scatters: &[Scattering::OneWay],
    is_clear: true,
    emits: false,
};

/// A refractive index within this of 1, and not 1, shows nowhere but at grazing incidence: rays are bent by |n - 1| tan θ.
const NEAR_ONE: f64 = 1e-6;

pub fn model(ior: f64) -> Model<'static> {
    let inside = 1.0 / ior;
    Model {
        slot: None,
        scattering: Scattering::OneWay,
        two_sided: None,
        numbers: vec![Number { field: "ior", what: "an ior", value: ior, check: length, warning: warning(ior) }],
        on_device: data::Material {
            parameter: ior as f32,
            contrast_outside: ((ior - 1.0) * (ior + 1.0)) as f32,
            contrast_inside: ((inside - 1.0) * (inside + 1.0)) as f32,
            ..data::Material::default()
        },
    }
}

fn warning(ior: f64) -> Option<String> {
    // The nearest f64 to a decimal near 1, and with it the difference, is off by half a unit at 1.
    let near = ior != 1.0 && (ior - 1.0).abs() <= NEAR_ONE + f64::EPSILON;
    // Up to about sqrt(2 |n - 1|) from grazing incidence, where total reflection begins.
    let grazing = (2.0 * NEAR_ONE).sqrt().to_degrees();
    near.then(|| {
        format!(
            "an ior of {ior} is within {NEAR_ONE:e} of 1: but for rays within {grazing:.2} degrees of its surface it reflects nothing and bends \
             nothing that an image would show: write 1 or a larger difference"
        )
    })
}
