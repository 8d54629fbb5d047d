//! Renders scenes through the library, as the program does: parse, flatten, plan, render, develop. On the software device.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use gpu_rt::data::{RUN_LENGTH, Sampler};
use gpu_rt::film::{Accumulation, Film, Picture, UNKNOWN_VARIANCE};
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::layout;
use gpu_rt::gpu::link::{Choices, Embedded, Library, link};
use gpu_rt::job::{Goal, Job, blocks};
use gpu_rt::options::{Filter, Integrator, LightPaths, RenderOptions, Scatter, Switch};
use gpu_rt::plan::{Bounce, Kernel, Kernels, Plan, Staged, Tuning};
use gpu_rt::render::{self, Next, Observer, following};
use gpu_rt::samples::Samples;
use gpu_rt::scene::Scene;
use gpu_rt::session::Session;

use super::device::software;
use super::stats::{sidak, student_two_sided};

/// The request of a render. Absent fields are the scene's own.
#[derive(Clone, Debug)]
pub struct Request {
    pub size: Option<(u32, u32)>,
    pub samples: Option<Range<u32>>,
    pub max_depth: Option<u32>,
    pub seed: u32,
    /// [`plain`] ones by default.
    pub options: RenderOptions,
    /// All of the scene's tables in storage bindings, also where the device would take small ones as uniforms.
    pub storage_tables: bool,
    /// The time that a submission should take, if not the usual one.
    pub submission: Option<Duration>,
}

/// Scattered rays alone, independent samples, every path to its end: most statistics of the tests take runs for independent.
pub fn plain() -> RenderOptions {
    RenderOptions {
        integrator: Integrator::Bsdf,
        roulette: Switch::Off,
        sampler: Sampler::Independent,
        light_paths: LightPaths::Off,
        ..RenderOptions::default()
    }
}

impl Default for Request {
    fn default() -> Request {
        Request {
            size: None,
            samples: None,
            max_depth: None,
            seed: 0,
            options: plain(),
            storage_tables: false,
            submission: None,
        }
    }
}

impl Request {
    pub fn spp(samples: u32) -> Request {
        Request { samples: Some(0..samples), ..Request::default() }
    }

    pub fn seed(self, seed: u32) -> Request {
        Request { seed, ..self }
    }

    pub fn with(mut self, change: impl FnOnce(&mut RenderOptions)) -> Request {
        change(&mut self.options);
        self
    }

    pub fn sobol(self) -> Request {
        self.with(|options| options.sampler = Sampler::Sobol)
    }

    /// With light sampling.
    pub fn mis(self) -> Request {
        self.with(|options| options.integrator = Integrator::Mis)
    }

    /// With Russian roulette.
    pub fn roulette(self) -> Request {
        self.with(|options| options.roulette = Switch::On)
    }

    /// With so many light paths for each run.
    pub fn light_paths(self, count: u32) -> Request {
        self.with(|options| options.light_paths = LightPaths::Count(count))
    }

    /// Its stages linked this way.
    pub fn scatter(self, scatter: Scatter) -> Request {
        self.with(|options| options.scatter = Some(scatter))
    }

    pub fn size(self, width: u32, height: u32) -> Request {
        Request { size: Some((width, height)), ..self }
    }

    pub fn depth(self, max_depth: u32) -> Request {
        Request { max_depth: Some(max_depth), ..self }
    }
}

/// A finished render.
#[derive(Debug)]
pub struct Shot {
    pub film: Film,
    pub picture: Picture,
    pub outcome: Outcome,
    pub sampler: Sampler,
}

/// The outcome of a render, and the samples that it has added to every pixel.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub samples: Samples,
    of_render: render::Outcome,
}

impl std::ops::Deref for Outcome {
    type Target = render::Outcome;

    fn deref(&self) -> &render::Outcome {
        &self.of_render
    }
}

/// A mean over pixels, by channel.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    pub value: [f64; 3],
    /// Of that mean.
    pub variance: [f64; 3],
    /// Degrees of freedom of that variance.
    pub degrees: [f64; 3],
}

/// The folder of the scenes with closed forms.
pub fn scene_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/test")
}

/// A scene from its text; paths in it are relative to the folder of the closed-form scenes.
pub fn scene(text: &str) -> Scene {
    scene_in(&scene_folder(), text)
}

