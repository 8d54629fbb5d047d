//! A render by one device or by several, which add to one film.

use std::ops::Range;
use std::thread;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use super::stretch::{Shared, Stretch};
use super::{Lane, Outcome, Watch};
use crate::aov::Aovs;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::job::{Goal, Job};
use crate::options::{Integrator, RenderOptions};
use crate::plan::Plan;
use crate::threads::each;

/// A render that is ready to go.
pub struct Renderer<'a> {
    lanes: Vec<Lane<'a>>,
}

impl<'a> Renderer<'a> {
    /// Allocates the buffers and compiles the kernels.
    ///
    /// # Errors
    /// `Error::Device` where a buffer exceeds the device's limits or memory, a kernel does not compile, or one relies on what the
    /// numerics probe does not find.
    pub fn new(device: &'a Device, plan: &Plan<'_>, job: &Job, profile: bool) -> Result<Renderer<'a>> {
        Renderer::of_devices(&[(device, plan)], job, profile)
    }

    /// A render by several devices, each with its plan. What they render is the same as by one of them, if their drivers round alike.
    ///
    /// # Errors
    /// As of [`Renderer::new`].
    pub fn of_devices(devices: &[(&'a Device, &Plan<'_>)], job: &Job, profile: bool) -> Result<Renderer<'a>> {
        let lanes = each(devices.len(), devices, |(device, plan)| Lane::new(device, plan, job, profile));
        Ok(Renderer { lanes: lanes.into_iter().collect::<Result<_>>()? })
    }

    /// Has submissions take so long, so that the caller is asked as often what it wants next.
    pub fn ask_every(&mut self, time: Duration) {
        self.lanes.iter_mut().for_each(|lane| lane.submission = time);
    }

    /// Renders until the goal is reached. Calls `watch` after each submission with the outcome so far; fields that are known only at the end
    /// have their defaults. If `watch` asks for a look, it is called again with the film. The job may differ from the one that the renderer
    /// was made for, but not in its size.
    ///
    /// # Errors
    /// `Error::Usage` if the film has another size than the job, or another scale than the scene. `Error::Device` if a device fails; the
    /// film then has what it had after the last look. `Error::Dropped` if `watch` asks for that.
    pub fn run(&mut self, job: &Job, film: &mut Film, watch: Watch<'_>) -> Result<Outcome> {
        self.lanes.iter().try_for_each(|lane| lane.check_film(job, film))?;
        let mut outcome = Outcome::default();
        let start = Instant::now();
        let processor = ThreadTime::now();
        self.lanes.iter_mut().for_each(|lane| lane.begin(job));
        let first = job.first_sample;
        let mut stretch = Stretch { film: &mut *film, watch, start, outcome: &mut outcome, whole: false, pilot: None };
        match job.goal {
            Goal::Samples(end) => self.render_samples(first..end, &mut stretch)?,
            Goal::Until { deadline, end } => self.render_until(first..end, deadline, &mut stretch)?,
            Goal::Noise { error, deadline, end, begun, looks } => {
                self.render_noise(first..end, error, deadline, (begun, looks), &mut stretch)?;
            }
        }
        self.bring_film(film)?;
        outcome.seconds = start.elapsed().as_secs_f64();
        outcome.host_seconds += processor.elapsed().as_secs_f64();
        for (name, seconds) in self.lanes.iter().flat_map(|lane| &lane.stages.seconds) {
            outcome.add_stage(name, *seconds);
        }
        let idle: Option<Vec<f64>> = self.lanes.iter().map(|lane| lane.stages.idle()).collect();
        outcome.device_idle = idle.map(|idle| idle.iter().sum::<f64>() / self.lanes.len() as f64);
        Ok(outcome)
    }

    /// Renders a range of samples of every pixel. Each device has a thread, and takes the next blocks of samples when it is free.
    pub(super) fn render_samples(&mut self, samples: Range<u32>, stretch: &mut Stretch<'_>) -> Result<()> {
        let count = self.lanes.len();
        let shared = Shared::new(samples, count, stretch);
        let caller = thread::current().id();
        let work = |lane: &mut Lane<'_>| -> Result<()> {
            let processor = ThreadTime::now();
            let present = shared.enter();
            lane.work(&shared)?;
            present.leave();
            if thread::current().id() != caller {
                shared.state().stretch.outcome.host_seconds += processor.elapsed().as_secs_f64();
            }
            Ok(())
        };
        each(count, &mut self.lanes, work).into_iter().collect()
    }

    /// Brings what the devices have rendered to the film.
    pub(super) fn bring_film(&mut self, film: &mut Film) -> Result<()> {
        self.lanes.iter_mut().try_for_each(|lane| lane.bring_film(film))
    }

    /// Drops what the devices' films have received.
    pub(super) fn drop_film(&mut self) {
        self.lanes.iter_mut().for_each(Lane::drop_film);
    }
}

/// An empty film for a render of this scene.
///
/// # Errors
/// As of [`Film::with_sampler`] and [`Film::with_aovs`].
pub fn empty_film(scene: &DeviceScene, (width, height): (u32, u32), options: &RenderOptions) -> Result<Film> {
    let film = Film::with_sampler(width, height, scene.radiance_exponent, options.sampler)?;
    film.sampling_lights(options.integrator == Integrator::Mis).with_aovs(&options.aov, scene.space)
}

impl Lane<'_> {
    /// Refuses a film that does not fit: on one of another scale the image would be too dark or too bright.
    fn check_film(&self, job: &Job, film: &Film) -> Result<()> {
        let needed = (job.size, self.exponent, &self.aovs);
        let found = ((film.width(), film.height()), film.exponent(), film.aovs());
        if found == needed {
            return Ok(());
        }
        let words = |((width, height), scale, aovs): ((u32, u32), i32, &Aovs)| {
            let aovs = aovs.words().map_or(String::new(), |aovs| format!(" with {aovs}"));
            format!("{width} x {height} pixels of the scale 2^{scale}{aovs}")
        };
        Err(Error::Usage(format!("the render needs a film of {}, found {}", words(needed), words(found))))
    }
}
