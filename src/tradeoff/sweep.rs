//! The measurement: renders all settings in turn, round after round with new random numbers, until the time is over.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::pace::Timed;
use super::replicates::{FEWEST_ROUNDS, Pixels};
use crate::aov::Aov;
use crate::data;
use crate::denoise::{Denoiser, Noisy};
use crate::error::{Error, Result};
use crate::film::{Accumulation, Film};
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::job::{Frame, Goal, Job};
use crate::options::{Class, LightPaths, OptionSpec, RenderOptions};
use crate::plan::{Plan, Tuning};
use crate::render::stopping;
use crate::scene::Scene;
use crate::session::Session;

/// The samples per pixel of the blocks of a round. Biases are measured with the middle one.
pub const LEVELS: [u32; 3] = [4, 16, 64];
/// Every round has blocks of the first level and of this one. The last level costs most, and has a block only every few rounds.
pub const LEVEL: u32 = LEVELS[1];
const ROUNDS_OF_LAST: usize = 4;
/// The most rounds of a sweep.
pub const MOST_ROUNDS: usize = 32;
/// Whether to stop. The threads of all devices call it.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The number of rounds from one block of `samples` samples to the next.
pub fn rounds_between(samples: u32) -> usize {
    if samples == LEVELS[2] { ROUNDS_OF_LAST } else { 1 }
}

/// The defaults are timed after this number of blocks of [`LEVEL`] samples, as the clock of the other settings' times.
const BLOCKS_A_CLOCK: usize = 3;

/// The mean cost of a round for a setting and its share of the clock, in samples per pixel.
pub const SAMPLES_OF_ROUND: f64 =
    LEVELS[0] as f64 + LEVEL as f64 * (1.0 + 1.0 / BLOCKS_A_CLOCK as f64) + LEVELS[2] as f64 / ROUNDS_OF_LAST as f64;
/// The cost of the fewest rounds, in samples per pixel.
pub const SAMPLES_OF_FEWEST: f64 = FEWEST_ROUNDS as f64 * (LEVELS[0] + 2 * LEVEL) as f64 + LEVELS[2] as f64;

/// The defaults with one option changed, or the defaults themselves.
#[derive(Clone, Debug)]
pub struct Setting {
    /// None for the defaults.
    pub option: Option<&'static OptionSpec>,
    /// The option's value, as the command line writes it.
    pub value: String,
    pub options: RenderOptions,
    pub max_depth: u32,
    /// The ratio of the image's sides to those of the sweep.
    pub scale: f64,
    /// Whether its images are denoised.
    pub denoise: bool,
}

impl Setting {
    /// `--clamp 10`, or `defaults`.
    pub fn name(&self) -> String {
        self.option.map_or("defaults".to_string(), |option| option.option(&self.value))
    }

    /// The class that its option declares.
    pub fn class(&self) -> Class {
        self.option.map_or(Class::Exact, |option| option.class)
    }

    /// Whether its option is declared to keep the expectation.
    pub fn declared_unbiased(&self) -> bool {
        matches!(self.class(), Class::Exact | Class::Noise)
    }
}

/// An image and the seconds that it took.
#[derive(Clone, Debug)]
pub struct Block {
    pub image: Pixels,
    /// Only the time of the passes, since the sweep began, without denoising, whose time does not grow with the samples.
    pub timed: Timed,
}

/// A setting under measurement.
pub struct Subject {
    pub setting: Setting,
    session: Session,
    film: Accumulation,
    /// The time to build its hierarchies and to compile its kernels.
    pub seconds_compile: f64,
    /// The blocks for each number of samples per pixel, in the order of the rounds. The n-th blocks of all subjects
    /// have the same random numbers.
    pub blocks: BTreeMap<u32, Vec<Block>>,
    /// All samples of the blocks in one film, for the error that it states.
    pub total: Film,
}

impl Subject {
    /// The blocks with this number of samples per pixel.
    pub fn blocks_of(&self, samples: u32) -> &[Block] {
        self.blocks.get(&samples).map_or(&[], Vec::as_slice)
    }

