//! What the blocks of a sweep say of every setting: seconds, noise, bias, time to an error, and where that puts it beside the others.

use super::model::{Falling, Model, Standing, Times, doubt, falling, standings};
use super::pace::{Pace, paces};
use super::replicates::{Estimate, Pixels, noise, signed_bias, squared_bias};
use super::sweep::{FEWEST_ROUNDS, LEVEL, LEVELS, Setting, Subject, Sweep};
use super::truth::{Distance, Truth};
use crate::knobs::Class;
use crate::metrics::error::RELATIVE_FLOOR;

/// relMSE to reach.
pub const TARGETS: [f64; 3] = [1e-1, 1e-2, 1e-3];
/// The probability that any unbiased setting at all is called biased.
const FALSE_ALARMS: f64 = 0.05;

/// The standard error, as a share, of the error that is promised, up to which it is called reliable.
const RELIABLE: f64 = 0.2;

/// What is known of a setting.
#[derive(Clone, Debug)]
pub struct Measured {
    pub setting: Setting,
    /// Blocks of [`LEVEL`] samples that it and the defaults have.
    pub rounds: usize,
    pub seconds_compile: f64,
    /// Of a sample a pixel, at the size of the sweep.
    pub seconds_here: f64,
    /// The same at the whole size, half the interquartile range, and the standard error as a share.
    pub seconds: f64,
    pub seconds_spread: f64,
    pub seconds_doubt: f64,
    pub model: Model,
    /// The mean's bias, relative; with sign. Against the defaults, or against the reference where these differ from it.
    pub signed: Estimate,
    /// relMSE of the bias, pixel by pixel.
    pub squared: Estimate,
    /// Whether either is more than noise, all settings and both tests taken into account.
    pub biased: bool,
    /// Whether biases are against the reference.
    pub against_reference: bool,
    /// Whether its noise is known; where few pixels make most of it, estimates are too low as long as these have not been met.
    pub reliable: bool,
    /// The standard error, as a share, of its noise where that comes to the middle target.
    pub noise_doubt: f64,
    /// Seconds to the targets.
    pub times: [Option<f64>; TARGETS.len()],
    pub standing: Standing,
}

impl Measured {
    /// 1 / (relative variance of a sample × its seconds) (Pharr, Jakob, Humphreys, PBR 4th ed., section 2.1.4), at [`LEVEL`] samples.
    pub fn efficiency(&self) -> f64 {
        let samples = f64::from(LEVEL);
        let variance = samples * (self.model.error(samples) - self.model.squared_bias);
        1.0 / (variance * self.model.seconds)
    }

    /// Whether its knob is declared to change no expectation.
    pub fn declared_unbiased(&self) -> bool {
        matches!(self.setting.class(), Class::Exact | Class::Noise)
    }

    /// What it is, within a sentence.
    pub fn named(&self) -> String {
        match self.setting.knob {
            None => "the defaults".to_string(),
            Some(_) => format!("`{}`", self.setting.name()),
        }
    }

    /// Where it stands, in words.
    pub fn verdict(&self) -> String {
        let standing = match self.standing {
            Standing::Front => "on the front",
            Standing::Dominated => "dominated",
            Standing::NeverReaches => "cannot reach",
        };
        let mut words = vec![standing];
        match (self.biased, self.setting.class()) {
            (true, Class::Noise | Class::Exact) if self.against_reference => words.push("differs from the reference"),
            (true, Class::Noise | Class::Exact) => words.push("biased, and declared not to be: a defect"),
            (true, _) => words.push("biased"),
            (false, _) => {}
        }
        if !self.reliable {
            words.push("unreliable: rare bright paths, or too few rounds");
        }
        words.join(", ")
    }
}

/// What a sweep came to.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    /// The settings that have three rounds; the defaults first.
    pub measured: Vec<Measured>,
    /// How far the defaults are from a reference that was given and tells its noise, and whether that is more than the noise of both.
    pub against_reference: Option<(Distance, bool)>,
    /// The image that errors are relative to.
    pub weights: Pixels,
}

