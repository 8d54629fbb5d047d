//! The thread that renders what the window wants.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use super::layers::{Layer, Shown};
use super::link::{Link, Orders, Surface};
use crate::aov::Aov;
use crate::cli::ViewArgs;
use crate::commands::changes::Changes;
use crate::commands::render::args::{GoalArgs, MessageArgs};
use crate::commands::render::{Finish, RenderArgs, Seconds, Series, error_words, per_sample, save};
use crate::commands::scene::{size_of, stem_of, tell_biases};
use crate::commands::signals::WAIT;
use crate::commands::view::args::WindowArgs;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::job::{Crop, Frame, Goal, Job, Size};
use crate::options::RenderOptions;
use crate::render::{Next, Observer, Outcome, Snapshot, empty_film};
use crate::scene::{Assets, Camera, Change, Scene, is_gltf};

/// The share of the image's width and height that the picture has while the camera moves, and its most pixels.
const SMALL: f64 = 0.25;
const SMALL_PIXELS: f64 = 262_144.0;
/// The time that such a picture may take beyond its first sample.
const SMALL_TIME: f64 = 0.06;
/// The camera rests when it has not moved for this long.
const REST: Duration = Duration::from_millis(150);
/// The time that a submission should take: one that is under way is waited for.
const SUBMISSION: Duration = Duration::from_millis(20);
/// The time after which the window gets the samples so far. The first pictures come sooner.
const PAUSE: Duration = Duration::from_millis(500);
/// Kernels are those of a render that goes on for so many samples: short ones have others.
const MANY: u32 = 1 << 20;

/// The thread's side of the window.
pub struct Rendering {
    link: Arc<Link>,
    args: RenderArgs,
    series: Series,
    /// As it was read last, and with the camera of the window.
    read: Scene,
    scene: Scene,
    reads: u64,
    /// The view of the session: its revision, and the part of the image that it renders.
    viewed: Option<(u64, Frame)>,
    /// The film of the image, and its revision.
    film: Option<(u64, Accumulation)>,
    /// The revision and the layer that the window shows.
    shown: Option<(u64, Layer)>,
    /// The revision that has failed.
    failed: Option<u64>,
    /// Small pictures: samples per second.
    pace: f64,
    seconds: Seconds,
}

/// The next thing to do.
enum Task {
    /// A small picture of a new view.
    Small,
    /// More samples of the image.
    More,
    Show,
    Save,
    Find((u32, u32)),
    Rest,
}

impl Rendering {
    /// Reads the scene and opens the devices.
    ///
    /// # Errors
    /// As of a render.
    pub fn open(args: &WindowArgs, link: Arc<Link>) -> Result<Rendering> {
        let args = args.clone().into_render();
        let mut series = Series { assets: Assets::of_frames(), ..Series::new(&args) };
        series.session = series.session.keeping_hierarchies();
        series.session.submission = Some(SUBMISSION);
        series.changes = args.keep.watch.then(Changes::new);
        let begin = Instant::now();
        let read = series.load(&args)?;
        series.tell_warnings(&read.warnings(), false);
        tell_biases(&args.options, args.paths.max_depth, &read, false);
        let seconds = Seconds { load: begin.elapsed().as_secs_f64(), ..Seconds::default() };
        let (scene, pace) = (read.clone(), 0.0);
        let (viewed, film, shown, failed) = (None, None, None, None);
        let mut own =
            Rendering { link, args, series, read, scene, reads: 0, viewed, film, shown, failed, pace, seconds };
        own.take_scene();
        own.view(&Orders::default(), own.small())?;
        own.series.tell_warnings(&own.series.session.scene.warnings.clone(), false);
        own.series.tell_devices(false);
        Ok(own)
    }

