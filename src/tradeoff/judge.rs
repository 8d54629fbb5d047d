//! Judges every setting from the blocks of a sweep: seconds, noise, bias, time to an error, and its ranking among the others.

use super::extent::FullSize;
use super::model::{Falling, Model, Ranking, Times, falling, falling_denoised, rankings, samples_to, tie_ratio};
use super::pace::{Pace, Timed, paces};
use super::replicates::{FEWEST_ROUNDS, Pixels, Weights, noise, signed_bias, squared_bias};
use super::sweep::{Block, LEVEL, LEVELS, Setting, Subject, Sweep, rounds_between};
use super::truth::{Distance, Truth};
use crate::data::luminance;
use crate::metrics::error::{RELATIVE_FLOOR, floor_of, mean_luminance};
use crate::metrics::estimate::Estimate;
use crate::metrics::flip::{self, error_map};
use crate::options::Class;
use crate::render::NOISE_LEVEL;

/// The targets: the relative MSE to reach, which is that of `render`'s relative errors of 32, 10 and 3.2 %.
pub const TARGETS: [f64; 3] = [1e-1, 1e-2, 1e-3];
/// The FLIP to reach: the perceived difference of an image that shows little of its noise.
pub const FLIP_TARGET: f64 = 0.05;
/// The probability that the report calls any unbiased setting biased.
const FALSE_ALARMS: f64 = 0.05;

/// A difference below this relative MSE does not count: a thousandth of the finest target.
const NEGLIGIBLE: f64 = 1e-6;

/// The largest relative standard error of a predicted error that counts as reliable.
pub const RELIABLE: f64 = 0.2;

/// The reason why the loss of detail of an image with fewer pixels is unknown.
const NOT_AT_FULL_SIZE: &str = "its loss of detail needs images of full size, for which the budget was too short";

/// The findings about a setting.
#[derive(Clone, Debug)]
pub struct Measured {
    pub setting: Setting,
    /// The number of blocks of [`LEVEL`] samples that both it and the defaults have.
    pub rounds: usize,
    pub seconds_compile: f64,
    /// Seconds for one sample of every pixel, at the size of the sweep.
    pub seconds_here: f64,
    /// Half the width of the 95 % interval of the model's seconds, which are those of full size.
    pub seconds_half_width: f64,
    /// The relative standard error of the model's seconds.
    pub seconds_error: f64,
    pub model: Model,
    /// The relative MSE of the noise for each measured number of samples, at full size; for denoised images, of noise and bias.
    pub noises: Vec<(u32, f64)>,
    /// The FLIP of an image for each measured number of samples, at the size of the sweep.
    pub flips: Vec<(u32, f64)>,
    /// The relative bias of the mean, with its sign. It is against the defaults, or against the reference if the
    /// defaults differ from it.
    pub signed: Estimate,
    /// The relative MSE of the pixels' bias.
    pub squared: Estimate,
    /// Whether either bias is significant, corrected for the number of settings and tests.
    pub biased: bool,
    /// Whether it is declared unbiased and differs by more than noise, and rare bright paths that were not found may explain the difference.
    pub lacks_paths: bool,
    /// Whether the biases are against the reference.
    pub against_reference: bool,
    /// Whether its noise is known, and its bias if it may have one. If most of the noise is in few pixels, estimates are
    /// too low until paths have found these.
    pub reliable: bool,
    /// The reasons why a render of all its samples would call its error unreliable.
    pub reasons_unreliable: Vec<String>,
    /// The relMSE of its noise over the relative MSE.
    pub relmse_ratio: f64,
    /// Whether the image that its bias refers to is known, or the setting is declared unbiased.
    pub bias_known: bool,
    /// The relative standard error of its noise at the number of samples that reaches the middle target.
    pub noise_error: f64,
    /// Seconds to the targets.
    pub times: [Option<f64>; TARGETS.len()],
    pub ranking: Ranking,
}

impl Measured {
    /// The seconds until FLIP reaches [`FLIP_TARGET`]; none if that is not known.
    pub fn seconds_to_flip(&self) -> Option<f64> {
        samples_to(&self.flips, FLIP_TARGET).map(|samples| self.model.seconds_of(samples))
    }

