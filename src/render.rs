//! The render loop of a device: generate → { { intersect → scatter → refill } … → accumulate } …

mod goals;
mod outcome;
mod renderer;
mod stretch;
mod turns;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::time::{Duration, Instant};

use crate::aov::Aovs;
use crate::data::{Counters, RUN_LENGTH, Settings, Window};
use crate::error::{Error, Result};
use crate::film::{Film, Totals, device_bytes};
use crate::gpu::buffers::{Buffers, Readback};
use crate::gpu::device::Device;
use crate::gpu::pipeline::{Pipeline, PipelineSpec};
use crate::gpu::probe;
use crate::gpu::timing::{MAX_PASSES, StageTimes, Timing};
use crate::job::{Job, blocks};
use crate::plan::{Bounce, Kernel, Plan, STEPS, SettingsLayout, Tuning};
pub use goals::{FIRST_LOOK, LAST_LOOK, look_after, look_at};
use outcome::totals_since;
pub use outcome::{NOISE_LEVEL, Noise, Outcome, level_after};
pub use renderer::{Renderer, empty_film};
use stretch::{Pilot, Shared};
use turns::{Rounds, Turn, pixel_in_order, tiles};

/// A look at the film of a render that goes on.
pub struct Look<'a> {
    pub film: &'a Film,
    /// When the device became idle for the look.
    pub begin: Instant,
    /// Whether the film is whole: every pixel has the outcome's samples, and none beyond.
    pub whole: bool,
}

/// Called after each submission with the render's outcome so far, and with the film if the last call asked for a look. Each device has a
/// thread, which calls.
pub type Watch<'a> = &'a mut (dyn FnMut(&Outcome, Option<Look<'_>>) -> Next + Send);

/// What the caller of a render wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    GoOn,
    /// Bring the film up to date, and show it as a [`Look`]. Runs that are under way are not in it.
    Look,
    /// End the block of samples that has been started, and show the film when it is whole.
    Whole,
    /// End the block of samples that has been started, and nothing after it.
    Stop,
    /// End at once. Nobody wants the image: the render fails with [`Error::Dropped`].
    Drop,
}

/// The time that a submission should take, unless a caller wants to be asked more often: long enough to hide what it costs to make one,
/// short enough that no watchdog fires and no user waits.
const SUBMISSION: Duration = Duration::from_millis(100);
/// Submissions in flight. While the device executes one, the next one waits in its queue, and the host reads the counters of the last one.
const IN_FLIGHT: usize = 2;
/// Bytes of the film that go to the host at a time.
const FILM_AT_ONCE: u64 = 16 << 20;

/// A device that is ready to render: kernels compiled, buffers filled.
struct Lane<'a> {
    device: &'a Device,
    settings: Settings,
    settings_layout: SettingsLayout,
    size: (u32, u32),
    /// The scale of the film, as that of the scene.
    exponent: i32,
    /// The channels that the film has beside the radiance.
    aovs: Aovs,
    tuning: Tuning,
    /// Bounces of the next submission, and whether their number is fixed.
    bounces: u32,
    bounces_fixed: bool,
    /// Bounces of a submission at most.
    most_bounces: u32,
    /// The time that a submission should take.
    submission: Duration,
    buffers: Buffers,
    generate: Pipeline,
    bounce: BouncePipelines,
    accumulate: Pipeline,
    /// One for each submission in flight.
    reports: Vec<Report>,
    /// The film on its way to the host.
    film: Readback,
    /// The tile that the device's film is of.
    tile: Range<u32>,
    /// What the device's film has received since it was last brought to the host.
    received: Totals,
    /// Whether its contents are no longer needed. If so, the next submission clears it.
    stale: bool,
    stages: StageTimes,
    /// When the last submission ended.
    landed: Instant,
}

/// What a submission reports to the host.
struct Report {
    counters: Readback,
    timing: Option<Timing>,
}

/// A submission that the device has not reported on yet.
struct Flight {
    submission: wgpu::SubmissionIndex,
    /// Its place among the reports.
    report: usize,
    bounces: u32,
    begin: Instant,
}

