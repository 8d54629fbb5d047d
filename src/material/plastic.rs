//! A matt body under a clear layer, as that of Mitsuba's plastic and roughplastic.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::boundary::glass_numbers;
use super::declared::plastic::FIELDS;
use super::declared::{Distribution, Plastic};
use super::layer::Layer;
use super::model::{MaterialKind, Model, with_numbers};
use super::row::{ALPHA, BECKMANN, EMISSION, ONE_SIDED, ROUGH_LAYER, Slot};
use super::width::{ANY_WIDTH, LEAST_ROUGHNESS, LobeWidth};
use crate::data::{self, NO_TEXTURE};
use crate::texture::Use;

/// The numbers and tables of layers by their index, alpha, and whether they have Beckmann's distribution.
type Layers = HashMap<(u64, u64, bool), Arc<(f64, Vec<f64>)>>;

pub const KIND: MaterialKind = MaterialKind {
    numbers: &["roughness", "contrast", "leaving"],
    second_part: &["nonlinear", "table"],
    rows: &[EMISSION, ALPHA, ONE_SIDED, BECKMANN, ROUGH_LAYER],
    ..MaterialKind::new("plastic", ANY_WIDTH)
};

impl Plastic {
    /// Without the number `leaving` and the table, which are computed for those that are used.
    pub fn model(&self) -> Model<'_> {
        let [_, contrast, _] = glass_numbers(self.ior);
        let nonlinear = f64::from(u8::from(self.nonlinear));
        let model = Model {
            slot: Some(Slot { field: &FIELDS.diffuse, usage: Use::Albedo, texture: &self.diffuse }),
            widths: vec![LobeWidth::Wide, LobeWidth::of_facets(self.roughness, 0.0)],
            on_device: with_numbers([self.roughness, contrast, 0.0]),
            second_part: Some(data::Material { texture: NO_TEXTURE, ..with_numbers([nonlinear, 0.0, 0.0]) }),
            ..Model::default()
        };
        let model = model.emissive(&self.emission, self.one_sided_emission);
        let model = model.cut_out(&self.alpha, None, false).one_sided(self.one_sided);
        model.distributed(self.distribution).flagged(&FIELDS.roughness, ROUGH_LAYER, self.is_rough())
    }

    fn is_rough(&self) -> bool {
        self.roughness as f32 >= LEAST_ROUGHNESS
    }

    /// The share of the body's light that leaves the layer, times the index squared; and what a rough layer lets pass: the table of
    /// shaders/lobe/rough_layer.
    pub fn layer(&self) -> Arc<(f64, Vec<f64>)> {
        // Scenes have many plastics of one layer, and a session has them in every image.
        static KNOWN: Mutex<Option<Layers>> = Mutex::new(None);
        let Plastic { ior, distribution, .. } = *self;
        let alpha = if self.is_rough() { self.roughness.powi(2) } else { 0.0 };
        let key = (ior.to_bits(), alpha.to_bits(), distribution == Distribution::Beckmann);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let made = known.get_or_insert_default().entry(key).or_insert_with(|| {
            let from = |eta: f64| Layer { eta, alpha, distribution };
            Arc::new(match alpha > 0.0 {
                true => (ior * ior * (1.0 - from(1.0 / ior).mean_reflectance()), from(ior).table()),
                // As much enters as leaves.
                false => (1.0 - from(ior).mean_reflectance(), Vec::new()),
            })
        });
        Arc::clone(made)
    }
}