    /// The squared bias with infinitely many samples; for denoised images, with [`LEVEL`] samples.
    pub fn bias_squared(&self) -> f64 {
        if self.setting.denoise { self.squared.value.max(0.0) } else { self.model.squared_bias }
    }

    /// 1 / (relative variance of a sample × its seconds) (Pharr, Jakob, Humphreys, PBR 4th ed., section 2.1.4), at
    /// [`LEVEL`] samples.
    pub fn efficiency(&self) -> f64 {
        let samples = f64::from(LEVEL);
        let variance = samples * (self.model.error(samples) - self.model.squared_bias);
        1.0 / (variance * self.model.seconds)
    }

    /// Whether no bias is declared, and none was found.
    pub fn is_faithful(&self) -> bool {
        self.setting.declared_unbiased() && !self.biased && !self.lacks_paths
    }

    /// Whether it reaches all targets at the same time as another setting, within the error of the timings.
    pub fn is_as_fast_as(&self, other: &Measured) -> bool {
        let tie = tie_ratio(self.seconds_error, other.seconds_error);
        self.times.iter().zip(other.times).all(|(own, theirs)| match (own, theirs) {
            (Some(own), Some(theirs)) => *own < tie * theirs && theirs < tie * own,
            (own, theirs) => *own == theirs,
        })
    }

    /// Its name within a sentence.
    pub fn named(&self) -> String {
        match self.setting.option {
            None => "the defaults".to_string(),
            Some(_) => format!("`{}`", self.setting.name()),
        }
    }

    /// Its verdict in two words at most, for the terminal.
    pub fn short_verdict(&self) -> &'static str {
        match (self.ranking, self.biased) {
            (Ranking::NeverReaches, _) => "cannot reach",
            (_, true) if self.setting.declared_unbiased() => "differs",
            _ if !self.reliable => "unreliable",
            (Ranking::Dominated, _) => "dominated",
            (Ranking::AsDefaults, true) => "biased",
            (Ranking::AsDefaults, false) => "as the defaults",
            (Ranking::Front, true) => "front, biased",
            (Ranking::Front, false) => "front",
        }
    }

    /// Its ranking and bias in words.
    pub fn verdict(&self) -> String {
        let ranking = match self.ranking {
            Ranking::AsDefaults => "as the defaults",
            Ranking::Front => "on the front",
            Ranking::Dominated => "dominated",
            Ranking::NeverReaches => "cannot reach",
        };
        let mut words = vec![ranking];
        match (self.biased, self.setting.class()) {
            (true, Class::Noise | Class::Exact) if self.against_reference => words.push("differs from the reference"),
            (true, Class::Noise | Class::Exact) if !self.reliable => words.push("differs from the defaults"),
            (true, Class::Noise | Class::Exact) => words.push("biased, which it should not be: a bug"),
            (true, Class::Detail) => words.push("loses detail"),
            (true, _) => words.push("biased"),
            (false, _) => {}
        }
        match (self.reliable, self.bias_known) {
            (true, _) => {}
            (false, _) if self.lacks_paths => {
                words.push("unreliable: it differs by more than noise, and may have missed rare bright paths");
            }
            (false, _) if !self.reasons_unreliable.is_empty() => words.push("unreliable, as `render` would say"),
            (false, false) => words.push("unreliable: the image that it is compared with is too noisy"),
            (false, true) => words.push("unreliable: rare bright paths, or too few rounds"),
        }
        words.join(", ")
    }
}

/// The result of a sweep.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    /// The settings with at least three rounds, the defaults first.
    pub measured: Vec<Measured>,
    /// The distance of the defaults from the given reference, and whether it is more than the noise of both; none if
    /// the reference's noise is unknown.
    pub against_reference: Option<(Distance, bool)>,
    /// The weights that make errors relative.
    pub weights: Option<Weights>,
}

