//! One device that renders: its kernels, its buffers, and the submissions in flight.

use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::observer::Next;
use super::outcome::totals_since;
use super::sample_range::SampleRange;
use super::tiles::{MOST_RUNS, Schedule, pixel_in_order, tiles};
use crate::aov::Aovs;
use crate::data::{Counters, RUN_LENGTH, Settings, Window};
use crate::error::{Error, Result};
use crate::film::{Film, MotionOf, Totals, device_bytes};
use crate::flatten::Neighbours;
use crate::gpu::buffers::{BufferSpec, Buffers, Readback};
use crate::gpu::compile_beside::{compile_beside, is_worth_it};
use crate::gpu::device::Device;
use crate::gpu::pipeline::{Pipeline, PipelineSpec};
use crate::gpu::probe;
use crate::gpu::timing::{MAX_PASSES, StageTimes, Timing};
use crate::job::{Job, blocks, light_paths_of, samples_of};
use crate::plan::{Bounce, Kernel, Plan, STEPS, SettingsLayout, Tuning};
use crate::threads::join;

/// The default time of a submission: long enough to hide the cost of making it, and short enough that no watchdog fires and no user waits.
const SUBMISSION: Duration = Duration::from_millis(100);
/// Submissions in flight. While the device executes one, the next one waits in its queue, and the host reads the counters of the last one.
const IN_FLIGHT: usize = 2;
/// The least work of a submission, in slots times bounces. The first one of a renderer has it: drivers end a device whose submission takes too
/// long, and how long it takes is not known yet.
const LEAST_WORK: u64 = 1024;
/// Small kernels that take longer than this to get ready were not in the driver's cache.
const COMPILED: Duration = Duration::from_millis(40);
/// The most bytes of the film in a transfer to the host.
const FILM_AT_ONCE: u64 = 16 << 20;

/// A device that is ready to render: kernels compiled, buffers filled.
pub struct DeviceRenderer {
    device: Arc<Device>,
    settings: Settings,
    tuning: Tuning,
    buffers: Buffers,
    kernels: Pipelines,
    planned: Planned,
    /// By the kind of paths that a submission is of.
    paces: [Workload; 2],
    film: DeviceFilm,
    /// One for each submission in flight.
    readings: Vec<Feedback>,
    /// The times of the stages since the job began.
    pub stages: StageTimes,
}

/// The pipelines of a plan, and the layout of its settings.
struct Pipelines {
    generate: Stage,
    /// The stages of a bounce; one for all bounces of a submission if they are fused.
    bounce: Vec<Stage>,
    is_fused: bool,
    accumulate: Stage,
    /// What sample 0 sees, if it is asked for.
    truth: Option<Stage>,
    /// Light paths, if they are traced.
    light_path: Option<Stage>,
    /// The last of a submission.
    receipt: Stage,
    settings_layout: SettingsLayout,
}

/// A dispatch of a pass.
struct Stage {
    pipeline: Pipeline,
    size: StageSize,
}

enum StageSize {
    /// An invocation for each slot.
    Slots,
    One,
    /// An invocation for each path in the queue of this number.
    Queue(u64),
}

/// The kind of paths that a submission is of.
#[derive(Clone, Copy, PartialEq)]
enum PathKind {
    Camera,
    Light,
}

/// Controls the slots and bounces of a submission.
struct Workload {
    /// Slots of the next submission times its bounces. It has bounces of all slots, or one bounce of some.
    work: u64,
    /// Bounces of each submission, if their number is fixed.
    fixed: Option<u32>,
    /// The most bounces of a submission.
    most: u32,
    /// The time that a submission should take.
    submission: Duration,
    /// When the last submission ended.
    last_end: Instant,
}

/// The film of one tile on the device.
struct DeviceFilm {
    /// The size of the image.
    size: (u32, u32),
    /// The radiance exponent of the scene and its film.
    exponent: i32,
    /// The channels of `--aov` in the film.
    aovs: Aovs,
    neighbours: Option<Arc<Neighbours>>,
    /// Whether the film has light paths.
    light_paths: bool,
    /// The film on its way to the host.
    readback: Readback,
    tile: Range<u32>,
    /// The totals since it was last read.
    received: Totals,
    /// Whether the next submission must clear it.
    is_stale: bool,
}

