//! A render under way: the devices render what the film lacks, while observers follow, and the image is written at the end.

use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use super::accumulation::Accumulation;
use super::compiling::show_compiling;
use super::last_write::LastWrite;
use super::observers::Observers;
use super::record::{FileSamples, Finish, Seconds, attributes_of, drop_absent, overrun, record};
use super::request::Request;
use crate::commands::console::{command_of_image, object, path_text};
use crate::commands::denoise::Denoised;
use crate::commands::target::open_devices;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::gpu::device::Device;
use crate::gpu::numerics::Numerics;
use crate::gpu::probe::numerics;
use crate::output::exr::{State, read_state};
use crate::plan::Plan;
use crate::render::{Outcome, Renderer};
use crate::threads::join;

/// Under `--watch`: the time that a submission should take, since the one that is under way is waited for.
const SOON: Duration = Duration::from_millis(30);

/// The work that a device gets at a time is halved so often after it has failed.
const HALVINGS_AFTER_LOSS: u32 = 2;

/// A render under way.
pub struct Rendering<'a> {
    pub request: &'a Request<'a>,
    pub devices: &'a mut Vec<Device>,
    pub film: Accumulation,
    pub held: FileSamples,
    pub observers: Observers<'a>,
    pub outcome: Outcome,
    pub clock: Clock,
    /// What the devices got ready; `None` before they begin to render.
    pub loaded: Option<Loaded>,
}

/// What a plan brings onto the devices.
pub struct Loaded {
    kernels: Vec<String>,
    gpu_bytes: u64,
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

/// The seconds of one of so many samples; 0, which is not known, if there are none.
fn per_sample(seconds: f64, samples: u64) -> f64 {
    if samples == 0 { 0.0 } else { seconds / samples as f64 }
}

impl Rendering<'_> {
    /// Renders what the film lacks. Devices that fail are opened once more, get less work at a time, and go on from the last checkpoint or from
    /// the beginning. `quiet` hides what compiles.
    pub fn run(&mut self, quiet: bool) -> Result<()> {
        let mut first = self.attempt(quiet);
        while first.is_err() && self.take_fewer_slots() {
            first = self.attempt(quiet);
        }
        let Err(Error::Device(why)) = &first else { return first };
        if self.loaded.is_none() || self.observers.signals.are_pending() {
            return first;
        }
        self.observers.progress.message(&format!("warning: {why}; the device is opened once more"));
        // If that fails too, the first failure is reported.
        let Ok((film, devices)) = self.begin_again() else { return first };
        // A watchdog may have ended work that took too long.
        for (before, again) in self.devices.iter().zip(&devices) {
            again.halve(before.class().halvings + HALVINGS_AFTER_LOSS);
        }
        (self.film, *self.devices) = (film, devices);
        self.attempt(quiet)
    }

    /// Halves the slots of the devices that had no memory for their buffers. Returns whether that leaves something to try.
    fn take_fewer_slots(&self) -> bool {
        let lacking: Vec<&Device> = self.devices.iter().filter(|device| device.take_lacked_memory()).collect();
        self.request.args.options.slots.is_none() && !lacking.is_empty() && lacking.iter().all(|device| device.halve(1))
    }

