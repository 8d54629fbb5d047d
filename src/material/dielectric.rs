//! A clear solid: glass, water.

use super::boundary::glass_numbers;
use super::declared::Dielectric;
use super::declared::dielectric::FIELDS;
use super::model::{MaterialKind, Model};
use super::width::LobeWidth;
use crate::data;
use crate::lobe::dispersion::DISPERSION;

pub const KIND: MaterialKind = MaterialKind {
    shader: "dielectric",
    numbers: &["ior", "outside", "inside"],
    second_part: &[],
    widths: &[LobeWidth::Specular],
    is_transmissive: true,
    is_pane: false,
    emits: false,
    rows: &[DISPERSION],
    has_lobes: false,
};

/// A refractive index within this of 1, but not 1, is visible only at grazing incidence: rays are bent by |n - 1| tan θ.
const NEAR_ONE: f64 = 1e-6;

impl Dielectric {
    pub fn model(&self) -> Model<'_> {
        let model = glass(self.ior).tinted(&self.transmittance).absorbing(self.absorption);
        model.dispersing(self.ior, self.dispersion)
    }
}

/// Clear glass of this index.
pub fn glass(ior: f64) -> Model<'static> {
    Model {
        widths: vec![LobeWidth::Specular],
        warning: warning(ior).map(|warning| (&FIELDS.ior, warning)),
        on_device: data::Material {
            numbers: glass_numbers(ior).map(|number| number as f32),
            ..data::Material::default()
        },
        ..Model::default()
    }
}

fn warning(ior: f64) -> Option<String> {
    // f64 rounds a decimal near 1 by up to half of its epsilon, and the difference from 1 is off by as much.
    let near = ior != 1.0 && (ior - 1.0).abs() <= NEAR_ONE + f64::EPSILON;
    // Total reflection begins about sqrt(2 |n - 1|) from grazing incidence.
    let grazing = (2.0 * NEAR_ONE).sqrt().to_degrees();
    near.then(|| {
        format!(
            "an ior of {ior} is within {NEAR_ONE:e} of 1: its reflection and refraction are visible only in rays within {grazing:.2} \
             degrees of the surface: write 1, or an ior that differs more from 1"
        )
    })
}
