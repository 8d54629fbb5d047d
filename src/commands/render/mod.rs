//! `gpu-rt render`: from a scene file to an image file.

mod changes;
mod denoising;
mod record;
mod resume;
mod session;
mod summary;
mod viewers;
mod watcher;

use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::denoise::Denoised;
use super::outputs::{Beside, EXR, EXR_OR_PNG, OutputImage, PNG, check_outputs};
use super::scene::stem_of;
use super::signals::Signals;
use super::{open_devices, print_json, size_of, tell, tell_biases, tell_software};
use crate::cli::{CHECKPOINT, OIDN, PathArgs, SceneArgs, ViewArgs, duration, relative_error, sample_range};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::flatten::{DeviceScene, flatten, flatten_again};
use crate::gpu::device::{AdapterName, Device};
use crate::gpu::probe::numerics;
use crate::identity::Identity;
use crate::job::{Crop, Frame, Goal, Job, MOST_SAMPLES};
use crate::options::{Class, DENOISE, DenoiseArg, RenderOptions, SizeArg, SppArg};
use crate::output::exr::{State, read_state, write_render};
use crate::output::format::{Format, format_of};
use crate::output::place::{Place, is_standard};
use crate::output::png::write_png;
use crate::output::progress::Progress;
use crate::output::view_transform::ViewTransform;
use crate::plan::Plan;
use crate::render::{Outcome, Renderer};
use crate::scene::{Camera, Scene};
use crate::threads::beside;
use changes::Changes;
use denoising::{Denoising, WANTED, beside as denoised_beside, picture_beside};
use record::{About, report};
pub use record::{Finish, attributes_of, excluded};
use resume::Accumulation;
use session::Session;
pub use summary::{doubts, error_words, noise_words};
use summary::{rejected_words, summarise};
use viewers::Viewers;
use watcher::{Watcher, look_time, pause_after};

#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The image to write: a linear .exr, or a .png, which is the picture alone and cannot be resumed. - is a PNG on standard output
    /// [default: the scene's name with .exr, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also write a tone-mapped picture, - for standard output.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[command(flatten)]
    pub spp: SppArg,
    /// Sample indices A to B - 1 of each pixel, to split a render over machines.
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with_all = ["spp", "time"])]
    pub samples: Option<Range<u32>>,
    /// Render for this time, counted from the start of the program [30s, 5m, …]: at least one sample per pixel, at most
    /// --spp if given.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    /// Render until the relative error is below this with 95 % confidence, such as 0.01 for 1 %: 16, 32, 64 … samples,
    /// limited by --spp and --time if given.
    #[arg(long, value_name = "E", value_parser = relative_error, conflicts_with = "samples")]
    pub noise: Option<f64>,
    #[command(flatten)]
    pub size: SizeArg,
    /// Render only a part of the image: WIDTH x HEIGHT pixels, from column X and row Y on, with the bytes of the whole image.
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub crop: Option<Crop>,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub view: ViewArgs,
    #[command(flatten)]
    pub denoise: DenoiseArg,
    #[arg(long, value_name = "FOLDER", requires = "denoise", help = OIDN, help_heading = DENOISE.class.heading())]
    pub oidn: Option<PathBuf>,
    /// Draw the image so far, about once a second, and the image at the end in the terminal, as --exposure and --tonemap have it.
    #[arg(long)]
    pub preview: bool,
    /// Send the image so far, about once a second, and the image at the end to a viewer: tev, which listens on 127.0.0.1:14158.
    #[arg(long, value_name = "HOST:PORT", value_parser = host_and_port)]
    pub display_server: Option<String>,
    /// Write the image so far at this interval, and the PNG too [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = CHECKPOINT)]
    pub checkpoint: Duration,
    /// Go on with the render in the output, and fail if there is none; --resume=auto starts afresh then. The image is that of one render.
    #[arg(long, value_name = "auto", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = parse_resume)]
    pub resume: Option<Resume>,
    /// Render again whenever the scene or one of its files is saved, until Ctrl-C: a quarter of the size, a half, then all of it.
    #[arg(long, conflicts_with_all = ["samples", "resume", "json", "denoise"])]
    pub watch: bool,
    /// Render with several devices or drivers, or go on with another one, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    /// Leave out of the EXR what --resume and `merge` need.
    #[arg(long)]
    pub no_state: bool,
    /// Overwrite an image of this render that has more samples.
    #[arg(long)]
    pub force: bool,
    /// Fail if a sample was not finite and therefore rejected.
    #[arg(long)]
    pub strict: bool,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Also say what the stated error excludes.
    #[arg(long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print one JSON object on stdout at the end.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Measure the seconds of each stage on the device; each dispatch then needs a pass of its own.
    #[arg(long, help_heading = Class::Exact.heading())]
    pub profile: bool,
}

