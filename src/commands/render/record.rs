//! What is told of a render, in its image's header and as JSON.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::summary::overrun;
use super::{Output, RenderArgs, Rendering, Seconds};
use crate::aov::Aov;
use crate::commands::denoise::Denoised;
use crate::commands::{command_line, path_text};
use crate::film::{Film, TooDeep, Totals, Verdict};
use crate::gpu::device::Device;
use crate::gpu::probe::Numerics;
use crate::identity::Identity;
use crate::job::Job;
use crate::output::exr::Attribute;
use crate::render::{NOISE_LEVEL, Noise, Outcome};
use crate::samples::Samples;
use crate::scene::Camera;

/// What the stated error of any render is not about, in words.
pub const EXCLUDED: &str =
    "what max_depth cut off (cut_paths), rejected samples, light that no sample has met, and rounding (about 1e-6)";

/// What a film came to.
#[derive(Clone, Debug)]
pub struct Finish {
    pub samples: Samples,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
    pub totals: Totals,
    pub verdict: Verdict,
    /// Of `--noise`: whether the error was reached.
    pub noise: Option<Noise>,
    /// What max_depth cut off.
    pub too_deep: TooDeep,
    /// Whether nothing is left to do.
    pub complete: bool,
}

impl Finish {
    pub fn of(
        film: &Film,
        samples: &Samples,
        devices: &[(String, String)],
        noise: Option<Noise>,
        complete: bool,
    ) -> Finish {
        Finish {
            samples: samples.clone(),
            devices: devices.to_vec(),
            totals: film.totals(),
            verdict: film.verdict(noise.map_or(NOISE_LEVEL, |noise| noise.level())),
            noise,
            too_deep: film.totals().too_deep(),
            complete,
        }
    }

    /// What is told of it. `excluded` says what the stated error is not about.
    pub fn record(&self, excluded: &str) -> FinishRecord {
        let Totals { paths, rays, rejected, .. } = self.totals;
        let names = |of: fn(&(String, String)) -> &String| {
            let names: Vec<&str> = self.devices.iter().map(|device| of(device).as_str()).collect();
            names.join("; ")
        };
        let Verdict { error, hidden, .. } = self.verdict;
        FinishRecord {
            device: names(|(device, _)| device),
            driver: names(|(_, driver)| driver),
            first_sample: self.samples.hull().start,
            end_sample: self.samples.hull().end,
            samples: self.samples.to_string(),
            complete: self.complete,
            paths,
            rays,
            rejected_samples: rejected.total(),
            rejected_nan: rejected.nan,
            rejected_infinite: rejected.infinite,
            rejected_cut: rejected.cut,
            cut_paths: self.too_deep.paths,
            cut_throughput: self.too_deep.mean(),
            relative_error: error.map(|error| error.value),
            relative_error_bound: error.map(|error| error.bound).filter(|bound| bound.is_finite()),
            relative_error_confidence: error.map(|_| 1.0 - NOISE_LEVEL),
            relative_error_excludes: error.map(|_| excluded.to_string()),
            reliable: self.verdict.reliable(),
            light_stopped_by_glass: hidden.probed(),
            light_met_through_glass: hidden.found(),
        }
    }
}

/// What is told of a film.
#[derive(Serialize)]
pub struct FinishRecord {
    device: String,
    driver: String,
    first_sample: u32,
    end_sample: u32,
    samples: String,
    complete: bool,
    paths: u64,
    rays: u64,
    rejected_samples: u64,
    rejected_nan: u64,
    rejected_infinite: u64,
    rejected_cut: u64,
    cut_paths: u64,
    cut_throughput: f64,
    relative_error: Option<f64>,
    /// Unknown where it is infinite.
    relative_error_bound: Option<f64>,
    relative_error_confidence: Option<f64>,
    relative_error_excludes: Option<String>,
    reliable: Option<bool>,
    light_stopped_by_glass: f64,
    light_met_through_glass: f64,
}

/// What a render was asked and where it ran: for the header and the report.
pub struct About<'a> {
    pub args: &'a RenderArgs,
    pub camera: &'a Camera,
    pub identity: &'a Identity,
    pub devices: &'a [Device],
    pub numerics: &'a Numerics,
    pub job: &'a Job,
    /// The options that bias the result or are less exact, as they were given.
    pub biases: &'a [String],
    /// What of the scene is likely to disappoint, as `check` tells it.
    pub warnings: &'a [String],
    /// Samples of a pixel that an earlier render has left.
    pub resumed_from: Option<u64>,
    /// The names of the scene's materials, in the order of their numbers.
    pub materials: &'a [String],
}

/// What the stated error is not about, in words.
pub fn excluded(biases: &str) -> String {
    match biases {
        "" => EXCLUDED.to_string(),
        biases => format!("{EXCLUDED}, and what {biases} did"),
    }
}

