//! A render by one or several devices, which add to one film.

use std::ops::Range;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use super::device::DeviceRenderer;
use super::observer::Observer;
use super::outcome::Outcome;
use super::sample_range::{Caller, SampleRange};
use crate::data::Settings;
use crate::error::Result;
use crate::film::{Accumulation, Film};
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::job::{Crop, Frame, Goal, Job};
use crate::options::RenderOptions;
use crate::plan::Plan;
use crate::threads::each;

/// Devices that are ready to render.
pub struct Renderer {
    devices: Vec<DeviceRenderer>,
}

impl Renderer {
    /// Allocates the buffers of devices, and compiles their kernels, each by its plan. The image is that of one device, if their drivers round
    /// alike. `submission` is the time that a submission should take, after which the observer is asked, if not the usual one.
    ///
    /// # Errors
    /// `Error::Device` if a buffer exceeds the device's limits or memory, a kernel does not compile, or one relies on arithmetic that
    /// the numerics probe does not find.
    pub fn new(
        devices: &[(&Arc<Device>, &Plan<'_>)],
        job: &Job,
        profile: bool,
        submission: Option<Duration>,
    ) -> Result<Renderer> {
        let ready =
            each(devices.len(), devices, |(device, plan)| DeviceRenderer::new(device, plan, job, profile, submission));
        Ok(Renderer { devices: ready.into_iter().collect::<Result<_>>()? })
    }

    /// This renderer for other plans that need the same kernels and buffers, which are filled anew; nothing if a device needs others.
    ///
    /// # Errors
    /// `Error::Device` if a device has failed.
    pub fn retaken(mut self, plans: &[(&Arc<Device>, &Plan<'_>)], job: &Job) -> Result<Option<Renderer>> {
        for (renderer, (_, plan)) in self.devices.iter_mut().zip(plans) {
            if !renderer.take(plan, job)? {
                return Ok(None);
            }
        }
        Ok(Some(self))
    }

    /// Renders until the goal is reached. The observer follows with the outcome so far; fields that are known only at the end have their defaults. The
    /// job may differ from the one that the renderer was made for, but not in its size.
    ///
    /// # Errors
    /// `Error::Usage` if the film has another size than the job, or another scale than the scene. `Error::Device` if a device fails; the
    /// film then has what it had after the last snapshot. `Error::Dropped` if the observer returns [`Next::Drop`](super::observer::Next::Drop).
    pub fn run(&mut self, job: &Job, film: &mut Accumulation, observer: &mut dyn Observer) -> Result<Outcome> {
        self.devices.iter().try_for_each(|device| device.check_film(job, &film.film))?;
        let mut outcome = Outcome::default();
        let start = Instant::now();
        let processor = ThreadTime::now();
        self.devices.iter_mut().for_each(|device| device.begin(job));
        let first = job.first_sample;
        let mut caller =
            Caller { film: &mut *film, observer, start, outcome: &mut outcome, wants_complete: false, probe: None };
        match job.goal {
            Goal::Samples(end) => self.render_samples(first..end, &mut caller)?,
            Goal::Until { deadline, end } => self.render_until(first..end, deadline, &mut caller)?,
            Goal::Noise { .. } => self.render_noise(job, &mut caller)?,
        }
        self.read_film(&mut film.film)?;
        outcome.seconds = start.elapsed().as_secs_f64();
        outcome.host_seconds += processor.elapsed().as_secs_f64();
        for (name, seconds) in self.devices.iter().flat_map(|device| &device.stages.seconds) {
            outcome.add_stage(name, *seconds);
        }
        let idle: Option<Vec<f64>> = self.devices.iter().map(|device| device.stages.idle()).collect();
        outcome.idle = idle.map(|idle| idle.iter().sum::<f64>() / self.devices.len() as f64);
        Ok(outcome)
    }

    /// Renders a range of samples of every pixel. Each device has a thread, and takes the next blocks of samples when it is free.
    pub(super) fn render_samples(&mut self, samples: Range<u32>, caller: &mut Caller<'_>) -> Result<()> {
        let count = self.devices.len();
        let range = SampleRange::new(samples, count, caller);
        let calling = thread::current().id();
        let work = |device: &mut DeviceRenderer| -> Result<()> {
            let processor = ThreadTime::now();
            let present = range.enter();
            device.work(&range)?;
            present.leave();
            if thread::current().id() != calling {
                range.state().caller.outcome.host_seconds += processor.elapsed().as_secs_f64();
            }
            Ok(())
        };
        each(count, &mut self.devices, work).into_iter().collect()
    }

    /// Adds the devices' films to the film on the host.
    pub(super) fn read_film(&mut self, film: &mut Film) -> Result<()> {
        self.devices.iter_mut().try_for_each(|device| device.read_film(film))
    }

    /// Drops the contents of the devices' films.
    pub(super) fn drop_film(&mut self) {
        self.devices.iter_mut().for_each(DeviceRenderer::drop_film);
    }
}

/// An empty film for a render of this scene, of the part of the image that the scene's settings name.
///
/// # Errors
/// As of [`Film::with_sampler`] and [`Film::with_channels`].
pub fn empty_film(scene: &DeviceScene, (width, height): (u32, u32), options: &RenderOptions) -> Result<Film> {
    let Settings { film_left: left, film_top: top, image_width, image_height, .. } = scene.settings;
    let frame = Frame { part: Crop { left, top, width, height }, full: (image_width, image_height) };
    let film = Film::with_sampler(width, height, scene.radiance_exponent, options.sampler)?.of_part(frame);
    let has_light_paths = scene.light_paths(options).count() > 0;
    let mut film = film.with_channels(&scene.aovs(options), scene.space, has_light_paths)?.with_lamps(&scene.lamps);
    film.bound.not_sampled = scene.not_sampled;
    Ok(film)
}