/// What a submission reports to the host.
struct Feedback {
    counters: Readback,
    timing: Option<Timing>,
}

/// A submission that the device has not reported on yet.
struct Flight {
    submission: wgpu::SubmissionIndex,
    receipt: u32,
    /// Its index among the readings.
    reading: usize,
    kind: PathKind,
    /// Its slots times its bounces.
    work: u64,
    /// The slots that have had a run when it ends.
    begun: u32,
    begin: Instant,
}

impl Pipelines {
    fn new(plan: &Plan<'_>, pipelines: Vec<Pipeline>) -> Result<Pipelines> {
        let mut named: BTreeMap<_, _> =
            pipelines.into_iter().map(|pipeline| (pipeline.name.clone(), pipeline)).collect();
        let mut pipeline = |kernel: &Kernel| {
            let missing = || Error::Shader(format!("the plan has two kernels named {}", kernel.name));
            named.remove(&kernel.name).ok_or_else(missing)
        };
        let mut stage = |kernel: &Kernel, size| Ok::<_, Error>(Stage { pipeline: pipeline(kernel)?, size });
        let bounce = match &plan.kernels.bounce {
            Bounce::Fused(kernel) => vec![stage(kernel, StageSize::Slots)?],
            Bounce::Staged(staged) => {
                let slots = |kernel| (kernel, StageSize::Slots);
                let scatter = (0..).zip(&staged.scatter).map(|(queue, kernel)| match staged.dispatch {
                    Some(_) => (kernel, StageSize::Queue(queue)),
                    None => slots(kernel),
                });
                let first = std::iter::once(&staged.intersect).chain(&staged.medium).map(slots);
                let dispatch = staged.dispatch.iter().map(|kernel| (kernel, StageSize::One));
                let last = staged.shadow.iter().chain([&staged.refill]).map(slots);
                let all = first.chain(dispatch).chain(scatter).chain(last);
                all.map(|(kernel, size)| stage(kernel, size)).collect::<Result<_>>()?
            }
        };
        Ok(Pipelines {
            generate: stage(&plan.kernels.generate, StageSize::Slots)?,
            bounce,
            is_fused: matches!(plan.kernels.bounce, Bounce::Fused(_)),
            accumulate: stage(&plan.kernels.accumulate, StageSize::Slots)?,
            light_path: { plan.kernels.light_path.as_ref() }
                .map(|kernel| stage(kernel, StageSize::Slots))
                .transpose()?,
            truth: { plan.kernels.truth.as_ref() }.map(|kernel| stage(kernel, StageSize::Slots)).transpose()?,
            receipt: stage(&plan.kernels.receipt, StageSize::One)?,
            settings_layout: plan.kernels.settings.clone(),
        })
    }
}

/// # Errors
/// `Error::Usage` if there are more slots or light paths than a dispatch or a window can number.
fn check_limits(device: &Device, plan: &Plan<'_>) -> Result<()> {
    let tuning = plan.tuning;
    let most_slots = u64::from(device.limits.max_compute_workgroups_per_dimension) * u64::from(tuning.workgroup);
    if u64::from(tuning.slots) > most_slots {
        return Err(Error::Usage(format!(
            "--slots {}: expected {most_slots} at most, with workgroups of {} invocations on {}",
            tuning.slots, tuning.workgroup, device.name
        )));
    }
    let Settings { image_width, image_height, .. } = plan.scene.settings;
    let light_paths = u64::from(image_width) * u64::from(image_height) * u64::from(plan.options.light_paths.count());
    if light_paths > u64::from(MOST_RUNS) {
        return Err(Error::Usage(format!(
            "--light-paths {}: an image of {image_width} x {image_height} pixels has {light_paths} of them for each eight samples; \
             expected {MOST_RUNS} at most",
            plan.options.light_paths
        )));
    }
    Ok(())
}