    /// The images with this number of samples per pixel.
    pub fn images(&self, samples: u32) -> Vec<Pixels> {
        self.blocks_of(samples).iter().map(|block| block.image.clone()).collect()
    }
}

/// A setting that is not measured, and the reason.
#[derive(Clone, Debug)]
pub struct Unmeasured {
    pub setting: Setting,
    pub why: String,
}

/// All measurements, the defaults first.
pub struct Sweep<'a> {
    pub size: (u32, u32),
    pub subjects: Vec<Subject>,
    pub unmeasured: Vec<Unmeasured>,
    device: &'a Arc<Device>,
    scene: &'a Scene,
    /// Without it, settings that denoise are not measured.
    pub denoiser: Option<&'a Denoiser>,
    pub seed: u32,
    /// The number of rounds that all subjects have.
    rounds: usize,
    /// When it began, and the times of the defaults' blocks of [`LEVEL`] samples since then.
    began: Instant,
    pub clock: Vec<Timed>,
    /// The effect of the defaults. A setting with the same effect changes nothing in this scene.
    defaults: Option<Effect>,
}

/// Everything that determines the image and the speed of a setting.
#[derive(PartialEq)]
struct Effect {
    /// The kernels' shaders.
    shaders: Vec<String>,
    settings: data::Settings,
    nodes: Vec<data::Node>,
    radiance_exponent: i32,
    brightest: f64,
    /// Their number is in no shader.
    light_paths: LightPaths,
}

impl Effect {
    fn new(plan: &Plan<'_>, max_depth: u32) -> Effect {
        let shaders = plan.kernels().into_iter().map(|kernel| kernel.linked.text.clone()).collect();
        let indirect_limit = plan.indirect_limit();
        // Without a walk, the hierarchy is not read.
        let walks = plan.buffers().iter().any(|buffer| buffer.name == "nodes");
        let root = if walks { plan.scene.settings.root } else { 0 };
        let nodes = if walks { plan.scene.nodes.clone() } else { Vec::new() };
        let settings = data::Settings { max_depth, indirect_limit, root, ..plan.scene.settings };
        let DeviceScene { radiance_exponent, brightest, .. } = *plan.scene;
        Effect { shaders, settings, nodes, radiance_exponent, brightest, light_paths: plan.options.light_paths }
    }
}

impl<'a> Sweep<'a> {
    /// The number of seeds before a sweep's own. They are reserved for images outside the rounds.
    pub const SEEDS_BEFORE: u32 = 4;

    /// The seed of this number among the seeds before a sweep's own.
    pub fn seed_before(seed: u32, number: u32) -> u32 {
        seed.wrapping_sub(1 + number)
    }

    /// Whether a sweep with the seed `seed` may render an image with the seed `other`.
    pub fn uses(seed: u32, other: u32) -> bool {
        other.wrapping_sub(seed.wrapping_sub(Self::SEEDS_BEFORE))
            <= Self::SEEDS_BEFORE + (MOST_ROUNDS * LEVELS.len()) as u32
    }