/// Judges every subject that has three rounds; the others are noted as not measured, for that reason. `whole` is what seconds and noise are
/// at the size that the scene asks for, over those at the sweep's.
///
/// Biases are against the defaults, which share their random numbers, so that most of the noise cancels. Where the defaults are not what a
/// reference shows, they are no measure, and biases are against the reference.
pub fn judge(sweep: &mut Sweep<'_>, reference: Option<&Truth>, whole: (f64, f64), unreached: &str) -> Judged {
    let Some(weights) = weights(sweep, reference) else {
        let all: Vec<Setting> = sweep.subjects.iter().map(|subject| subject.setting.clone()).collect();
        all.into_iter().for_each(|setting| sweep.leave_out(setting, unreached));
        return Judged::default();
    };
    let seconds: Vec<Vec<f64>> = sweep.subjects.iter().map(seconds).collect();
    let timed: Vec<usize> = (0..seconds.len()).filter(|&i| seconds[i].len() >= FEWEST_ROUNDS).collect();
    let mut paces = paces(&timed.iter().map(|&i| seconds[i].as_slice()).collect::<Vec<_>>()).into_iter();
    // Rounds that all of them have: an image more would be a difference between settings that have none.
    let rounds =
        |level: u32| timed.iter().map(|&i| sweep.subjects[i].blocks.get(&level).map_or(0, Vec::len)).min().unwrap_or(0);
    let common = LEVELS.map(|level| (level, rounds(level)));
    let mut found: Vec<(usize, Measured)> = Vec::new();
    let mut missing = Vec::new();
    for (i, subject) in sweep.subjects.iter().enumerate() {
        let pace = if timed.contains(&i) { paces.next() } else { None };
        match pace.and_then(|pace| measured(subject, &sweep.subjects[0], pace, &common, &weights, whole)) {
            Some(measured) => found.push((i, measured)),
            None => missing.push(subject.setting.clone()),
        }
    }
    for setting in missing {
        sweep.leave_out(setting, unreached);
    }
    let distance = |subject: usize| reference?.distance(&images(&sweep.subjects[subject]), &weights);
    let of_defaults = distance(0);
    // Two tests of each setting beside the defaults, and of these against the reference (Šidák, JASA 62(318), 1967).
    let tests = 2 * (found.len().saturating_sub(1) + usize::from(of_defaults.is_some()));
    let level = 1.0 - (1.0 - FALSE_ALARMS).powf(1.0 / tests.max(1) as f64);
    let shows = |signed: &Estimate, squared: &Estimate| {
        signed.p() < level || (squared.value > 0.0 && squared.p() / 2.0 < level)
    };
    let against_reference = of_defaults.map(|found| (found, shows(&found.signed, &found.squared)));
    let differs = against_reference.is_some_and(|(_, differs)| differs);
    for (subject, measured) in &mut found {
        if let Some(distance) = differs.then(|| distance(*subject)).flatten() {
            (measured.signed, measured.squared) = (distance.signed, distance.squared);
            measured.against_reference = true;
        }
        measured.biased = shows(&measured.signed, &measured.squared);
        // What is declared unbiased and not found otherwise has none.
        let unbiased = measured.declared_unbiased() && !measured.biased;
        if !unbiased {
            let (least, most) = by_mean(&measured.signed, &weights);
            measured.model.squared_bias = measured.squared.value.max(least);
            measured.model.squared_bias_upper = measured.squared.upper().max(most);
        }
        measured.times = TARGETS.map(|target| measured.model.seconds_to(target));
    }
    let mut found: Vec<Measured> = found.into_iter().map(|(_, measured)| measured).collect();
    let times: Vec<Times> = found.iter().map(|m| (m.times.to_vec(), m.seconds_doubt)).collect();
    for (measured, standing) in found.iter_mut().zip(standings(&times)) {
        measured.standing = standing;
    }
    Judged { measured: found, against_reference, weights }
}

/// The image that errors are relative to: the less noisy of the reference and the pooled samples. Where noise makes a pixel dark, its errors
/// would look larger than they are.
fn weights(sweep: &Sweep<'_>, reference: Option<&Truth>) -> Option<Pixels> {
    let pooled = Truth::pooled(sweep, None)?;
    let Some(reference) = reference else { return Some(pooled.image) };
    let errors = reference.error(&pooled.image).zip(pooled.error(&pooled.image));
    let noisier = errors.is_some_and(|(reference, pooled)| reference > pooled);
    Some(if noisier { pooled.image } else { reference.image.clone() })
}

/// What the mean tells of the bias pixel by pixel: relMSE that is there at least, and that may be there by what is known of it. For a bias b
/// and w = 1 / (r² + 0.01), (mean b)² <= mean(w b²) mean(1/w) (Cauchy and Schwarz). Bias that sits in rare bright paths, as a limit takes it,
/// shows in the mean long before pixels of different images have it in common.
fn by_mean(signed: &Estimate, weights: &Pixels) -> (f64, f64) {
    let values = weights.as_flattened().iter().map(|&r| f64::from(r));
    let (sum, squares) = values.fold((0.0, 0.0), |(sum, squares), r| (sum + r, squares + r * r + RELATIVE_FLOOR));
    let share = sum * sum / (squares * (3 * weights.len()) as f64);
    let size = Estimate { value: signed.value.abs(), ..*signed };
    let least = (size.value - size.half_width()).max(0.0);
    (share * least.powi(2), share * size.upper().powi(2))
}

/// Seconds of a sample in each round.
fn seconds(subject: &Subject<'_>) -> Vec<f64> {
    let blocks = subject.blocks.get(&LEVEL).map_or(&[][..], Vec::as_slice);
    blocks.iter().map(|block| block.seconds / f64::from(LEVEL)).collect()
}

/// The images that biases are measured with.
fn images(subject: &Subject<'_>) -> Vec<Pixels> {
    subject.blocks.get(&LEVEL).map_or(Vec::new(), |blocks| blocks.iter().map(|block| block.image.clone()).collect())
}