    /// Renders until the window ends.
    pub fn run(mut self) {
        // Files wake the thread that has made this.
        if self.series.changes.is_some() {
            self.series.changes = Some(Changes::new());
            self.follow_files();
        }
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
                Err(error) => self.fail(&error, &orders),
            }
        }
    }

    fn work(&mut self, orders: &Orders) -> Result<()> {
        if let Layer::Of { aov, .. } = orders.layer
            && !self.args.options.aov.has(aov)
        {
            self.args.options.aov.include(&[aov]);
            (self.viewed, self.film) = (None, None);
        }
        match self.task(orders) {
            Task::Small => self.show_small(orders),
            Task::More => self.render_more(orders),
            Task::Show => {
                let shown = self.film.take();
                let told = shown.iter().try_for_each(|(_, film)| self.show(orders, film, false));
                self.film = shown;
                told
            }
            Task::Save => self.save(orders),
            Task::Find(pixel) => self.find(orders, pixel),
            Task::Rest => {
                self.link.tell(|findings| findings.activity.clear());
                thread::park_timeout(WAIT);
                Ok(())
            }
        }
    }

    /// What the orders want first.
    fn task(&self, orders: &Orders) -> Task {
        let revision = orders.revision;
        let film = self.film.as_ref().filter(|(of, _)| *of == revision).map(|(_, film)| film);
        let is_at_rest = orders.moved.is_none_or(|moved| moved.elapsed() > REST);
        let has_samples = film.is_some_and(|film| !film.samples.is_empty());
        match () {
            () if self.failed == Some(revision) => Task::Rest,
            () if self.shown.is_none_or(|(of, _)| of != revision) => Task::Small,
            () if orders.pixel.is_some() => Task::Find(orders.pixel.unwrap_or_default()),
            () if orders.save.is_some() && has_samples => Task::Save,
            () if self.shown != Some((revision, orders.layer)) && has_samples => Task::Show,
            () if !is_at_rest || (orders.paused && has_samples) => Task::Rest,
            () if film.is_none_or(|film| film.samples.count() < u64::from(self.samples())) => Task::More,
            () => Task::Rest,
        }
    }

    /// The size of the image.
    fn full(&self) -> (u32, u32) {
        size_of(&self.read, self.args.goal.size)
    }

    fn small(&self) -> Frame {
        let (width, height) = self.full();
        let share = (SMALL_PIXELS / (f64::from(width) * f64::from(height))).sqrt();
        Frame::full(Size::Share(share.min(SMALL)).in_pixels((width, height)))
    }

    /// The samples of a pixel, at the end.
    fn samples(&self) -> u32 {
        self.args.goal.spp.unwrap_or(self.read.render.samples)
    }

    fn job(&self, size: (u32, u32), end: u32) -> Job {
        let max_depth = self.args.paths.max_depth.unwrap_or(self.read.render.max_depth);
        Job { size, max_depth, seed: self.args.paths.seed, first_sample: 0, goal: Goal::Samples(end) }
    }

    /// Flattens the scene for a part of the image, and compiles what that needs.
    fn view(&mut self, orders: &Orders, frame: Frame) -> Result<()> {
        let options = self.args.options.clone();
        self.view_with(orders, frame, &options)
    }

    fn view_with(&mut self, orders: &Orders, frame: Frame, options: &RenderOptions) -> Result<()> {
        self.viewed = None;
        self.scene = self.read.changed(&Change { camera: orders.camera.as_deref(), ..Change::default() })?;
        self.series.session.view(&self.scene, &frame, options)?;
        self.viewed = Some((orders.revision, frame));
        Ok(())
    }

    /// Compiles what the view needs for a size.
    fn prepare(&mut self, orders: &Orders, size: (u32, u32)) -> Result<()> {
        let job = self.job(size, MANY);
        let mut following = Following::new(&self.link, orders, (&self.args.options, size));
        self.series.session.prepare(&job, &mut following)
    }

    /// Renders and shows a small picture. Orders that come meanwhile do not end it, so that a camera which never rests is seen.
    fn show_small(&mut self, orders: &Orders) -> Result<()> {
        let frame = self.small();
        self.view(orders, frame)?;
        let size = frame.part.size();
        self.prepare(orders, size)?;
        let mut film = self.series.session.film(size)?;
        let begin = Instant::now();
        let count = ((self.pace * SMALL_TIME) as u32).clamp(1, RUN_LENGTH);
        let job = self.job(size, count);
        let mut following = Following::new(&self.link, orders, (&self.args.options, size));
        self.series.session.render(&job, &mut film, &mut following)?;
        drop(following);
        self.pace = f64::from(count) / begin.elapsed().as_secs_f64();
        self.show(orders, &film, true)
    }

    /// Adds samples to the image for a while, and shows it.
    fn render_more(&mut self, orders: &Orders) -> Result<()> {
        let frame = Frame::full(self.full());
        let size = frame.part.size();
        if self.viewed != Some((orders.revision, frame)) {
            self.view(orders, frame)?;
            self.prepare(orders, size)?;
        }
        let kept = self.film.take().filter(|(of, _)| *of == orders.revision).map(|(_, film)| film);
        if kept.is_none() {
            self.seconds = Seconds { load: self.seconds.load, ..Seconds::default() };
        }
        let mut film = kept.map_or_else(|| self.series.session.film(size), Ok)?;
        // A range of whole runs, so that the image is that of one render.
        let pace = if self.seconds.per_sample > 0.0 { 1.0 / self.seconds.per_sample } else { 0.0 };
        let runs = ((pace * PAUSE.as_secs_f64()) as u32 / RUN_LENGTH).max(1);
        let held = film.samples.range().end;
        let end = (held / RUN_LENGTH).saturating_add(runs).saturating_mul(RUN_LENGTH).min(self.samples());
        let job = self.job(size, end);
        let mut following = Following::new(&self.link, orders, (&self.args.options, size));
        following.is_of_image = true;
        let rendered = self.series.session.render(&job, &mut film, &mut following);
        drop(following);
        if matches!(rendered, Err(Error::Dropped)) {
            return Ok(());
        }
        rendered?;
        let new = film.samples.count().saturating_sub(u64::from(held));
        self.seconds.render += self.series.session.outcome.seconds;
        self.seconds.per_sample = per_sample(self.series.session.outcome.seconds, new);
        self.show(orders, &film, false)?;
        self.film = Some((orders.revision, film));
        Ok(())
    }

    /// Hands a film to the window.
    fn show(&mut self, orders: &Orders, film: &Accumulation, is_small: bool) -> Result<()> {
        let mut shown = Shown::new(&film.film, orders.layer, None);
        (shown.revision, shown.is_small, shown.samples) = (orders.revision, is_small, film.samples.count());
        if !is_small {
            let finish = Finish::new(film, None, false);
            shown.pace = if self.seconds.per_sample > 0.0 { 1.0 / self.seconds.per_sample } else { 0.0 };
            shown.error = error_words(&finish);
            shown.reasons = finish.verdict.reasons_unreliable();
        }
        self.shown = Some((orders.revision, orders.layer));
        self.link.tell(|findings| {
            findings.shown = Some(Arc::new(shown));
            findings.errors.clear();
            findings.activity.clear();
        });
        Ok(())
    }

    /// Writes the image and its picture, under names that no file has.
    fn save(&mut self, orders: &Orders) -> Result<()> {
        let view = self.link.order(|orders| orders.save.take()).unwrap_or_default();
        let frame = Frame::full(self.full());
        if self.viewed != Some((orders.revision, frame)) {
            self.view(orders, frame)?;
            self.prepare(orders, frame.part.size())?;
        }
        let Some((_, film)) = &self.film else { return Ok(()) };
        let exr = unused(&self.args.image().with_extension("exr"));
        let (mut args, png) = (self.args.clone(), exr.with_extension("png"));
        (args.files.output, args.files.png) = (Some(exr.clone()), Some(png.clone()));
        args.goal.spp = u32::try_from(film.samples.count()).ok();
        args.view = ViewArgs { exposure: view.exposure, tonemap: view.tonemap };
        let saved = save(&args, &self.scene, &self.series.session, film, &self.seconds);
        let message = match saved {
            Ok(()) => format!("saved {} and {}", exr.display(), png.display()),
            Err(error) => format!("error: {error}"),
        };
        crate::commands::tell(&message);
        self.link.tell(|findings| findings.message = message);
        Ok(())
    }

    /// Finds what a pixel shows, by one sample of it.
    fn find(&mut self, orders: &Orders, (x, y): (u32, u32)) -> Result<()> {
        self.link.order(|orders| orders.pixel = None);
        let full = self.full();
        let part = Crop { left: x.min(full.0 - 1), top: y.min(full.1 - 1), width: 1, height: 1 };
        let mut options = self.args.options.clone();
        options.aov.set(vec![Aov::Depth0, Aov::Distance0, Aov::Object, Aov::Material]);
        self.view_with(orders, Frame { part, full }, &options)?;
        self.prepare(orders, part.size())?;
        let job = self.job(part.size(), 1);
        let session = &mut self.series.session;
        let mut film = session.film(part.size())?;
        session.render(&job, &mut film, &mut ())?;
        let value = |aov| {
            let channels = film.film.aovs().channels();
            channels.iter().find(|channel| channel.aov == aov).map_or(0.0, |channel| film.film.channel(0, channel))
        };
        let name = |names: &[String], number: f32| {
            let name = (number as usize).checked_sub(1).and_then(|index| names.get(index));
            name.cloned().unwrap_or_default()
        };
        let (object, material) = (value(Aov::Object), value(Aov::Material));
        let view = &session.scene;
        let names = (object > 0.0).then(|| (name(&view.object_names, object), name(&view.material_names, material)));
        let (distance, depth) = (f64::from(value(Aov::Distance0)), f64::from(value(Aov::Depth0)));
        let surface = Surface { pixel: (x, y), names, distance, depth };
        self.link.tell(|findings| findings.surface = Some(surface));
        Ok(())
    }

    /// Tells the window of a new scene.
    fn take_scene(&mut self) {
        self.reads += 1;
        let Camera { shutter: (opens, _), .. } = self.read.camera;
        let camera = Camera { moving: Vec::new(), ..self.read.camera.at(opens) };
        let (size, samples, reads) = (self.full(), self.samples(), self.reads);
        self.link.tell(|findings| {
            findings.camera = (camera, reads);
            (findings.size, findings.samples) = (size, u64::from(samples));
        });
    }

    fn follow_files(&mut self) {
        if let Some(changes) = &mut self.series.changes {
            changes.follow(&self.series.assets.files);
        }
    }

    /// Reads the scene again. Where that fails, the picture stays.
    fn read_again(&mut self) {
        let ends = || self.link.orders().ends;
        if self.series.changes.as_ref().is_some_and(|changes| changes.wait(ends).is_none()) {
            return;
        }
        let read = self.series.load(&self.args);
        self.follow_files();
        let revision = self.link.order(|orders| {
            orders.revision += 1;
            orders.revision
        });
        match read {
            Ok(read) => {
                self.read = read;
                self.take_scene();
            }
            Err(error) => {
                self.failed = Some(revision);
                self.tell_errors(&error);
            }
        }
    }

    fn tell_errors(&self, error: &Error) {
        let messages = error.messages();
        messages.iter().for_each(|message| crate::commands::tell(&format!("error: {message}")));
        self.link.tell(|findings| {
            findings.errors = messages;
            findings.activity.clear();
        });
    }

    /// Shows an error. The next change tries again, with devices that open anew if one has failed.
    fn fail(&mut self, error: &Error, orders: &Orders) {
        self.failed = Some(orders.revision);
        if self.series.session.devices.iter().any(|device| device.check().is_err()) {
            let fresh = Series::new(&self.args).session.keeping_hierarchies();
            self.series.session = fresh;
            self.series.session.submission = Some(SUBMISSION);
        }
        (self.viewed, self.film) = (None, None);
        self.tell_errors(error);
    }
}