/// Judges every subject with at least three rounds. The others are recorded as not measured, with `unreached` as the reason.
///
/// Biases are against the defaults, which share their random numbers, so that most of the noise cancels. If the
/// defaults differ from a given reference, or are not known well, biases are against the reference instead. The loss of
/// detail with fewer pixels depends on the size of the image, so it is computed from images of full size.
pub fn judge(sweep: &mut Sweep<'_>, reference: Option<&Truth>, full_size: &FullSize, unreached: &str) -> Judged {
    let Some((weights, fixed)) = weights(sweep, reference) else {
        let all: Vec<Setting> = sweep.subjects.iter().map(|subject| subject.setting.clone()).collect();
        all.into_iter().for_each(|setting| sweep.leave_out(setting, unreached));
        return Judged::default();
    };
    let mut found = measure(sweep, (&weights, &fixed), full_size, unreached);
    let distance = |subject: usize| reference?.distance(&sweep.subjects[subject].images(LEVEL), &weights);
    let of_defaults = distance(0);
    // Two tests for each setting against the defaults, and two for the defaults against the reference (Šidák, JASA 62(318), 1967).
    let tests = 2 * (found.len().saturating_sub(1) + usize::from(of_defaults.is_some()));
    let level = 1.0 - (1.0 - FALSE_ALARMS).powf(1.0 / tests.max(1) as f64);
    let shows = |signed: &Estimate, squared: &Estimate| {
        signed.p() < level || (squared.value > 0.0 && squared.p() / 2.0 < level)
    };
    // A setting that is declared unbiased may have missed light that only few paths find.
    let rounds = found.first().map_or(0, |(_, defaults)| defaults.rounds);
    let (of_mean, of_squares) = unmet(sweep.brightest(), rounds, level, &weights);
    let shows_more =
        |signed: &Estimate, squared: &Estimate| shows(&signed.beyond(of_mean), &squared.beyond(of_squares));
    let against_reference = of_defaults.map(|found| (found, shows_more(&found.signed, &found.squared)));
    let differs = against_reference.is_some_and(|(_, differs)| differs);
    let defaults_known = found.first().is_some_and(|(_, defaults)| defaults.reliable);
    let lacks_light = reference.is_some_and(|reference| reference.reliable == Some(false));
    let reference_known =
        !lacks_light && against_reference.is_some_and(|(found, _)| found.noise_error <= RELIABLE * TARGETS[1]);
    let by_reference = differs || (reference_known && !defaults_known);
    let base_known = if by_reference { reference_known } else { defaults_known };
    for (subject, measured) in &mut found {
        let of_size = measured.setting.scale < 1.0;
        if let Some(distance) = (by_reference && !of_size).then(|| distance(*subject)).flatten() {
            (measured.signed, measured.squared) = (distance.signed, distance.squared);
            measured.against_reference = true;
        }
        let declared = measured.setting.declared_unbiased();
        measured.biased = match declared {
            true => shows_more(&measured.signed, &measured.squared),
            false => shows(&measured.signed, &measured.squared),
        };
        // The loss of detail is computed from the defaults' own images, also if there is a reference.
        measured.bias_known = declared || if of_size { defaults_known } else { base_known };
        let matters = measured.signed.value.powi(2).max(measured.squared.value) > NEGLIGIBLE;
        measured.lacks_paths = declared && !measured.biased && matters && shows(&measured.signed, &measured.squared);
        measured.reliable &= measured.bias_known && !measured.lacks_paths;
        // A setting that is declared unbiased has no bias unless one is found. The bias of denoised images falls with the samples, and is
        // part of the error measured at each number of samples.
        if !measured.setting.denoise && (!declared || measured.biased) {
            let (least, most) = by_mean(&measured.signed, &weights);
            measured.model.squared_bias = measured.squared.value.max(least);
            measured.model.squared_bias_upper = measured.squared.upper().max(most);
        }
        // A relative MSE of ε² is a relative error of ε. A setting that certainly loses a larger share of the light does not reach it.
        let lost = (measured.signed.value.abs() - measured.signed.half_width()).max(0.0);
        let is_faithful = |target: &f64| !measured.biased || lost <= target.sqrt();
        let time = |target: f64| Some(target).filter(is_faithful).and_then(|target| measured.model.seconds_to(target));
        measured.times = TARGETS.map(time);
    }
    let first = Truth::after_first_round(sweep);
    if let Some(truth) = reference.or(first.as_ref()) {
        found
            .iter_mut()
            .for_each(|(subject, measured)| measured.flips = flips(&sweep.subjects[*subject], truth, sweep.size));
    }
    let mut found: Vec<Measured> = found.into_iter().map(|(_, measured)| measured).collect();
    rank(&mut found);
    Judged { measured: found, against_reference, weights: Some(weights) }
}