fn measured(
    subject: &Subject<'_>,
    defaults: &Subject<'_>,
    pace: Pace,
    common: &[(u32, usize)],
    weights: &Pixels,
    (slower, noisier): (f64, f64),
) -> Option<Measured> {
    let images = |subject: &Subject<'_>, level: u32| {
        let (_, rounds) = common.iter().find(|(of, _)| *of == level)?;
        let blocks = subject.blocks.get(&level)?.get(..*rounds)?;
        Some(blocks.iter().map(|block| block.image.clone()).collect::<Vec<_>>())
    };
    let (own_images, base_images) = (images(subject, LEVEL)?, images(defaults, LEVEL)?);
    let levels: Vec<(u32, Estimate)> =
        common.iter().filter_map(|&(level, _)| Some((level, noise(&images(subject, level)?, weights)?))).collect();
    let fall = falling(&levels).or_else(|| {
        // No noise at all: a scene of one colour.
        let silent = levels.iter().all(|(_, noise)| noise.value <= 0.0);
        (silent && !levels.is_empty()).then_some(Falling::SILENT)
    })?;
    let fall = Falling { noise: noisier * fall.noise, ..fall };
    let noise_doubt = fall.doubt(fall.samples_to(TARGETS[1]));
    let seconds = slower * pace.seconds;
    Some(Measured {
        setting: subject.setting.clone(),
        rounds: own_images.len(),
        seconds_compile: subject.seconds_compile,
        seconds_here: pace.seconds,
        seconds,
        seconds_spread: slower * pace.spread,
        seconds_doubt: pace.doubt,
        model: Model { squared_bias: 0.0, squared_bias_upper: 0.0, noise: fall, seconds },
        signed: signed_bias(&own_images, &base_images, weights)?,
        squared: squared_bias(&own_images, &base_images, weights)?,
        biased: false,
        against_reference: false,
        reliable: noise_doubt <= RELIABLE,
        noise_doubt,
        times: [None; TARGETS.len()],
        standing: Standing::NeverReaches,
    })
}

/// The setting that reaches a target soonest, of those that meet a condition.
fn soonest(found: &[Measured], target: usize, condition: impl Fn(&Measured) -> bool) -> Option<&Measured> {
    let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
    let reaching = found.iter().filter(|m| m.times[target].is_some() && condition(m));
    reaching.min_by(|a, b| time(a).total_cmp(&time(b)))
}

/// The soonest that meets a condition, or the defaults or another setting declared unbiased that is as soon within the doubt of timings.
pub fn preferred(found: &[Measured], target: usize, condition: impl Fn(&Measured) -> bool) -> Option<&Measured> {
    let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
    let best = soonest(found, target, &condition)?;
    let near = |m: &&Measured| time(m) < doubt(m.seconds_doubt, best.seconds_doubt) * time(best);
    let defaults = soonest(found, target, |m| m.setting.knob.is_none() && condition(m)).filter(near);
    let faithful = soonest(found, target, |m| m.declared_unbiased() && condition(m)).filter(near);
    Some(defaults.or(faithful).unwrap_or(best))
}

/// What is advised for each target: nothing whose noise is not known.
pub fn recommended(found: &[Measured]) -> [Option<&Measured>; TARGETS.len()] {
    std::array::from_fn(|target| preferred(found, target, |measured| measured.reliable))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the mean tells of the bias of pixels is never more than there is, and all of it where the bias is spread as 1/w.
    #[test]
    fn a_bias_of_the_mean_is_one_of_pixels() {
        let weights: Pixels = (0..64).map(|i| [0.02 * i as f32, 0.5, 3.0 / (1 + i) as f32]).collect();
        let values: Vec<f64> = weights.as_flattened().iter().map(|&r| f64::from(r)).collect();
        let mean = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(of).sum::<f64>() / values.len() as f64;
        let whole = mean(&|i| values[i]);
        let of_pixel = |i: usize| values[i] * values[i] + RELATIVE_FLOOR;
        let biases: [&dyn Fn(usize) -> f64; 3] =
            [&of_pixel, &|i| if i == 17 { -1.0 } else { 0.0 }, &|i| (i as f64).sin() - 0.1];
        for (case, bias) in biases.into_iter().enumerate() {
            let squared = mean(&|i| bias(i) * bias(i) / of_pixel(i));
            let signed = Estimate { value: mean(bias) / whole, error: 0.0, degrees: 7.0 };
            let (least, most) = by_mean(&signed, &weights);
            assert!(least == most && least <= squared * (1.0 + 1e-9) && least > 0.0, "{case}: {least} {squared}");
            assert!(case > 0 || (least / squared - 1.0).abs() < 1e-9, "{least} {squared}");
            // What is known less well may be more, and is less for sure.
            let unsure = Estimate { error: 0.1 * signed.value.abs(), ..signed };
            let (low, high) = by_mean(&unsure, &weights);
            assert!(low < least && high > most);
        }
        assert_eq!(by_mean(&Estimate { value: 0.1, error: 1.0, degrees: 7.0 }, &weights).0, 0.0);
    }
}
