//! A session: all renders flatten a view of a scene, plan it for devices, compile its kernels and add samples to a film here.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::flatten::{DeviceScene, Hierarchies, flatten_with};
use crate::gpu::device::{Adapters, Device};
use crate::gpu::numerics::Numerics;
use crate::gpu::probe::numerics;
use crate::job::{Frame, Job};
use crate::options::RenderOptions;
use crate::plan::Plan;
use crate::render::{Observer, Outcome, Renderer, empty_film};
use crate::scene::Scene;
use crate::threads::join;

/// The work that a device gets at a time is halved so often after it has failed.
const HALVINGS_AFTER_LOSS: u32 = 2;

/// Renders views of scenes on devices, one after the other. Devices keep their kernels: where the next view links the same texts, nothing compiles.
/// A flattened scene is relative to the camera, so that each view is flattened anew.
#[derive(Default)]
pub struct Session {
    pub devices: Vec<Arc<Device>>,
    /// Which devices to open for the first view, as [`Adapters::choose_several`] takes it.
    choice: Option<String>,
    /// The hierarchies of meshes, which views have in common; `None` if they are not kept.
    hierarchies: Option<Hierarchies>,
    /// The view that is rendered, and its options.
    pub scene: Arc<DeviceScene>,
    options: RenderOptions,
    /// Whether the seconds of each stage are measured.
    pub profile: bool,
    /// The time that a submission should take, if not the usual one.
    pub submission: Option<Duration>,
    /// `None` before the view's kernels are compiled.
    ready: Option<Ready>,
    /// The view before, if nothing of it is under way: its buffers may fit the next one.
    before: Option<Ready>,
    /// The outcome of the last render, also where it failed.
    pub outcome: Outcome,
}

/// A view whose kernels are compiled.
struct Ready {
    renderer: Renderer,
    size: (u32, u32),
    kernels: Vec<String>,
    gpu_bytes: u64,
    /// Whether nothing of a render is under way.
    is_idle: bool,
}

impl Session {
    /// A session on the devices of this choice, which open when the first view is flattened.
    pub fn opening(choice: Option<&str>) -> Session {
        Session { choice: choice.map(str::to_owned), ..Session::default() }
    }

    /// A session on open devices.
    pub fn on(devices: Vec<Arc<Device>>) -> Session {
        Session { devices, ..Session::default() }
    }

    /// Keeps the hierarchies of meshes from view to view.
    pub fn keeping_hierarchies(self) -> Session {
        Session { hierarchies: Some(Hierarchies::default()), ..self }
    }

    /// Flattens a view of a scene, and returns the time that this took. If no device is open, the driver loads meanwhile.
    ///
    /// # Errors
    /// As of [`flatten`](crate::flatten::flatten). `Error::Usage` if the choice names no device, `Error::Device` if one does not open.
    pub fn view(&mut self, scene: &Scene, frame: &Frame, options: &RenderOptions) -> Result<Duration> {
        let Session { devices, choice, hierarchies, .. } = self;
        let opening = || Adapters::find().choose_several(choice.as_deref())?.into_iter().map(Device::open).collect();
        let begin = Instant::now();
        let mut flatten = || {
            let flat = flatten_with(scene, frame.full, options, hierarchies.as_mut());
            (flat, begin.elapsed())
        };
        let (opened, (flat, took)) = match devices.is_empty() {
            true => join(opening, flatten),
            false => (Ok(Vec::new()), flatten()),
        };
        let (mut flat, opened): (_, Vec<Device>) = (flat?, opened?);
        (flat.settings.film_left, flat.settings.film_top) = (frame.part.left, frame.part.top);
        self.devices.extend(opened.into_iter().map(Arc::new));
        self.show(flat, options);
        Ok(took)
    }

    /// Takes a view that is flattened.
    pub fn show(&mut self, view: DeviceScene, options: &RenderOptions) {
        (self.scene, self.options) = (Arc::new(view), options.clone());
        self.before = self.ready.take().filter(|ready| ready.is_idle);
    }

    /// A film of this size for the view, without samples.
    ///
    /// # Errors
    /// As of [`empty_film`].
    pub fn film(&self, size: (u32, u32)) -> Result<Accumulation> {
        Ok(Accumulation::empty(empty_film(&self.scene, size, &self.options)?))
    }

    /// The numerics of the first device.
    ///
    /// # Errors
    /// `Error::Device` if it fails, or no device is open.
    pub fn numerics(&self) -> Result<&Numerics> {
        numerics(self.devices.first().ok_or_else(|| Error::Device("no device is open".to_string()))?)
    }

    /// The names of the kernels, and the bytes of all buffers on the devices; nothing before the view's kernels are compiled.
    pub fn kernels(&self) -> (&[String], u64) {
        self.ready.as_ref().map_or((&[], 0), |ready| (&ready.kernels, ready.gpu_bytes))
    }

    /// Whether the view's kernels are compiled.
    pub fn is_ready(&self) -> bool {
        self.ready.is_some()
    }

