//! What a film says of its own error, and whether that can be relied on.

use super::{ErrorEstimate, Film, HiddenLight};

/// The relative error that missing light makes, over its share of the image's light: 1 where it lies on all pixels alike, and 4, as a caustic,
/// where it lies on a sixteenth of them.
const CONCENTRATION: f64 = 4.0;

/// The stated error of a film, and the light that it may lack, as shares of the image's light.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// None while nothing is known of it.
    pub error: Option<ErrorEstimate>,
    /// Light that narrow lobes hide from light sampling.
    pub hidden: HiddenLight,
    /// Where lights are not sampled: the most light that no path has found.
    pub unfound: f64,
}

impl Film {
    /// The film's error and what it may lack. Its bounds are wrong with a probability of `level` each.
    pub fn verdict(&self, level: f64) -> Verdict {
        let light = self.mean_radiance() * self.totals.paths as f64;
        let share = if light > 0.0 { 1.0 / light } else { 0.0 };
        // A path brings at most the brightest radiance of the scene, which is at most 1 in device units. If k such paths are expected, none
        // comes with the probability e^-k.
        let unfound = if self.samples_lights { 0.0 } else { level.recip().ln() * share };
        Verdict { error: self.error_estimate(level), hidden: self.totals.hidden_light().times(share), unfound }
    }
}

impl Verdict {
    /// Whether light may be missing that makes an error larger than the stated bound.
    pub fn lacks_light(&self) -> bool {
        let error_of_missing = CONCENTRATION * self.hidden.missing();
        self.error.is_some_and(|error| error_of_missing.max(self.unfound) > error.bound)
    }

    /// Whether the stated error can be relied on.
    pub fn reliable(&self) -> Option<bool> {
        self.error.map(|error| error.reliable && !self.lacks_light())
    }

    /// Why the stated error cannot be relied on.
    pub fn reasons_unreliable(&self) -> Vec<String> {
        let percent = |share: f64| format!("{:.2}", 100.0 * share);
        let mut reasons = Vec::new();
        if let Some(error) = self.error.filter(|error| !error.reliable) {
            let may_be = match error.bound.is_finite() {
                true => format!(". It may be {} %", percent(error.bound)),
                false => String::new(),
            };
            reasons.push(format!("rare bright paths dominate it{may_be}"));
        }
        if self.lacks_light() && self.unfound > self.hidden.missing() {
            reasons.push(format!(
                "--integrator bsdf finds lights by chance: up to {} % of the image's light may be missing, from the brightest light. Raise \
                 --spp, or use --integrator mis",
                percent(self.unfound)
            ));
        } else if self.lacks_light() {
            reasons.push(format!(
                "mirrors, glass and other narrow lobes hide {} % of the image's light from light sampling, and paths have found {} %. Raise \
                 --spp",
                percent(self.hidden.probed()),
                percent(self.hidden.found())
            ));
        }
        reasons
    }
}