/// The subjects with at least three rounds, with their indices. The others are recorded as not measured.
fn measure(
    sweep: &mut Sweep<'_>,
    weights: (&Weights, &Weights),
    full_size: &FullSize,
    unreached: &str,
) -> Vec<(usize, Measured)> {
    let seconds =
        sweep.subjects.iter().map(|subject| subject.blocks_of(LEVEL).iter().map(|block| block.timed).collect());
    let seconds: Vec<Vec<Timed>> = seconds.collect();
    let timed: Vec<usize> = (0..seconds.len()).filter(|&i| seconds[i].len() >= FEWEST_ROUNDS).collect();
    let mut paces = paces(&timed.iter().map(|&i| seconds[i].as_slice()).collect::<Vec<_>>(), &sweep.clock).into_iter();
    // The number of rounds that all of them have: an additional image of one setting alone would look like a difference.
    let rounds = |level: u32| timed.iter().map(|&i| sweep.subjects[i].blocks_of(level).len()).min().unwrap_or(0);
    let common = LEVELS.map(|level| (level, rounds(level)));
    let mut found: Vec<(usize, Measured)> = Vec::new();
    let mut missing = Vec::new();
    for (i, subject) in sweep.subjects.iter().enumerate() {
        let pace = if timed.contains(&i) { paces.next() } else { None };
        let own = pace.and_then(|pace| measured(subject, &sweep.subjects[0], pace, &common, weights, full_size));
        match own {
            Some(measured) if measured.setting.scale < 1.0 => match full_size.lost_detail(measured.setting.scale) {
                Some((signed, squared)) => found.push((i, Measured { signed, squared, ..measured })),
                None => missing.push((subject.setting.clone(), NOT_AT_FULL_SIZE)),
            },
            Some(measured) => found.push((i, measured)),
            None => missing.push((subject.setting.clone(), unreached)),
        }
    }
    for (setting, why) in missing {
        sweep.leave_out(setting, why);
    }
    found
}

/// Ranks the settings by their times; the first are the defaults.
fn rank(found: &mut [Measured]) {
    let times = |m: &Measured| Times { seconds: m.times.to_vec(), error: m.seconds_error, reliable: m.reliable };
    let all: Vec<Times> = found.iter().map(times).collect();
    for (measured, ranking) in found.iter_mut().zip(rankings(&all)) {
        measured.ranking = ranking;
    }
    // Settings whose times differ by less than the error of the timings are not ranked, so those as fast as the defaults form one group.
    if let Some((defaults, others)) = found.split_first_mut() {
        let reaches = defaults.ranking != Ranking::NeverReaches;
        others
            .iter_mut()
            .filter(|m| reaches && m.is_as_fast_as(defaults))
            .for_each(|m| m.ranking = Ranking::AsDefaults);
    }
    // The advised setting reaches its target as soon as the fastest one without bias, within the error of the timings.
    let advised: Vec<String> = recommended(found).into_iter().flatten().map(|m| m.setting.name()).collect();
    for measured in found.iter_mut().filter(|m| advised.contains(&m.setting.name())) {
        measured.ranking = Ranking::Front;
    }
}

