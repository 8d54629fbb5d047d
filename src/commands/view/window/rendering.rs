//! The thread that renders for the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use super::layers::{PictureLayer, Shown};
use super::link::{Link, Orders, PixelSurface};
use super::navigation::turn_around;
use crate::aov::{Aov, Aovs};
use crate::cli::ViewArgs;
use crate::commands::changes::Changes;
use crate::commands::render::args::{GoalArgs, MessageArgs};
use crate::commands::render::{Finish, RenderArgs, Series, error_words, frame_and_job, save};
use crate::commands::scene::{stem_of, tell_biases};
use crate::commands::signals::WAIT;
use crate::commands::view::args::WindowArgs;
use crate::commands::{tell, tell_error};
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::job::{Crop, Frame, Goal, Job, Size};
use crate::options::RenderOptions;
use crate::output::view_transform::ViewTransform;
use crate::render::{Next, Observer, Outcome, Snapshot};
use crate::scene::{Camera, Change, Scene, is_gltf};

/// The share of the image's width and height that the picture has while the camera moves, and its most pixels.
const SMALL: f64 = 0.25;
const SMALL_PIXELS: f64 = 262_144.0;
/// The time that such a picture may take beyond its first sample, in seconds.
const SMALL_TIME: f64 = 0.06;
/// The camera rests when it has not moved for this long.
const REST: Duration = Duration::from_millis(150);
/// The time that a submission should take: one that is under way is waited for.
const SUBMISSION: Duration = Duration::from_millis(20);
/// The time after which the window gets the samples so far.
const PAUSE: Duration = Duration::from_millis(500);
/// Kernels are those of a render that goes on for so many samples: short ones have others.
const MANY: u32 = 1 << 20;

/// Renders a scene as the window orders.
pub struct Rendering {
    link: Arc<Link>,
    args: RenderArgs,
    series: Series,
    /// The scene as it was read last.
    read: Scene,
    /// The job of the image.
    job: Job,
    /// The view that the session has: its revision, the part of the image, and its channels.
    viewed: Option<(u64, Frame, Aovs)>,
    /// The film of the image, and its revision.
    film: Option<(u64, Accumulation)>,
    failed: Option<u64>,
    /// Samples per second of small pictures and of the image; 0 before the first.
    small_pace: f64,
    pace: f64,
}

impl Rendering {
    /// Reads the scene and opens the devices.
    ///
    /// # Errors
    /// As of a render.
    pub fn open(args: &WindowArgs, link: Arc<Link>) -> Result<Rendering> {
        let args = args.clone().into_render();
        let mut series = new_series(&args);
        let read = series.load(&args)?;
        series.tell_warnings(&read.warnings(), false);
        tell_biases(&args.options, args.paths.max_depth, &read, false);
        let (_, job) = frame_and_job(&args, &read, Instant::now())?;
        let frame = small(job.size);
        series.session.view(&read, &frame, &args.options)?;
        series.tell_warnings(&Arc::clone(&series.session.scene).warnings, false);
        series.tell_devices(false);
        let (viewed, film, failed) = (Some((0, frame, args.options.aov.clone())), None, None);
        let own = Rendering { link, args, series, read, job, viewed, film, failed, small_pace: 0.0, pace: 0.0 };
        own.tell_scene();
        Ok(own)
    }

    /// Renders until the window ends.
    pub fn run(mut self) {
        // Changes of files wake the thread that makes this.
        self.series.changes = self.args.keep.watch.then(Changes::new);
        self.follow_files();
        let _ = self.link.renderer.set(thread::current());
        loop {
            let orders = self.link.orders();
            if orders.ends {
                return;
            }
            if self.series.changes.as_ref().is_some_and(Changes::have_changed) {
                self.read_again();
                continue;
            }
            match self.work(&orders) {
                Ok(()) | Err(Error::Dropped) => {}
                Err(error) => self.fail(&error, orders.revision),
            }
        }
    }

    /// Does what the orders want first.
    fn work(&mut self, orders: &Orders) -> Result<()> {
        if let PictureLayer::Of { aov, .. } = orders.layer
            && !self.args.options.aov.has(aov)
        {
            self.args.options.aov.include(&[aov]);
            self.film = None;
        }
        let revision = orders.revision;
        let film = self.film.as_ref().filter(|(of, _)| *of == revision).map(|(_, film)| film);
        let samples = film.map_or(0, |film| film.samples.count());
        let shown = self.link.state().shown.filter(|shown| shown.revision == revision);
        let is_at_rest = orders.moved.is_none_or(|moved| moved.elapsed() > REST);
        if self.failed == Some(revision) {
            thread::park_timeout(WAIT);
        } else if shown.is_none() {
            self.show_small(orders)?;
        } else if let Some(pixel) = orders.pixel {
            self.find(orders, pixel)?;
        } else if let Some(view) = orders.save.filter(|_| samples > 0) {
            self.save(orders, view)?;
        } else if samples > 0 && shown.is_some_and(|shown| shown.layer != orders.layer) {
            self.show_image(orders);
        } else if is_at_rest && (samples == 0 || !orders.paused) && samples < u64::from(self.job.goal.end()) {
            self.render_more(orders)?;
        } else {
            thread::park_timeout(WAIT);
        }
        Ok(())
    }