/// What a renderer has of a plan, and may have of the next one.
struct Planned {
    kernels: Vec<Arc<Kernel>>,
    buffers: Vec<(&'static str, u64, wgpu::BufferUsages)>,
    /// The texels of the scene's images.
    images: Vec<Arc<Vec<u32>>>,
}

impl Planned {
    fn new(plan: &Plan<'_>, specs: &[BufferSpec<'_>]) -> Planned {
        Planned {
            kernels: plan.kernels().into_iter().cloned().collect(),
            buffers: specs.iter().map(|spec| (spec.name, spec.bytes, spec.usage)).collect(),
            images: plan.scene.images.iter().map(|(_, bitmap)| Arc::clone(&bitmap.words)).collect(),
        }
    }
}

impl DeviceRenderer {
    /// Allocates the buffers and compiles the kernels.
    ///
    /// # Errors
    /// `Error::Device` if a buffer exceeds the device's limits or memory, a kernel does not compile, or one relies on arithmetic that
    /// the numerics probe does not find.
    pub fn new(
        device: &Arc<Device>,
        plan: &Plan<'_>,
        job: &Job,
        profile: bool,
        submission: Option<Duration>,
    ) -> Result<DeviceRenderer> {
        check_limits(device, plan)?;
        let tuning = plan.tuning;
        let numerics = probe::numerics(device)?;
        let allowed = |kernel: &Arc<Kernel>| numerics.allow(device, &kernel.name, &kernel.linked);
        plan.kernels().into_iter().try_for_each(allowed)?;
        let most_steps = numerics.most_steps().map(f64::from);
        let of_steps = |name| most_steps.map(|most| (name, most));
        let constants: Vec<_> = STEPS.into_iter().filter_map(of_steps).collect();
        let buffer_specs = plan.buffers();
        let buffers = Buffers::create(device, &buffer_specs)?;
        let specs: Vec<_> = plan
            .kernels()
            .into_iter()
            .map(|kernel| PipelineSpec {
                name: &kernel.name,
                entry_point: kernel.stage,
                module: &kernel.module,
                text: &kernel.linked.text,
                bindings: &kernel.bindings,
                workgroup: tuning.workgroup,
                constants: &constants,
            })
            .collect();
        let kernels = Pipelines::new(plan, Pipeline::all(device, &specs, &buffers)?)?;
        let light_paths = plan.options.light_paths.count() > 0;
        let film_bytes = u64::from(tuning.tile) * device_bytes(&plan.options.aov, light_paths);
        let reading = |_| Feedback {
            counters: Readback::new(device, "counters", size_of::<Counters>() as u64),
            timing: if profile { Timing::new(device) } else { None },
        };
        let pace = || Workload {
            work: LEAST_WORK,
            fixed: tuning.bounces,
            most: 1,
            submission: submission.unwrap_or(SUBMISSION),
            last_end: Instant::now(),
        };
        let renderer = DeviceRenderer {
            device: Arc::clone(device),
            settings: plan.settings(job),
            kernels,
            planned: Planned::new(plan, &buffer_specs),
            paces: [pace(), pace()],
            film: DeviceFilm {
                size: job.size,
                exponent: plan.scene.radiance_exponent,
                aovs: plan.options.aov.of_film(),
                light_paths,
                neighbours: plan.scene.neighbours.clone(),
                readback: Readback::new(device, "film", film_bytes.min(FILM_AT_ONCE)),
                tile: 0..0,
                received: Totals::default(),
                is_stale: false,
            },
            readings: (0..IN_FLIGHT).map(reading).collect(),
            stages: StageTimes::default(),
            tuning,
            buffers,
        };
        renderer.warm_up(&specs, &buffer_specs)?;
        Ok(renderer)
    }