/// The weights that make errors relative, from the less noisy of the reference and the defaults' images. If noise makes
/// a pixel dark, its relative errors look too large. Images of noisier settings are therefore not used: a pixel is half
/// as bright if half of the images found no light in it. The second weights have the floor of relMSE.
fn weights(sweep: &Sweep<'_>, reference: Option<&Truth>) -> Option<(Weights, Weights)> {
    let defaults = sweep.subjects.first()?;
    let blocks = defaults.blocks.iter().flat_map(|(&samples, blocks)| {
        let images = blocks.iter().enumerate();
        images.map(move |(i, block)| (i * rounds_between(samples), samples, &block.image))
    });
    let own = Weights::of_rounds(blocks.clone(), floor_of)?;
    let fixed = || Weights::of_rounds(blocks, |_| RELATIVE_FLOOR);
    let Some(reference) = reference else { return Some((own, fixed()?)) };
    let errors = reference.error(&own).zip(Truth::of_subject(sweep, 0).and_then(|truth| truth.error(&own)));
    let noisier = errors.is_some_and(|(reference, own)| reference > own);
    match noisier {
        true => Some((own, fixed()?)),
        false => {
            let image = || reference.image.clone();
            Some((Weights::of_image(image(), floor_of), Weights::of_image(image(), |_| RELATIVE_FLOOR)))
        }
    }
}

/// Bounds of the light that no path found in `rounds` rounds: as a share of the mean, and as squared bias. The light
/// may be missing in a setting or in the images that it is compared with. Own derivation: if k paths are expected, none
/// is found with the probability e^-k, and a path carries at most the brightest radiance M of the scene. So, except
/// with the probability `level`, the missed light b has a mean below ln(1/level) M / N, where N is the number of
/// samples in all pixels. Its part of b² / (r² + f) with b <= r is at most b r / (r² + f) <= b / (2 √f).
fn unmet(brightest: f64, rounds: usize, level: f64, weights: &Weights) -> (f64, f64) {
    let image = &weights.image;
    let samples = rounds as f64 * f64::from(LEVEL) * image.len() as f64;
    let light = level.recip().ln() * brightest / samples;
    let mean = mean_luminance(image);
    // A black image has the mean 0, of which there is no share.
    let of_mean = if mean > 0.0 { light / mean } else { 0.0 };
    (of_mean, 0.5 / weights.floor.sqrt() * light)
}

/// The squared bias of the pixels that follows from the bias of the mean luminance: its certain part, and its largest value for a
/// mean within the interval. For a bias b, w = 1 / (r² + f) and the shares l of the channels in the luminance, with means over pixels and
/// channels, (mean 3 l b)² <= mean(w b²) mean(9 l²/w) (Cauchy-Schwarz). Bias in rare bright paths, such as that of a clamp, shows in the mean long before it shows in the same pixels of
/// different images.
fn by_mean(signed: &Estimate, weights: &Weights) -> (f64, f64) {
    let image = &weights.image;
    let shares = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(luminance);
    let term = |(r, share): (&f32, f64)| 3.0 * share * share * (f64::from(*r).powi(2) + weights.floor);
    let squares: f64 = image.iter().flat_map(|rgb| rgb.iter().zip(shares).map(term)).sum();
    let share = mean_luminance(image).powi(2) * image.len() as f64 / squares;
    let size = Estimate { value: signed.value.abs(), ..*signed };
    let least = (size.value - size.half_width()).max(0.0);
    (share * least.powi(2), share * size.upper().powi(2))
}

/// The FLIP of the first image of each number of samples.
fn flips(subject: &Subject, truth: &Truth, size: (u32, u32)) -> Vec<(u32, f64)> {
    let flip = |image: &Pixels| flip::mean(&error_map(size.0 as usize, image, &truth.image));
    let first = |(samples, blocks): (&u32, &Vec<Block>)| Some((*samples, flip(&blocks.first()?.image)));
    subject.blocks.iter().filter_map(first).collect()
}