    /// The job of a view of this size.
    fn job_of(&self, size: (u32, u32), end: u32) -> Job {
        Job { size, goal: Goal::Samples(end), ..self.job.clone() }
    }

    /// Flattens the scene for a part of the image and these channels, and compiles what that needs, unless that has been done.
    fn view(&mut self, orders: &Orders, frame: Frame, aov: &Aovs) -> Result<()> {
        let view = (orders.revision, frame, aov.clone());
        let (size, options) = (frame.part.size(), RenderOptions { aov: aov.clone(), ..self.args.options.clone() });
        if self.viewed.as_ref() != Some(&view) {
            self.viewed = None;
            self.series.session.view(&self.scene(orders)?, &frame, &options)?;
            self.viewed = Some(view);
        }
        if self.series.session.is_ready() {
            return Ok(());
        }
        let job = self.job_of(size, MANY);
        self.series.session.prepare(&job, &mut Following::new(&self.link, orders, false))
    }

    /// The scene with the camera of the window.
    fn scene(&self, orders: &Orders) -> Result<Scene> {
        self.read.changed(&Change { camera: orders.camera.as_deref(), ..Change::default() })
    }

    /// The view of the image.
    fn view_image(&mut self, orders: &Orders) -> Result<()> {
        self.view(orders, Frame::full(self.job.size), &self.args.options.aov.clone())
    }

    /// Renders and shows a small picture. Orders that come meanwhile do not end it, so that a camera which never rests is seen.
    fn show_small(&mut self, orders: &Orders) -> Result<()> {
        let frame = small(self.job.size);
        self.view(orders, frame, &self.args.options.aov.clone())?;
        let begin = Instant::now();
        let count = ((self.small_pace * SMALL_TIME) as u32).clamp(1, RUN_LENGTH);
        let film = self.render(orders, frame, count)?;
        self.small_pace = f64::from(count) / begin.elapsed().as_secs_f64();
        self.show(orders, Shown { is_small: true, ..Shown::new(&film.film, orders.layer, None) });
        Ok(())
    }

    /// Renders a film of the session's view.
    fn render(&mut self, orders: &Orders, frame: Frame, count: u32) -> Result<Accumulation> {
        let size = frame.part.size();
        let (job, mut film) = (self.job_of(size, count), self.series.session.film(size)?);
        self.series.session.render(&job, &mut film, &mut Following::new(&self.link, orders, false))?;
        Ok(film)
    }

    /// Adds samples to the image for a while, and shows it.
    fn render_more(&mut self, orders: &Orders) -> Result<()> {
        self.view_image(orders)?;
        let kept = self.film.take().filter(|(of, _)| *of == orders.revision);
        let mut film = kept.map_or_else(|| self.series.session.film(self.job.size), |(_, film)| Ok(film))?;
        // A range of whole runs, so that the image is that of one render.
        let runs = (PAUSE.as_secs_f64() * self.pace) as u32 / RUN_LENGTH;
        let held = film.samples.range().end;
        let end = (held / RUN_LENGTH).saturating_add(runs.max(1)).saturating_mul(RUN_LENGTH).min(self.job.goal.end());
        let job = self.job_of(self.job.size, end);
        self.series.session.render(&job, &mut film, &mut Following::new(&self.link, orders, true))?;
        let new = film.samples.count().saturating_sub(held.into());
        self.pace = new as f64 / self.series.session.outcome.seconds.max(1e-9);
        self.film = Some((orders.revision, film));
        self.show_image(orders);
        Ok(())
    }

    fn show_image(&self, orders: &Orders) {
        let Some((_, film)) = &self.film else { return };
        let finish = Finish::new(film, None, false);
        let mut shown = Shown::new(&film.film, orders.layer, None);
        (shown.samples, shown.pace) = (film.samples.count(), self.pace);
        (shown.error, shown.reasons) = (error_words(&finish), finish.verdict.reasons_unreliable());
        self.show(orders, shown);
    }

