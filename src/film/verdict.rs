//! The stated error of a film, and whether it is reliable.

use super::{ErrorEstimate, Film, HiddenLight};
use crate::printable::{known_bound, percent};

/// The relative error by missing light, over its share of the image's light: 1 if all pixels lack it alike, and 4 if a sixteenth of them do, as
/// in a caustic.
const CONCENTRATION: f64 = 4.0;

/// The stated error of a film, and the light that it may lack, as shares of the image's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// `None` while it is not known.
    pub error: Option<ErrorEstimate>,
    /// Light that narrow lobes hide from light sampling.
    pub hidden: HiddenLight,
    /// The most light that no path has found, of what is not sampled as a light.
    pub unfound: f64,
    /// The most light that `max_depth` has cut off: each of these paths might have met the brightest emitter.
    pub cut: f64,
}

impl Film {
    /// The film's error and the light that it may lack. Each bound is wrong with the probability `level`.
    pub fn verdict(&self, level: f64) -> Verdict {
        let light = self.mean_radiance() * self.totals.paths as f64;
        let share = if light > 0.0 { 1.0 / light } else { 0.0 };
        // A path carries at most the largest radiance of what is not sampled. If k such paths are expected, the probability of none is e^-k.
        let unfound = level.recip().ln() * self.bound.not_sampled * share;
        let (error, hidden) = (self.error_estimate(level), self.totals.hidden_light().times(share));
        // The brightest emitter is below 2 in device units.
        Verdict { error, hidden, unfound, cut: 2.0 * self.totals.cut_throughput() * share }
    }
}

impl Verdict {
    /// Whether missing light may make an error larger than the stated bound.
    pub fn lacks_light(&self) -> bool {
        let error_of_missing = CONCENTRATION * self.hidden.missing();
        self.error.is_some_and(|error| error_of_missing.max(self.unfound) > error.bound)
    }

    /// Whether the stated error is reliable; `None` while it is not known.
    pub fn reliable(&self) -> Option<bool> {
        self.error.map(|error| error.reliable && !self.lacks_light())
    }

    /// Why the stated error is not reliable.
    pub fn reasons_unreliable(&self) -> Vec<String> {
        let of_light = |share: f64| known_bound(share).map_or("most".to_owned(), percent);
        let mut reasons = Vec::new();
        if let Some(error) = self.error.filter(|error| !error.reliable) {
            let may_be =
                known_bound(error.bound).map_or(String::new(), |bound| format!(". It may be {}", percent(bound)));
            reasons.push(format!("rare bright paths dominate it{may_be}"));
        }
        if self.lacks_light() && self.unfound > self.hidden.missing() {
            reasons.push(format!(
                "BSDF sampling alone finds some of the light (a sky without an image, lights beyond the limit, all with --integrator \
                 bsdf), and may have missed {} of the image's light. Raise --spp",
                of_light(self.unfound)
            ));
        } else if self.lacks_light() {
            reasons.push(format!(
                "mirrors, glass and other narrow lobes hide {} of the image's light from light sampling, and paths have found {}. Raise --spp",
                of_light(self.hidden.probed()),
                percent(self.hidden.found())
            ));
        }
        reasons
    }
}