fn measured(
    subject: &Subject,
    defaults: &Subject,
    pace: Pace,
    common: &[(u32, usize)],
    (weights, fixed): (&Weights, &Weights),
    full_size: &FullSize,
) -> Option<Measured> {
    let images = |subject: &Subject, level: u32| {
        let (_, rounds) = common.iter().find(|(of, _)| *of == level)?;
        let blocks = subject.blocks.get(&level)?.get(..*rounds)?;
        Some(blocks.iter().map(|block| block.image.clone()).collect::<Vec<_>>())
    };
    let (own_images, base_images) = (images(subject, LEVEL)?, images(defaults, LEVEL)?);
    // The bias of denoised images falls with the samples, so it belongs to the falling part.
    let denoises = subject.setting.denoise;
    let error = |level: u32| {
        let (own, apart) = (images(subject, level)?, rounds_between(level));
        let noise = noise(&own, weights, apart)?;
        let bias = if denoises { squared_bias(&own, &images(defaults, level)?, weights, apart) } else { None };
        Some(bias.map_or(noise, |bias| Estimate {
            value: noise.value + bias.value.max(0.0),
            error: noise.error.hypot(bias.error),
            ..noise
        }))
    };
    let levels: Vec<(u32, Estimate)> = common.iter().filter_map(|&(level, _)| Some((level, error(level)?))).collect();
    let fall = if denoises { falling_denoised(&levels) } else { falling(&levels, subject.setting.options.sampler) };
    let fall = fall.or_else(|| {
        // A scene of one colour has no noise at all.
        let silent = levels.iter().all(|(_, noise)| noise.value <= 0.0);
        (silent && !levels.is_empty()).then_some(Falling::SILENT)
    })?;
    let fall = Falling { noise: full_size.noisier * fall.noise, ..fall };
    let noise_error = fall.relative_error(fall.samples_to(TARGETS[1]));
    let seconds_here = pace.seconds / f64::from(LEVEL);
    let seconds = full_size.slower * seconds_here;
    let relmse_ratio = match noise(&own_images, fixed, 1).zip(noise(&own_images, weights, 1)) {
        Some((fixed, own)) if own.value > 0.0 => fixed.value / own.value,
        _ => 1.0,
    };
    let verdict = subject.total.verdict(NOISE_LEVEL);
    let reasons_unreliable = if verdict.reliable() == Some(false) { verdict.reasons_unreliable() } else { Vec::new() };
    Some(Measured {
        setting: subject.setting.clone(),
        rounds: own_images.len(),
        seconds_compile: subject.seconds_compile,
        seconds_here,
        seconds_half_width: seconds * pace.half_width.exp_m1(),
        seconds_error: 0.5 * pace.half_width,
        model: Model {
            squared_bias: 0.0,
            squared_bias_upper: 0.0,
            noise: fall,
            seconds,
            fixed_seconds: if denoises { full_size.seconds_to_denoise } else { 0.0 },
        },
        flips: Vec::new(),
        noises: levels.iter().map(|(samples, noise)| (*samples, full_size.noisier * noise.value)).collect(),
        signed: signed_bias(&own_images, &base_images, &weights.image)?,
        squared: squared_bias(&own_images, &base_images, weights, 1)?,
        biased: false,
        lacks_paths: false,
        against_reference: false,
        reliable: noise_error <= RELIABLE && reasons_unreliable.is_empty(),
        reasons_unreliable,
        relmse_ratio,
        bias_known: true,
        noise_error,
        times: [None; TARGETS.len()],
        ranking: Ranking::NeverReaches,
    })
}

/// The fastest setting to a target among those that satisfy a condition.
fn soonest(found: &[Measured], target: usize, condition: impl Fn(&Measured) -> bool) -> Option<&Measured> {
    let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
    let reaching = found.iter().filter(|m| m.times[target].is_some() && condition(m));
    reaching.min_by(|a, b| time(a).total_cmp(&time(b)))
}

/// The fastest setting that satisfies a condition. If the defaults or another unbiased setting are as fast within the
/// error of the timings and of the noise that is extrapolated, they are preferred.
pub fn preferred(found: &[Measured], target: usize, condition: impl Fn(&Measured) -> bool) -> Option<&Measured> {
    let time = |measured: &Measured| measured.times[target].unwrap_or(f64::INFINITY);
    let best = soonest(found, target, &condition)?;
    let unsure = |m: &Measured| m.seconds_error.hypot(m.model.relative_error_to(TARGETS[target]));
    let near = |m: &&Measured| time(m) < tie_ratio(unsure(m), unsure(best)) * time(best);
    let defaults = soonest(found, target, |m| m.setting.option.is_none() && condition(m)).filter(near);
    let faithful = soonest(found, target, |m| m.setting.declared_unbiased() && condition(m)).filter(near);
    Some(defaults.or(faithful).unwrap_or(best))
}