/// A scene from its text; paths in it are relative to `folder`.
pub fn scene_in(folder: &Path, text: &str) -> Scene {
    Scene::parse(text, &folder.join("test.ron")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A scene from its text, with these files beside it.
pub fn scene_with(files: &[(&str, String)], text: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, file) in files {
        std::fs::write(folder.path().join(name), file).expect("the file is written");
    }
    scene_in(folder.path(), text)
}

/// What `gpu-rt check` warns of in the scene's objects as they are placed.
pub fn diagnostics(scene: &Scene) -> Vec<String> {
    let flat = flatten(scene, (scene.image.width, scene.image.height), &plain());
    flat.expect("the scene flattens").warnings
}

/// Renders the scene.
pub fn render(scene: &Scene, request: &Request) -> Shot {
    let samples = request.samples.clone().unwrap_or(0..scene.render.samples);
    let mut shots = render_each(scene, request, &[samples]);
    shots.remove(0)
}

/// Renders several ranges of samples, one after the other by the same kernels and buffers, each onto a film of its own. The samples
/// that are requested elsewhere do not count.
pub fn render_each(scene: &Scene, request: &Request, ranges: &[Range<u32>]) -> Vec<Shot> {
    let mut shots = Vec::new();
    render_all(scene, request, ranges.iter().map(|samples| (request.seed, samples.clone())), |shot| shots.push(shot));
    shots
}

/// Renders several seeds and ranges; each shot is handed over when it is there.
pub fn render_all(
    scene: &Scene,
    request: &Request,
    wanted: impl Iterator<Item = (u32, Range<u32>)>,
    mut take: impl FnMut(Shot),
) {
    let size = request.size.unwrap_or((scene.image.width, scene.image.height));
    render_with(scene, request, wanted, &Change::default(), |shot| {
        shot.check(size, request.options.filter);
        take(shot);
    });
}

/// Renders with kernels that are linked from another library, in which errors can be planted; the caller checks the counts.
pub fn render_planted(scene: &Scene, request: &Request, library: &dyn Library) -> Shot {
    render_changed(scene, request, &Change { library: Some(library), ..Change::default() })
}

/// What a test changes between a scene and its kernels.
#[derive(Default)]
pub struct Change<'a> {
    /// The tables that the kernels read.
    pub flat: Option<&'a dyn Fn(&mut DeviceScene)>,
    /// What each kernel is linked with.
    pub choices: Option<&'a dyn Fn(&mut Choices)>,
    /// Where its modules come from.
    pub library: Option<&'a dyn Library>,
}

/// Renders a scene that was changed.
pub fn render_changed(scene: &Scene, request: &Request, change: &Change<'_>) -> Shot {
    let samples = request.samples.clone().unwrap_or(0..scene.render.samples);
    let mut shots = Vec::new();
    render_with(scene, request, std::iter::once((request.seed, samples)), change, |shot| shots.push(shot));
    shots.remove(0)
}

pub fn render_with(
    scene: &Scene,
    request: &Request,
    wanted: impl Iterator<Item = (u32, Range<u32>)>,
    change: &Change<'_>,
    mut take: impl FnMut(Shot),
) {
    let size = request.size.unwrap_or((scene.image.width, scene.image.height));
    let mut flat = flatten(scene, size, &request.options).expect("the scene flattens");
    if let Some(change) = change.flat {
        change(&mut flat);
    }
    let job = |seed: u32, samples: &Range<u32>| Job {
        size,
        max_depth: request.max_depth.unwrap_or(scene.render.max_depth),
        seed,
        first_sample: samples.start,
        goal: Goal::Samples(samples.end),
    };
    let mut wanted = wanted.peekable();
    let (seed, samples) = wanted.peek().expect("something is asked for");
    let first = job(*seed, samples);
    let mut class = software().class();
    if request.storage_tables {
        class.max_uniform_bytes = 0;
    }
    let mut options = request.options.clone();
    if wanted.size_hint() != (1, Some(1)) {
        // All of them together are no short render.
        options.scatter.get_or_insert(Tuning::scatter_of_long_renders(class));
    }
    let mut session = Session::on(vec![Arc::clone(software())]);
    session.submission = request.submission;
    compile(&mut session, flat, &options, class, &first, |plan| relink(&mut plan.kernels, change));
    for (seed, samples) in wanted {
        let job = job(seed, &samples);
        let mut film = session.film(size).expect("the film fits");
        let mut watch = Watchdog::new(job.max_depth);
        let mut observer = following(|outcome, _| watch.observe(outcome));
        session.render(&job, &mut film, &mut observer).expect("the device renders");
        let outcome = Outcome { samples: film.samples, of_render: std::mem::take(&mut session.outcome) };
        let film = film.film;
        take(Shot { picture: film.develop(), film, outcome, sampler: request.options.sampler });
    }
}