impl RenderArgs {
    /// Whether the image is denoised at the end.
    pub fn denoise(&self) -> bool {
        self.denoise.0 == Some(true)
    }
}

/// What `--resume` does where there is nothing to resume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// It fails.
    Yes,
    /// The render starts afresh.
    Auto,
}

fn parse_resume(text: &str) -> std::result::Result<Resume, String> {
    match text {
        "yes" => Ok(Resume::Yes),
        "auto" => Ok(Resume::Auto),
        _ => Err("expected --resume or --resume=auto".to_string()),
    }
}

fn host_and_port(text: &str) -> std::result::Result<String, String> {
    match text.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0) => Ok(text.to_owned()),
        _ => Err("expected HOST:PORT, such as 127.0.0.1:14158".to_string()),
    }
}

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
    /// A part of the rendering: for one sample of every pixel. It tells the pace also of a render that goes on with an earlier one, and of
    /// one that is under way.
    per_sample: f64,
}

/// The seconds of one of so many samples; 0, which is not known, of none.
fn per_sample(seconds: f64, samples: u64) -> f64 {
    if samples == 0 { 0.0 } else { seconds / samples as f64 }
}

/// Under `--watch`: the time that a submission should take, since the one that is under way is waited for.
const SOON: Duration = Duration::from_millis(30);
/// Under `--watch`: the most between two checkpoints, unless they would take too long.
const WATCHED: Duration = Duration::from_secs(2);

/// Where the image goes: into an EXR, a PNG or both.
struct Output<'a> {
    /// What `-o` names: the EXR, or the PNG where there is no EXR.
    image: PathBuf,
    /// What of the two it is. A PNG has no state: nothing can go on from it.
    format: Format,
    /// Whether a later image can replace it. A pipe gets one image, at the end.
    can_be_replaced: bool,
    /// The picture beside the EXR.
    png: Option<&'a Path>,
    view: ViewTransform,
}

impl Output<'_> {
    /// The path of the EXR, which may have a state.
    fn exr(&self) -> Option<&Path> {
        (self.format == Format::Exr).then_some(&*self.image)
    }
}

/// Renders the scene as asked, once or whenever it changes.
pub fn run(args: &RenderArgs, start: Instant) -> Result<()> {
    Viewers::check(args)?;
    if args.watch {
        return session::watch(args, start);
    }
    let mut session = Session::default();
    let scene = session.load(args)?;
    if args.denoise() {
        let mut args = args.clone();
        args.options.aov.include(&WANTED);
        return render(&args, &scene, &mut session, start);
    }
    render(args, &scene, &mut session, start)
}