/// The setting advised for each target: never one whose noise is unknown, and a biased one only if no other reaches the target.
pub fn recommended(found: &[Measured]) -> [Option<&Measured>; TARGETS.len()] {
    let faithful = |target| preferred(found, target, |measured| measured.reliable && measured.is_faithful());
    std::array::from_fn(|target| faithful(target).or_else(|| preferred(found, target, |measured| measured.reliable)))
}

/// A setting that reaches a target sooner than the advised one, at the price of a bias.
pub fn sooner_with_bias<'a>(found: &'a [Measured], target: usize, advised: &Measured) -> Option<&'a Measured> {
    let best = preferred(found, target, |measured| measured.reliable)?;
    (advised.is_faithful() && !best.is_faithful()).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound from the mean is never above the squared bias, and equals it if the bias is proportional to l/w.
    #[test]
    fn a_bias_of_the_mean_is_one_of_pixels() {
        let weights: Pixels = (0..64).map(|i| [0.02 * i as f32, 0.5, 3.0 / (1 + i) as f32]).collect();
        let values: Vec<f64> = weights.as_flattened().iter().map(|&r| f64::from(r)).collect();
        let mean = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(of).sum::<f64>() / values.len() as f64;
        let share = |i: usize| [0.2126, 0.7152, 0.0722][i % 3];
        let mean_luminance = |of: &dyn Fn(usize) -> f64| 3.0 * mean(&|i| share(i) * of(i));
        let luminance = mean_luminance(&|i| values[i]);
        let weights = Weights::of_image(weights, floor_of);
        let of_pixel = |i: usize| values[i] * values[i] + weights.floor;
        let biases: [&dyn Fn(usize) -> f64; 3] =
            [&|i| share(i) * of_pixel(i), &|i| if i == 17 { -1.0 } else { 0.0 }, &|i| (i as f64).sin() - 0.1];
        for (case, bias) in biases.into_iter().enumerate() {
            let squared = mean(&|i| bias(i) * bias(i) / of_pixel(i));
            let signed = Estimate { value: mean_luminance(bias) / luminance, error: 0.0, degrees: 7.0 };
            let (least, most) = by_mean(&signed, &weights);
            assert!(least == most && least <= squared * (1.0 + 1e-9) && least > 0.0, "{case}: {least} {squared}");
            assert!(case > 0 || (least / squared - 1.0).abs() < 1e-9, "{least} {squared}");
            // A less certain bias has a higher upper bound and a lower lower bound.
            let unsure = Estimate { error: 0.1 * signed.value.abs(), ..signed };
            let (low, high) = by_mean(&unsure, &weights);
            assert!(low < least && high > most);
        }
        assert_eq!(by_mean(&Estimate { value: 0.1, error: 1.0, degrees: 7.0 }, &weights).0, 0.0);
    }

    /// If k paths are expected, none is found with the probability e^-k. A setting that misses the light of k <
    /// ln(1/level) paths cannot be distinguished from one that has it; a setting that misses more can.
    #[test]
    fn light_that_few_paths_bring_may_be_missed() {
        let weights = Weights::of_image(vec![[0.05; 3]; 100], floor_of);
        let (of_mean, of_squares) = unmet(800.0, 10, 0.01, &weights);
        let light = 0.01f64.recip().ln() * 800.0 / 16_000.0;
        // The floor is 0.01 times the square of the mean luminance.
        assert!((of_mean * 0.05 / light - 1.0).abs() < 1e-6 && (of_squares / (5.0 * light / 0.05) - 1.0).abs() < 1e-6);
        let missing = |share: f64| Estimate { value: -share * of_mean, error: 0.0, degrees: 9.0 }.beyond(of_mean);
        assert_eq!((missing(0.9).p(), missing(1.1).p()), (1.0, 0.0));
        assert_eq!(unmet(1.0, 10, 0.01, &Weights::of_image(vec![[0.0; 3]; 4], floor_of)).0, 0.0);
    }
}