/// Compiles a flattened scene in a session, by a plan that is changed.
fn compile(
    session: &mut Session,
    flat: DeviceScene,
    options: &RenderOptions,
    class: DeviceClass,
    job: &Job,
    change: impl FnOnce(&mut Plan<'_>),
) {
    session.show(flat, options);
    let view = Arc::clone(&session.scene);
    let mut plan = Plan::new(&view, options, class, job).expect("the kernels link");
    change(&mut plan);
    session.compile_plans(&[plan], job, &mut ()).expect("the kernels compile and the buffers fit");
}

/// Renders a job by a plan that is changed, onto a film whose samples are taken to be placed by a sampler.
pub fn render_job(
    scene: &Scene,
    options: &RenderOptions,
    job: &Job,
    of_film: Sampler,
    change: impl FnOnce(&mut Plan<'_>),
    observer: &mut dyn Observer,
) -> (Film, Outcome) {
    let flat = flatten(scene, job.size, options).expect("the scene flattens");
    let film = Film::with_sampler(job.size.0, job.size.1, flat.radiance_exponent, of_film).expect("the film fits");
    let mut film = film.with_lamps(&flat.lamps);
    film.bound.not_sampled = flat.not_sampled;
    let outcome = render_flat(flat, options, job, &mut film, change, observer);
    (film, outcome)
}

/// Renders onto a film that has samples.
pub fn render_onto(
    scene: &Scene,
    options: &RenderOptions,
    job: &Job,
    film: &mut Film,
    change: impl FnOnce(&mut Plan<'_>),
    observer: &mut dyn Observer,
) -> Outcome {
    render_flat(flatten(scene, job.size, options).expect("the scene flattens"), options, job, film, change, observer)
}

fn render_flat(
    flat: DeviceScene,
    options: &RenderOptions,
    job: &Job,
    film: &mut Film,
    change: impl FnOnce(&mut Plan<'_>),
    observer: &mut dyn Observer,
) -> Outcome {
    let mut session = Session::on(vec![Arc::clone(software())]);
    compile(&mut session, flat, options, software().class(), job, change);
    render_in(&mut session, job, film, observer)
}

/// Renders a job in a session, all of it, onto a film that may have other samples.
pub fn render_in(session: &mut Session, job: &Job, film: &mut Film, observer: &mut dyn Observer) -> Outcome {
    let checks = if let Goal::Noise { checks, .. } = job.goal { checks } else { 0 };
    let mut onto = Accumulation { checks, ..Accumulation::empty(std::mem::replace(film, one_pixel())) };
    session.render(job, &mut onto, observer).expect("the device renders");
    *film = onto.film;
    Outcome { samples: onto.samples, of_render: std::mem::take(&mut session.outcome) }
}

/// A film of one pixel.
pub fn one_pixel() -> Film {
    Film::new(1, 1, 0).expect("it is small")
}

/// Links the kernels of a plan another way.
fn relink(plan: &mut Kernels, change: &Change<'_>) {
    if change.library.is_none() && change.choices.is_none() {
        return;
    }
    let library = change.library.unwrap_or(&Embedded);
    let relink = |kernel: &mut Arc<Kernel>| {
        let kernel = Arc::make_mut(kernel);
        if let Some(change) = change.choices {
            change(&mut kernel.choices);
        }
        kernel.linked = link(library, &format!("stage/{}", kernel.stage), &kernel.choices).expect("the kernel links");
        kernel.module = kernel.linked.validate().unwrap_or_else(|error| panic!("{error}")).0;
        kernel.bindings = layout::bindings(&kernel.module).expect("the kernel has bindings");
    };
    relink(&mut plan.generate);
    relink(&mut plan.accumulate);
    plan.light_path.iter_mut().for_each(relink);
    match &mut plan.bounce {
        Bounce::Fused(bounce) => relink(bounce),
        Bounce::Staged(staged) => {
            let Staged { intersect, medium, dispatch, scatter, shadow, refill } = &mut **staged;
            let stages = [intersect, refill].into_iter().chain(medium).chain(dispatch).chain(scatter).chain(shadow);
            stages.for_each(relink);
        }
    }
}

/// Fails a render that would never end, by a count of submissions and not by time.
struct Watchdog {
    /// Submissions within which a run must end: each takes every path at least one ray further, a path has at most one ray more
    /// than scattering events, and a run at most [`RUN_LENGTH`] paths. Then some room.
    patience: u64,
    idle: u64,
    paths: u64,
}

impl Watchdog {
    fn new(max_depth: u32) -> Watchdog {
        Watchdog { patience: u64::from(RUN_LENGTH) * (u64::from(max_depth) + 1) + 16, idle: 0, paths: 0 }
    }

    fn observe(&mut self, outcome: &render::Outcome) -> Next {
        let paths = outcome.totals.paths + outcome.totals.light_paths.iter().sum::<u64>();
        self.idle = if paths > self.paths { 0 } else { self.idle + 1 };
        self.paths = paths;
        assert!(
            self.idle < self.patience,
            "no path has ended in {} submissions: this render would never end",
            self.idle
        );
        Next::GoOn
    }
}

impl Mean {
    /// The probability of a difference as large as that from another one by chance, and the difference in standard errors, by Welch's test. Noise
    /// aside, they may differ by `rounding` of themselves.
    pub fn difference(&self, other: &Mean, channel: usize, rounding: f64) -> (f64, f64) {
        let of = |values: fn(&Mean) -> [f64; 3]| (values(self)[channel], values(other)[channel]);
        let ((va, vb), (of_a, of_b)) = (of(|mean| mean.value), of(|mean| mean.variance));
        let excess = ((va - vb).abs() - rounding * va.max(vb)).max(0.0);
        let z = if excess == 0.0 { 0.0 } else { excess / (of_a + of_b).sqrt() };
        // A variance of 0 takes no part.
        let part = |v: f64, degrees: f64| if v > 0.0 { v * v / degrees } else { 0.0 };
        let parts = part(of_a, self.degrees[channel]) + part(of_b, other.degrees[channel]);
        let degrees = if parts > 0.0 { (of_a + of_b).powi(2) / parts } else { f64::INFINITY };
        // No number is worse than any.
        if z.is_nan() { (0.0, f64::INFINITY) } else { (student_two_sided(z, degrees), z) }
    }

    /// Whether it is what is expected, within its noise, which is at most this share of it. Noise: 4.9 standard errors, which a mean is off by
    /// once in 1e6.
    pub fn is_near(&self, expected: [f64; 3], most_noise: f64) -> Result<(), String> {
        const NOISE: f64 = 4.9;
        for (channel, expected) in expected.into_iter().enumerate() {
            let (value, noise) = (self.value[channel], NOISE * self.variance[channel].sqrt());
            if noise > most_noise * expected || (value - expected).abs() > noise + 1e-5 * expected {
                return Err(format!("channel {channel}: {value} +- {noise}, expected {expected}"));
            }
        }
        Ok(())
    }
}

impl Shot {
    /// Every pixel got every sample, and none was rejected: no image test may pass on what is left of an image. None is below 0, where the
    /// filter is not.
    fn check(&self, size: (u32, u32), filter: Filter) {
        let (pixels, spp) = (u64::from(size.0) * u64::from(size.1), self.outcome.samples.count());
        let totals = self.film.totals;
        assert_eq!(totals.paths, pixels * spp, "camera samples");
        assert_eq!(totals.rejected.total(), 0, "{:?}", totals.rejected);
        assert_eq!((self.picture.width, self.picture.height), size, "size of the picture");
        assert_eq!(self.picture.rgb.len() as u64, pixels);
        assert!(self.picture.samples.iter().all(|&n| u64::from(n) == spp));
        let values = self.picture.rgb.as_flattened();
        assert!(values.iter().all(|v| v.is_finite() && (*v >= 0.0 || filter == Filter::Mitchell)));
    }

    /// The render with another picture: for planting errors.
    pub fn changed(&self, change: impl Fn(u32, u32, [f32; 3]) -> [f32; 3]) -> Shot {
        let mut picture = self.picture.clone();
        for (pixel, rgb) in (0..).zip(&mut picture.rgb) {
            *rgb = change(pixel % self.picture.width, pixel / self.picture.width, *rgb);
        }
        self.with(picture)
    }

    /// The render with its columns in reverse order, its rows, or both.
    pub fn flipped(&self, (columns, rows): (bool, bool)) -> Shot {
        let (width, height) = (self.picture.width, self.picture.height);
        let mut picture = self.picture.clone();
        for y in 0..height {
            for x in 0..width {
                let from_x = if columns { width - 1 - x } else { x };
                let from_y = if rows { height - 1 - y } else { y };
                let (to, from) = ((y * width + x) as usize, (from_y * width + from_x) as usize);
                picture.rgb[to] = self.picture.rgb[from];
                picture.variance[to] = self.picture.variance[from];
            }
        }
        self.with(picture)
    }

    fn with(&self, picture: Picture) -> Shot {
        Shot { film: self.film.clone(), picture, outcome: self.outcome.clone(), sampler: self.sampler }
    }

    /// The picture bit by bit.
    pub fn bits(&self) -> Vec<u32> {
        self.picture.rgb.as_flattened().iter().map(|value| value.to_bits()).collect()
    }

    pub fn pixel(&self, x: u32, y: u32) -> [f64; 3] {
        self.picture.rgb[(y * self.picture.width + x) as usize].map(f64::from)
    }

    /// Runs of each pixel.
    pub fn runs(&self) -> u32 {
        blocks(self.outcome.samples.range()).len() as u32
    }

    /// Degrees of freedom of a pixel's variance: runs less one, or the one that the two halves of Sobol points have.
    fn degrees_of_pixel(&self) -> f64 {
        match self.sampler {
            Sampler::Independent => f64::from(self.runs() - 1),
            Sampler::Sobol => 1.0,
        }
    }

    /// The mean over the pixels of a rectangle, its right and lower bounds excluded.
    pub fn mean(&self, columns: Range<u32>, rows: Range<u32>) -> Mean {
        let width = self.picture.width;
        self.mean_over(rows.flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize)))
    }

    /// The mean over some pixels.
    pub fn mean_over(&self, pixels: impl Iterator<Item = usize>) -> Mean {
        let Picture { rgb, variance, .. } = &self.picture;
        let is_known = |pixel: &usize| variance[*pixel].iter().all(|v| *v < UNKNOWN_VARIANCE);
        let known = pixels.inspect(|pixel| assert!(is_known(pixel), "a variance takes two runs: at least 9 samples"));
        mean_over(rgb, variance, known, self.degrees_of_pixel())
    }

    /// The mean over the image.
    pub fn mean_of_all(&self) -> Mean {
        self.mean(0..self.picture.width, 0..self.picture.height)
    }
}

/// The mean over some pixels of an image. Pixels are independent, since random numbers are keyed by the pixel, and so are the scrambles of Sobol
/// points: the variance of the mean of n pixels is the sum of theirs, v, over n². Each v is known by k degrees of freedom, so
/// that v² is expected to be (1 + 2/k) times the square of what v estimates; the sum's degrees by Satterthwaite (1946), with the squares of
/// those variances estimated by v² k/(k + 2), are (Σ v)² / Σ v²/(k + 2): n k where all pixels have one variance.
pub fn mean_over(rgb: &[[f32; 3]], variances: &[[f32; 3]], pixels: impl Iterator<Item = usize>, degrees: f64) -> Mean {
    let (mut value, mut variance, mut squares) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let mut n = 0.0;
    for pixel in pixels {
        for channel in 0..3 {
            let v = f64::from(variances[pixel][channel]);
            value[channel] += f64::from(rgb[pixel][channel]);
            variance[channel] += v;
            squares[channel] += v * v / (degrees + 2.0);
        }
        n += 1.0;
    }
    assert!(n > 0.0, "a mean of no pixels");
    // Without any variance there is nothing to know of it.
    let degrees = |c: usize| if squares[c] > 0.0 { variance[c] * variance[c] / squares[c] } else { f64::INFINITY };
    Mean {
        value: value.map(|v| v / n),
        variance: variance.map(|v| v / (n * n)),
        degrees: [degrees(0), degrees(1), degrees(2)],
    }
}

/// What each of some materials returns per channel of light of 1 from all sides at this cosine, and its standard errors. All are in one image, each
/// on a strip of one plane, so that its kernels are compiled once.
pub fn in_a_furnace(materials: &[String], cos: f64, samples: u32) -> Vec<([f64; 3], [f64; 3])> {
    const ROWS: u32 = 16;
    let strips = materials.len() as f64;
    let degrees = 0.1f64;
    let strip = 2.0 * (0.5 * degrees).to_radians().tan() / strips;
    let named = materials.iter().enumerate().map(|(i, material)| format!("\"{i}\": {material}"));
    // The first strip is at the top.
    let quads = (0..materials.len()).map(|i| {
        let bottom = strip * (0.5 * strips - 1.0 - i as f64);
        format!("Quad(corner: (-1, {bottom}, 0), u: (2, 0, 0), v: (0, {strip}, 0), material: \"{i}\")")
    });
    let scene = scene(&format!(
        "Scene(
    image: (width: {ROWS}, height: {}),
    camera: (look_from: ({}, 0, {cos}), look_at: (0, 0, 0), vertical_fov: {degrees}),
    background: Solid((1, 1, 1)),
    materials: {{{}}},
    objects: [{}],
)",
        ROWS * materials.len() as u32,
        -(1.0 - cos * cos).sqrt(),
        named.collect::<Vec<_>>().join(", "),
        quads.collect::<Vec<_>>().join(", "),
    ));
    let shot = render(&scene, &Request::spp(samples));
    // Without the rows next to another strip.
    let of_strip = |i: u32| shot.mean(0..ROWS, ROWS * i + 1..ROWS * (i + 1) - 1);
    (0..materials.len() as u32).map(of_strip).map(|mean| (mean.value, mean.variance.map(f64::sqrt))).collect()
}

/// Tests that two independent renders (two seeds) have one expectation, with this share of false alarms: see [`worst_difference`].
pub fn same_expectation(a: &Shot, b: &Shot, rounding: f64, alpha: f64) -> Result<(), String> {
    let worst = worst_difference(a, b, rounding);
    match worst.p < sidak(alpha, worst.compared) {
        true => Err(worst.tile),
        false => Ok(()),
    }
}

/// Where two renders differ by the most standard errors.
pub struct Difference {
    /// Of a difference as large as that by chance, in one comparison.
    pub p: f64,
    /// In standard errors.
    pub z: f64,
    /// How many comparisons there were.
    pub compared: usize,
    pub tile: String,
}

/// Compares two independent renders (two seeds) in tiles of 8 x 8 pixels and the full image, each by the difference of the means. For noise without rare values: a tile has hundreds of runs, so that its mean is normal. Noise aside, values may
/// differ by `rounding` of them.
pub fn worst_difference(a: &Shot, b: &Shot, rounding: f64) -> Difference {
    const TILE: u32 = 8;
    let (width, height) = (a.picture.width, a.picture.height);
    assert_eq!((width, height), (b.picture.width, b.picture.height));
    assert!(width.is_multiple_of(TILE) && height.is_multiple_of(TILE));
    let corners = (0..height / TILE).flat_map(|y| (0..width / TILE).map(move |x| (x, y)));
    let tiles = corners.map(|(x, y)| (x * TILE..(x + 1) * TILE, y * TILE..(y + 1) * TILE));
    let areas: Vec<_> = std::iter::once((0..width, 0..height)).chain(tiles).collect();
    let mut worst = Difference { p: 1.0, z: 0.0, compared: 3 * areas.len(), tile: "nowhere".to_string() };
    for (columns, rows) in areas {
        let (mean_a, mean_b) = (a.mean(columns.clone(), rows.clone()), b.mean(columns.clone(), rows.clone()));
        for channel in 0..3 {
            let (va, vb) = (mean_a.value[channel], mean_b.value[channel]);
            let (p, z) = mean_a.difference(&mean_b, channel, rounding);
            if p < worst.p {
                let tile = format!(
                    "columns {columns:?}, rows {rows:?}, channel {channel}: {va} and {vb}, z = {z:.2}, p = {p:.1e}"
                );
                worst = Difference { p, z, tile, ..worst };
            }
        }
    }
    worst
}