/// Renders a scene, writing the image now and then and at the end. `start` is when it began to be loaded.
fn render(args: &RenderArgs, scene: &Scene, session: &mut Session, start: Instant) -> Result<()> {
    let Session { devices, signals, changes, compile, told, hierarchies, .. } = session;
    let mut clock = Clock(start);
    let mut seconds = Seconds::default();
    // As `check` has them; --quiet leaves them to the report and the image's header.
    let mut warnings = scene.warnings();
    let tell_warnings = |warnings: &[String]| {
        if !args.quiet {
            warnings.iter().for_each(|warning| tell(&format!("warning: {warning}")));
        }
    };
    tell_warnings(&warnings);
    let biases = tell_biases(&args.options, args.paths.max_depth.0, scene, args.quiet);
    let output = output_of(args, scene)?;
    let denoising = Denoising::of(args, &output)?;
    seconds.load = clock.lap();

    let size = size_of(scene, args.size.0);
    // The driver loads while the scene is built; `device` is the time that it takes beyond. A scene that does not load waits for no driver.
    let opening = || match devices.is_empty() {
        true => open_devices(args.paths.device.as_deref()),
        false => Ok(Vec::new()),
    };
    let (opened, built) = beside(opening, || {
        let built = match hierarchies {
            Some(hierarchies) => flatten_again(scene, size, &args.options, hierarchies),
            None => flatten(scene, size, &args.options),
        };
        seconds.build = clock.lap();
        built
    });
    let mut flat = built?;
    let frame = frame_of(args, size)?;
    (flat.settings.film_left, flat.settings.film_top) = (frame.part.left, frame.part.top);
    let job = job_of(args, scene, frame.part.size(), start);
    let identity = LazyLock::new(|| Identity::of(scene, &frame, &job, &args.options));
    let earlier = match output.exr() {
        Some(exr) => resume::earlier(args, exr, &identity, &job)?,
        None => None,
    };
    tell_warnings(&flat.warnings);
    warnings.extend_from_slice(&flat.warnings);
    devices.extend(opened?);
    for (number, device) in devices.iter().enumerate() {
        let is_told = devices.iter().take(number).any(|other| other.name == device.name);
        tell_software(device, args.quiet || is_told || *told);
    }
    *told |= !args.quiet;
    seconds.device = clock.lap();

    let mut film = match &earlier {
        Some(state) => Accumulation::of_file(&output.image, state)?,
        None => Accumulation::new(frame, &flat, &args.options)?,
    };
    film.note_devices(names_of(devices), &output.image, args.mixed_drivers)?;
    let resumed_from = earlier.as_ref().map(|state| state.samples.count());
    let signals = signals.get_or_insert_with(|| {
        Signals::listen(&match resumed_from {
            Some(_) => format!("{} holds what it held before", output.image.display()),
            None => "nothing has been written".to_owned(),
        })
    });
    let progress = Progress::new(args.quiet, &job, resumed_from.unwrap_or(0));
    let task = Task {
        args,
        camera: &scene.camera,
        flat: &flat,
        frame,
        output: &output,
        identity: &identity,
        job: &job,
        biases: &biases,
        warnings: &warnings,
        signals,
        changes: changes.as_ref(),
        progress: &progress,
        resumed_from,
    };
    let viewers = Viewers::open(args, output.image.display().to_string(), job.size);
    let mut rendering = Rendering { viewers, ..Rendering::default() };
    // Hashing a large scene takes as long as reading it; the hashes are needed when something is written.
    let hashing = || _ = LazyLock::force(&identity);
    let ((), mut rendered) =
        beside(hashing, || task.render(devices, &mut film, &mut rendering, &mut seconds, &mut clock));
    if let Err(Error::Device(why)) = &rendered
        && rendering.started
        && !signals.came()
    {
        progress.message(&format!("warning: {why}; the device is opened once more"));
        let again =
            task.last_whole(&rendering).and_then(|last| Ok((last, open_devices(args.paths.device.as_deref())?)));
        // Where that fails too, the first failure is the one to tell.
        if let Ok((last, other)) = again {
            (film, *devices) = (last, other);
            film.note_devices(names_of(devices), &output.image, args.mixed_drivers)?;
            rendered = task.render(devices, &mut film, &mut rendering, &mut seconds, &mut clock);
        }
    }
    progress.finish();
    *compile = seconds.compile;
    seconds.render = clock.lap();

    let about = task.about(devices)?;
    let outcome = std::mem::take(&mut rendering.outcome);
    let complete = rendered.is_ok() && !outcome.interrupted;
    seconds.per_sample = per_sample(outcome.seconds, film.samples.count().saturating_sub(resumed_from.unwrap_or(0)));
    let finish = Finish::of(&film.film, &film.samples, &film.devices, outcome.noise, complete);
    match rendered {
        Ok(()) => match task.write(&about, &film, &finish, &seconds, &mut rendering) {
            Err(error) if outcome.interrupted => return Err(signals.interrupted(&error.to_string())),
            written => written?,
        },
        Err(error) => return Err(task.failed(&about, &film, &finish, &seconds, &rendering, error)),
    }
    seconds.write = clock.lap();
    if let Some((denoising, exr)) = denoising.as_ref().zip(output.exr()).filter(|_| complete) {
        rendering.denoised = Some(denoising.write(exr, args.quiet)?);
    }

    // The report has the passes alone, from the first to the last.
    seconds.render = outcome.seconds;
    seconds.first_pass = outcome.first_pass;
    seconds.total = start.elapsed().as_secs_f64();
    rendering.viewers.end(&film.film, &progress);
    if !args.quiet {
        summarise(&about, &output, &outcome, &finish, rendering.stays, seconds.total);
    }
    if args.json {
        print_json(&json!(report(&about, &output, &outcome, &finish, &seconds, &rendering)))?;
    }
    if finish.totals.paths > 0 && finish.totals.rejected.total() >= finish.totals.paths {
        let words = rejected_words(&finish.totals);
        return Err(Error::Strict(format!("the image is black: {words}. `gpu-rt check` may say why")));
    }
    if args.strict && finish.totals.rejected.total() > 0 {
        return Err(Error::Strict(format!("--strict: {}", rejected_words(&finish.totals))));
    }
    match outcome.interrupted {
        true => Err(signals.interrupted(&task.what_is_kept(film.samples.count()))),
        false => Ok(()),
    }
}

