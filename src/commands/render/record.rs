//! The facts about a render, in its image's header and as JSON. docs/files.md has their list.

use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::request::Request;
use crate::aov::Aov;
use crate::commands::console::{command_line, object, path_text};
use crate::commands::denoise::Denoised;
use crate::error::Result;
use crate::film::{Accumulation, Totals, Verdict};
use crate::gpu::numerics::Numerics;
use crate::options::Word;
use crate::output::exr::{Attribute, State};
use crate::render::{NOISE_LEVEL, Noise};
use crate::samples::Samples;
use crate::session::Session;

/// The result of a render, or of films that were joined.
pub struct Finish {
    pub samples: Samples,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
    pub totals: Totals,
    pub verdict: Verdict,
    /// In how many pixels mattes lack samples, if there are mattes.
    pub matte_pixels_lost: Option<u64>,
    /// The result of `--noise`.
    pub noise: Option<Noise>,
    /// Whether nothing is left to do.
    pub complete: bool,
    /// The samples of the output, if it stays as it was because they are more than this render has.
    pub more: Option<u64>,
}

impl Finish {
    pub fn new(film: &Accumulation, noise: Option<Noise>, complete: bool) -> Finish {
        let Accumulation { film, samples, devices, .. } = film;
        Finish {
            samples: samples.clone(),
            devices: devices.clone(),
            totals: film.totals,
            verdict: film.verdict(noise.map_or(NOISE_LEVEL, |noise| noise.level())),
            matte_pixels_lost: film.matte_pixels_lost(),
            noise,
            complete,
            more: None,
        }
    }

    /// The facts about it. `excluded` says what the stated error excludes.
    pub fn record(&self, excluded: &str) -> Map<String, Value> {
        let Totals { paths, rays, rejected, too_deep, light_paths: [even, odd], .. } = self.totals;
        let names = |name: fn(&(String, String)) -> &str| self.devices.iter().map(name).collect::<Vec<_>>().join("; ");
        let Verdict { error, hidden, .. } = self.verdict;
        let mut record = object(json!({
            "device": names(|(device, _)| device),
            "driver": names(|(_, driver)| driver),
            "first_sample": self.samples.range().start,
            "end_sample": self.samples.range().end,
            "samples": self.samples.to_string(),
            "complete": self.complete,
            "paths": paths,
            "rays": rays,
            "light_paths": even.saturating_add(odd),
            "rejected_samples": rejected.total(),
            "rejected_nan": rejected.nan,
            "rejected_infinite": rejected.infinite,
            "rejected_cut": rejected.cut,
            "cut_paths": too_deep,
            "cut_throughput": self.totals.cut_throughput() / too_deep.max(1) as f64,
            "relative_error": error.map(|error| error.value),
            // JSON has no infinity: it becomes null.
            "relative_error_bound": error.map(|error| error.bound),
            "relative_error_confidence": error.map(|_| 1.0 - NOISE_LEVEL),
            "relative_error_excludes": error.map(|_| excluded),
            "reliable": self.verdict.reliable(),
            "light_stopped_by_glass": hidden.probed(),
            "light_met_through_glass": hidden.found(),
        }));
        record.extend(self.matte_pixels_lost.map(|lost| ("crypto_lost_pixels".to_string(), json!(lost))));
        record
    }
}

/// Seconds of the parts of a render.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub build: f64,
    /// Finding and opening the device, beyond the time that the build took.
    pub device: f64,
    /// Linking the kernels and creating their pipelines, up to one dispatch of zero workgroups of each.
    pub compile: f64,
    pub render: f64,
    pub write: f64,
    pub total: f64,
    /// From the start of the rendering to the end of the first submission.
    pub first_pass: f64,
    /// For one sample of every pixel. It is the pace of this process, also while it renders and after a resumption.
    pub per_sample: f64,
}

/// The seconds of one of so many samples; 0, which is not known, if there are none.
pub fn per_sample(seconds: f64, samples: u64) -> f64 {
    if samples == 0 { 0.0 } else { seconds / samples as f64 }
}

/// Measures the parts of a render.
pub struct Clock {
    last: Instant,
    pub seconds: Seconds,
}

impl Clock {
    pub fn new(start: Instant) -> Clock {
        Clock { last: start, seconds: Seconds::default() }
    }

    /// The seconds since the last call.
    pub fn lap(&mut self) -> f64 {
        let before = std::mem::replace(&mut self.last, Instant::now());
        self.last.duration_since(before).as_secs_f64()
    }
}