    fn attempt(&mut self, quiet: bool) -> Result<()> {
        let Rendering { request, devices, film, observers, outcome, clock, loaded, .. } = self;
        outcome.noise = film.noise_reached(&request.job);
        let jobs = film.jobs(&request.job, outcome.noise);
        let Some(first) = jobs.first() else { return Ok(()) };
        let ending = observers.signals.end_at_once("while compiling")?;
        // The device keeps what its probe finds; its error is returned again when the findings are read.
        let probe = || devices.iter().all(|device| numerics(device).is_ok());
        let plan = |device: &Device| Plan::new(&request.flat, &request.args.options, device.class(), first);
        let (_, plans) = join(probe, || devices.iter().map(plan).collect::<Result<Vec<_>>>());
        let plans = plans?;
        let pairs: Vec<_> = devices.iter().zip(&plans).collect();
        let compile = || Renderer::of_devices(&pairs, first, request.args.profile);
        let mut renderer = show_compiling(devices, quiet, compile)?;
        drop(ending);
        let kernels = plans.iter().take(1).flat_map(Plan::kernels).map(|kernel| kernel.name.clone()).collect();
        let gpu_bytes = plans.iter().flat_map(Plan::buffers).map(|buffer| buffer.allocated()).sum();
        *loaded = Some(Loaded { kernels, gpu_bytes });
        clock.seconds.compile += clock.lap();
        observers.progress.restart();
        if request.args.watch {
            renderer.set_submission_time(SOON);
        }

        let (numerics, signals) = (numerics_of(devices)?, observers.signals);
        for job in &jobs {
            let Accumulation { film: pixels, samples, checks, devices } = &mut *film;
            let (begun, earlier) = (Instant::now(), samples.count());
            let checkpoint = |film: &Film, outcome: &Outcome| {
                let mut samples = samples.clone();
                samples.join(&outcome.samples);
                let finish = Finish::new(film, &samples, devices, outcome.noise, false);
                let mut seconds = clock.seconds;
                seconds.pace.per_sample =
                    per_sample(begun.elapsed().as_secs_f64(), samples.count().saturating_sub(earlier));
                let checks = outcome.noise.map_or(*checks, |noise| noise.checks);
                let state = State::new(request.identity().clone(), devices.clone(), film, samples, checks);
                let attributes = attributes_of(&record(request, numerics, &finish, &seconds));
                request.write(film, Some(&state), &attributes)?;
                let kept = request.what_is_in(&request.image, &state.samples);
                signals.set_loss(format!("the samples since the last checkpoint are lost. {kept}"));
                Ok(())
            };
            observers.begin(job, earlier, clock.seconds.compile);
            let picture = |film: &Film| request.write_png_so_far(film);
            let done = renderer
                .run(job, pixels, &mut |so_far, snapshot| observers.follow(so_far, snapshot, &checkpoint, &picture))?;
            samples.join(&done.samples);
            *checks = done.noise.map_or(*checks, |noise| noise.checks);
            outcome.join(done);
            if outcome.interrupted {
                break;
            }
        }
        Ok(())
    }

    /// Ends the rendering; `is_ok` if no device has failed.
    pub fn finish(&mut self, is_ok: bool) -> Finish {
        let Rendering { film: Accumulation { film, samples, devices, .. }, held, outcome, clock, .. } = self;
        clock.seconds.render = clock.lap();
        let rendered = samples.count().saturating_sub(held.before.unwrap_or(0));
        clock.seconds.pace.per_sample = per_sample(outcome.seconds, rendered);
        Finish::new(film, samples, devices, outcome.noise, is_ok && !outcome.interrupted)
    }

    /// The facts about the result.
    pub fn record(&self, finish: &Finish) -> Result<Map<String, Value>> {
        Ok(record(self.request, numerics_of(self.devices)?, finish, &self.clock.seconds))
    }

    /// Writes the image and its picture. An EXR with more samples than the complete render is kept: the number of samples of `--time` and
    /// `--noise` is known only now.
    pub fn write(&mut self, finish: &Finish, record: &Map<String, Value>) -> Result<()> {
        let request = self.request;
        let Accumulation { film: pixels, samples, checks, devices } = &self.film;
        self.held.at_end = if finish.complete { request.more_than(samples.count()) } else { None };
        if self.loaded.is_some() && self.held.at_end.is_none() {
            let state = State::new(request.identity().clone(), devices.clone(), pixels, samples.clone(), *checks);
            if let Err(error) = self.last_write(Some(state), record).write() {
                let _ = request.write_png(pixels);
                return Err(error);
            }
        }
        let image = request.image.display();
        let contents = if request.args.watch { "last picture" } else { "image" };
        self.observers.signals.set_loss(format!("{image} holds the {contents}"));
        let develop = command_of_image("develop", &request.image, "NAME.png");
        let held = format!("{image} holds the image. `{develop}` makes the picture");
        request.write_png(pixels).map_err(|error| error.and(&held))
    }

