//! The findings in words and numbers: the table on the terminal, CSV, JSON, and advice.

use serde_json::{Value, json};

use super::judge::{FLIP_TARGET, Measured, TARGETS, preferred, recommended, sooner_with_bias};
use super::model::Ranking;
use super::sweep::{LEVEL, Setting, Unmeasured};
use super::truth::Distance;
use crate::metrics::estimate::Estimate;
use crate::options::Class;
use crate::output::csv::csv;

/// The results of a measurement.
#[derive(Clone, Debug)]
pub struct Findings {
    pub scene: String,
    pub device: String,
    pub driver: String,
    pub size: (u32, u32),
    /// The size of the scene's image, or of the reference.
    pub full_size: (u32, u32),
    /// Ratios, for the defaults, of the seconds of a sample and of the relative MSE of the noise at full size to those
    /// at the measured size; none if they were not measured.
    pub calibration: Option<(f64, f64)>,
    pub seed: u32,
    pub budget: f64,
    /// The seconds until the report.
    pub seconds: f64,
    /// The change of the machine's speed: the ratio of the times of one render, slow to fast.
    pub swing: f64,
    /// The reference file; none if the images of the unbiased settings are pooled instead.
    pub reference: Option<String>,
    /// Whether its error is reliable, if its header says so.
    pub reference_reliable: Option<bool>,
    /// The relative MSE of the noise of the reference or of the pooled image, if known.
    pub error_of_truth: Option<f64>,
    /// The relative difference of the defaults' mean from the given reference. If the noise of the reference is
    /// unknown, the error of the estimate includes only the noise of the defaults.
    pub against_reference: Option<Estimate>,
    /// If the noise of the reference is known: the distance of the defaults from it, and whether that is more than noise.
    pub distance: Option<(Distance, bool)>,
    pub interrupted: bool,
    /// The measured settings, the defaults first.
    pub measured: Vec<Measured>,
    pub unmeasured: Vec<Unmeasured>,
    /// The size of the reference, if only its middle is measured.
    pub middle_of: Option<(u32, u32)>,
    pub examples: Vec<Example>,
}

/// A picture of a setting, rendered in the same time as all pictures.
#[derive(Clone, Debug)]
pub struct Example {
    pub setting: String,
    pub samples: u32,
    pub seconds: f64,
    /// The relative MSE, without that of the noise of the image that it is compared with.
    pub error: f64,
    pub relmse: f64,
    pub flip: f64,
    /// PNG files.
    pub picture: Vec<u8>,
    pub flip_map: Vec<u8>,
}

/// The caption of the plot.
pub const CAPTION: &str = "The relative MSE is the mean over pixels and channels of (error)² / (value² + 0.01 L²), with L the image's mean \
                           luminance: the square of the relative error that `render` states, so that 1e-2 is an error of 10 %. Each curve is \
                           bias² + c N^-p, with the measured bias. The dots are the noise measured at 4, 16 and 64 samples; beyond them the curve is \
                           extrapolated, and dashed. A curve that becomes level has a \
                           bias that more samples do not remove.";
/// A machine is busy from this swing on. On an idle one with two cores, the times of one render are within 20 % of each other.
const BUSY: f64 = 1.3;
/// The plot has colours for this many curves.
pub const MOST_CURVES: usize = 10;

/// The columns of the tables.
pub const HEADINGS: [&str; 13] = [
    "setting",
    "verdict",
    "gives up",
    "to 1e-1",
    "to 1e-2",
    "to 1e-3",
    "FLIP 0.05",
    "bias of the mean",
    "bias²",
    "s / sample",
    "noise",
    "p",
    "efficiency",
];
/// The columns of the CSV.
const COLUMNS: &str = "setting,knob,value,class,gives_up,measured,rounds,seconds_compile,seconds_per_sample,seconds_half_width,variance_1spp,\
                       exponent,exponent_half_width,bias,bias_half_width,squared_bias,squared_bias_upper,biased,reliable,relmse_ratio,seconds_to_1e-1,seconds_to_1e-2,\
                       seconds_to_1e-3,seconds_beside,seconds_to_flip,efficiency,verdict,device,driver";