/// What stays the same while a render is tried on a device, and once more on another.
struct Task<'a> {
    args: &'a RenderArgs,
    camera: &'a Camera,
    flat: &'a DeviceScene,
    frame: Frame,
    output: &'a Output<'a>,
    identity: &'a (dyn Deref<Target = Identity> + Sync),
    job: &'a Job,
    biases: &'a [String],
    warnings: &'a [String],
    signals: &'a Signals,
    /// What would end the render, because nobody wants its image.
    changes: Option<&'a Changes>,
    progress: &'a Progress,
    /// Samples of a pixel that an earlier render has left.
    resumed_from: Option<u64>,
}

/// What has come of the tries.
#[derive(Default)]
struct Rendering {
    outcome: Outcome,
    /// The names of the kernels, and the bytes of the buffers.
    kernels: Vec<String>,
    gpu_bytes: u64,
    /// Whether the device has begun to render.
    started: bool,
    /// Whether the file has a checkpoint of this render.
    kept: bool,
    /// The samples of each pixel that the file has, if it stays as it was because these are more.
    stays: Option<u64>,
    denoised: Option<Denoised>,
    viewers: Viewers,
}

impl Task<'_> {
    fn about<'b>(&'b self, devices: &'b [Device]) -> Result<About<'b>> {
        let Task { args, camera, job, biases, warnings, resumed_from, .. } = self;
        let first = devices.first().ok_or_else(|| Error::Device("no device is open".to_string()))?;
        let (numerics, resumed_from) = (numerics(first)?, *resumed_from);
        let (identity, materials) = (&**self.identity, self.flat.material_names.as_slice());
        Ok(About { args, camera, identity, devices, numerics, job, biases, warnings, resumed_from, materials })
    }

    /// Renders what the film lacks.
    fn render(
        &self,
        devices: &[Device],
        film: &mut Accumulation,
        rendering: &mut Rendering,
        seconds: &mut Seconds,
        clock: &mut Clock,
    ) -> Result<()> {
        rendering.outcome.noise = film.noise_reached(self.job);
        let jobs = film.jobs(self.job, rendering.outcome.noise);
        let Some(first) = jobs.first() else { return Ok(()) };
        // The device keeps what its probe finds; an error comes again where the findings are asked for.
        let probe = || devices.iter().all(|device| numerics(device).is_ok());
        let plan = |device: &Device| Plan::new(self.flat, &self.args.options, device.class(), first);
        let (_, plans) = beside(probe, || devices.iter().map(plan).collect::<Result<Vec<_>>>());
        let plans = plans?;
        let pairs: Vec<_> = devices.iter().zip(&plans).collect();
        let mut renderer = Renderer::of_devices(&pairs, first, self.args.profile)?;
        let kernels = plans.iter().take(1).flat_map(Plan::kernels);
        rendering.kernels = kernels.map(|kernel| kernel.name.clone()).collect();
        rendering.gpu_bytes = plans.iter().flat_map(Plan::buffers).map(|buffer| buffer.allocated()).sum();
        seconds.compile += clock.lap();
        if self.changes.is_some() {
            renderer.ask_every(SOON);
        }

        let about = self.about(devices)?;
        for job in &jobs {
            let Accumulation { film: pixels, samples, looks, devices } = &mut *film;
            let (begun, earlier) = (Instant::now(), samples.count());
            let mut watcher = Watcher {
                progress: self.progress,
                signals: self.signals,
                begun,
                pixels: u64::from(job.size.0) * u64::from(job.size.1),
                earlier,
                next_look: (!self.args.quiet || rendering.viewers.any())
                    .then(|| begun + pause_after(look_time(job.size))),
                next_checkpoint: self.output.can_be_replaced.then(|| begun + self.checkpoint()),
                interval: self.checkpoint(),
                changes: self.changes,
                error: None,
                until: None,
                goal: job.goal,
                failed: None,
                kept: false,
                told: false,
                checkpoint: &|film, outcome| {
                    let mut samples = samples.clone();
                    samples.join(&outcome.samples);
                    let looks = outcome.noise.map_or(*looks, |noise| noise.looks);
                    let finish = Finish::of(film, &samples, devices, outcome.noise, false);
                    let pace =
                        per_sample(begun.elapsed().as_secs_f64(), finish.samples.count().saturating_sub(earlier));
                    self.keep(&about, film, looks, &finish, &Seconds { per_sample: pace, ..*seconds })?;
                    let image = self.output.image.display();
                    self.signals.set_loss(format!("{image} holds the last checkpoint; what came since is lost"));
                    Ok(())
                },
                picture: &|film| self.show_checkpoint(film),
                viewers: &mut rendering.viewers,
            };
            rendering.started = true;
            let outcome = renderer.run(job, pixels, &mut |outcome, look| watcher.watch(outcome, look));
            rendering.kept |= watcher.kept;
            let outcome = outcome?;
            samples.join(&outcome.samples);
            *looks = outcome.noise.map_or(*looks, |noise| noise.looks);
            rendering.outcome.join(outcome);
            if rendering.outcome.interrupted {
                break;
            }
        }
        Ok(())
    }

    /// The interval of checkpoints. Who watches wants one soon.
    fn checkpoint(&self) -> Duration {
        match self.changes {
            Some(_) => self.args.checkpoint.min(WATCHED),
            None => self.args.checkpoint,
        }
    }

    /// Writes the image that `-o` names. It is an error if that is an EXR with more samples of this render, which another process may have
    /// put there meanwhile.
    fn keep(&self, about: &About<'_>, film: &Film, looks: u32, finish: &Finish, seconds: &Seconds) -> Result<()> {
        let Some(exr) = self.output.exr() else { return self.write_picture(&self.output.image, film) };
        let Finish { samples, devices, .. } = finish;
        let state = State::new(Identity::clone(self.identity), devices.clone(), film, samples.clone(), looks);
        let mine = samples.count();
        let may = || match resume::more_there(exr, self.identity, mine).filter(|_| !self.args.force) {
            None => Ok(()),
            Some(more) => Err(format!(
                "it holds {more} samples per pixel of this render, more than the {mine} here: it stays. --force overwrites it"
            )),
        };
        let attributes = about.record(finish, seconds).attributes();
        write_render(exr, film, &attributes, (!self.args.no_state).then_some(&state), may)
    }

    /// Writes what the render came to. Where the EXR has more samples of it than a complete one, it stays: how many samples `--time` and
    /// `--noise` take is known only now.
    fn write(
        &self,
        about: &About<'_>,
        film: &Accumulation,
        finish: &Finish,
        seconds: &Seconds,
        rendering: &mut Rendering,
    ) -> Result<()> {
        let exr = self.output.exr().filter(|_| finish.complete && !self.args.force);
        rendering.stays = exr.and_then(|exr| resume::more_there(exr, self.identity, finish.samples.count()));
        if rendering.started && rendering.stays.is_none() {
            self.keep(about, &film.film, film.looks, finish, seconds)?;
        }
        self.signals.set_loss(format!("{} holds the image", self.output.image.display()));
        self.show(&film.film)
    }

    /// Writes the picture beside the EXR, if one is asked for.
    fn show(&self, film: &Film) -> Result<()> {
        self.output.png.map_or(Ok(()), |png| self.write_picture(png, film))
    }

    /// The same at a checkpoint. A pipe gets one picture, at the end.
    fn show_checkpoint(&self, film: &Film) -> Result<()> {
        if self.output.png.is_some_and(can_be_replaced) { self.show(film) } else { Ok(()) }
    }

    fn write_picture(&self, png: &Path, film: &Film) -> Result<()> {
        write_png(png, self.job.size, &|index| film.developed(index).rgb, &self.output.view)
    }

    /// The EXR, if it holds a checkpoint of this render, or what it goes on with.
    fn in_file(&self, rendering: &Rendering) -> Option<&Path> {
        self.output.exr().filter(|_| rendering.kept || self.resumed_from.is_some())
    }

    /// The film as it was when it was last whole: that of the file, or an empty one.
    fn last_whole(&self, rendering: &Rendering) -> Result<Accumulation> {
        let kept = self.in_file(rendering).map(|exr| Ok((exr, read_state(exr)?))).transpose()?;
        match kept {
            Some((exr, Some(state))) => Accumulation::of_file(exr, &state),
            _ => Accumulation::new(self.frame, self.flat, &self.args.options),
        }
    }

    /// Keeps what there is where the device has failed for good. The error says what that is.
    fn failed(
        &self,
        about: &About<'_>,
        film: &Accumulation,
        finish: &Finish,
        seconds: &Seconds,
        rendering: &Rendering,
        error: Error,
    ) -> Error {
        let Error::Device(why) = error else { return error };
        let image = self.output.image.display();
        if let Some(exr) = self.in_file(rendering) {
            let held = read_state(exr).ok().flatten().map_or(0, |state| state.samples.count());
            return Error::Device(format!("{why}; {}", self.what_is_kept(held)));
        }
        // A film with runs under way left out favours short paths. Nothing can go on from it.
        if film.film.totals().paths > 0 {
            let attributes = about.record(finish, seconds).attributes();
            let written = match self.output.exr() {
                Some(exr) => write_render(exr, &film.film, &attributes, None, || Ok(())),
                None => self.write_picture(&self.output.image, &film.film),
            };
            let written = written.and_then(|()| self.show(&film.film));
            return Error::Device(match written {
                Ok(()) => format!("{why}; {image} holds what there was, and cannot be resumed"),
                Err(error) => format!("{why}; {error}"),
            });
        }
        Error::Device(why)
    }

    /// What the file holds, and how to go on.
    fn what_is_kept(&self, samples: u64) -> String {
        let image = self.output.image.display();
        match self.output.exr().is_none() || self.args.no_state || samples == 0 || !self.output.can_be_replaced {
            true => format!("{image} holds the image so far"),
            false if self.args.watch => {
                format!("{image} holds {samples} samples per pixel. --resume in place of --watch goes on")
            }
            false => format!("{image} holds {samples} samples per pixel. Add --resume to go on"),
        }
    }
}