    fn last_write(&self, state: Option<State>, record: &Map<String, Value>) -> LastWrite<'_> {
        LastWrite {
            request: self.request,
            signals: self.observers.signals,
            film: &self.film.film,
            samples: &self.film.samples,
            state,
            attributes: attributes_of(record),
        }
    }

    /// Keeps what there is where the device has failed for good. The error says what that is.
    pub fn keep(&self, error: Error, record: &Map<String, Value>) -> Error {
        let Rendering { request, film, .. } = self;
        if !matches!(error, Error::Device(_)) {
            return error;
        }
        let in_file = if self.is_in_file() { read_state(&request.image).ok().flatten() } else { None };
        if let Some(state) = in_file {
            return error.and(&request.what_is_in(&request.image, &state.samples));
        }
        // A film with runs under way left out favours short paths. Nothing can go on from it.
        if film.film.totals().paths == 0 {
            return error.and("nothing has been written");
        }
        match self.last_write(None, record).write().and_then(|()| request.write_png(&film.film)) {
            Ok(()) => error.and(&format!("{} holds what there was, and cannot be resumed", request.image.display())),
            Err(failed) => error.and(&failed.to_string()),
        }
    }

    /// Whether the output is an EXR with a checkpoint of this render, or with what it goes on with.
    fn is_in_file(&self) -> bool {
        self.request.exr().is_some() && (self.observers.checkpoints.kept || self.held.before.is_some())
    }

    /// The film when it was last complete, that of the file or an empty one; and new devices.
    fn begin_again(&self) -> Result<(Accumulation, Vec<Device>)> {
        let state = if self.is_in_file() { read_state(&self.request.image)? } else { None };
        let devices = open_devices(self.request.args.paths.device.as_deref())?;
        Ok((Accumulation::begin(self.request, state.as_ref(), &devices)?, devices))
    }

    /// The JSON of the render: its record, and further fields.
    pub fn report(&self, record: Map<String, Value>, denoised: Option<&Denoised>) -> Value {
        let Rendering { request, outcome, held, .. } = self;
        let per_second = |n: u64| n as f64 / outcome.seconds.max(1e-9);
        let stages = || outcome.profile.stages.iter().map(|(name, s)| (name.clone(), json!(s))).collect::<Map<_, _>>();
        let mut report = object(json!({
            "output": path_text(&request.image),
            "width": request.job.size.0,
            "height": request.job.size.1,
            "samples_per_pixel": self.film.samples.count(),
            "resumed_from": held.before,
            "output_samples": held.at_end,
            "denoised": denoised,
        }));
        report.extend(record);
        report.extend(object(json!({
            "features": request.args.options.features.to_string(),
            "software": self.devices.iter().any(|device| device.name.software),
            "paths_per_second": per_second(outcome.totals.paths),
            "rays_per_second": per_second(outcome.totals.rays),
            "host_seconds": outcome.host_seconds,
            "interrupted": outcome.interrupted,
            "time_overrun_seconds": overrun(request.args.time, self.clock.seconds.total),
            "stage_seconds": request.args.profile.then(stages),
            "device_idle": outcome.profile.idle,
            "kernels": self.loaded.as_ref().map_or(&[][..], |loaded| &loaded.kernels),
            "gpu_bytes": self.loaded.as_ref().map_or(0, |loaded| loaded.gpu_bytes),
        })));
        drop_absent(&mut report);
        Value::Object(report)
    }
}

/// The numerics of the first device.
fn numerics_of(devices: &[Device]) -> Result<&Numerics> {
    numerics(devices.first().ok_or_else(|| Error::Device("no device is open".to_string()))?)
}
