//! What the blocks of a sweep say of every setting: seconds, noise, bias, time to an error, and where that puts it beside the others.

use super::model::{DOUBT, Model, Standing, falling, standings};
use super::replicates::{Estimate, Pixels, noise, signed_bias, squared_bias};
use super::sweep::{Block, LEVEL, Setting, Subject, Sweep};
use super::truth::{Distance, Truth};
use crate::knobs::Class;

/// relMSE to reach.
pub const TARGETS: [f64; 3] = [1e-1, 1e-2, 1e-3];
/// The probability that any unbiased setting at all is called biased.
const FALSE_ALARMS: f64 = 0.05;

/// What is known of a setting.
#[derive(Clone, Debug)]
pub struct Measured {
    pub setting: Setting,
    /// Blocks of [`LEVEL`] samples that it and the defaults have.
    pub rounds: usize,
    pub seconds_compile: f64,
    /// Of a sample a pixel at the size of the sweep: the median over the rounds.
    pub seconds_here: f64,
    /// The same at the whole size, and half the interquartile range.
    pub seconds: f64,
    pub seconds_spread: f64,
    pub model: Model,
    /// The mean's bias, relative; with sign. Against the defaults, or against the reference where these differ from it.
    pub signed: Estimate,
    /// relMSE of the bias, pixel by pixel.
    pub squared: Estimate,
    /// Whether either is more than noise, all settings and both tests taken into account.
    pub biased: bool,
    /// Whether biases are against the reference.
    pub against_reference: bool,
    /// Whether few pixels make most of its noise, so that estimates of it are too low.
    pub reliable: bool,
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
            words.push("unreliable: rare bright paths");
        }
        words.join(", ")
    }
}

/// The median.
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = share * (sorted.len().saturating_sub(1)) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    match sorted.get(high) {
        Some(above) => sorted[low] + (above - sorted[low]) * (at - low as f64),
        None => f64::NAN,
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
    let mut found: Vec<(usize, Measured)> = Vec::new();
    let mut missing = Vec::new();
    for (i, subject) in sweep.subjects.iter().enumerate() {
        match measured(subject, &sweep.subjects[0], &weights, whole) {
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
        let unbiased = matches!(measured.setting.class(), Class::Exact | Class::Noise) && !measured.biased;
        if !unbiased {
            measured.model.squared_bias = measured.squared.value.max(0.0);
            measured.model.squared_bias_upper = measured.squared.upper().max(0.0);
        }
        measured.times = TARGETS.map(|target| measured.model.seconds_to(target));
    }
    let mut found: Vec<Measured> = found.into_iter().map(|(_, measured)| measured).collect();
    let times: Vec<Vec<Option<f64>>> = found.iter().map(|measured| measured.times.to_vec()).collect();
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

/// The images that biases are measured with.
fn images(subject: &Subject<'_>) -> Vec<Pixels> {
    subject.blocks.get(&LEVEL).map_or(Vec::new(), |blocks| blocks.iter().map(|block| block.image.clone()).collect())
}

fn measured(
    subject: &Subject<'_>,
    defaults: &Subject<'_>,
    weights: &Pixels,
    (slower, noisier): (f64, f64),
) -> Option<Measured> {
    let images = |blocks: &[Block]| blocks.iter().map(|block| block.image.clone()).collect::<Vec<_>>();
    let own = subject.blocks.get(&LEVEL)?;
    let base = defaults.blocks.get(&LEVEL)?;
    let rounds = own.len().min(base.len());
    let (own_images, base_images) = (images(&own[..rounds]), images(&base[..rounds]));
    let levels: Vec<(u32, Estimate)> = subject
        .blocks
        .iter()
        .filter_map(|(samples, blocks)| Some((*samples, noise(&images(blocks), weights)?)))
        .collect();
    let (c, exponent) = falling(&levels).or_else(|| {
        // No noise at all: a scene of one colour.
        let silent = levels.iter().all(|(_, noise)| noise.value <= 0.0);
        (silent && !levels.is_empty()).then_some((0.0, 1.0))
    })?;
    let pace: Vec<f64> = own.iter().map(|block| block.seconds / f64::from(LEVEL)).collect();
    let seconds_here = median(&pace);
    let seconds = slower * seconds_here;
    Some(Measured {
        setting: subject.setting.clone(),
        rounds,
        seconds_compile: subject.seconds_compile,
        seconds_here,
        seconds,
        seconds_spread: slower * 0.5 * (quantile(&pace, 0.75) - quantile(&pace, 0.25)),
        model: Model { squared_bias: 0.0, squared_bias_upper: 0.0, noise: noisier * c, exponent, seconds },
        signed: signed_bias(&own_images, &base_images, weights)?,
        squared: squared_bias(&own_images, &base_images, weights)?,
        biased: false,
        against_reference: false,
        reliable: own.iter().all(|block| block.reliable != Some(false)),
        times: [None; TARGETS.len()],
        standing: Standing::NeverReaches,
    })
}

/// The setting that reaches a target soonest, of those that are reliable and meet a condition.
pub fn soonest(found: &[Measured], target: usize, condition: impl Fn(&Measured) -> bool) -> Option<&Measured> {
    let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
    let reaching = found.iter().filter(|m| m.reliable && m.times[target].is_some() && condition(m));
    reaching.min_by(|a, b| time(a).total_cmp(&time(b)))
}

/// What is advised for each target: the soonest, or the defaults or another unbiased setting that is as soon within the doubt of timings.
pub fn recommended(found: &[Measured]) -> [Option<&Measured>; TARGETS.len()] {
    std::array::from_fn(|target| {
        let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
        let best = soonest(found, target, |_| true)?;
        let near = |measured: &&Measured| time(measured) < DOUBT * time(best);
        let defaults = soonest(found, target, |m| m.setting.knob.is_none()).filter(near);
        let faithful =
            soonest(found, target, |m| matches!(m.setting.class(), Class::Exact | Class::Noise)).filter(near);
        Some(defaults.or(faithful).unwrap_or(best))
    })
}