    /// Takes another plan with the kernels and buffers of the last one, and fills the buffers anew. False if they are others. The renderer must
    /// have ended all that it has begun.
    ///
    /// # Errors
    /// `Error::Device` if the device has failed.
    pub fn take(&mut self, plan: &Plan<'_>, job: &Job) -> Result<bool> {
        let specs = plan.buffers();
        let before = std::mem::replace(&mut self.planned, Planned::new(plan, &specs));
        let has_kernels = before.kernels.iter().map(Arc::as_ptr).eq(self.planned.kernels.iter().map(Arc::as_ptr));
        if !has_kernels || before.buffers != self.planned.buffers || self.tuning != plan.tuning {
            return Ok(false);
        }
        let has_images = before.images == self.planned.images;
        let is_new = |spec: &&BufferSpec<'_>| !(has_images && spec.name == "texels");
        self.buffers.fill(&self.device, specs.iter().filter(is_new))?;
        self.settings = plan.settings(job);
        self.film.exponent = plan.scene.radiance_exponent;
        self.film.neighbours = plan.scene.neighbours.clone();
        self.film.aovs = plan.options.aov.of_film();
        Ok(self.film.size == job.size)
    }

    /// Makes the kernels ready, and counts those that are. The first three are small: if they take long, the driver compiles. Then this device
    /// compiles the largest kernel, while another device compiles the others.
    fn warm_up(&self, specs: &[PipelineSpec<'_>], buffers: &[BufferSpec<'_>]) -> Result<()> {
        let Pipelines { generate, bounce, accumulate, truth, light_path, receipt, .. } = &self.kernels;
        let device = &*self.device;
        let large: Vec<&Stage> = bounce.iter().chain(truth).chain(light_path).collect();
        device.compiling.begin(3 + large.len());
        let warm_up = |stage: &Stage| {
            stage.pipeline.warm_up(device)?;
            device.compiling.advance();
            Ok(())
        };
        let begin = Instant::now();
        [generate, accumulate, receipt].into_iter().try_for_each(warm_up)?;
        let is_large = |spec: &&PipelineSpec<'_>| large.iter().any(|stage| stage.pipeline.name == spec.name);
        let mut by_size: Vec<_> = specs.iter().filter(is_large).collect();
        by_size.sort_by_key(|spec| Reverse(spec.text.len()));
        if let [largest, others @ ..] = by_size.as_slice()
            && !others.is_empty()
            && begin.elapsed() > COMPILED
            && is_worth_it(device)
        {
            let mut largest = large.iter().filter(|stage| stage.pipeline.name == largest.name);
            let here = || largest.try_for_each(|stage| stage.pipeline.warm_up(device));
            // What the other device does not compile, this one compiles below.
            let (_, done) = join(|| compile_beside(device, others, buffers), here);
            done?;
        }
        large.into_iter().try_for_each(warm_up)
    }

    /// Prepares for another job.
    pub fn begin(&mut self, job: &Job) {
        self.stages = StageTimes::default();
        self.drop_film();
        self.settings = Settings { max_depth: job.max_depth, seed: job.seed, ..self.settings };
    }

    /// Renders blocks of samples of every pixel until none are left.
    pub fn work(&mut self, shared: &SampleRange<'_, '_>) -> Result<()> {
        let samples = &shared.samples;
        self.settings.first_sample = samples.start;
        self.settings.end_sample = samples.end;
        self.write("settings", &self.kernels.settings_layout.bytes(&self.settings))?;
        self.paces[PathKind::Camera as usize].most = self.most_bounces(samples);
        self.paces[PathKind::Light as usize].most = u32::MAX;
        let pixels = u64::from(self.film.size.0) * u64::from(self.film.size.1);
        let pixels = u32::try_from(pixels).unwrap_or(u32::MAX);
        let light_paths = self.light_paths_of_block();
        let mut schedule = Schedule::new(pixels, self.tuning.tile, light_paths, self.tuning.slots, shared.devices > 1);
        while let Some(taken) = shared.take(&schedule) {
            let begin = Instant::now();
            let mut blocks = taken.clone();
            for tile in tiles(pixels, self.tuning.tile) {
                if tile != self.film.tile {
                    self.finish_film(shared)?;
                    self.film.tile = tile.clone();
                }
                // The first tile may end early. The others get as many blocks.
                blocks.end = self.render_tile(blocks.clone(), tile.start == 0, shared)?;
                if self.kernels.light_path.is_some() {
                    self.trace_light_paths(blocks.clone(), shared)?;
                }
            }
            schedule.adapt(begin.elapsed());
            if shared.finish(blocks, taken.end) {
                let begin = Instant::now();
                self.finish_film(shared)?;
                shared.show_complete(begin);
            }
        }
        // Other devices may show the film before this one renders again.
        if shared.devices > 1 { self.finish_film(shared) } else { Ok(()) }
    }