    /// An empty sweep over images of this size.
    pub fn new(device: &'a Arc<Device>, scene: &'a Scene, size: (u32, u32), seed: u32) -> Sweep<'a> {
        Sweep {
            size,
            subjects: Vec::new(),
            unmeasured: Vec::new(),
            device,
            scene,
            denoiser: None,
            seed,
            rounds: 0,
            began: Instant::now(),
            clock: Vec::new(),
            defaults: None,
        }
    }

    /// Compiles a setting; the first must be the defaults. A setting that changes nothing in this scene, or that the
    /// device refuses, is recorded as not measured.
    ///
    /// # Errors
    /// If the defaults themselves fail.
    pub fn add(&mut self, setting: Setting) -> Result<()> {
        let is_first = self.defaults.is_none();
        match self.compile(&setting) {
            Ok(Some(subject)) => self.subjects.push(subject),
            Ok(None) => self.leave_out(setting, "it changes nothing in this scene"),
            Err(error) if is_first => return Err(error),
            Err(error) => self.leave_out(setting, &error.to_string()),
        }
        Ok(())
    }

    /// An upper bound of the scene's radiance, in its own units.
    pub fn brightest(&self) -> f64 {
        self.defaults.as_ref().map_or(0.0, |defaults| defaults.brightest)
    }

    /// An empty sweep of the same scene with the same seed.
    pub fn of_size(&self, size: (u32, u32)) -> Sweep<'a> {
        Sweep::new(self.device, self.scene, size, self.seed)
    }

    /// Records a setting as not measured.
    pub fn leave_out(&mut self, setting: Setting, why: &str) {
        self.unmeasured.push(Unmeasured { setting, why: why.to_string() });
    }

    fn compile(&mut self, setting: &Setting) -> Result<Option<Subject>> {
        if setting.denoise && self.denoiser.is_none() {
            return Err(Error::Denoiser(
                "it needs Open Image Denoise; `gpu-rt denoise` says how to get it".to_string(),
            ));
        }
        let begin = Instant::now();
        let size = scaled(self.size, setting.scale);
        let job = job_of(size, setting.max_depth, LEVEL, 0);
        // What is measured here is to hold for renders that are longer.
        let mut options = setting.options.clone();
        options.scatter.get_or_insert(Tuning::scatter_of_long_renders(self.device.class()));
        let mut session = Session::on(vec![Arc::clone(self.device)]);
        session.view(self.scene, &Frame::full(size), &options)?;
        let view = Arc::clone(&session.scene);
        let plan = Plan::new(&view, &options, self.device.class(), &job)?;
        let effect = Effect::new(&plan, setting.max_depth);
        if size == self.size && self.defaults.as_ref() == Some(&effect) {
            return Ok(None);
        }
        session.compile_plans(&[plan], &job, &mut ())?;
        let film = session.film(size)?;
        let subject = Subject {
            setting: setting.clone(),
            session,
            total: film.film.clone(),
            film,
            seconds_compile: begin.elapsed().as_secs_f64(),
            blocks: BTreeMap::new(),
        };
        self.defaults.get_or_insert(effect);
        Ok(Some(subject))
    }

    /// Renders an image of one subject and enlarges it to the size of the sweep; none if the render was interrupted.
    pub fn image(&mut self, subject: usize, samples: u32, seed: u32, stop: Stop<'_>) -> Result<Option<Block>> {
        let Subject { session, film, setting, .. } = &mut self.subjects[subject];
        let size = scaled(self.size, setting.scale);
        let job = job_of(size, setting.max_depth, samples, seed);
        film.clear();
        let begin = self.began.elapsed().as_secs_f64();
        session.render(&job, film, &mut stopping(stop))?;
        if session.outcome.interrupted {
            return Ok(None);
        }
        let (film, seconds) = (&film.film, session.outcome.seconds);
        let at = begin + 0.5 * seconds;
        let image = match self.denoiser.filter(|_| setting.denoise) {
            Some(denoiser) => denoiser.denoise(&layers_of(film))?,
            None => film.develop().rgb,
        };
        Ok(Some(Block { image: enlarged(&image, size, self.size), timed: Timed { at, seconds } }))
    }

    /// The seconds that denoising an image of some size takes; none if no setting denoises. They do not depend on what the image shows. It is timed
    /// several times, but only once after `until`.
    pub fn seconds_to_denoise(&self, size: (u32, u32), until: Instant) -> Result<Option<f64>> {
        let Some(subject) = self.subjects.iter().find(|subject| subject.setting.denoise) else { return Ok(None) };
        let Some(denoiser) = self.denoiser else { return Ok(None) };
        let Noisy { size: own, rgb, albedo, normal } = layers_of(&subject.film.film);
        let enlarged = |layer: Pixels| enlarged(&layer, own, size);
        let layers = Noisy { size, rgb: enlarged(rgb), albedo: albedo.map(enlarged), normal: normal.map(enlarged) };
        let mut least = f64::INFINITY;
        for _ in 0..TIMED {
            let begin = Instant::now();
            denoiser.denoise(&layers)?;
            least = least.min(begin.elapsed().as_secs_f64());
            if Instant::now() > until {
                break;
            }
        }
        Ok(Some(least))
    }

    /// Renders rounds of blocks of every subject until the time is over, `stop` is true, or `most` rounds are done,
    /// including those of earlier calls. The order of the subjects rotates from round to round, and the defaults are timed
    /// between the others, so that a slower machine slows all of them alike.
    ///
    /// # Errors
    /// If the device fails.
    pub fn measure(
        &mut self,
        until: Instant,
        most: usize,
        stop: Stop<'_>,
        progress: &mut dyn FnMut(usize, &str),
    ) -> Result<()> {
        self.drop_begun_round();
        for round in self.rounds..most {
            let levels = LEVELS.iter().filter(|level| round % rounds_between(**level) == 0);
            for (i, &level) in levels.enumerate() {
                // No two blocks of a sweep share a seed, and none has the seed of --seed's own image.
                let seed = self.seed.wrapping_add(1 + (round * LEVELS.len() + i) as u32);
                let is_timed = level == LEVEL && self.subjects.len() > 1;
                for position in 0..=self.subjects.len() {
                    let is_last = position == self.subjects.len();
                    let subject = (position + round) % self.subjects.len();
                    progress(round, &self.subjects[subject].setting.name());
                    if stop() || Instant::now() + self.expected(subject, level) > until {
                        return Ok(());
                    }
                    if is_timed && (is_last || position % BLOCKS_A_CLOCK == 0) {
                        let Some(block) = self.image(0, level, seed, stop)? else { return Ok(()) };
                        self.clock.push(block.timed);
                    }
                    if is_last {
                        break;
                    }
                    let Some(block) = self.image(subject, level, seed, stop)? else { return Ok(()) };
                    if subject == 0 && level == LEVEL {
                        self.clock.push(block.timed);
                    }
                    let Subject { blocks, total, film, .. } = &mut self.subjects[subject];
                    total.merge(&film.film)?;
                    blocks.entry(level).or_default().push(block);
                }
            }
            self.rounds = round + 1;
        }
        Ok(())
    }

    /// Removes the blocks of an unfinished round, which is rendered again: the same image twice is not a replicate.
    fn drop_begun_round(&mut self) {
        let rounds = self.rounds;
        for (level, blocks) in self.subjects.iter_mut().flat_map(|subject| &mut subject.blocks) {
            blocks.truncate(rounds.div_ceil(rounds_between(*level)));
        }
    }

    /// Drops all images, for a measurement with another seed.
    pub fn begin_again(&mut self, seed: u32) {
        (self.seed, self.rounds) = (seed, 0);
        self.clock.clear();
        for subject in &mut self.subjects {
            subject.blocks.clear();
            subject.total.clear();
        }
    }

    /// The samples per pixel in all blocks of a subject.
    pub fn samples(&self, subject: usize) -> u32 {
        self.subjects[subject].blocks.iter().map(|(samples, blocks)| samples * blocks.len() as u32).sum()
    }

    /// The expected time of a block, from the times of earlier ones.
    fn expected(&self, subject: usize, level: u32) -> Duration {
        let mut known = self.subjects[subject].blocks.iter().filter_map(|(samples, blocks)| {
            let last = blocks.last()?;
            Some(last.timed.seconds * f64::from(level) / f64::from(*samples))
        });
        Duration::from_secs_f64(known.next_back().unwrap_or(0.0))
    }
}

