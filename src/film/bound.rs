//! What the bound of a film's error follows from, beside the samples: light that they may not have found.

use crate::data::LampPixel;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bound {
    /// The largest radiance, in device units, of what the paths do not sample as a light: they find it by BSDF sampling alone.
    pub not_sampled: f64,
    /// The pixels that lamps cover in part.
    pub lamps: Vec<LampPixel>,
}

impl Bound {
    /// Joins that of another film of the same image.
    pub fn merge(&mut self, other: &Bound) {
        self.not_sampled = self.not_sampled.max(other.not_sampled);
        if self.lamps.is_empty() {
            self.lamps.clone_from(&other.lamps);
        }
    }
}