    /// Adds the device's film to the film on the host, or drops it after a pace probe.
    fn finish_film(&mut self, shared: &SampleRange<'_, '_>) -> Result<()> {
        let mut state = shared.state();
        if state.caller.drops_film() {
            self.drop_film();
            return Ok(());
        }
        self.read_film(&mut state.caller.film.film)
    }

    /// Renders blocks of samples of the tile, until every slot is idle. Returns one past the last block. If `may_end_early` and the caller
    /// decides so, the last block is the one that has been started.
    fn render_tile(&mut self, blocks: Range<u32>, may_end_early: bool, shared: &SampleRange<'_, '_>) -> Result<u32> {
        let pixels = self.film.tile.len() as u32;
        let (end, totals) = self.render_window(&blocks, pixels, PathKind::Camera, may_end_early, shared)?;
        let rendered = blocks.start..blocks.start + end / pixels;
        self.device.expect_done(totals.paths == u64::from(pixels) * self.samples_in(&rendered).len() as u64)?;
        Ok(rendered.end)
    }

    /// Traces the light paths of blocks of samples, of the whole image, until every slot is idle. They add light to the pixels of the tile.
    fn trace_light_paths(&mut self, blocks: Range<u32>, shared: &SampleRange<'_, '_>) -> Result<()> {
        let of_block = self.light_paths_of_block();
        let (_, totals) = self.render_window(&blocks, of_block, PathKind::Light, false, shared)?;
        let expected = light_paths_of(&self.samples_in(&blocks), u64::from(of_block));
        self.device.expect_done(totals.light_paths.into_iter().sum::<u64>() == expected)
    }

    /// Renders paths of a kind into the tile until every slot is idle, so many runs of each block. Returns the number of runs, and their totals.
    /// If `may_end_early` and the caller decides so, the last block is the one that has been started. Snapshots are of camera paths alone.
    fn render_window(
        &mut self,
        blocks: &Range<u32>,
        runs_of_block: u32,
        kind: PathKind,
        may_end_early: bool,
        shared: &SampleRange<'_, '_>,
    ) -> Result<(u32, Totals)> {
        let (first_block, end) = (blocks.start, blocks.len() as u32 * runs_of_block);
        let (first_pixel, pixels) = (self.film.tile.start, self.film.tile.len() as u32);
        let mut window = Window { first_block, end, first_pixel, pixels, begins: 1, ..Window::default() };
        self.write("counters", bytemuck::bytes_of(&Counters::default()))?;
        let mut flights: VecDeque<Flight> = VecDeque::new();
        let mut counters = Counters::default();
        let mut submitted = 0;
        let mut wants_snapshot = false;
        // Whether the tile must end early, and whether its end is set, which nothing may be in flight for.
        let (mut to_cut, mut cut) = (false, false);
        loop {
            // If all runs have been started, a second submission might find only idle slots. Each slot takes a run in its first one.
            let wanted = if counters.next.max(self.tuning.slots) < window.end { IN_FLIGHT } else { 1 };
            while counters.idle < self.tuning.slots && !wants_snapshot && !to_cut && flights.len() < wanted {
                flights.push_back(self.submit(&mut window, submitted, kind)?);
                submitted += 1;
            }
            match flights.pop_front() {
                Some(flight) => {
                    let before = std::mem::replace(&mut counters, self.finish(flight)?);
                    let mut counted = totals_since(&counters, &before);
                    if first_pixel > 0 {
                        // Every tile has the same light paths.
                        counted.light_paths = [0; 2];
                    }
                    self.film.received += counted;
                    match shared.state().caller.add(counted) {
                        Next::Snapshot => wants_snapshot = kind == PathKind::Camera,
                        Next::Drop => return Err(Error::Dropped),
                        _ => {}
                    }
                }
                None if to_cut => {
                    (to_cut, cut) = (false, true);
                    let started = counters.next.div_ceil(runs_of_block).max(1);
                    window.end = window.end.min(started.saturating_mul(runs_of_block));
                    continue;
                }
                None if wants_snapshot => {
                    wants_snapshot = false;
                    let begin = Instant::now();
                    let mut state = shared.state();
                    self.read_film(&mut state.caller.film.film)?;
                    state.caller.notify(Some((begin, false)));
                }
                None => break,
            }
            to_cut |= may_end_early && !cut && shared.state().ends_early();
        }
        Ok((window.end, totals_since(&counters, &Counters::default())))
    }

