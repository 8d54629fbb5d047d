//! `gpu-rt render`: from a scene file to an image file.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{
    check_place, flatten_for, open_device, path_text, print_json, same_file, stop_on_interrupt, tell, tell_biases,
    tell_software,
};
use crate::cli::{MOST_SAMPLES, RenderArgs};
use crate::error::{Error, Result};
use crate::film::{ErrorEstimate, Film, Picture, Totals};
use crate::gpu::device::Device;
use crate::gpu::probe::{Numerics, numerics};
use crate::job::{Goal, Job};
use crate::output::exr::{Attribute, write_exr};
use crate::output::png::write_png;
use crate::output::progress::{Loading, Progress, Status};
use crate::plan::Plan;
use crate::render::{Look, NOISE_LEVEL, Next, Noise, Outcome, Renderer, ThroughGlass, TooDeep};
use crate::scene::Scene;
use crate::threads::beside;

/// Seconds of the parts of a render, as `--json` and the EXR's header report them.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    /// Finding and opening the device, beyond the time that the build took.
    device: f64,
    /// Linking the kernels and creating their pipelines, up to one dispatch of zero workgroups of each.
    compile: f64,
    render: f64,
    write: f64,
    total: f64,
    /// A part of the rendering: from its start to the end of the first submission.
    first_pass: f64,
}

/// Where the image goes.
struct Output<'a> {
    exr: PathBuf,
    png: Option<&'a Path>,
    exposure: f64,
}

/// Renders the scene as asked, writing the image now and then and at the end.
pub fn run(args: &RenderArgs, start: Instant) -> Result<()> {
    let mut clock = Clock(start);
    let mut seconds = Seconds::default();
    let mut loading = Loading::new(args.quiet);
    let scene = Scene::load_with(&args.scene, &mut |file, done, whole| loading.update(file, done, whole))?;
    drop(loading);
    // As `check` has them; --quiet leaves them to the report and the image's header.
    let mut warnings = scene.warnings();
    let tell_warnings = |warnings: &[String]| {
        if !args.quiet {
            warnings.iter().for_each(|warning| tell(&format!("warning: {warning}")));
        }
    };
    tell_warnings(&warnings);
    let biases = tell_biases(&args.options, args.paths.max_depth, &scene, args.quiet);
    let output = output_of(args)?;
    seconds.load = clock.lap();

    // The driver loads while the scene is built; `device` is the time that it takes beyond. A scene that does not load waits for no driver.
    let opening = || open_device(args.paths.device.as_deref());
    let (device, built) = beside(opening, || {
        let built = flatten_for(&scene, args.size, &args.options);
        seconds.build = clock.lap();
        built
    });
    let (size, flat) = built?;
    tell_warnings(&flat.warnings);
    warnings.extend_from_slice(&flat.warnings);
    let device = device?;
    tell_software(&device, args.quiet);
    seconds.device = clock.lap();

    let job = job_of(args, &scene, size, start);
    // The device keeps what its probe finds; an error comes again where the findings are asked for.
    let (_, plan) = beside(|| numerics(&device).is_ok(), || Plan::new(&flat, &args.options, device.class(), &job));
    let plan = plan?;
    let mut renderer = Renderer::new(&device, &plan, &job, args.profile)?;
    seconds.compile = clock.lap();

    let mut film = Film::with_sampler(size.0, size.1, flat.radiance_exponent, args.options.sampler)?;
    let stopped = stop_on_interrupt();
    let about =
        About { args, device: &device, numerics: numerics(&device)?, job: &job, biases: &biases, warnings: &warnings };
    let progress = Progress::new(args.quiet, &job);
    let begun = Instant::now();
    let mut watcher = Watcher {
        progress: &progress,
        stopped: &stopped,
        begun,
        pixels: u64::from(size.0) * u64::from(size.1),
        next_look: (!args.quiet).then(|| begun + pause_after(look_time(size))),
        next_checkpoint: begun + args.checkpoint,
        error: None,
        failed: None,
        outcome: Outcome::default(),
        checkpoint: &|film: &Film, outcome: &Outcome| {
            let each = film.totals().paths / (u64::from(film.width()) * u64::from(film.height()));
            let end = job.first_sample.saturating_add(u32::try_from(each).unwrap_or(u32::MAX));
            let finish = Finish { samples: job.first_sample..end, ..Finish::of(film, outcome) };
            let attributes = about.record(&finish, &seconds).attributes();
            write_exr(&output.exr, &film.develop(), &attributes)
        },
        interval: args.checkpoint,
    };
    let rendered = renderer.run(&job, &mut film, &mut |outcome, look| watcher.watch(outcome, look));
    if let Some(error) = watcher.failed.take() {
        progress.message(&format!("warning: {error}"));
    }
    progress.finish();
    let last = std::mem::take(&mut watcher.outcome);
    seconds.render = clock.lap();

    // A device that failed leaves what was in the film at the last look; it is written before the failure is told.
    let outcome = match &rendered {
        Ok(outcome) => outcome.clone(),
        Err(_) => Outcome { samples: job.first_sample..job.first_sample, ..last },
    };
    let finish = Finish { complete: rendered.is_ok() && !outcome.interrupted, ..Finish::of(&film, &outcome) };
    if finish.totals.paths > 0 || rendered.is_ok() {
        write_all(&output, &film.develop(), &about.record(&finish, &seconds).attributes())?;
    }
    rendered?;
    seconds.write = clock.lap();

    // The report has the passes alone, from the first to the last.
    seconds.render = outcome.seconds;
    seconds.first_pass = outcome.first_pass;
    seconds.total = start.elapsed().as_secs_f64();
    if !args.quiet {
        summarise(&about, &output, &outcome, &finish, seconds.total);
    }
    if args.json {
        print_json(&json!(report(&about, &output, &outcome, &finish, &seconds, &plan)))?;
    }
    if args.strict && finish.totals.rejected.total() > 0 {
        return Err(Error::Strict(format!("--strict: {}", rejected_words(&finish.totals))));
    }
    match outcome.interrupted {
        true => Err(Error::Interrupted(format!("interrupted; {} holds the image so far", output.exr.display()))),
        false => Ok(()),
    }
}