/// The name of a class in the tables.
pub fn class_name(class: Class) -> &'static str {
    match class {
        Class::Exact | Class::Channels => "exact",
        Class::Noise => "noise",
        Class::Detail => "detail",
        Class::Look => "look",
        Class::Bias => "bias",
        Class::Numerics => "numerics",
    }
}

/// A target in words, with the relative error that `render` would state of it.
fn target_words(target: f64) -> String {
    format!("a relative MSE of {target:e} ({:.1} %)", 100.0 * target.sqrt())
}

/// A mean square error with two digits. It may be below 0 after the noise of the reference is subtracted.
pub fn error_text(error: f64) -> String {
    match error {
        ..=0.0 => "0".to_string(),
        error => format!("{error:.1e}"),
    }
}

/// A time with two or three digits, or never.
pub fn time_text(seconds: Option<f64>) -> String {
    match seconds {
        None => "never".to_string(),
        Some(s) if s >= 7200.0 => format!("{:.1} h", s / 3600.0),
        Some(s) if s >= 600.0 => format!("{:.0} min", s / 60.0),
        Some(s) if s >= 100.0 => format!("{s:.0} s"),
        Some(s) if s >= 1.0 => format!("{s:.1} s"),
        Some(s) if s >= 1e-3 => format!("{:.0} ms", 1e3 * s),
        Some(s) => format!("{:.0} µs", 1e6 * s),
    }
}

/// The exponent of the noise, with its interval unless it is known.
pub fn exponent_text(measured: &Measured) -> String {
    let (exponent, half) = (measured.model.noise.exponent, measured.model.noise.exponent_half_width());
    if half > 0.0 { format!("{exponent:.2} ± {half:.2}") } else { format!("{exponent:.0}") }
}

/// The seconds of a sample, with their interval.
fn seconds_text(measured: &Measured) -> String {
    let (value, half) = (measured.model.seconds, measured.seconds_half_width);
    let digits = digits(half.max(1e-3 * value));
    format!("{value:.digits$} ± {half:.digits$}")
}

/// The number of decimals that show two digits of a value.
fn digits(value: f64) -> usize {
    (1.0 - value.abs().max(1e-9).log10().floor()).clamp(1.0, 8.0) as usize
}

/// The signed bias in percent with its interval.
fn bias_text(measured: &Measured) -> String {
    let (value, half) = (100.0 * measured.signed.value, 100.0 * measured.signed.half_width());
    match measured.signed.error == 0.0 && measured.signed.value == 0.0 {
        // A limit that has clamped no sample yet may clamp a later one.
        true if measured.setting.class() == Class::Bias => "0 so far".to_string(),
        true => "0".to_string(),
        // The mean of a smaller image is the same, but for rounding.
        false if value.abs().max(half) < 5e-5 => "0.0000 %".to_string(),
        false => {
            let digits = digits(half).min(4);
            format!("{value:+.digits$} ± {half:.digits$} %")
        }
    }
}

/// The bias of a setting in words: lost or added light, or lost detail.
fn cost_text(best: &Measured) -> String {
    let (value, half) = (100.0 * best.signed.value, 100.0 * best.signed.half_width());
    let digits = digits(half);
    if best.biased {
        let stays =
            format!("a relative MSE of {} that more samples do not remove", error_text(best.model.squared_bias));
        return match value {
            _ if best.setting.denoise => {
                let at_level = error_text(best.bias_squared());
                format!("biased by a relative MSE of {at_level} at {LEVEL} samples, and by less at more")
            }
            _ if best.setting.class() == Class::Detail => format!("loses detail, {stays}"),
            // Losses and gains of different pixels cancel in the mean.
            _ if value.abs() <= half => format!("biased by {stays}"),
            ..0.0 => format!("loses {:.digits$} ± {half:.digits$} % of the light", -value),
            _ => format!("adds {value:.digits$} ± {half:.digits$} % of light"),
        };
    }
    match best.signed.error == 0.0 {
        true if best.setting.class() == Class::Bias => "it has changed no sample so far".to_string(),
        true => "no bias".to_string(),
        // Lost detail does not change the mean.
        false if best.setting.class() == Class::Detail => "the lost detail is within noise".to_string(),
        false => format!("differs by {value:+.digits$} ± {half:.digits$} % of the light, which may be noise"),
    }
}