/// A render of so many samples of every pixel.
fn job_of(size: (u32, u32), max_depth: u32, samples: u32, seed: u32) -> Job {
    Job { size, max_depth, seed, first_sample: 0, goal: Goal::Samples(samples) }
}

/// The number of times that denoising is timed. The smallest time counts, because other load on the machine only adds to it.
const TIMED: u32 = 3;

/// The picture and the two layers that help to denoise it.
fn layers_of(film: &Film) -> Noisy {
    let channels = film.aovs().channels();
    let size = (film.width(), film.height());
    let layer = |aov: Aov| -> Option<Pixels> {
        let component = |index: usize, c: usize| {
            let found = channels.iter().find(|channel| channel.aov == aov && channel.component == c);
            found.map_or(0.0, |channel| film.channel(index, channel))
        };
        let pixels = size.0 as usize * size.1 as usize;
        Some((0..pixels).map(|index| std::array::from_fn(|c| component(index, c))).collect())
    };
    Noisy { size, rgb: film.develop().rgb, albedo: layer(Aov::Albedo), normal: layer(Aov::Normal) }
}

/// The sides times a factor.
fn scaled((width, height): (u32, u32), factor: f64) -> (u32, u32) {
    let side = |side: u32| ((f64::from(side) * factor).round() as u32).max(1);
    (side(width), side(height))
}