/// Laps from the start of the program.
struct Clock(Instant);

impl Clock {
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now.duration_since(self.0).as_secs_f64();
        self.0 = now;
        lap
    }
}

/// The paths to write to, checked before anything costs time.
fn output_of(args: &RenderArgs) -> Result<Output<'_>> {
    let exr: PathBuf = match &args.output {
        Some(path) => path.clone(),
        None => {
            let name = args.scene.file_stem().unwrap_or_default();
            PathBuf::from(name).with_added_extension("exr")
        }
    };
    let places: Vec<&Path> = std::iter::once(exr.as_path()).chain(args.png.as_deref()).collect();
    places.iter().try_for_each(|place| check_place(place, "nothing has been rendered"))?;
    let twice = args.png.as_deref().is_some_and(|png| same_file(&exr, png));
    if twice || places.iter().any(|place| same_file(place, &args.scene)) {
        return Err(Error::Usage(format!(
            "{}: expected different files for the scene, the EXR and the PNG; nothing has been rendered",
            exr.display()
        )));
    }
    Ok(Output { exr, png: args.png.as_deref(), exposure: args.exposure })
}

fn job_of(args: &RenderArgs, scene: &Scene, size: (u32, u32), start: Instant) -> Job {
    let samples = args.samples.clone().unwrap_or(0..args.spp.unwrap_or(scene.render.samples));
    let deadline = args.time.map(|time| start + time.saturating_sub(write_time(size)));
    let end = args.spp.unwrap_or(MOST_SAMPLES as u32);
    let goal = match (args.noise, deadline) {
        (None, None) => Goal::Samples(samples.end),
        (None, Some(deadline)) => Goal::Until { deadline, end },
        (Some(error), deadline) => Goal::Noise { error, deadline, end },
    };
    Job {
        size,
        max_depth: args.paths.max_depth.unwrap_or(scene.render.max_depth),
        seed: args.paths.seed,
        first_sample: samples.start,
        goal,
    }
}