impl BouncePipelines {
    /// All of them, in order.
    fn pipelines(&self) -> impl Iterator<Item = &Pipeline> {
        let (stages, last) = match self {
            BouncePipelines::Fused(bounce) => (None, bounce),
            BouncePipelines::Staged { intersect, medium, dispatch, scatter, shadow, refill } => {
                (Some(std::iter::once(intersect).chain(medium).chain(dispatch).chain(scatter).chain(shadow)), refill)
            }
        };
        stages.into_iter().flatten().chain(std::iter::once(last))
    }
}

/// The pipelines of a plan's `Bounce`.
enum BouncePipelines {
    Fused(Pipeline),
    Staged {
        intersect: Pipeline,
        medium: Option<Pipeline>,
        dispatch: Option<Pipeline>,
        scatter: Vec<Pipeline>,
        shadow: Option<Pipeline>,
        refill: Pipeline,
    },
}

impl<'a> Lane<'a> {
    /// Allocates the buffers and compiles the kernels.
    ///
    /// # Errors
    /// `Error::Device` where a buffer exceeds the device's limits or memory, a kernel does not compile, or one relies on what the
    /// numerics probe does not find.
    fn new(device: &'a Device, plan: &Plan<'_>, job: &Job, profile: bool) -> Result<Lane<'a>> {
        let tuning = plan.tuning;
        let most_slots = u64::from(device.limits.max_compute_workgroups_per_dimension) * u64::from(tuning.workgroup);
        if u64::from(tuning.slots) > most_slots {
            return Err(Error::Usage(format!(
                "--slots {}: expected {most_slots} at most, with workgroups of {} invocations on {}",
                tuning.slots, tuning.workgroup, device.name
            )));
        }
        let numerics = probe::numerics(device)?;
        let allowed = |kernel: &Kernel| numerics.allow(device, &kernel.name, &kernel.linked);
        plan.kernels().into_iter().try_for_each(allowed)?;
        let most_steps = numerics.most_steps().map(f64::from);
        let of_steps = |name| most_steps.map(|most| (name, most));
        let constants: Vec<_> = STEPS.into_iter().filter_map(of_steps).collect();
        let buffers = Buffers::create(device, &plan.buffers())?;
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
        let pipelines = Pipeline::all(device, &specs, &buffers)?;
        let mut named: BTreeMap<_, _> =
            pipelines.into_iter().map(|pipeline| (pipeline.name.clone(), pipeline)).collect();
        let mut pipeline = |kernel: &Kernel| {
            let missing = || Error::Shader(format!("the plan has two kernels named {}", kernel.name));
            named.remove(&kernel.name).ok_or_else(missing)
        };
        let bounce = match &plan.kernels.bounce {
            Bounce::Fused(kernel) => BouncePipelines::Fused(pipeline(kernel)?),
            Bounce::Staged(staged) => BouncePipelines::Staged {
                intersect: pipeline(&staged.intersect)?,
                medium: staged.medium.as_ref().map(&mut pipeline).transpose()?,
                dispatch: staged.dispatch.as_ref().map(&mut pipeline).transpose()?,
                scatter: staged.scatter.iter().map(&mut pipeline).collect::<Result<_>>()?,
                shadow: staged.shadow.as_ref().map(&mut pipeline).transpose()?,
                refill: pipeline(&staged.refill)?,
            },
        };
        let film_bytes = u64::from(tuning.tile) * device_bytes(&plan.options.aov);
        let report = |_| Report {
            counters: Readback::new(device, "counters", size_of::<Counters>() as u64),
            timing: if profile { Timing::new(device) } else { None },
        };
        let settings = Settings {
            max_depth: job.max_depth,
            seed: job.seed,
            slots: tuning.slots,
            film_width: job.size.0,
            film_height: job.size.1,
            indirect_limit: plan.indirect_limit(),
            ..plan.scene.settings
        };
        let lane = Lane {
            device,
            settings,
            settings_layout: plan.kernels.settings.clone(),
            size: job.size,
            exponent: plan.scene.radiance_exponent,
            aovs: plan.options.aov.of_film(),
            bounces: tuning.bounces.unwrap_or(1),
            bounces_fixed: tuning.bounces.is_some(),
            most_bounces: 1,
            submission: SUBMISSION,
            generate: pipeline(&plan.kernels.generate)?,
            bounce,
            accumulate: pipeline(&plan.kernels.accumulate)?,
            reports: (0..IN_FLIGHT).map(report).collect(),
            film: Readback::new(device, "film", film_bytes.min(FILM_AT_ONCE)),
            tile: 0..0,
            received: Totals::default(),
            stale: false,
            stages: StageTimes::default(),
            landed: Instant::now(),
            tuning,
            buffers,
        };
        lane.warm_up()?;
        Ok(lane)
    }

    /// Dispatches nothing by each kernel: some drivers compile at the first dispatch.
    fn warm_up(&self) -> Result<()> {
        let mut encoder = self.encoder();
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let stages = [&self.generate, &self.accumulate].into_iter().chain(self.bounce.pipelines());
            stages.for_each(|pipeline| pipeline.dispatch(&mut pass, 0));
        }
        self.device.wait(self.device.queue.submit([encoder.finish()]))
    }

    /// Gets ready for another job.
    fn begin(&mut self, job: &Job) {
        self.stages = StageTimes::default();
        self.drop_film();
        self.settings = Settings { max_depth: job.max_depth, seed: job.seed, ..self.settings };
    }

    /// Renders blocks of samples of every pixel while there are any left.
    fn work(&mut self, shared: &Shared<'_, '_>) -> Result<()> {
        let samples = &shared.samples;
        self.settings.first_sample = samples.start;
        self.settings.end_sample = samples.end;
        self.write("settings", &self.settings_layout.bytes(&self.settings))?;
        self.most_bounces = self.most_bounces(samples);
        let pixels = u64::from(self.size.0) * u64::from(self.size.1);
        let pixels = u32::try_from(pixels).unwrap_or(u32::MAX);
        let mut rounds = Rounds::new(pixels, self.tuning.tile, shared.lanes > 1);
        while let Some(taken) = shared.take(&rounds) {
            let begin = Instant::now();
            let mut round = taken.clone();
            for tile in tiles(pixels, self.tuning.tile) {
                if tile != self.tile {
                    self.hand_over(shared)?;
                    self.tile = tile.clone();
                }
                // The first tile may end the round early. The others get the same samples.
                let first = tile.start == 0;
                round.end = self.render_turn(&Turn { pixels: tile, blocks: round.clone() }, first, shared)?;
            }
            rounds.took(begin.elapsed());
            if shared.note(round, taken.end) {
                let begin = Instant::now();
                self.hand_over(shared)?;
                shared.show_whole(begin);
            }
        }
        // The others may show the film before this lane renders again.
        if shared.lanes > 1 { self.hand_over(shared) } else { Ok(()) }
    }

    /// Brings what the device's film has received to the film on the host, or drops it if nobody wants it.
    fn hand_over(&mut self, shared: &Shared<'_, '_>) -> Result<()> {
        let mut state = shared.state();
        match state.stretch.pilot {
            Some(Pilot { discards: true }) => self.drop_film(),
            _ => self.bring_film(state.stretch.film)?,
        }
        Ok(())
    }

    /// Renders the runs of a turn, until every slot is idle. The result is one past the last block: if the turn may end early and is asked to, it
    /// ends with the block that has been started.
    fn render_turn(&mut self, turn: &Turn, may_end_early: bool, shared: &Shared<'_, '_>) -> Result<u32> {
        let pixels = turn.pixels.len() as u32;
        let first_block = turn.blocks.start;
        let end = turn.blocks.len() as u32 * pixels;
        let mut window = Window { first_block, end, bounces: 0, first_pixel: turn.pixels.start, pixels };
        self.write("counters", bytemuck::bytes_of(&Counters::default()))?;
        let mut flights: VecDeque<Flight> = VecDeque::new();
        let mut counters = Counters::default();
        let mut submitted = 0;
        let mut look = false;
        // Whether the turn ends early, and whether its end is known: nothing may be in flight for that.
        let (mut to_cut, mut cut) = (false, false);
        loop {
            // If all runs have been started, a second submission might find only idle slots. Each slot asks for a run in the first
            // submission.
            let wanted = if counters.next.max(self.tuning.slots) < window.end { IN_FLIGHT } else { 1 };
            while counters.idle < self.tuning.slots && !look && !to_cut && flights.len() < wanted {
                flights.push_back(self.submit(&mut window, submitted)?);
                submitted += 1;
            }
            match flights.pop_front() {
                Some(flight) => {
                    let before = std::mem::replace(&mut counters, self.land(flight)?);
                    let counted = totals_since(&counters, &before);
                    self.received += counted;
                    match shared.state().stretch.landed(counted) {
                        Next::Look => look = true,
                        Next::Drop => return Err(Error::Dropped),
                        _ => {}
                    }
                }
                None if to_cut => {
                    (to_cut, cut) = (false, true);
                    let started = counters.next.div_ceil(pixels).max(1);
                    window.end = window.end.min(started.saturating_mul(pixels));
                    continue;
                }
                None if look => {
                    look = false;
                    let begin = Instant::now();
                    let mut state = shared.state();
                    self.bring_film(state.stretch.film)?;
                    state.stretch.ask(Some((begin, false)));
                }
                None => break,
            }
            to_cut |= may_end_early && !cut && shared.state().ends_early();
        }
        Ok(first_block + window.end / pixels)
    }

    /// Waits for a submission, and reads what it has counted.
    fn land(&mut self, flight: Flight) -> Result<Counters> {
        let Flight { submission, report, bounces, begin } = flight;
        let Report { counters, timing } = &mut self.reports[report];
        let bytes = size_of::<Counters>() as u64;
        let counted = counters.read(self.device, submission.clone(), bytes, bytemuck::pod_read_unaligned)?;
        if let Some(timing) = timing {
            timing.collect(self.device, submission, &mut self.stages)?;
        }
        // The device starts a submission when the one before has ended.
        let now = Instant::now();
        let took = now - begin.max(std::mem::replace(&mut self.landed, now));
        self.adapt(bounces, took);
        Ok(counted)
    }

    /// Drops what the device's film has received. A buffer that nobody has written is clear.
    fn drop_film(&mut self) {
        self.stale = !self.tile.is_empty();
        self.received = Totals::default();
    }

    /// Adds the totals of the device's film to the film on the host.
    fn bring_film(&mut self, film: &mut Film) -> Result<()> {
        if self.received == Totals::default() {
            return Ok(());
        }
        let each = device_bytes(&self.aovs);
        let at_once = (self.film.room() / each).clamp(1, u64::from(u32::MAX)) as u32;
        let tile = self.tile.clone();
        let places: Vec<u32> = tile.clone().step_by(at_once as usize).collect();
        for first in places {
            let end = tile.end.min(first.saturating_add(at_once));
            let bytes = u64::from(end - first) * each;
            let mut encoder = self.encoder();
            self.film.copy(&mut encoder, self.buffers.get("film")?, u64::from(first - tile.start) * each, bytes);
            let submission = self.device.queue.submit([encoder.finish()]);
            self.film.read(self.device, submission, bytes, |bytes| {
                let indices = (first..end).map(|place| pixel_in_order(place, self.size));
                film.add_from_device(indices, bytes);
            })?;
        }
        film.add([], std::mem::take(&mut self.received));
        self.stale = true;
        Ok(())
    }

    /// Records and submits a pass; `number` counts the passes of the turn. The first pass gives each slot a run. Each pass has some bounces,
    /// and adds the finished runs to the film.
    fn submit(&mut self, window: &mut Window, number: usize) -> Result<Flight> {
        let bounces = self.bounces.clamp(1, self.most_bounces);
        window.bounces = bounces;
        self.write("window", bytemuck::bytes_of(window))?;
        let begin = Instant::now();
        let report = number % IN_FLIGHT;
        let mut encoder = self.encoder();
        if std::mem::take(&mut self.stale) {
            encoder.clear_buffer(self.buffers.get("film")?, 0, None);
        }
        let groups = self.tuning.slots.div_ceil(self.tuning.workgroup);
        let mut stages: Vec<Stage<'_>> = Vec::new();
        if number == 0 {
            stages.push(Stage::all(&self.generate, groups));
        }
        match &self.bounce {
            BouncePipelines::Fused(bounce) => stages.push(Stage::all(bounce, groups)),
            BouncePipelines::Staged { intersect, medium, dispatch, scatter, shadow, refill } => {
                for _ in 0..bounces {
                    stages.push(Stage::all(intersect, groups));
                    stages.extend(medium.iter().map(|medium| Stage::all(medium, groups)));
                    match dispatch {
                        None => stages.extend(scatter.iter().map(|kernel| Stage::all(kernel, groups))),
                        Some(dispatch) => {
                            stages.push(Stage::all(dispatch, 1));
                            stages.extend((0..).zip(scatter).map(|(queue, kernel)| Stage::queue(kernel, queue)));
                        }
                    }
                    stages.extend(shadow.iter().map(|shadow| Stage::all(shadow, groups)));
                    stages.push(Stage::all(refill, groups));
                }
            }
        }
        stages.push(Stage::all(&self.accumulate, groups));
        let sizes = self.buffers.get("queue_args").ok();
        let Report { counters: readback, timing } = &mut self.reports[report];
        match timing {
            None => {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                stages.iter().for_each(|stage| stage.record(&mut pass, sizes));
            }
            Some(timing) => {
                for stage in &stages {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some(&stage.kernel.name),
                        timestamp_writes: timing.next(&stage.kernel.name),
                    });
                    stage.record(&mut pass, sizes);
                }
                timing.resolve(&mut encoder);
            }
        }
        let counters = self.buffers.get("counters")?;
        readback.copy(&mut encoder, counters, 0, size_of::<Counters>() as u64);
        // The film now has the runs of the records.
        encoder.clear_buffer(counters, std::mem::offset_of!(Counters, records) as u64, Some(4));
        let submission = self.device.queue.submit([encoder.finish()]);
        Ok(Flight { submission, report, bounces, begin })
    }

    /// The most bounces of a submission. They leave room for the records of all finished runs: a slot finishes the run that it has, and then
    /// at most one for each bounce of its samples. There is also a timestamp for each pass, if passes are timed.
    fn most_bounces(&self, samples: &Range<u32>) -> u32 {
        let whole = samples.start.is_multiple_of(RUN_LENGTH) && samples.end.is_multiple_of(RUN_LENGTH);
        let shortest = match whole {
            true => RUN_LENGTH,
            false => {
                let blocks = blocks(samples.clone());
                let first = ((blocks.start + 1) * RUN_LENGTH).min(samples.end) - samples.start;
                let last = samples.end - (samples.end - 1) / RUN_LENGTH * RUN_LENGTH;
                first.min(last)
            }
        };
        let kernels = self.bounce.pipelines().count() as u32;
        let timed = match self.reports.iter().any(|report| report.timing.is_some()) {
            // Beside the first kernel and the last.
            true => (MAX_PASSES as u32 - 2) / kernels,
            false => u32::MAX,
        };
        ((self.tuning.records_per_slot - 1) * shortest).clamp(1, timed)
    }

    /// Aims the next submission at its target time.
    fn adapt(&mut self, bounces: u32, took: Duration) {
        if !self.bounces_fixed {
            let ratio = self.submission.as_secs_f64() / took.as_secs_f64().max(1e-6);
            self.bounces = (f64::from(bounces) * ratio.clamp(0.25, 4.0)).round().clamp(1.0, 4096.0) as u32;
        }
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("pass") })
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.device.write(self.buffers.get(name)?, bytes)
    }
}

/// A dispatch of a pass.
struct Stage<'a> {
    kernel: &'a Pipeline,
    size: StageSize,
}

enum StageSize {
    Groups(u32),
    Queue(u64),
}

impl<'a> Stage<'a> {
    fn all(kernel: &'a Pipeline, groups: u32) -> Stage<'a> {
        Stage { kernel, size: StageSize::Groups(groups) }
    }

    fn queue(kernel: &'a Pipeline, queue: u64) -> Stage<'a> {
        Stage { kernel, size: StageSize::Queue(queue * 16) }
    }

    fn record(&self, pass: &mut wgpu::ComputePass<'_>, sizes: Option<&wgpu::Buffer>) {
        match (&self.size, sizes) {
            (StageSize::Groups(groups), _) => self.kernel.dispatch(pass, *groups),
            (StageSize::Queue(offset), Some(sizes)) => self.kernel.dispatch_indirect(pass, sizes, *offset),
            (StageSize::Queue(_), None) => {}
        }
    }
}