    /// The samples that are rendered of these blocks.
    fn samples_in(&self, blocks: &Range<u32>) -> Range<u32> {
        samples_of(blocks, &(self.settings.first_sample..self.settings.end_sample))
    }

    /// The light paths of a block of samples: of all pixels of the image, also where a part of it is rendered.
    fn light_paths_of_block(&self) -> u32 {
        let Settings { image_width, image_height, light_paths, .. } = self.settings;
        image_width * image_height * light_paths
    }

    /// Waits for a submission, and returns its counters.
    fn finish(&mut self, flight: Flight) -> Result<Counters> {
        let Flight { submission, receipt, reading, kind, work, begun, begin } = flight;
        let Feedback { counters, timing } = &mut self.readings[reading];
        let bytes = size_of::<Counters>() as u64;
        let counted: Counters = counters.read(&self.device, submission.clone(), bytes, bytemuck::pod_read_unaligned)?;
        // Each slot asks for a run in its first submission.
        self.device.expect_done(counted.receipt == receipt && counted.next >= begun)?;
        if let Some(timing) = timing {
            timing.collect(&self.device, submission, &mut self.stages)?;
        }
        self.paces[kind as usize].adapt(work, begin);
        Ok(counted)
    }

    /// Drops the contents of the device's film. A buffer that was never written is clear.
    pub fn drop_film(&mut self) {
        self.film.is_stale = !self.film.tile.is_empty();
        self.film.received = Totals::default();
    }