/// What developing and writing the image is allowed for under `--time`: measured as 0.3 to 0.5 µs a pixel on two cores.
fn write_time((width, height): (u32, u32)) -> Duration {
    Duration::from_nanos(u64::from(width) * u64::from(height) * 500) + Duration::from_millis(20)
}

/// What bringing the film from the device and measuring its error takes: 0.1 to 0.2 µs a pixel.
fn look_time((width, height): (u32, u32)) -> Duration {
    Duration::from_nanos(u64::from(width) * u64::from(height) * 150)
}

/// The time between two looks: they shall cost 0.5 % at most, and no terminal needs more than one a second.
fn pause_after(look: Duration) -> Duration {
    (200 * look).max(Duration::from_secs(1))
}

/// Called after each submission: shows progress, looks at the film now and then, writes checkpoints, passes interrupts on.
struct Watcher<'a> {
    progress: &'a Progress,
    stopped: &'a AtomicBool,
    begun: Instant,
    pixels: u64,
    /// Nothing where nobody watches.
    next_look: Option<Instant>,
    next_checkpoint: Instant,
    interval: Duration,
    error: Option<f64>,
    failed: Option<Error>,
    /// As of the film's last look.
    outcome: Outcome,
    checkpoint: &'a dyn Fn(&Film, &Outcome) -> Result<()>,
}

impl Watcher<'_> {
    fn watch(&mut self, outcome: &Outcome, look: Option<Look<'_>>) -> Next {
        let now = Instant::now();
        let is_due = self.next_look.is_some_and(|next| now >= next) || now >= self.next_checkpoint;
        let looked = look.is_some();
        if let Some(Look { film, begin }) = look {
            self.outcome.clone_from(outcome);
            if now >= self.next_checkpoint {
                // A checkpoint that fails is told at the end; the render is worth more than it.
                self.failed = (self.checkpoint)(film, outcome).err();
                self.next_checkpoint = Instant::now() + self.interval;
            } else if let Some(next) = &mut self.next_look {
                self.error = film.relative_error();
                *next = Instant::now() + pause_after(begin.elapsed());
            }
        }
        let paths = outcome.totals.paths;
        self.progress.update(Status {
            samples_per_pixel: paths / self.pixels.max(1),
            paths_per_second: paths as f64 / self.begun.elapsed().as_secs_f64().max(1e-6),
            relative_error: self.error,
        });
        match self.stopped.load(Ordering::Relaxed) {
            true => Next::Stop,
            false if is_due && !looked => Next::Look,
            false => Next::GoOn,
        }
    }
}

/// What the stated error of any render is not about, in words.
const EXCLUDED: &str =
    "what max_depth cut off (cut_paths), rejected samples, light that no sample has met, and rounding (about 1e-6)";

/// What a film came to.
#[derive(Clone, Debug)]
struct Finish {
    samples: Range<u32>,
    totals: Totals,
    error: Option<ErrorEstimate>,
    /// Light by mirrors and through glass, as shares of the image's.
    through_glass: ThroughGlass,
    /// Of `--noise`: whether the error was reached.
    noise: Option<Noise>,
    /// What max_depth cut off.
    too_deep: TooDeep,
    complete: bool,
}

impl Finish {
    fn of(film: &Film, outcome: &Outcome) -> Finish {
        Finish {
            samples: outcome.samples.clone(),
            totals: film.totals(),
            error: film.error_estimate(outcome.noise.map_or(NOISE_LEVEL, |noise| noise.level)),
            through_glass: shares(outcome, film),
            noise: outcome.noise,
            too_deep: outcome.too_deep,
            complete: false,
        }
    }