/// The names of devices.
fn names_of(devices: &[Device]) -> impl Iterator<Item = &AdapterName> {
    devices.iter().map(|device| &device.name)
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

/// Whether a later image can replace what is there.
fn can_be_replaced(path: &Path) -> bool {
    !matches!(Place::of(path), Ok(Place::Stream))
}

/// The image to write.
fn image_of(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| exr_of_scene(args))
}

/// The scene's name with .exr, in the current folder.
fn exr_of_scene(args: &RenderArgs) -> PathBuf {
    PathBuf::from(stem_of(&args.scene.path)).with_added_extension("exr")
}

/// The paths to write to, checked before anything costs time.
fn output_of<'a>(args: &'a RenderArgs, scene: &Scene) -> Result<Output<'a>> {
    let image = image_of(args);
    let png = args.png.as_deref();
    // A name that says no format is refused below.
    let format = format_of(&image, EXR_OR_PNG).unwrap_or(Format::Exr);
    let first = OutputImage { option: "-o", path: &image, formats: EXR_OR_PNG };
    let second = png.map(|path| OutputImage { option: "--png", path, formats: PNG });
    let denoised = args.denoise().then(|| denoised_beside(&image));
    let denoised_png = png.filter(|_| args.denoise()).and_then(picture_beside);
    let third = denoised.as_ref().map(|path| OutputImage { option: "-o", path, formats: EXR });
    let fourth = denoised_png.as_ref().map(|path| OutputImage { option: "--png", path, formats: PNG });
    let can_be_replaced = can_be_replaced(&image);
    if args.denoise() && (format == Format::Png || !can_be_replaced) {
        return Err(Error::Usage(format!(
            "{}: --denoise reads the EXR that the render writes: give -o {}; nothing has been rendered",
            image.display(),
            exr_of_scene(args).display()
        )));
    }
    let images: Vec<OutputImage<'_>> = std::iter::once(first).chain(second).chain(third).chain(fourth).collect();
    let stdout = args.json.then_some("the report of --json");
    check_outputs(&images, &Beside { inputs: &scene.inputs(), stdout, undone: "nothing has been rendered" })?;
    if format == Format::Png {
        let refuse = |why: &str| {
            let exr = if is_standard(&image) { exr_of_scene(args) } else { image.with_extension("exr") };
            let (name, exr) = (image.display(), exr.display());
            Err(Error::Usage(format!("{name}: {why}: give -o {exr} --png {name}; nothing has been rendered")))
        };
        if !args.options.aov.is_empty() {
            return refuse("a PNG has no room for the channels of --aov");
        }
        if args.resume.is_some() {
            return refuse("a PNG cannot be resumed, and --resume goes on from an EXR");
        }
        if png.is_some() {
            return refuse("-o and --png are both a PNG");
        }
    }
    Ok(Output { image, format, can_be_replaced, png, view: args.view.transform() })
}

