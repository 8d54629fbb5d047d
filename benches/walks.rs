//! Judges ways of walking through meshes on a device, in one run: `make gpu-walks`. Each scene is rendered by today's trees and by those of another
//! kind in turns, `--scatter linked`. For each the medians of the rays per second within the kernels that walk, and of the paths per second. The images must
//! be the same, as docs/promises.md says. docs/walks-NAME.md has the figures, and says which trees should be the default.
//!
//! `walks [--device SPEC] [--seconds N] [--out DIR]`, in the root of the repository.

#[path = "common/names.rs"]
mod names;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use gpu_rt::film::Picture;
use gpu_rt::gpu::device::{Adapters, Device};
use gpu_rt::job::{Frame, Goal, Job};
use gpu_rt::metrics::error::{RELATIVE_FLOOR, relative_variance, relmse};
use gpu_rt::options::{RenderOptions, Scatter, Walk};
use gpu_rt::scene::Scene;
use gpu_rt::session::Session;
use names::file_name;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Scenes with meshes, and one without as a control. The scan is made here.
const SCENES: [&str; 6] = [
    "scenes/mesh.ron",
    "scenes/instances.ron",
    "scenes/still-life.glb",
    "scenes/glass.ron",
    SCAN,
    "scenes/weekend.ron",
];
const SCAN: &str = "scan.ply";
const CONTROL: &str = "scenes/weekend.ron";
/// The rings of the scan, and the faces around each: a million in all.
const RINGS: u32 = 500;
const AROUND: u32 = 2000;
const TREES: [Walk; 2] = [Walk::Coded, Walk::Siblings];
/// Renders of each scene with each tree. The median of the ratios decides.
const TURNS: u32 = 3;
/// The other trees become the default if the scenes with meshes render this much faster, by the geometric mean, and the control at most so much slower.
const WORTH_IT: f64 = 1.03;
const LEAST_OF_CONTROL: f64 = 0.99;
/// The largest difference of the images on a GPU, as a share of their noise (docs/promises.md). On software drivers there is none.
const PARTED: f64 = 0.2;

/// What a render tells of the device.
#[derive(Clone, Copy)]
struct Pace {
    paths: f64,
    /// Rays per second within the kernels that walk; not finite if the device has no timestamps.
    rays: f64,
}

/// A scene: today's pace, and the medians of the ratios of the other trees to it.
struct Judged {
    scene: &'static str,
    usual: Pace,
    /// The difference of both images, as a share of their noise.
    differs: f64,
    paths: f64,
    rays: f64,
}

struct Bench {
    device: Arc<Device>,
    size: (u32, u32),
    /// Of each render.
    time: Duration,
    scan: PathBuf,
}

fn main() -> Result<()> {
    let (mut spec, mut seconds, mut out) = (None, 360.0, PathBuf::from("docs"));
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let value = words.next().ok_or(format!("{word}: a value is missing"))?;
        match word.as_str() {
            "--device" => spec = Some(value).filter(|value| !value.is_empty()),
            "--seconds" => seconds = value.parse()?,
            "--out" => out = value.into(),
            _ => return Err(format!("{word}: expected --device, --seconds or --out").into()),
        }
    }
    let device = Arc::new(Device::open(Adapters::find().choose(spec.as_deref())?)?);
    let folder = tempfile::tempdir()?;
    let scan = folder.path().join(SCAN);
    write_scan(&scan)?;
    // A render with timestamps and one without. A sixth of the time is left for compiling.
    let renders = 2 * TURNS * (SCENES.len() * TREES.len()) as u32;
    let time = Duration::from_secs_f64(seconds * 5.0 / 6.0 / f64::from(renders));
    let size = if device.name.software { (64, 36) } else { (640, 360) };
    let bench = Bench { device, size, time, scan };
    let judged = SCENES.into_iter().map(|scene| bench.judge(scene)).collect::<Result<Vec<Judged>>>()?;
    let text = document(&bench, &judged);
    fs::create_dir_all(&out)?;
    let path = out.join(format!("walks-{}.md", file_name(&bench.device.name.name)));
    fs::write(&path, &text)?;
    println!("{text}\n{} has this.", path.display());
    Ok(())
}

/// A ball with bumps, as a scanner gives it: no normals, and a million faces.
fn write_scan(path: &Path) -> Result<()> {
    let mut file = BufWriter::new(fs::File::create(path)?);
    let (vertices, faces) = ((RINGS + 1) * AROUND, 2 * RINGS * AROUND);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for ring in 0..=RINGS {
        let polar = std::f32::consts::PI * ring as f32 / RINGS as f32;
        for step in 0..AROUND {
            let angle = std::f32::consts::TAU * step as f32 / AROUND as f32;
            let radius =
                1.0 + 0.02 * (40.0 * polar).sin() * (60.0 * angle).sin() + 0.1 * (3.0 * polar + 2.0 * angle).sin();
            let point = [polar.sin() * angle.cos(), polar.cos(), polar.sin() * angle.sin()];
            for x in point {
                file.write_all(&(radius * x).to_le_bytes())?;
            }
        }
    }
    for (ring, step) in (0..RINGS).flat_map(|ring| (0..AROUND).map(move |step| (ring, step))) {
        let [a, b] = [step, (step + 1) % AROUND].map(|step| ring * AROUND + step);
        for corners in [[a, b, b + AROUND], [a, b + AROUND, a + AROUND]] {
            file.write_all(&[3])?;
            for corner in corners {
                file.write_all(&corner.to_le_bytes())?;
            }
        }
    }
    Ok(file.flush()?)
}