/// An image reduced to a share of its sides and enlarged again: each pixel is the mean over a larger rectangle.
pub fn coarsened(image: &Pixels, size: (u32, u32), share: f64) -> Pixels {
    let small = scaled(size, share);
    // The pixels that a pixel of the smaller image covers, with their shares.
    let covers = |at: u32, from: u32, to: u32| {
        let ratio = f64::from(from) / f64::from(to);
        let (begin, end) = (f64::from(at) * ratio, f64::from(at + 1) * ratio);
        let last = (end.ceil() as u32).min(from);
        (begin as u32..last).map(move |i| (i as usize, (f64::from(i + 1).min(end) - f64::from(i).max(begin)) / ratio))
    };
    let pixel = |x: u32, y: u32| {
        let mut sum = [0.0f64; 3];
        for (row, tall) in covers(y, size.1, small.1) {
            for (column, wide) in covers(x, size.0, small.0) {
                let p = image[row * size.0 as usize + column];
                (0..3).for_each(|c| sum[c] += tall * wide * f64::from(p[c]));
            }
        }
        sum.map(|v| v as f32)
    };
    let coarse: Pixels =
        (0..small.1).flat_map(|y| (0..small.0).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    enlarged(&coarse, small, size)
}

/// An image scaled up by repeating its pixels.
fn enlarged(image: &Pixels, (width, height): (u32, u32), to: (u32, u32)) -> Pixels {
    if (width, height) == to {
        return image.clone();
    }
    let source = |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(from) / u64::from(to)) as usize;
    let rows = (0..to.1).map(|y| source(y, height, to.1) * width as usize);
    rows.flat_map(|row| (0..to.0).map(move |x| image[row + source(x, width, to.0)])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_of_a_sweep_are_recognised() {
        for seed in [0u32, 7, u32::MAX - 3] {
            let rounds = (MOST_ROUNDS * LEVELS.len()) as u32;
            let used = |offset: i64| Sweep::uses(seed, (i64::from(seed) + offset) as u32);
            assert!((-4..=i64::from(rounds)).all(used), "{seed}");
            assert!(!used(-5) && !used(i64::from(rounds) + 1), "{seed}");
            // A sweep that starts after a taken seed does not use it.
            assert!((0..200).all(|taken| !Sweep::uses(taken + Sweep::SEEDS_BEFORE + 1, taken)));
        }
    }

    #[test]
    fn enlarged_images_repeat_their_pixels() {
        let image: Pixels = (0..6).map(|i| [i as f32; 3]).collect();
        let grey = |image: Pixels| image.iter().map(|p| p[0] as i32).collect::<Vec<_>>();
        assert_eq!(grey(enlarged(&image, (3, 2), (3, 2))), [0, 1, 2, 3, 4, 5]);
        assert_eq!(
            grey(enlarged(&image, (3, 2), (6, 4))),
            [0, 0, 1, 1, 2, 2, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 3, 3, 4, 4, 5, 5]
        );
    }

    #[test]
    fn coarse_images_are_means() {
        let image: Pixels = (0..8).map(|i| [i as f32; 3]).collect();
        let grey = |image: Pixels| image.iter().map(|p| p[0]).collect::<Vec<_>>();
        assert_eq!(grey(coarsened(&image, (4, 2), 0.5)), [2.5, 2.5, 4.5, 4.5, 2.5, 2.5, 4.5, 4.5]);
        // Three pixels become two: each covers one and a half.
        let found = grey(coarsened(&image[..3].to_vec(), (3, 1), 0.5));
        let expected = [1.0 / 3.0, 1.0 / 3.0, 5.0 / 3.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