/// The part of an image of this size that is asked for.
fn frame_of(args: &RenderArgs, whole: (u32, u32)) -> Result<Frame> {
    let part = args.crop.unwrap_or(Crop::whole(whole));
    match part.is_in(whole) {
        true => Ok(Frame { part, whole }),
        false => Err(Error::Usage(format!(
            "--crop {part}: expected a part of the image, which has {} x {} pixels",
            whole.0, whole.1
        ))),
    }
}

fn job_of(args: &RenderArgs, scene: &Scene, size: (u32, u32), start: Instant) -> Job {
    let samples = args.samples.clone().unwrap_or(0..args.spp.0.unwrap_or(scene.render.samples));
    let deadline = args.time.map(|time| start + time.saturating_sub(write_time(size, args)));
    let end = args.spp.0.unwrap_or(MOST_SAMPLES as u32);
    let goal = match (args.noise, deadline) {
        (None, None) => Goal::Samples(samples.end),
        (None, Some(deadline)) => Goal::Until { deadline, end },
        (Some(error), deadline) => Goal::Noise { error, deadline, end, begun: samples.start, looks: 0 },
    };
    Job {
        size,
        max_depth: args.paths.max_depth.0.unwrap_or(scene.render.max_depth),
        seed: args.paths.seed,
        first_sample: samples.start,
        goal,
    }
}

/// What developing and writing the image is allowed for under `--time`: measured as 0.15 to 0.5 µs a pixel on two cores, and 0.5 to 0.6 µs more
/// with the state; denoising takes 5 µs.
fn write_time((width, height): (u32, u32), args: &RenderArgs) -> Duration {
    let state = if args.no_state { 0 } else { 600 };
    let denoise = if args.denoise() { 5000 } else { 0 };
    let pixels = u64::from(width) * u64::from(height);
    Duration::from_nanos(pixels * (500 + state + denoise)) + Duration::from_millis(20)
}