impl WindowArgs {
    fn into_render(self) -> RenderArgs {
        let WindowArgs { scene, output, size, spp, paths, view, watch, mut options } = self;
        options.aov.complete(is_gltf(&scene.path));
        let messages = MessageArgs { quiet: true, ..MessageArgs::default() };
        let mut args = RenderArgs { scene, paths, view, options, messages, ..RenderArgs::default() };
        args.goal = GoalArgs { size, spp, ..GoalArgs::default() };
        (args.files.output, args.keep.watch) = (output, watch);
        args
    }
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
    /// Those of the film, for one that begins anew.
    options: RenderOptions,
    size: (u32, u32),
    /// Whether the image is rendered, which ends with a change and is shown meanwhile. A small picture is not.
    is_of_image: bool,
    /// What the window showed before.
    before: Option<Arc<Shown>>,
    next: Instant,
}

impl Following<'_> {
    fn new<'a>(link: &'a Link, orders: &'a Orders, (options, size): (&RenderOptions, (u32, u32))) -> Following<'a> {
        let (options, next) = (options.clone(), Instant::now() + PAUSE / 2);
        Following { link, orders, options, size, is_of_image: false, before: link.findings().shown, next }
    }
}

impl Observer for Following<'_> {
    fn compiling(&mut self, _: &[Arc<Device>]) -> Result<()> {
        self.link.tell(|findings| findings.activity = "compiling".to_owned());
        if self.link.orders().ends { Err(Error::Dropped) } else { Ok(()) }
    }

    fn compiled(&mut self) {
        self.link.tell(|findings| findings.activity.clear());
    }

    fn follow(&mut self, _: &Outcome, snapshot: Option<Snapshot<'_>>) -> Next {
        let now = Instant::now();
        if let Some(snapshot) = snapshot {
            let mut shown = Shown::new(&snapshot.film.film, self.orders.layer, self.before.as_deref());
            shown.revision = self.orders.revision;
            // Its error is that of the last complete runs.
            if let Some(before) = self.link.findings().shown.filter(|before| !before.is_small)
                && before.revision == shown.revision
            {
                (shown.error, shown.reasons) = (before.error.clone(), before.reasons.clone());
                (shown.pace, shown.samples) = (before.pace, before.samples);
            }
            let shown = Arc::new(shown);
            self.link.tell(|findings| findings.shown = Some(shown));
            self.next = now + PAUSE;
        }
        let orders = self.link.orders();
        let has_changed = self.is_of_image && orders.revision != self.orders.revision;
        match () {
            () if orders.ends || has_changed => Next::Drop,
            () if !self.is_of_image => Next::GoOn,
            () if orders.paused
                || orders.pixel.is_some()
                || orders.save.is_some()
                || orders.layer != self.orders.layer =>
            {
                Next::Stop
            }
            () if now >= self.next => Next::Snapshot,
            () => Next::GoOn,
        }
    }

    /// Goes on with an empty film.
    fn lost(&mut self, why: &Error, view: &DeviceScene, _: &[Arc<Device>]) -> Option<Accumulation> {
        let message = format!("{why}: the device is opened again");
        crate::commands::tell(&format!("warning: {message}"));
        self.link.tell(|findings| findings.message = message);
        empty_film(view, self.size, &self.options).ok().map(Accumulation::empty)
    }
}