    /// Whether light is missing that only chance can meet, more than the error that is stated.
    fn lacks_light(&self) -> bool {
        self.error.is_some_and(|error| self.through_glass.missing() > error.bound)
    }

    /// Whether the stated error can be relied on.
    fn reliable(&self) -> Option<bool> {
        self.error.map(|error| error.reliable && !self.lacks_light())
    }
}

/// Light by mirrors and through glass as shares of the image's.
fn shares(outcome: &Outcome, film: &Film) -> ThroughGlass {
    let all = film.mean_radiance() * film.totals().paths as f64;
    outcome.through_glass.times(if all > 0.0 { 1.0 / all } else { 0.0 })
}

/// What a render was asked and where it ran: for the header and the report.
struct About<'a> {
    args: &'a RenderArgs,
    device: &'a Device,
    numerics: &'a Numerics,
    job: &'a Job,
    /// The options that bias the result or are less exact, as they were given.
    biases: &'a [String],
    /// What of the scene is likely to disappoint, as `check` tells it.
    warnings: &'a [String],
}

impl About<'_> {
    /// What the stated error is not about, in words.
    fn excluded(&self) -> String {
        match self.biases {
            [] => EXCLUDED.to_string(),
            biases => format!("{EXCLUDED}, and what {} did", biases.join(", ")),
        }
    }

    /// What the header and the JSON have in common.
    fn record(&self, finish: &Finish, seconds: &Seconds) -> Record<'_> {
        let error = finish.error;
        let Totals { paths, rays, rejected } = finish.totals;
        Record {
            version: env!("CARGO_PKG_VERSION"),
            scene: path_text(&self.args.scene),
            device: &self.device.name.name,
            driver: &self.device.name.driver,
            numerics: self.numerics,
            integrator: self.args.options.integrator.to_string(),
            sampler: self.args.options.sampler.to_string(),
            seed: self.job.seed,
            max_depth: self.job.max_depth,
            first_sample: finish.samples.start,
            end_sample: finish.samples.end,
            complete: finish.complete,
            biases: self.biases,
            warnings: self.warnings,
            seconds: *seconds,
            paths,
            rays,
            rejected_samples: rejected.total(),
            rejected_nan: rejected.nan,
            rejected_infinite: rejected.infinite,
            rejected_cut: rejected.cut,
            cut_paths: finish.too_deep.paths,
            cut_throughput: finish.too_deep.mean(),
            relative_error: error.map(|error| error.value),
            relative_error_bound: error.map(|error| error.bound).filter(|bound| bound.is_finite()),
            relative_error_confidence: error.map(|_| 1.0 - NOISE_LEVEL),
            relative_error_excludes: error.map(|_| self.excluded()),
            reliable: finish.reliable(),
            light_stopped_by_glass: finish.through_glass.blocked_by_dielectrics(),
            light_met_through_glass: finish.through_glass.found_by_bsdf(),
            noise: self.args.noise,
            noise_reached: finish.noise.map(|noise| noise.reached),
        }
    }
}

/// What is told of a render, in its image's header and as JSON.
#[derive(Serialize)]
struct Record<'a> {
    version: &'static str,
    scene: String,
    device: &'a str,
    driver: &'a str,
    numerics: &'a Numerics,
    integrator: String,
    sampler: String,
    seed: u32,
    max_depth: u32,
    first_sample: u32,
    end_sample: u32,
    complete: bool,
    biases: &'a [String],
    warnings: &'a [String],
    seconds: Seconds,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_reached: Option<bool>,
}