    /// Hands a picture to the window.
    fn show(&self, orders: &Orders, mut shown: Shown) {
        shown.revision = orders.revision;
        self.link.tell(|state| (state.shown, state.errors) = (Some(Arc::new(shown)), Vec::new()));
    }

    /// Writes the image and its picture, under names that no file has.
    fn save(&mut self, orders: &Orders, view: ViewTransform) -> Result<()> {
        self.link.order(|orders| orders.save = None);
        self.view_image(orders)?;
        let Some((_, film)) = &self.film else { return Ok(()) };
        let exr = unused(&self.args.image().with_extension("exr"));
        let (mut args, png) = (self.args.clone(), exr.with_extension("png"));
        let message = format!("saved {} and {}", exr.display(), png.display());
        (args.files.output, args.files.png) = (Some(exr), Some(png));
        args.goal.image.spp = u32::try_from(film.samples.count()).ok();
        args.view = ViewArgs { exposure: view.exposure, tonemap: view.tonemap };
        let saved = save(&args, &self.scene(orders)?, &self.series.session, film);
        let message = saved.map_or_else(|error| format!("error: {error}"), |()| message);
        tell(&message);
        self.link.tell(|state| state.message = message);
        Ok(())
    }

    /// Finds what a pixel shows, by one sample of it.
    fn find(&mut self, orders: &Orders, (x, y): (u32, u32)) -> Result<()> {
        self.link.order(|orders| orders.pixel = None);
        let full = self.job.size;
        let part = Crop { left: x.min(full.0 - 1), top: y.min(full.1 - 1), width: 1, height: 1 };
        let mut aov = Aovs::default();
        aov.set(vec![Aov::Depth0, Aov::Distance0, Aov::Object, Aov::Material]);
        self.view(orders, Frame { part, full }, &aov)?;
        let film = self.render(orders, Frame { part, full }, 1)?;
        let channels = film.film.aovs().channels();
        let value = |aov| channels.iter().find(|channel| channel.aov == aov).map_or(0.0, |of| film.film.channel(0, of));
        // They count from 1.
        let name = |names: &[String], aov| names.get((value(aov) as usize).checked_sub(1)?).cloned();
        let view = &self.series.session.scene;
        let names = name(&view.object_names, Aov::Object).zip(name(&view.material_names, Aov::Material));
        let (distance, depth) = (value(Aov::Distance0), names.as_ref().map(|_| f64::from(value(Aov::Depth0))));
        let words = names.map_or("no surface".to_owned(), |(object, material)| {
            format!("{object}\nmaterial {material}\ndistance {distance:.6}")
        });
        let surface = PixelSurface { pixel: (x, y), words: format!("{x}, {y}: {words}"), depth };
        let turns = self.target() == Some(surface.pixel) && orders.camera.is_none();
        self.link.tell(|state| {
            depth.iter().filter(|_| turns).for_each(|depth| turn_around(&mut state.camera, *depth));
            state.surface = Some(surface);
        });
        Ok(())
    }

    /// The pixel in the middle, if the camera turns around what it shows: files of other programs have no target.
    fn target(&self) -> Option<(u32, u32)> {
        let is_imported = self.args.scene.path.extension().is_some_and(|ending| ending != "ron");
        is_imported.then_some((self.job.size.0 / 2, self.job.size.1 / 2))
    }

    /// Tells the window of a scene that has been read.
    fn tell_scene(&self) {
        let camera = Camera { moving: Vec::new(), ..self.read.camera.at(self.read.camera.shutter.0) };
        let (size, samples) = (self.job.size, u64::from(self.job.goal.end()));
        self.link.tell(|state| (state.camera, state.size, state.samples) = (camera, size, samples));
        self.link.order(|orders| orders.pixel = self.target().or(orders.pixel));
    }

    fn follow_files(&mut self) {
        let files = &self.series.assets.files;
        self.series.changes.iter_mut().for_each(|changes| changes.follow(files));
    }

    /// Reads the scene again. Where that fails, the picture stays.
    fn read_again(&mut self) {
        let ends = || self.link.orders().ends;
        if self.series.changes.as_ref().is_some_and(|changes| changes.wait(ends).is_none()) {
            return;
        }
        self.link.order(|orders| orders.revision += 1);
        let read = self.read();
        self.follow_files();
        read.unwrap_or_else(|error| self.fail(&error, self.link.orders().revision));
    }

    fn read(&mut self) -> Result<()> {
        let read = self.series.load(&self.args)?;
        (_, self.job) = frame_and_job(&self.args, &read, Instant::now())?;
        self.read = read;
        self.tell_scene();
        Ok(())
    }