impl About<'_> {
    /// What the stated error is not about, in words.
    pub fn excluded(&self) -> String {
        excluded(&self.biases.join(", "))
    }

    /// What the header and the JSON have in common.
    pub fn record(&self, finish: &Finish, seconds: &Seconds) -> Record<'_> {
        Record {
            version: env!("CARGO_PKG_VERSION"),
            command: command_line(),
            scene: path_text(&self.args.scene.path),
            scene_hash: self.identity.hash_of_scene(),
            camera: self.camera,
            numerics: self.numerics,
            integrator: self.args.options.integrator.to_string(),
            sampler: self.args.options.sampler.to_string(),
            seed: self.job.seed,
            max_depth: self.job.max_depth,
            aov: self.args.options.aov.words(),
            materials: if self.args.options.aov.has(Aov::Material) { self.materials } else { &[] },
            biases: self.biases,
            warnings: self.warnings,
            seconds: *seconds,
            finish: finish.record(&self.excluded()),
            noise: self.args.noise,
            noise_reached: finish.noise.map(|noise| noise.reached),
        }
    }
}

/// What is told of a render, in its image's header and as JSON.
#[derive(Serialize)]
pub struct Record<'a> {
    version: &'static str,
    /// As it was typed.
    command: String,
    scene: String,
    /// Of what it says, and of its images and meshes.
    scene_hash: String,
    /// As the scene says it, in the scene's units and degrees.
    camera: &'a Camera,
    numerics: &'a Numerics,
    integrator: String,
    sampler: String,
    seed: u32,
    max_depth: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    aov: Option<String>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    materials: &'a [String],
    biases: &'a [String],
    warnings: &'a [String],
    seconds: Seconds,
    #[serde(flatten)]
    finish: FinishRecord,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_reached: Option<bool>,
}

impl Record<'_> {
    /// The EXR's header.
    pub fn attributes(&self) -> Vec<(String, Attribute)> {
        attributes_of(&json!(self))
    }
}

/// A record as the EXR's header has it.
pub fn attributes_of(record: &Value) -> Vec<(String, Attribute)> {
    let fields = record.as_object().cloned().unwrap_or_default();
    let attribute = |(name, value): (String, Value)| {
        let list = if name == "warnings" { "\n" } else { ", " };
        Some((format!("gpu-rt:{name}"), attribute(&value, list)?))
    };
    let (times, others): (Vec<_>, Vec<_>) = fields.into_iter().partition(|(name, _)| name == "seconds");
    let times = times.into_iter().filter_map(|(_, times)| times.as_object().cloned()).flatten();
    // What has not ended when the file is written has no time yet.
    let times = times.filter(|(_, seconds)| seconds.as_f64() != Some(0.0));
    times.map(|(name, value)| (format!("seconds_{name}"), value)).chain(others).filter_map(attribute).collect()
}

/// A value as the header holds it; nothing of what is not known or empty.
fn attribute(value: &Value, list: &str) -> Option<Attribute> {
    match value {
        Value::Null => None,
        Value::Bool(yes) => Some(Attribute::Int(i64::from(*yes))),
        Value::Number(number) => number.as_i64().map(Attribute::Int).or(number.as_f64().map(Attribute::Float)),
        Value::String(text) => Some(Attribute::Text(text.clone())),
        Value::Array(items) => {
            let items: Vec<&str> = items.iter().filter_map(Value::as_str).collect();
            (!items.is_empty()).then(|| Attribute::Text(items.join(list)))
        }
        Value::Object(_) => Some(Attribute::Text(value.to_string())),
    }
}

/// The record, and what the JSON has beside it.
#[derive(Serialize)]
pub struct RenderReport<'a> {
    output: String,
    width: u32,
    height: u32,
    samples_per_pixel: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    resumed_from: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output_samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    denoised: Option<&'a Denoised>,
    #[serde(flatten)]
    record: Record<'a>,
    features: String,
    software: bool,
    paths_per_second: f64,
    rays_per_second: f64,
    host_seconds: f64,
    interrupted: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_overrun_seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stage_seconds: Option<Map<String, Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    device_idle: Option<f64>,
    kernels: Vec<&'a str>,
    gpu_bytes: u64,
}

pub fn report<'a>(
    about: &'a About<'_>,
    output: &Output<'_>,
    outcome: &Outcome,
    finish: &Finish,
    seconds: &Seconds,
    rendering: &'a Rendering,
) -> RenderReport<'a> {
    let per_second = |n: u64| n as f64 / outcome.seconds.max(1e-9);
    let stages = || outcome.stages.iter().map(|(name, s)| (name.clone(), json!(s))).collect();
    RenderReport {
        output: path_text(&output.image),
        width: about.job.size.0,
        height: about.job.size.1,
        samples_per_pixel: finish.samples.count(),
        resumed_from: about.resumed_from,
        output_samples: rendering.stays,
        denoised: rendering.denoised.as_ref(),
        record: about.record(finish, seconds),
        features: about.args.options.features.to_string(),
        software: about.devices.iter().any(|device| device.name.software),
        paths_per_second: per_second(outcome.totals.paths),
        rays_per_second: per_second(outcome.totals.rays),
        host_seconds: outcome.host_seconds,
        interrupted: outcome.interrupted,
        time_overrun_seconds: overrun(about.args.time, seconds.total),
        stage_seconds: about.args.profile.then(stages),
        device_idle: outcome.device_idle,
        kernels: rendering.kernels.iter().map(String::as_str).collect(),
        gpu_bytes: rendering.gpu_bytes,
    }
}