impl Record<'_> {
    /// The EXR's header.
    fn attributes(&self) -> Vec<(String, Attribute)> {
        let Value::Object(fields) = json!(self) else { return Vec::new() };
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

fn write_all(output: &Output<'_>, picture: &Picture, attributes: &[(String, Attribute)]) -> Result<()> {
    write_exr(&output.exr, picture, attributes)?;
    match output.png {
        Some(png) => write_png(png, picture, output.exposure),
        None => Ok(()),
    }
}

/// The record, and what the JSON has beside it.
#[derive(Serialize)]
struct RenderReport<'a> {
    output: String,
    width: u32,
    height: u32,
    samples_per_pixel: u64,
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

fn report<'a>(
    about: &'a About<'_>,
    output: &Output<'_>,
    outcome: &Outcome,
    finish: &Finish,
    seconds: &Seconds,
    plan: &'a Plan<'_>,
) -> RenderReport<'a> {
    let per_second = |n: u64| n as f64 / outcome.seconds.max(1e-9);
    let stages = || outcome.stages.iter().map(|(name, s)| (name.clone(), json!(s))).collect();
    RenderReport {
        output: path_text(&output.exr),
        width: about.job.size.0,
        height: about.job.size.1,
        samples_per_pixel: samples_done(outcome, finish, about.job),
        record: about.record(finish, seconds),
        features: about.args.options.features.to_string(),
        software: about.device.name.software,
        paths_per_second: per_second(finish.totals.paths),
        rays_per_second: per_second(finish.totals.rays),
        host_seconds: outcome.host_seconds,
        interrupted: outcome.interrupted,
        time_overrun_seconds: overrun(about.args.time, seconds.total),
        stage_seconds: about.args.profile.then(stages),
        device_idle: outcome.device_idle,
        kernels: plan.kernels().iter().map(|kernel| kernel.name.as_str()).collect(),
        gpu_bytes: plan.buffers().iter().map(|buffer| buffer.allocated()).sum(),
    }
}

/// Seconds beyond the time that was asked for, if the render took longer.
fn overrun(time: Option<Duration>, total: f64) -> Option<f64> {
    time.map(|time| total - time.as_secs_f64()).filter(|over| *over > 0.0)
}

/// The last line, and before it what the user should know.
fn summarise(about: &About<'_>, output: &Output<'_>, outcome: &Outcome, finish: &Finish, total: f64) {
    let About { args, job, .. } = about;
    if finish.totals.rejected.total() > 0 {
        tell(&format!("warning: {}", rejected_words(&finish.totals)));
    }
    let cut = outcome.too_deep;
    if cut.paths > 0 {
        let (paths, mean) = (finish.totals.paths.max(1) as f64, cut.mean());
        tell(&format!(
            "max_depth {} cut {} of {} paths, with a mean throughput of {mean:.2e}: averaged over the image, at most {:.2e} of the \
             radiance that they would have found is missing",
            job.max_depth,
            cut.paths,
            finish.totals.paths,
            cut.throughput / paths
        ));
    }
    if let Some((time, over)) = args.time.zip(overrun(args.time, total)) {
        let over = if over < 1.0 { format!("{:.1} ms", 1e3 * over) } else { format!("{over:.1} s") };
        tell(&format!("warning: the render took {over} longer than --time {} s", time.as_secs_f64()));
    }
    if args.profile {
        match outcome.stages.is_empty() {
            true => tell("stages: this device has no timestamps"),
            false => outcome.stages.iter().for_each(|(name, s)| tell(&format!("stage {name}: {s:.3} s on the device"))),
        }
        if let Some(idle) = outcome.device_idle {
            tell(&format!("the device was idle for {} % of the time", percent(idle)));
        }
    }
    if let Some(error) = finish.error.filter(|error| !error.reliable) {
        tell(&format!(
            "warning: the relative error is unreliable: rare bright paths dominate it{}",
            match error.bound.is_finite() {
                true => format!(". It may be {} %", percent(error.bound)),
                false => String::new(),
            }
        ));
    }
    if finish.lacks_light() {
        tell(&format!(
            "warning: the relative error is unreliable: mirrors and glass block {} % of the image's light from light sampling, and paths \
             have found {} % by chance. Raise --spp.",
            percent(finish.through_glass.blocked_by_dielectrics()),
            percent(finish.through_glass.found_by_bsdf())
        ));
    }
    if let (Some(wish), Some(noise)) = (args.noise, finish.noise) {
        let words = if noise.reached { "was reached" } else { "was not reached" };
        tell(&match finish.error.map(|error| error.bound).filter(|bound| bound.is_finite()) {
            Some(bound) => {
                format!(
                    "--noise {wish} {words}: the relative error is at most {} %, with 95 % confidence",
                    percent(bound)
                )
            }
            None => format!(
                "--noise {wish} {words}: the error has no bound, since too few pixels have any light; give --spp or --time"
            ),
        });
    }
    if finish.error.is_some() {
        tell(&format!("the relative error covers noise; it excludes {}", about.excluded()));
    }
    let error = match finish.error {
        Some(error) if error.bound.is_finite() => {
            format!("relative error {} % (95 % sure: below {} %)", percent(error.value), percent(error.bound))
        }
        Some(error) => format!("relative error {} %", percent(error.value)),
        None => "error unknown (it needs 9 samples per pixel, and light)".to_string(),
    };
    let samples = samples_done(outcome, finish, job);
    tell(&format!("{}: {samples} samples, {error}, {total:.1} s", output.exr.display()));
}

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