impl Bench {
    fn judge(&self, name: &'static str) -> Result<Judged> {
        eprintln!("{name}");
        let scene = Scene::load(if name == SCAN { &self.scan } else { Path::new(name) })?;
        let mut sessions = Vec::new();
        let mut pictures = Vec::new();
        for walk in TREES {
            let options = RenderOptions { walk, scatter: Some(Scatter::Linked), ..RenderOptions::default() };
            let mut session = Session::on(vec![Arc::clone(&self.device)]);
            session.view(&scene, &Frame::full(self.size), &options)?;
            pictures.push(self.rendered(&mut session, &scene, Goal::Samples(8))?);
            sessions.push(session);
        }
        let (a, b) = (&pictures[0], &pictures[1]);
        let noise = relative_variance(&a.variance, &a.rgb, RELATIVE_FLOOR).ok_or("there is no noise")?;
        let differs = (relmse(&b.rgb, &a.rgb).ok_or("the images have other sizes")? / (2.0 * noise)).sqrt();
        let most = if self.device.name.software { 0.0 } else { PARTED };
        if differs > most {
            return Err(format!("{name}: the images differ by {differs:.3} of their noise").into());
        }
        let (mut usual, mut paths, mut rays) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..TURNS {
            let coded = self.pace(&mut sessions[0], &scene)?;
            let other = self.pace(&mut sessions[1], &scene)?;
            paths.push(other.paths / coded.paths);
            rays.push(other.rays / coded.rays);
            usual.push(coded);
        }
        usual.sort_by(|a, b| a.paths.total_cmp(&b.paths));
        Ok(Judged { scene: name, usual: usual[usual.len() / 2], differs, paths: median(paths), rays: median(rays) })
    }

    fn rendered(&self, session: &mut Session, scene: &Scene, goal: Goal) -> Result<Picture> {
        let mut film = session.film(self.size)?;
        let job = Job { size: self.size, max_depth: scene.render.max_depth, seed: 0, first_sample: 0, goal };
        session.render(&job, &mut film, &mut ())?;
        Ok(film.film.develop())
    }

    /// Renders twice: with timestamps, which take time themselves, and without.
    fn pace(&self, session: &mut Session, scene: &Scene) -> Result<Pace> {
        let mut timed = |profile| -> Result<(f64, f64, f64)> {
            session.profile = profile;
            self.rendered(session, scene, Goal::Until { deadline: Instant::now() + self.time, end: 1 << 30 })?;
            let outcome = &session.outcome;
            let walks = outcome.stages.iter().filter(|(name, _)| ["intersect", "shadow"].contains(&name.as_str()));
            let in_walks: f64 = walks.map(|(_, seconds)| seconds).sum();
            Ok((outcome.totals.rays as f64 / in_walks, outcome.totals.paths as f64, outcome.seconds))
        };
        let (rays, ..) = timed(true)?;
        let (_, paths, seconds) = timed(false)?;
        Ok(Pace { paths: paths / seconds, rays })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn document(bench: &Bench, judged: &[Judged]) -> String {
    let name = &bench.device.name;
    let (meshes, control): (Vec<&Judged>, Vec<&Judged>) = judged.iter().partition(|own| own.scene != CONTROL);
    let mean = |those: &[&Judged]| (those.iter().map(|own| own.paths.ln()).sum::<f64>() / those.len() as f64).exp();
    let (gain, kept) = (mean(&meshes), mean(&control));
    let mut text = format!(
        "# Walks: {}\n\nDriver: {}, {}. Images of {}x{} pixels. Written by `make gpu-walks`.\n\n\
         | scene | million rays/s in walks | million paths/s | siblings: rays/s | paths/s | difference, of the noise |\n\
         |---|--:|--:|--:|--:|--:|\n",
        name.name, name.driver, name.backend, bench.size.0, bench.size.1
    );
    for own in judged {
        let number = |value: f64| if value.is_finite() { format!("{value:.3}") } else { "–".to_string() };
        let numbers = [own.usual.rays / 1e6, own.usual.paths / 1e6, own.rays, own.paths, own.differs].map(number);
        let scene = Path::new(own.scene).file_stem().unwrap_or_default().to_string_lossy();
        _ = writeln!(text, "| {scene} | {} |", numbers.join(" | "));
    }
    let verdict = if gain >= WORTH_IT && kept >= LEAST_OF_CONTROL { "should be" } else { "should not be" };
    _ = write!(
        text,
        "\nTrees of siblings render meshes {gain:.3} times as fast and the control {kept:.3} times: they {verdict} the default.\n"
    );
    text
}