    /// Renders what a film lacks of a job. Devices that fail are opened once more, get less work at a time, and go on with the film that the
    /// observer has kept.
    ///
    /// # Errors
    /// `Error::Usage` if the film is not of this view. `Error::Device` if a device fails; the film then has what it had after the last snapshot.
    /// `Error::Dropped` if the observer drops the render.
    pub fn render(&mut self, job: &Job, film: &mut Accumulation, observer: &mut dyn Observer) -> Result<()> {
        self.outcome = Outcome::default();
        let rendered = self.attempt(job, film, observer);
        let Err(error @ Error::Device(_)) = &rendered else { return rendered };
        let kept = if self.is_ready() { observer.lost(error, &self.scene, &self.devices, film) } else { None };
        // If the devices do not open, the first failure is reported, and the film stays.
        let (Some(kept), Ok(devices)) = (kept, self.opened_again()) else { return rendered };
        (*film, self.devices) = (kept, devices);
        (self.ready, self.before) = (None, None);
        self.attempt(job, film, observer)
    }

    fn attempt(&mut self, job: &Job, film: &mut Accumulation, observer: &mut dyn Observer) -> Result<()> {
        self.outcome.noise = film.noise_reached(job);
        let jobs = film.jobs(job, self.outcome.noise);
        let Some(first) = jobs.first() else { return Ok(()) };
        if self.ready.as_ref().is_none_or(|ready| ready.size != job.size) {
            self.prepare(first, observer)?;
        }
        for job in &jobs {
            observer.begin(job, film, self.numerics()?);
            let Some(Ready { renderer, is_idle, .. }) = &mut self.ready else { return Ok(()) };
            let before = film.samples.clone();
            *is_idle = false;
            // A device that has failed has kept back what it rendered last.
            let done = renderer.run(job, film, observer).inspect_err(|_| film.samples = before);
            self.outcome.join(done?);
            *is_idle = true;
            if self.outcome.interrupted {
                break;
            }
        }
        Ok(())
    }

    /// Plans the view for a job and compiles its kernels. Where devices have no memory for their buffers, they get half of the slots. A render does
    /// this where nobody has; who renders a job bit by bit does it first, since the kernels of a long job are others.
    ///
    /// # Errors
    /// As of [`Plan::new`] and [`Session::compile_plans`].
    pub fn prepare(&mut self, job: &Job, observer: &mut dyn Observer) -> Result<()> {
        loop {
            let (devices, scene) = (self.devices.clone(), Arc::clone(&self.scene));
            // A device keeps what its probe finds; its error is returned again when the findings are read.
            let probe = || devices.iter().all(|device| numerics(device).is_ok());
            let plan = |device: &Arc<Device>| Plan::new(&scene, &self.options, device.class(), job);
            let (_, plans) = join(probe, || devices.iter().map(plan).collect::<Result<Vec<_>>>());
            let made = self.compile_plans(&plans?, job, observer);
            if made.is_ok() || !self.takes_fewer_slots() {
                return made;
            }
        }
    }

    /// Compiles the kernels of these plans of the view, one for each device.
    ///
    /// # Errors
    /// `Error::Device` if a buffer exceeds a device's limits or memory, a kernel does not compile, or one relies on arithmetic that the numerics
    /// probe does not find.
    pub fn compile_plans(&mut self, plans: &[Plan<'_>], job: &Job, observer: &mut dyn Observer) -> Result<()> {
        let pairs: Vec<_> = self.devices.iter().zip(plans).collect();
        let renderer = match self.before.take().map(|ready| ready.renderer.retaken(&pairs, job)).transpose()?.flatten()
        {
            Some(renderer) => renderer,
            None => {
                observer.compiling(&self.devices)?;
                let made = Renderer::new(&pairs, job, self.profile, self.submission);
                observer.compiled();
                made?
            }
        };
        let kernels = plans.iter().take(1).flat_map(Plan::kernels).map(|kernel| kernel.name.clone()).collect();
        let gpu_bytes = plans.iter().flat_map(Plan::buffers).map(|buffer| buffer.allocated()).sum();
        self.ready = Some(Ready { renderer, size: job.size, kernels, gpu_bytes, is_idle: true });
        Ok(())
    }

    /// Halves the slots of the devices that had no memory for their buffers. Returns whether that leaves something to try.
    fn takes_fewer_slots(&self) -> bool {
        let lacking: Vec<_> = self.devices.iter().filter(|device| device.take_lacked_memory()).collect();
        self.options.slots.is_none() && !lacking.is_empty() && lacking.iter().all(|device| device.halve(1))
    }

    /// The same devices, opened anew. A watchdog may have ended work that took too long: they get less at a time.
    fn opened_again(&self) -> Result<Vec<Arc<Device>>> {
        let adapters = Adapters::find();
        let again = |before: &Arc<Device>| {
            let device = Device::open(adapters.like(&before.name)?)?;
            device.halve(before.class().halvings + HALVINGS_AFTER_LOSS);
            Ok(Arc::new(device))
        };
        self.devices.iter().map(again).collect()
    }
}