/// Samples of each pixel; of an interrupted render the whole ones of the mean.
fn samples_done(outcome: &Outcome, finish: &Finish, job: &Job) -> u64 {
    match outcome.interrupted {
        false => outcome.samples.len() as u64,
        true => finish.totals.paths / (u64::from(job.size.0) * u64::from(job.size.1)),
    }
}

fn rejected_words(totals: &Totals) -> String {
    let rejected = totals.rejected;
    format!(
        "{} of {} samples were rejected: {} were not a number, {} infinite, {} cut short, {} not delivered \
         whole",
        rejected.total(),
        totals.paths,
        rejected.nan,
        rejected.infinite,
        rejected.cut,
        rejected.refused
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a watcher says to `calls` submissions, with a film that takes 10 ms to be looked at: how often it looks.
    fn looks(next_look: Option<Instant>, checkpoint: Duration, calls: usize) -> usize {
        let goal = Goal::Samples(1);
        let job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal };
        let (film, outcome) = (Film::new(1, 1, 0).unwrap(), Outcome::default());
        let (progress, stopped, begun) = (Progress::new(true, &job), AtomicBool::new(false), Instant::now());
        let mut watcher = Watcher {
            progress: &progress,
            stopped: &stopped,
            begun,
            pixels: 1,
            next_look,
            next_checkpoint: begun + checkpoint,
            interval: checkpoint,
            error: None,
            failed: None,
            outcome: Outcome::default(),
            checkpoint: &|_, _| Ok(()),
        };
        let mut count = 0;
        for _ in 0..calls {
            if watcher.watch(&outcome, None) == Next::Look {
                count += 1;
                let begin = Instant::now() - Duration::from_millis(10);
                assert_eq!(watcher.watch(&outcome, Some(Look { film: &film, begin })), Next::GoOn);
            }
        }
        count
    }

    /// A look of 10 ms is followed by two seconds without one, and nobody looks for a quiet render but to write checkpoints.
    #[test]
    fn looks_are_rare_and_for_somebody() {
        let hour = Duration::from_secs(3600);
        assert_eq!(looks(Some(Instant::now()), hour, 1000), 1);
        assert_eq!(looks(None, hour, 1000), 0);
        assert_eq!(looks(None, Duration::ZERO, 10), 10);
        assert_eq!(pause_after(Duration::from_millis(10)), Duration::from_secs(2));
        assert_eq!(pause_after(Duration::ZERO), Duration::from_secs(1));
    }
}