impl Findings {
    /// The measured settings by their time to the middle target, then to the last, then to the first.
    pub fn sorted(&self) -> Vec<&Measured> {
        let mut sorted: Vec<&Measured> = self.measured.iter().collect();
        let time = |measured: &Measured, i: usize| measured.times[i].unwrap_or(f64::INFINITY);
        sorted.sort_by(|a, b| {
            let by = |i| time(a, i).total_cmp(&time(b, i));
            by(1).then(by(2)).then(by(0))
        });
        sorted
    }

    /// The settings that the plot draws: the defaults, then the front, then the rest by their times. The second list
    /// has those that it leaves out because they are as fast as the defaults within the error of the timings.
    pub fn drawn(&self) -> (Vec<&Measured>, Vec<&Measured>) {
        let Some(defaults) = self.measured.first() else { return (Vec::new(), Vec::new()) };
        let as_defaults = |measured: &&Measured| measured.setting.option.is_some() && measured.is_as_fast_as(defaults);
        let (same, mut others): (Vec<&Measured>, Vec<&Measured>) = self.sorted().into_iter().partition(as_defaults);
        others.sort_by_key(|measured| (measured.setting.option.is_some(), measured.ranking != Ranking::Front));
        (others, same)
    }

    /// The settings that the plot leaves out.
    pub fn left_out(&self) -> Vec<String> {
        let (drawn, same) = self.drawn();
        let names = |list: &[&Measured]| list.iter().map(|measured| measured.named()).collect::<Vec<_>>().join(", ");
        let mut words = Vec::new();
        if !same.is_empty() {
            words.push(format!("As fast as the defaults, within the error of the timings: {}.", names(&same)));
        }
        if drawn.len() > MOST_CURVES {
            words.push(format!("Not drawn: {}.", names(&drawn[MOST_CURVES..])));
        }
        words
    }

    /// A sentence for each target.
    pub fn advice(&self) -> Vec<String> {
        let sentence = |(index, best): (usize, Option<&Measured>)| {
            let target = target_words(TARGETS[index]);
            let unreliable = preferred(&self.measured, index, Measured::is_faithful);
            let Some(best) = best else {
                if self.measured.is_empty() {
                    return format!("{target}: nothing was measured");
                }
                let words = unreliable.map_or(String::new(), |m| {
                    format!("; {} would take {}, or longer if light was missed", m.named(), time_text(m.times[index]))
                });
                return format!("{target}: no reliable setting reaches it{words}");
            };
            let time = time_text(best.times[index]);
            let cost = cost_text(best);
            let what = best.named();
            let besides = match (sooner_with_bias(&self.measured, index, best), unreliable) {
                (Some(other), _) => {
                    let time = time_text(other.times[index]);
                    format!("; with a bias, {}: {time}, {}", other.named(), cost_text(other))
                }
                (None, Some(other)) if !best.is_faithful() => format!(
                    "; without bias, {}: about {}, but its noise is uncertain",
                    other.named(),
                    time_text(other.times[index])
                ),
                _ => String::new(),
            };
            let relmse = error_text(TARGETS[index] * best.relmse_ratio);
            format!("To reach {target}, which is a relMSE of {relmse}, use {what}: {time}, {cost}{besides}")
        };
        recommended(&self.measured).into_iter().enumerate().map(sentence).chain(self.flip_of_denoised()).collect()
    }

    /// The time to a FLIP with and without denoising, in words; none if no setting denoises.
    fn flip_of_denoised(&self) -> Option<String> {
        let denoised = self.measured.iter().find(|measured| measured.setting.denoise)?;
        let time = |measured: &Measured| match measured.seconds_to_flip() {
            None => "is not reached".to_string(),
            time => format!("takes {}", time_text(time)),
        };
        Some(format!(
            "A FLIP of {FLIP_TARGET} {} with the defaults, and {} with {}, of which denoising takes {}",
            time(self.measured.first()?),
            time(denoised),
            denoised.named(),
            time_text(Some(denoised.model.fixed_seconds))
        ))
    }