    /// Adds the totals of the device's film to the film on the host.
    pub fn read_film(&mut self, film: &mut Film) -> Result<()> {
        let DeviceFilm { size, aovs, light_paths, neighbours, readback, tile, received, is_stale, .. } = &mut self.film;
        if *received == Totals::default() {
            return Ok(());
        }
        let motion = neighbours.as_ref().map(|neighbours| |seen| neighbours.motion(seen));
        let motion = motion.as_ref().map(|motion| motion as MotionOf<'_>);
        let each = device_bytes(aovs, *light_paths);
        let at_once = (readback.room() / each).clamp(1, u64::from(u32::MAX)) as u32;
        for first in tile.clone().step_by(at_once as usize) {
            let end = tile.end.min(first.saturating_add(at_once));
            let bytes = u64::from(end - first) * each;
            let mut encoder = self.device.encoder("film");
            let from = u64::from(first - tile.start) * each;
            readback.copy(&self.device, &mut encoder, self.buffers.get("film")?, from, bytes)?;
            readback.read(&self.device, self.device.submit(encoder), bytes, |bytes| {
                let indices = (first..end).map(|rank| pixel_in_order(rank, *size));
                film.add_from_device(indices, bytes, motion);
            })?;
        }
        film.add([], std::mem::take(received));
        *is_stale = true;
        Ok(())
    }

    /// Refuses a film of another size, other channels, or another radiance exponent, which would change the brightness, and one that has light
    /// paths where the render has none, or the reverse.
    pub fn check_film(&self, job: &Job, film: &Film) -> Result<()> {
        let needed = (job.size, self.film.exponent, &self.film.aovs, self.film.light_paths);
        let found = ((film.width(), film.height()), film.exponent, film.aovs(), film.has_light_paths());
        if found == needed {
            return Ok(());
        }
        let words = |((width, height), scale, aovs, light_paths): ((u32, u32), i32, &Aovs, bool)| {
            let more: Vec<String> =
                aovs.words().into_iter().chain(light_paths.then(|| "light paths".to_string())).collect();
            let more = if more.is_empty() { String::new() } else { format!(" with {}", more.join(" and ")) };
            format!("{width} x {height} pixels of the scale 2^{scale}{more}")
        };
        Err(Error::Usage(format!("the render needs a film of {}, found {}", words(needed), words(found))))
    }

    /// Records and submits a pass of camera paths or of light paths; `number` counts the passes of the tile. Each pass has some bounces of the
    /// next slots, and adds the finished runs to the film. After the last slots come the first ones again. The first pass of a slot gives it
    /// a run.
    fn submit(&mut self, window: &mut Window, number: usize, kind: PathKind) -> Result<Flight> {
        let begin = Instant::now();
        let all = self.tuning.slots;
        if window.end_slot == all {
            (window.end_slot, window.begins) = (0, 0);
        }
        let (slots, bounces) = self.paces[kind as usize].next(all - window.end_slot, all);
        (window.first_slot, window.end_slot) = (window.end_slot, window.end_slot + slots);
        let reading = number % IN_FLIGHT;
        let receipt = self.readings[reading].counters.next_receipt();
        (window.bounces, window.receipt) = (bounces, receipt);
        self.write("window", bytemuck::bytes_of(window))?;
        let mut encoder = self.device.encoder("pass");
        if std::mem::take(&mut self.film.is_stale) {
            encoder.clear_buffer(self.buffers.get("film")?, 0, None);
        }
        let groups = slots.div_ceil(self.tuning.workgroup);
        let Pipelines { generate, bounce, is_fused, accumulate, truth, light_path, receipt: last, .. } = &self.kernels;
        let repeated = (0..if *is_fused { 1 } else { bounces }).flat_map(|_| bounce);
        let first = (window.begins == 1).then_some(generate);
        let stages: Vec<&Stage> = match kind {
            PathKind::Camera => first.into_iter().chain(repeated).chain(truth).chain([accumulate, last]).collect(),
            PathKind::Light => light_path.iter().chain([last]).collect(),
        };
        let sizes = self.buffers.get("queue_args").ok();
        let Feedback { counters: readback, timing } = &mut self.readings[reading];
        match timing {
            None => {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                stages.iter().for_each(|stage| stage.record(&mut pass, groups, sizes));
            }
            Some(timing) => {
                for stage in &stages {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some(&stage.pipeline.name),
                        timestamp_writes: timing.next(&stage.pipeline.name),
                    });
                    stage.record(&mut pass, groups, sizes);
                }
                timing.resolve(&self.device, &mut encoder)?;
            }
        }
        let counters = self.buffers.get("counters")?;
        // The records have been added to the film.
        encoder.clear_buffer(counters, std::mem::offset_of!(Counters, records) as u64, Some(4));
        readback.copy(&self.device, &mut encoder, counters, 0, size_of::<Counters>() as u64)?;
        let (work, begun) =
            (u64::from(slots) * u64::from(bounces), if window.begins == 1 { window.end_slot } else { all });
        Ok(Flight { submission: self.device.submit(encoder), receipt, reading, kind, work, begun, begin })
    }

    /// The most bounces of a submission, for which there are records for all finished runs: a slot finishes the run that it has, and then at
    /// most one run for as many bounces as the run has samples. If passes are timed, there is also a timestamp for each.
    fn most_bounces(&self, samples: &Range<u32>) -> u32 {
        let has_full_runs = samples.start.is_multiple_of(RUN_LENGTH) && samples.end.is_multiple_of(RUN_LENGTH);
        let shortest = match has_full_runs {
            true => RUN_LENGTH,
            false => {
                let blocks = blocks(samples.clone());
                let first = ((blocks.start + 1) * RUN_LENGTH).min(samples.end) - samples.start;
                let last = samples.end - (samples.end - 1) / RUN_LENGTH * RUN_LENGTH;
                first.min(last)
            }
        };
        let kernels = self.kernels.bounce.len() as u32;
        let timed = match self.readings.iter().any(|reading| reading.timing.is_some()) {
            // Without the first kernel and the last three.
            true => (MAX_PASSES as u32 - 4) / kernels,
            false => u32::MAX,
        };
        ((self.tuning.records_per_slot - 1) * shortest).clamp(1, timed)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.device.write(self.buffers.get(name)?, bytes)
    }
}

