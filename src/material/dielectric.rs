//! A clear solid: glass, water.

use super::boundary::glass_numbers;
use super::declared::Dielectric;
use super::declared::dielectric::FIELDS;
use super::model::{MaterialKind, Model, with_numbers};
use super::width::LobeWidth;
use crate::lobe::dispersion::DISPERSION;
use crate::texture::{Colour, Texture};

pub const KIND: MaterialKind = MaterialKind {
    numbers: &["ior", "outside", "inside"],
    is_transmissive: true,
    rows: &[DISPERSION],
    ..MaterialKind::new("dielectric", &[LobeWidth::Specular])
};

/// A refractive index within this of 1, but not 1, is visible only at grazing incidence: rays are bent by |n - 1| tan θ.
const NEAR_ONE: f64 = 1e-6;

impl Dielectric {
    pub fn model(&self) -> Model<'_> {
        glass(self.ior, &self.transmittance, self.absorption, self.dispersion)
    }
}

/// Clear glass of this index.
pub fn glass(ior: f64, tint: &Option<Texture>, absorption: Option<Colour>, dispersion: f64) -> Model<'_> {
    let model = Model {
        widths: vec![LobeWidth::Specular],
        warning: warning(ior).map(|warning| (&FIELDS.ior, warning)),
        on_device: with_numbers(glass_numbers(ior)),
        absorption,
        ..Model::default()
    };
    model.tinted(tint).dispersing(ior, dispersion)
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