    /// The conditions of the measurement.
    pub fn basis(&self) -> Vec<String> {
        let (w, h) = self.size;
        let of_all = self.measured.len() + self.unmeasured.len();
        let busy = match self.swing > BUSY {
            true => {
                format!("; the machine was busy, at times {:.1} times slower, so the seconds are uncertain", self.swing)
            }
            false => String::new(),
        };
        let mut lines = vec![format!(
            "{} of {of_all} settings measured at {w}x{h} pixels on {} ({}), each with {} images of {LEVEL} samples; on another device \
             other settings may be best{busy}",
            self.measured.len(),
            self.device,
            self.driver,
            self.measured.first().map_or(0, |defaults| defaults.rounds)
        )];
        let (w, h) = self.full_size;
        if let Some((width, height)) = self.middle_of {
            lines.push(format!(
                "only the middle {w}x{h} pixels of the reference's {width}x{height} are measured, because these sides have divisors for \
                 smaller images"
            ));
        }
        match self.calibration {
            _ if self.full_size == self.size => {}
            Some((slower, noisier)) => lines.push(format!(
                "all seconds are for {w}x{h}: a sample of the defaults takes {slower:.1} times as long there and has {noisier:.2} times the noise, \
                 both measured; the other settings are assumed to change by the same factors"
            )),
            None => lines.push(format!(
                "all seconds are estimates for {w}x{h}, where the budget was too short to measure: time is assumed to grow with the \
                 number of pixels, and noise to stay the same"
            )),
        }
        if let Some(defaults) = self.measured.first().filter(|defaults| !defaults.reliable) {
            let known = self.measured.iter().any(|m| !m.setting.declared_unbiased() && m.bias_known);
            let so = if known { "" } else { "; so no bias is known, and no biased setting is recommended" };
            let noise = format!(
                "the noise of the defaults is known only to within {:.0} %, because of rare bright paths, or because there are too few \
                 rounds",
                100.0 * defaults.noise_error
            );
            let reasons: Vec<String> = match defaults.reasons_unreliable.is_empty() {
                true => vec![noise],
                false => {
                    let words = |reason: &String| format!("the relative error of the defaults is unreliable: {reason}");
                    defaults.reasons_unreliable.iter().map(words).collect()
                }
            };
            lines.extend(reasons.iter().map(|reason| format!("{reason}{so}")));
        }
        lines.extend(self.measured_against());
        if self.reference_reliable == Some(false) {
            lines.push(
                "the header of the reference calls its error unreliable: it may lack light, and then has more error than its noise shows; so no \
                 bias against it is known"
                    .to_string(),
            );
        }
        if self.interrupted {
            lines.push("interrupted: the report has only the measurements until then".to_string());
        }
        lines
    }

    /// The images that biases and the errors of pictures refer to.
    fn measured_against(&self) -> Vec<String> {
        const TO_DEFAULTS: &str = "biases are differences from the defaults, rendered with the same random numbers";
        let own = self.error_of_truth.map(|own| {
            format!("the noise of that image, a relative MSE of {own:.1e}, is subtracted from their errors")
        });
        let Some(file) = &self.reference else {
            let own = own.map_or(String::new(), |own| format!("; {own}"));
            return vec![format!(
                "{TO_DEFAULTS}; each picture is compared with the mean image of all other unbiased settings{own}"
            )];
        };
        let mean = self.against_reference.map_or(String::new(), |found| {
            let (value, half) = (100.0 * found.value, 100.0 * found.half_width());
            format!("; the mean of the defaults' image differs by {value:+.2} ± {half:.2} % from the reference's")
        });
        let Some((distance, differs)) = &self.distance else {
            return vec![
                format!("the reference is {file}; it has no variance, so the errors of the pictures include its noise"),
                format!("{TO_DEFAULTS}{mean}; that interval leaves out the reference's noise"),
            ];
        };
        let own = own.unwrap_or_default();
        let squared = &distance.squared;
        let far = format!(
            "the relative MSE between them is {:.1e}, at most {:.1e}, after subtracting the noise of both",
            squared.value.max(0.0),
            squared.upper().max(0.0)
        );
        vec![
            format!("the reference is {file}; pictures are compared with it, and {own}"),
            match (differs, self.measured.iter().any(|measured| measured.against_reference)) {
                (false, false) => {
                    format!("{TO_DEFAULTS}; the defaults differ from the reference by noise only{mean}; {far}")
                }
                (false, true) => format!(
                    "the defaults differ from the reference by noise only{mean}; {far}; their noise is not known well, so all biases are against \
                     the reference"
                ),
                (true, _) => format!(
                    "the defaults differ from the reference by more than noise{mean}; {far}; all biases are against the reference"
                ),
            },
        ]
    }