/// The facts about a render that its header and the JSON have in common.
pub fn record(request: &Request<'_>, numerics: &Numerics, finish: &Finish, seconds: &Seconds) -> Map<String, Value> {
    let Request { args, scene, job, warnings, materials, objects, .. } = request;
    let options = &args.options;
    let materials = Some(materials).filter(|names| options.aov.has(Aov::Material) && !names.is_empty());
    let mut record = object(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": command_line(),
        "scene": path_text(&args.scene.path),
        "scene_hash": request.identity().hash_of_scene(),
        "camera": scene.camera,
        "frame": scene.frame.map(|frame| frame.number),
        "fps": scene.frame.map(|frame| frame.fps),
        "numerics": numerics,
        "integrator": options.integrator.word(),
        "sampler": options.sampler.word(),
        "seed": job.seed,
        "max_depth": job.max_depth,
        "aov": options.aov.words(),
        "materials": materials,
        "objects": Some(objects).filter(|names| !names.is_empty()),
        "biases": request.biases(),
        "warnings": warnings,
        "seconds": seconds,
    }));
    record.extend(finish.record(&request.excluded()));
    record.extend(object(json!({
        "noise": args.goal.noise,
        "noise_reached": finish.noise.map(|noise| noise.reached),
    })));
    drop_absent(&mut record);
    record
}

/// The facts that are left out if they are unknown or not requested. Others are null then.
const OPTIONAL: [&str; 13] = [
    "frame",
    "fps",
    "aov",
    "materials",
    "objects",
    "noise",
    "noise_reached",
    "resumed_from",
    "output_samples",
    "denoised",
    "time_overrun_seconds",
    "stage_seconds",
    "device_idle",
];

/// Leaves out optional facts that are null.
pub fn drop_absent(record: &mut Map<String, Value>) {
    record.retain(|name, value| !(value.is_null() && OPTIONAL.contains(&name.as_str())));
}

/// A record as the EXR's header has it.
pub fn attributes_of(record: &Map<String, Value>) -> Vec<(String, Attribute)> {
    let attribute = |(name, value): (String, &Value)| {
        let list = if name == "warnings" || name == "objects" { "\n" } else { ", " };
        Some((format!("gpu-rt:{name}"), attribute(value, list)?))
    };
    let times = record.get("seconds").and_then(Value::as_object).into_iter().flatten();
    // What has not ended when the file is written has no time yet.
    let times = times.filter(|(_, seconds)| seconds.as_f64() != Some(0.0));
    let times = times.map(|(name, value)| (format!("seconds_{name}"), value));
    let others = record.iter().filter(|(name, _)| *name != "seconds").map(|(name, value)| (name.clone(), value));
    times.chain(others).filter_map(attribute).collect()
}

/// Writes the image with this record and its state, to go on from.
pub fn write_film(request: &Request<'_>, film: &Accumulation, record: &Map<String, Value>) -> Result<()> {
    let state = State::new(request.identity().clone(), film);
    request.write(&film.film, Some(&state), &attributes_of(record))
}

/// Writes the film of the session's view and its picture as `render` with these arguments writes them.
///
/// # Errors
/// As of `render`, where a file cannot be written.
#[cfg(feature = "window")]
pub fn save(
    args: &super::args::RenderArgs,
    scene: &crate::scene::Scene,
    session: &Session,
    film: &Accumulation,
) -> Result<()> {
    let mut request = Request::new(args, scene, Instant::now())?;
    request.take(&session.scene)?;
    let record = record(&request, session.numerics()?, &Finish::new(film, None, true), &Seconds::default());
    write_film(&request, film, &record)?;
    request.write_png(&film.film)
}

/// A value as the header holds it; `None` if it is not known or empty.
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

/// Seconds beyond `--time`, if the render took longer.
pub fn overrun(time: Option<Duration>, total: f64) -> Option<f64> {
    time.map(|time| total - time.as_secs_f64()).filter(|over| *over > 0.0)
}

/// The JSON of a render: its record with all of the seconds, and further fields.
pub fn report(
    request: &Request<'_>,
    session: &Session,
    finish: &Finish,
    (mut record, seconds): (Map<String, Value>, &Seconds),
    denoised: Option<&Denoised>,
) -> Value {
    let (Request { args, .. }, outcome, (kernels, gpu_bytes)) = (request, &session.outcome, session.kernels());
    let per_second = |n: u64| n as f64 / outcome.seconds.max(1e-9);
    let stages = || outcome.stages.iter().map(|(name, s)| (name.clone(), json!(s))).collect::<Map<_, _>>();
    let mut report = object(json!({
        "output": path_text(&request.image),
        "width": request.job.size.0,
        "height": request.job.size.1,
        "samples_per_pixel": finish.samples.count(),
        "resumed_from": request.held,
        "output_samples": finish.more,
        "denoised": denoised,
    }));
    record.insert("seconds".to_string(), json!(seconds));
    report.extend(record);
    report.extend(object(json!({
        "features": args.options.features.word(),
        "software": session.devices.iter().any(|device| device.name.software),
        "paths_per_second": per_second(outcome.totals.paths),
        "rays_per_second": per_second(outcome.totals.rays),
        "host_seconds": outcome.host_seconds,
        "interrupted": outcome.interrupted,
        "time_overrun_seconds": overrun(args.goal.time, seconds.total),
        "stage_seconds": args.profile.then(stages),
        "device_idle": outcome.idle,
        "kernels": kernels,
        "gpu_bytes": gpu_bytes,
    })));
    drop_absent(&mut report);
    Value::Object(report)
}