impl Workload {
    /// The slots and bounces of the next submission, if so many slots of all are left. What is left is divided evenly.
    fn next(&self, left: u32, all: u32) -> (u32, u32) {
        if let Some(bounces) = self.fixed {
            return (left, bounces.clamp(1, self.most));
        }
        let parts = u64::from(left).div_ceil(self.work);
        let slots = u64::from(left).div_ceil(parts.max(1)) as u32;
        (slots, (self.work / u64::from(all)).clamp(1, u64::from(self.most)) as u32)
    }

    /// Sets the work of the next submission by the time of one that began at `begin` and has just ended.
    fn adapt(&mut self, work: u64, begin: Instant) {
        // The device starts a submission when the previous one has ended.
        let now = Instant::now();
        let took = now - begin.max(std::mem::replace(&mut self.last_end, now));
        let ratio = self.submission.as_secs_f64() / took.as_secs_f64().max(1e-6);
        self.work = ((work as f64 * ratio.clamp(0.25, 4.0)) as u64).max(LEAST_WORK);
    }
}

impl Stage {
    /// `groups` is the number of workgroups for all slots, and `sizes` has those of the queues.
    fn record(&self, pass: &mut wgpu::ComputePass<'_>, groups: u32, sizes: Option<&wgpu::Buffer>) {
        match (&self.size, sizes) {
            (StageSize::Slots, _) => self.pipeline.dispatch(pass, groups),
            (StageSize::One, _) => self.pipeline.dispatch(pass, 1),
            (StageSize::Queue(queue), Some(sizes)) => self.pipeline.dispatch_indirect(pass, sizes, queue * 16),
            (StageSize::Queue(_), None) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(work: u64) -> Workload {
        Workload { work, fixed: None, most: 120, submission: SUBMISSION, last_end: Instant::now() }
    }

    /// Little first; then some slots, all of them, and bounces of all, up to the most.
    #[test]
    fn submissions_grow_from_little() {
        let all = 1 << 20;
        assert_eq!(pace(LEAST_WORK).next(all, all), (1024, 1));
        // Evenly: 700,000 would leave a third.
        assert_eq!(pace(700_000).next(all, all), (all / 2, 1));
        assert_eq!(pace(700_000).next(all / 2, all), (all / 2, 1));
        assert_eq!(pace(7 << 20).next(all, all), (all, 7));
        assert_eq!(pace(1 << 40).next(all, all), (all, 120));
        assert_eq!(pace(1 << 40).next(5, all), (5, 120));
        assert_eq!(Workload { fixed: Some(3), ..pace(LEAST_WORK) }.next(all, all), (all, 3));
    }

    /// A device that needs a second for each bounce of all slots gets a tenth of them, within four submissions.
    #[test]
    fn a_slow_device_gets_fewer_slots_at_a_time() {
        let mut slow = pace(1 << 20);
        for _ in 0..4 {
            let took = Duration::from_secs(1).mul_f64(slow.work as f64 / f64::from(1 << 20));
            slow.last_end = Instant::now() - took;
            slow.adapt(slow.work, slow.last_end);
        }
        let slots = slow.next(1 << 20, 1 << 20).0;
        assert!((95_000..=105_000).contains(&slots), "{slots}");
    }

    /// What takes no time gets four times as much; what takes for ever a fourth, but never nothing.
    #[test]
    fn the_work_changes_by_a_factor_of_four_at_most() {
        let mut fast = pace(5000);
        fast.adapt(5000, Instant::now());
        assert_eq!(fast.work, 20_000);
        let mut slow = pace(5000);
        for expected in [1250, LEAST_WORK, LEAST_WORK] {
            slow.last_end = Instant::now() - Duration::from_secs(100);
            slow.adapt(slow.work, slow.last_end);
            assert_eq!(slow.work, expected);
        }
    }
}