    /// The cells of the tables, below [`HEADINGS`].
    pub fn cells(&self, measured: &Measured) -> [String; HEADINGS.len()] {
        let efficiency = measured.efficiency() / self.measured.first().map_or(1.0, Measured::efficiency);
        let [coarse, middle, fine] = measured.times.map(time_text);
        [
            measured.setting.name(),
            measured.verdict(),
            class_name(measured.setting.class()).to_string(),
            coarse,
            middle,
            fine,
            measured.seconds_to_flip().map_or("–".to_string(), |seconds| time_text(Some(seconds))),
            bias_text(measured),
            error_text(measured.bias_squared()),
            seconds_text(measured),
            format!("{:.3}", measured.model.noise.noise),
            exponent_text(measured),
            // Without noise there is none.
            if efficiency.is_finite() { format!("{efficiency:.2}") } else { "-".to_string() },
        ]
    }

    /// The table for the terminal, with the columns that fit into 80 characters. The page and the CSV have all of them.
    pub fn table(&self) -> String {
        const COLUMNS: usize = 6;
        let of_terminal = |measured: &Measured| {
            let [coarse, middle, fine] = measured.times.map(time_text);
            [measured.setting.name(), coarse, middle, fine, bias_text(measured), measured.short_verdict().to_string()]
        };
        let mut rows = vec![["setting", "to 1e-1", "to 1e-2", "to 1e-3", "bias", "verdict"].map(str::to_string)];
        rows.extend(self.sorted().into_iter().map(of_terminal));
        let widths: [usize; COLUMNS] =
            std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
        let line = |row: &[String; COLUMNS]| {
            let cells = row.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
                0 | 5 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            });
            cells.collect::<Vec<_>>().join(" ").trim_end().to_string()
        };
        let mut lines: Vec<String> = rows.iter().map(line).collect();
        // The settings by the reason why they are not measured.
        let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
        for left in &self.unmeasured {
            match reasons.iter_mut().find(|(why, _)| *why == left.why) {
                Some((_, names)) => names.push(left.setting.name()),
                None => reasons.push((&left.why, vec![left.setting.name()])),
            }
        }
        lines.extend(reasons.iter().map(|(why, names)| format!("not measured: {}: {why}", names.join(", "))));
        lines.join("\n")
    }

    /// A row for every setting.
    pub fn csv(&self) -> String {
        let mut rows = self.rows();
        for row in &mut rows {
            for (i, target) in TARGETS.into_iter().enumerate() {
                let seconds = row["seconds_to"][i]["seconds"].clone();
                row[format!("seconds_to_{target:e}")] = seconds;
            }
            row["device"] = json!(self.device);
            row["driver"] = json!(self.driver);
        }
        csv(COLUMNS, &rows)
    }

    /// The settings for JSON and CSV: the measured ones, then the others.
    fn rows(&self) -> Vec<Value> {
        let row = |setting: &Setting, measured: bool, verdict: String| {
            json!({
                "setting": setting.name(),
                "knob": setting.option.map(|option| option.name),
                "value": setting.value,
                "class": class_name(setting.class()),
                "gives_up": setting.option.map(|option| option.trade_off),
                "measured": measured,
                "verdict": verdict,
            })
        };
        let of_measured = |measured: &Measured| {
            let (model, half) = (&measured.model, measured.signed.half_width());
            let times = TARGETS.iter().zip(measured.times);
            let figures = json!({
                "rounds": measured.rounds,
                "seconds_compile": measured.seconds_compile,
                "seconds_per_sample": model.seconds,
                "seconds_doubt": measured.seconds_error,
                "seconds_half_width": measured.seconds_half_width,
                "variance_1spp": model.noise.noise,
                "exponent": model.noise.exponent,
                "exponent_half_width": model.noise.exponent_half_width(),
                "bias": measured.signed.value,
                "bias_half_width": half,
                "against": if measured.against_reference { "reference" } else { "defaults" },
                "bias_interval": [measured.signed.value - half, measured.signed.value + half],
                "squared_bias": measured.squared.value,
                "squared_bias_upper": measured.squared.upper(),
                "biased": measured.biased,
                "reliable": measured.reliable,
                "doubts": measured.reasons_unreliable,
                "relmse_ratio": measured.relmse_ratio,
                "noise_doubt": measured.noise_error,
                "seconds_to": times.map(|(target, time)| json!({"relative_mse": target, "relmse": target * measured.relmse_ratio, "seconds": time})).collect::<Vec<_>>(),
                "seconds_beside": model.fixed_seconds,
                "flip": measured.flips.iter().map(|(samples, flip)| json!({"samples": samples, "flip": flip})).collect::<Vec<_>>(),
                "seconds_to_flip": measured.seconds_to_flip(),
                "efficiency": measured.efficiency(),
            });
            let mut row = row(&measured.setting, true, measured.verdict());
            if let (Some(row), Value::Object(figures)) = (row.as_object_mut(), figures) {
                row.extend(figures);
            }
            row
        };
        let unmeasured = |left: &Unmeasured| row(&left.setting, false, format!("not measured: {}", left.why));
        self.sorted().into_iter().map(of_measured).chain(self.unmeasured.iter().map(unmeasured)).collect()
    }

    pub fn json(&self) -> Value {
        let best = recommended(&self.measured);
        let recommendations: Vec<Value> = TARGETS
            .iter()
            .enumerate()
            .zip(self.advice())
            .map(|((i, target), words)| {
                json!({
                    "relative_mse": target,
                    "relmse": best[i].map(|measured| target * measured.relmse_ratio),
                    "setting": best[i].map(|measured| measured.setting.name()),
                    "seconds": best[i].and_then(|measured| measured.times[i]),
                    "samples": best[i].and_then(|m| Some((m.times[i]? - m.model.fixed_seconds) / m.model.seconds)),
                    "words": words,
                })
            })
            .collect();
        json!({
            "scene": self.scene,
            "device": self.device,
            "driver": self.driver,
            "width": self.size.0,
            "height": self.size.1,
            "whole_width": self.full_size.0,
            "whole_height": self.full_size.1,
            "seed": self.seed,
            "budget": self.budget,
            "seconds": self.seconds,
            "reference": self.reference,
            "reference_reliable": self.reference_reliable,
            "swing": self.swing,
            "relative_mse_of_reference": self.error_of_truth,
            "defaults_against_reference": self.against_reference.map(|found| json!({
                "bias": found.value,
                "half_width": found.half_width(),
                "squared_bias": self.distance.map(|(distance, _)| distance.squared.value),
                "squared_bias_upper": self.distance.map(|(distance, _)| distance.squared.upper()),
                "differs": self.distance.map(|(_, differs)| differs),
            })),
            "interrupted": self.interrupted,
            "basis": self.basis(),
            "left_out": self.left_out(),
            "settings": self.rows(),
            "recommendations": recommendations,
            "equal_time": self.examples.iter().map(|example| json!({
                "setting": example.setting,
                "samples": example.samples,
                "seconds": example.seconds,
                "relative_mse": example.error,
                "relmse": example.relmse,
                "flip": example.flip,
            })).collect::<Vec<_>>(),
        })
    }
}