    /// Shows an error. The next change tries again, with devices that open anew if one has failed.
    fn fail(&mut self, error: &Error, revision: u64) {
        self.failed = Some(revision);
        if self.series.session.devices.iter().any(|device| device.check().is_err()) {
            self.series.session = new_series(&self.args).session;
            (self.viewed, self.film) = (None, None);
        }
        tell_error(error);
        self.link.tell(|state| state.errors = error.messages());
    }
}

impl WindowArgs {
    fn into_render(self) -> RenderArgs {
        let WindowArgs { scene, output, image, paths, view, watch, mut options } = self;
        options.aov.complete(is_gltf(&scene.path));
        let messages = MessageArgs { quiet: true, ..MessageArgs::default() };
        let goal = GoalArgs { image, ..GoalArgs::default() };
        let mut args = RenderArgs { scene, goal, paths, view, options, messages, ..RenderArgs::default() };
        (args.files.output, args.keep.watch) = (output, watch);
        args
    }
}

fn new_series(args: &RenderArgs) -> Series {
    let mut series = Series::new(args);
    series.session = series.session.keeping_hierarchies();
    series.session.submission = Some(SUBMISSION);
    series
}

/// The small picture of an image of this size.
fn small((width, height): (u32, u32)) -> Frame {
    let share = (SMALL_PIXELS / (f64::from(width) * f64::from(height))).sqrt();
    Frame::full(Size::Share(share.min(SMALL)).in_pixels((width, height)))
}

/// This name, or the first one with a number that no file has: `scene.2.exr`.
fn unused(path: &Path) -> PathBuf {
    let stem = stem_of(path).to_string_lossy().into_owned();
    let numbered = (2..).map(|number| path.with_file_name(format!("{stem}.{number}.exr")));
    let is_unused = |path: &PathBuf| !path.exists() && !path.with_extension("png").exists();
    std::iter::once(path.to_owned()).chain(numbered).find(is_unused).unwrap_or_default()
}

/// Follows a render for the window.
struct Following<'a> {
    link: &'a Link,
    orders: &'a Orders,
    /// Whether the image is rendered, which ends with a change and is shown meanwhile. A small picture is not.
    is_of_image: bool,
    /// The picture that pixels without samples are filled from.
    before: Option<Arc<Shown>>,
    next: Instant,
}

impl Following<'_> {
    fn new<'a>(link: &'a Link, orders: &'a Orders, is_of_image: bool) -> Following<'a> {
        Following { link, orders, is_of_image, before: link.state().shown, next: Instant::now() + PAUSE / 2 }
    }
}

impl Observer for Following<'_> {
    fn compiling(&mut self, _: &[Arc<Device>]) -> Result<()> {
        self.link.tell(|state| state.is_compiling = true);
        if self.link.orders().ends { Err(Error::Dropped) } else { Ok(()) }
    }

    fn compiled(&mut self) {
        self.link.tell(|state| state.is_compiling = false);
    }

    fn follow(&mut self, _: &Outcome, snapshot: Option<Snapshot<'_>>) -> Next {
        let now = Instant::now();
        if let Some(snapshot) = snapshot {
            let mut shown = Shown::new(&snapshot.film.film, self.orders.layer, self.before.as_deref());
            shown.revision = self.orders.revision;
            // The error is that of the last complete runs.
            if let Some(before) = self.before.as_ref().filter(|before| before.revision == shown.revision) {
                (shown.error, shown.reasons) = (before.error.clone(), before.reasons.clone());
                (shown.pace, shown.samples) = (before.pace, before.samples);
            }
            self.link.tell(|state| state.shown = Some(Arc::new(shown)));
            self.next = now + PAUSE;
        }
        let orders = self.link.orders();
        let is_changed = orders.revision != self.orders.revision;
        let has_other_work = orders.paused || orders.pixel.is_some() || orders.save.is_some();
        match self.is_of_image {
            _ if orders.ends => Next::Drop,
            true if is_changed => Next::Drop,
            true if has_other_work || orders.layer != self.orders.layer => Next::Stop,
            true if now >= self.next => Next::Snapshot,
            _ => Next::GoOn,
        }
    }

    /// Goes on with an empty film.
    fn lost(&mut self, why: &Error, _: &DeviceScene, _: &[Arc<Device>], film: &Accumulation) -> Option<Accumulation> {
        let message = format!("{why}: the device is opened again");
        tell(&format!("warning: {message}"));
        self.link.tell(|state| state.message = message);
        let mut empty = film.clone();
        empty.clear();
        Some(empty)
    }
}
