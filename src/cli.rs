//! The command line: the commands, their arguments, and the parsers of the values.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};

use crate::job::Crop;
use crate::options::{self, Class, RenderOptions};
use crate::output::view_transform::{Tonemap, ViewTransform};
use crate::scene::Thin;

/// A path tracer for GPUs, and for machines without one.
#[derive(Debug, Parser)]
#[command(name = "gpu-rt", version, about, max_term_width = 80)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a linear EXR.
    Render(RenderArgs),
    /// Join renders of disjoint samples of one scene, in any order: the image is that of one render.
    Merge(MergeArgs),
    /// Make a PNG of an EXR, whichever program wrote it.
    Develop(DevelopArgs),
    /// Remove the noise of an EXR by Intel's Open Image Denoise, which biases the result. The EXR stays as it is.
    Denoise(DenoiseArgs),
    /// Report the progress of a render that `gpu-rt submit` shares: samples, parts, time left. It changes no file.
    Status(StatusArgs),
    /// Share one render among many processes or machines.
    #[command(subcommand)]
    Submit(Scheduler),
    /// Measure the error of an image against a reference, and separate it from noise.
    Compare(CompareArgs),
    /// Measure the trade of render's settings on a scene: seconds against noise and bias.
    Tradeoff(TradeoffArgs),
    /// Measure how the error falls with samples and seconds, against a reference: CSV and plot.
    Converge(ConvergeArgs),
    /// Show what a scene requires: kernels, buffers and bytes, and which object asked for each.
    Plan(PlanArgs),
    /// Validate a scene without a GPU.
    Check(CheckArgs),
    /// Write a glTF scene as a scene file of our own form, which renders to the same image.
    Convert(ConvertArgs),
    /// List the devices, their drivers and limits.
    Devices(DevicesArgs),
    /// Print what a shell needs to complete command lines.
    #[command(hide = true)]
    Completions(CompletionsArgs),
    /// Print the manual page, or write the pages of all commands into a folder.
    #[command(hide = true)]
    Man(ManArgs),
}

/// The interval of checkpoints where none is given.
pub const CHECKPOINT: &str = "60s";

/// Of `--oidn`.
const OIDN: &str = "The folder of the library of Open Image Denoise [default: the environment's OIDN_DIR, or where the system finds it].";

#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// The scene: a .ron, .glb or .gltf file, or - for a .ron on standard input.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The image to write: a linear .exr, or a .png, which is the picture alone and cannot be resumed. - is a PNG on standard output
    /// [default: the scene's name with .exr, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also write a tone-mapped picture, - for standard output.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES),
          help = options::SPP.help(), help_heading = options::SPP.class.heading())]
    pub spp: Option<u32>,
    /// Sample indices A to B - 1 of each pixel, to split a render over machines.
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with_all = ["spp", "time"])]
    pub samples: Option<Range<u32>>,
    /// Render for this time, counted from the start of the program [30s, 5m, …]: at least one sample per pixel, at most
    /// --spp if given.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    /// Render until the relative error is below this with 95 % confidence, such as 0.01 for 1 %: 16, 32, 64 … samples,
    /// limited by --spp and --time if given.
    #[arg(long, value_name = "E", value_parser = relative_error, conflicts_with = "samples")]
    pub noise: Option<f64>,
    #[arg(long, value_name = "WxH|N%", value_parser = image_size,
          help = options::SIZE.help(), help_heading = options::SIZE.class.heading())]
    pub size: Option<Size>,
    /// Render only a part of the image: WIDTH x HEIGHT pixels, from column X and row Y on, with the bytes of the whole image.
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub crop: Option<Crop>,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub view: ViewArgs,
    #[arg(long, conflicts_with = "watch", help = options::DENOISE.help(), help_heading = options::DENOISE.class.heading())]
    pub denoise: bool,
    #[arg(long, value_name = "FOLDER", requires = "denoise", help = OIDN, help_heading = options::DENOISE.class.heading())]
    pub oidn: Option<PathBuf>,
    /// Draw the image so far, about once a second, and the image at the end in the terminal, as --exposure and --tonemap have it.
    #[arg(long)]
    pub preview: bool,
    /// Send the image so far, about once a second, and the image at the end to a viewer: tev, which listens on 127.0.0.1:14158.
    #[arg(long, value_name = "HOST:PORT", value_parser = host_and_port)]
    pub display_server: Option<String>,
    /// Write the image so far at this interval, and the PNG too [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = CHECKPOINT)]
    pub checkpoint: Duration,
    /// Go on with the render in the output, and fail if there is none; --resume=auto starts afresh then. The image is that of one render.
    #[arg(long, value_name = "auto", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = resume)]
    pub resume: Option<Resume>,
    /// Render again whenever the scene or one of its files is saved, until Ctrl-C: a quarter of the size, a half, then all of it.
    #[arg(long, conflicts_with_all = ["samples", "resume", "json"])]
    pub watch: bool,
    /// Render with several devices or drivers, or go on with another one, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    /// Leave out of the EXR what --resume and `merge` need.
    #[arg(long)]
    pub no_state: bool,
    /// Overwrite an image of this render that has more samples.
    #[arg(long)]
    pub force: bool,
    /// Fail if a sample was not finite and therefore rejected.
    #[arg(long)]
    pub strict: bool,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Also say what the stated error excludes.
    #[arg(long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print one JSON object on stdout at the end.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Measure the seconds of each stage on the device; each dispatch then needs a pass of its own.
    #[arg(long, help_heading = Class::Exact.heading())]
    pub profile: bool,
}

/// What a glTF file leaves open.
#[derive(Clone, Debug, Default, Args)]
pub struct GltfArgs {
    /// Of a .glb or .gltf: the camera, by its name or that of its node [default: the first one].
    #[arg(long, value_name = "NAME", help_heading = GLTF)]
    pub camera: Option<String>,
    /// Of a .glb or .gltf: an image of the sky, as `background: Image` takes it.
    #[arg(long, value_name = "FILE", help_heading = GLTF)]
    pub sky: Option<PathBuf>,
    /// Of a .glb or .gltf: add a sun, at this elevation, and this azimuth from -z to +x, in degrees.
    #[arg(long, value_name = "ELEVATION,AZIMUTH", num_args = 0..=1, require_equals = true, default_missing_value = "45,60",
          value_parser = sun, allow_hyphen_values = true, help_heading = GLTF)]
    pub sun: Option<(f64, f64)>,
    /// Of a .glb or .gltf: whether its lights are in Blender's watts, which are divided by 683 lm/W [default: on for files by Blender].
    #[arg(long, value_name = "on|off", num_args = 0..=1, require_equals = true, default_missing_value = "on",
          value_parser = on_or_off, help_heading = GLTF)]
    pub watts: Option<bool>,
    /// Of a .glb or .gltf: which glass is thin. `auto`: of files by Blender open meshes, as it renders them; `pane`: glass without a
    /// thickness in the file, as glTF says.
    #[arg(long, value_name = "WORD", value_enum, default_value_t, help_heading = GLTF)]
    pub thin: Thin,
}

fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("expected on or off".to_owned()),
    }
}

/// The place of a sun: two angles in degrees.
fn sun(text: &str) -> Result<(f64, f64), String> {
    let angles =
        text.split_once(',').and_then(|(a, b)| Some((a.trim().parse::<f64>().ok()?, b.trim().parse::<f64>().ok()?)));
    let fits = |(elevation, azimuth): &(f64, f64)| elevation.abs() <= 90.0 && azimuth.abs() <= 360.0;
    angles.filter(fits).ok_or_else(|| "expected an elevation of at most 90 and an azimuth, such as 45,60".to_owned())
}

const GLTF: &str = "Scenes that are glTF";

/// Who runs the processes.
#[derive(Debug, Subcommand)]
pub enum Scheduler {
    /// Share it through Slurm: write a folder with the scene and scripts, submit an array of tasks that render, and a job that joins their images.
    Slurm(SubmitArgs),
}

#[derive(Debug, Args)]
pub struct SubmitArgs {
    /// The scene file. It is copied, and so are the files that it names by relative paths.
    #[arg(required_unless_present_any = ["missing", "next"])]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub gltf: GltfArgs,
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES),
          help = options::SPP.help(), help_heading = options::SPP.class.heading())]
    pub spp: Option<u32>,
    /// Render until the relative error is below this with 95 % confidence, in rounds that double the samples, limited by --spp if
    /// given.
    #[arg(long, value_name = "E", value_parser = relative_error)]
    pub noise: Option<f64>,
    /// The parts that the samples are split into: at most one for 8 samples.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=1_000_000), required_unless_present_any = ["missing", "next"])]
    pub parts: Option<u32>,
    /// The folder, which all machines must see; created if missing [default: SCENE-job].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Submit the parts of this folder whose images lack samples, and the join after them.
    #[arg(long, value_name = "DIR", conflicts_with_all = of_a_new_folder().chain(["next"]))]
    pub missing: Option<PathBuf>,
    /// Submit the next round of this folder, unless the error is reached. The job that joins does it.
    #[arg(long, value_name = "DIR", conflicts_with_all = of_a_new_folder())]
    pub next: Option<PathBuf>,
    /// Write the folder and print what would be submitted.
    #[arg(long)]
    pub dry_run: bool,
    #[arg(long, value_name = "WxH|N%", value_parser = image_size,
          help = options::SIZE.help(), help_heading = options::SIZE.class.heading())]
    pub size: Option<Size>,
    #[command(flatten)]
    pub paths: PathArgs,
    /// Write the images of parts so far at this interval [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = CHECKPOINT)]
    pub checkpoint: Duration,
    /// Allow several devices or drivers, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Options of sbatch.
    #[arg(last = true, value_name = "SBATCH OPTION")]
    pub sbatch: Vec<String>,
}

/// The arguments of `submit` that a folder has already.
fn of_a_new_folder() -> impl Iterator<Item = &'static str> {
    let own = [
        "scene",
        "camera",
        "sky",
        "sun",
        "watts",
        "thin",
        "spp",
        "noise",
        "parts",
        "output",
        "size",
        "checkpoint",
        "mixed_drivers",
    ];
    own.into_iter().chain(["max_depth", "seed", "device"]).chain(RenderOptions::names())
}

/// What `--resume` does where there is nothing to resume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// It fails.
    Yes,
    /// The render starts afresh.
    Auto,
}

fn resume(text: &str) -> Result<Resume, String> {
    match text {
        "yes" => Ok(Resume::Yes),
        "auto" => Ok(Resume::Auto),
        _ => Err("expected --resume or --resume=auto".to_string()),
    }
}

/// Which paths are traced, and where.
#[derive(Clone, Debug, Args)]
pub struct PathArgs {
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000),
          help = options::MAX_DEPTH.help(), help_heading = options::MAX_DEPTH.class.heading())]
    pub max_depth: Option<u32>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// The device, by its index or a part of its name as `gpu-rt devices` lists them. `render` also takes a list A,B,…, or `all` for all GPUs.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
}

/// How a PNG shows radiance.
#[derive(Clone, Copy, Debug, Args)]
pub struct ViewArgs {
    /// Exposure of the PNG, in stops.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    exposure: f64,
    /// Curve of the PNG: `srgb` clips what is brighter than white; `soft` is the same with a shoulder, so that bright lamps keep a
    /// hue; `neutral` is Khronos PBR Neutral; `filmic` is a film curve with darker shadows (ACES).
    #[arg(long, value_name = "CURVE", value_enum, default_value_t)]
    tonemap: Tonemap,
}

impl ViewArgs {
    pub fn transform(&self) -> ViewTransform {
        ViewTransform { exposure: self.exposure, tonemap: self.tonemap }
    }
}

#[derive(Debug, Args)]
pub struct DevelopArgs {
    /// The EXR: red, green and blue, or a luminance alone.
    #[arg(value_name = "IN.exr")]
    pub image: PathBuf,
    /// The PNG to write, - for standard output.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    #[command(flatten)]
    pub view: ViewArgs,
}

#[derive(Debug, Args)]
pub struct DenoiseArgs {
    /// The EXR: red, green and blue, and to keep more detail albedo and normal, as `render --aov albedo,normal` writes them.
    #[arg(value_name = "IN.exr")]
    pub image: PathBuf,
    /// The denoised EXR to write. It has no estimate of its error, and cannot be resumed or joined.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Also write a tone-mapped picture of it, - for standard output.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[arg(long, value_name = "FOLDER", help = OIDN)]
    pub oidn: Option<PathBuf>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The parts: EXRs of `gpu-rt render --samples A..B`, or of this command, or folders of them.
    #[arg(value_name = "PART.exr", required = true)]
    pub parts: Vec<PathBuf>,
    /// Fail unless the parts together have exactly these samples.
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with = "allow_gaps")]
    pub samples: Option<Range<u32>>,
    /// Join parts until the relative error is below this, as `render --noise` would: it is checked at 16, 32, 64 … samples, and a part
    /// must end at each check.
    #[arg(long, value_name = "E", value_parser = relative_error, conflicts_with = "allow_gaps")]
    pub noise: Option<f64>,
    /// The EXR to write. It can be resumed, and joined with others.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Join parts that leave out samples between them.
    #[arg(long)]
    pub allow_gaps: bool,
    /// Join parts of several devices or drivers, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The folder that `gpu-rt submit` has written.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Also join the samples that are there, and print the error of their image.
    #[arg(long)]
    pub error: bool,
    /// Also join the samples that are there, and write a tone-mapped picture of them.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Print results and errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TradeoffArgs {
    /// The scene: a .ron, .glb or .gltf file, or - for a .ron on standard input.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The time limit, compiling included.
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "120s")]
    pub budget: Duration,
    /// The reference image, from any renderer [default: the mean image of the unbiased settings].
    #[arg(long, value_name = "R.exr")]
    pub reference: Option<PathBuf>,
    /// The settings to sweep, by their options' names [default: all].
    #[arg(long, value_name = "A,B,…", value_delimiter = ',')]
    pub knobs: Vec<String>,
    #[arg(long, value_name = "FOLDER", help = OIDN)]
    pub oidn: Option<PathBuf>,
    /// The folder for index.html, plot.svg, tradeoff.csv and tradeoff.json; created if missing [default: SCENE-tradeoff].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// The device, by its index or a part of its name as `gpu-rt devices` lists them.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
    /// Print results and errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ConvergeArgs {
    /// The scene: a .ron, .glb or .gltf file, or - for a .ron on standard input.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The reference image, from any renderer. The render has its size.
    #[arg(long, value_name = "R.exr")]
    pub reference: PathBuf,
    /// The folder for SCENE-converge.csv and SCENE-converge.svg; created if missing.
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Samples per pixel at the end [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES),
          help_heading = options::SPP.class.heading())]
    pub spp: Option<u32>,
    /// Stop before a doubling of the samples would exceed this time [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The EXR to judge.
    #[arg(value_name = "A.exr")]
    pub image: PathBuf,
    /// The reference: an EXR of the same size, from any renderer.
    #[arg(value_name = "B.exr")]
    pub reference: PathBuf,
    /// Compare this layer of both files instead of the picture: albedo, N, Z, direct, … as `render --aov` names them, or those of other programs.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Also write a heat map of FLIP's error: black is none, pale yellow is the most.
    #[arg(long, value_name = "FILE.png")]
    pub heatmap: Option<PathBuf>,
    /// Exit with status 1 if this metric is above the value, such as relmse=0.01. Metrics: mse, rmse, relmse,
    /// relmse_trimmed, flip and mean_difference (its magnitude). Can be given several times. A pixel that is not finite
    /// fails too.
    #[arg(long, value_name = "METRIC=VALUE", value_parser = limit)]
    pub fail_above: Vec<Limit>,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// A limit of `--fail-above`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    pub metric: Metric,
    pub value: f64,
}

/// The metrics for which 0 is best.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    Mse,
    Rmse,
    Relmse,
    RelmseTrimmed,
    Flip,
    MeanDifference,
}

impl Metric {
    pub const ALL: [Metric; 6] =
        [Metric::Mse, Metric::Rmse, Metric::Relmse, Metric::RelmseTrimmed, Metric::Flip, Metric::MeanDifference];

    pub fn name(self) -> &'static str {
        match self {
            Metric::Mse => "mse",
            Metric::Rmse => "rmse",
            Metric::Relmse => "relmse",
            Metric::RelmseTrimmed => "relmse_trimmed",
            Metric::Flip => "flip",
            Metric::MeanDifference => "mean_difference",
        }
    }
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The scene: a .ron, .glb or .gltf file, or - for a .ron on standard input.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// Write the linked shaders into this folder.
    #[arg(long, value_name = "DIR")]
    pub wgsl: Option<PathBuf>,
    /// Explain one kernel: its modules, with the user of each and the object or option that asked for it; its bindings,
    /// path state and constants. With --json: list this kernel only.
    #[arg(long, value_name = "KERNEL")]
    pub why: Option<String>,
    #[arg(long, value_name = "WxH|N%", value_parser = image_size,
          help = options::SIZE.help(), help_heading = options::SIZE.class.heading())]
    pub size: Option<Size>,
    /// The device whose sizes to plan for.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The scene: a .ron, .glb or .gltf file, or - for a .ron on standard input.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The .glb or .gltf file. Its meshes and images stay in it.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The scene file to write.
    #[arg(short, long, value_name = "SCENE.ron")]
    pub output: PathBuf,
}

#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub struct ManArgs {
    /// The folder for a page of each command; created if missing.
    pub folder: Option<PathBuf>,
}

/// The size of an image, in pixels or as a share of the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    Pixels(u32, u32),
    Share(f64),
}

impl Size {
    /// The size in pixels, at least one in each direction.
    pub fn of(self, (width, height): (u32, u32)) -> (u32, u32) {
        match self {
            Size::Pixels(width, height) => (width, height),
            Size::Share(share) => {
                let part = |n: u32| ((f64::from(n) * share).round() as u32).max(1);
                (part(width), part(height))
            }
        }
    }
}

/// The most samples of a pixel. Sample indices are 32-bit words, and must leave room to round up to a block.
pub const MOST_SAMPLES: i64 = 1 << 31;

fn sample_range(text: &str) -> Result<Range<u32>, String> {
    let expected = || format!("expected A..B with A < B <= {MOST_SAMPLES}, such as 0..64");
    let (from, to) = text.split_once("..").ok_or_else(expected)?;
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| expected());
    let (from, to) = (number(from)?, number(to)?);
    match from < to && i64::from(to) <= MOST_SAMPLES {
        true => Ok(from..to),
        false => Err(expected()),
    }
}

/// Parses a time such as 30s.
pub fn duration(text: &str) -> Result<Duration, String> {
    // A bare number is seconds.
    let duration = match text.parse::<f64>() {
        Ok(seconds) => Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string()),
        Err(_) => humantime::parse_duration(text).map_err(|error| error.to_string()),
    };
    match duration {
        Ok(duration) if duration.is_zero() => Err("expected a time above zero, such as 30s".to_string()),
        Ok(duration) if duration.as_secs() > 10 * 365 * 86_400 => Err("expected a time below ten years".to_string()),
        Ok(duration) => Ok(duration),
        Err(error) => Err(format!("expected a time such as 30s or 5m: {error}")),
    }
}

/// Parses an image's size. The limits are those of a scene's `image`; a share is at most 100 % of the scene's size.
fn image_size(text: &str) -> Result<Size, String> {
    let expected = || {
        "expected WIDTHxHEIGHT from 1x1 to 65536x65536, 2^30 pixels at most, such as 640x360, or a share of the scene's up to 100%"
            .to_string()
    };
    if let Some(percent) = text.strip_suffix('%') {
        let share = percent.parse::<f64>().ok().filter(|percent| *percent > 0.0 && *percent <= 100.0);
        return share.map(|percent| Size::Share(percent / 100.0)).ok_or_else(expected);
    }
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let number = |text: &str| text.parse::<u32>().ok().filter(|n| (1..=65_536).contains(n)).ok_or_else(expected);
    let (width, height) = (number(width)?, number(height)?);
    match u64::from(width) * u64::from(height) <= 1 << 30 {
        true => Ok(Size::Pixels(width, height)),
        false => Err(expected()),
    }
}

fn relative_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if (1e-6..=1.0).contains(&error) => Ok(error),
        _ => Err("expected a relative error from 0.000001 to 1, such as 0.01 for 1 %".to_string()),
    }
}

fn limit(text: &str) -> Result<Limit, String> {
    let names = || Metric::ALL.map(Metric::name).join(", ");
    let (name, value) =
        text.split_once('=').ok_or_else(|| format!("expected METRIC=VALUE, with a METRIC of {}", names()))?;
    if name == "psnr" {
        return Err(
            "a higher psnr is better, so it cannot have an upper limit; use mse, or flip for the perceived difference"
                .to_string(),
        );
    }
    let metric = Metric::ALL.into_iter().find(|metric| metric.name() == name);
    let metric = metric.ok_or_else(|| format!("expected one of {}, found {name}", names()))?;
    match value.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(Limit { metric, value }),
        _ => Err(format!("expected a number of at least 0 as the limit of {name}, such as {name}=0.01")),
    }
}

fn host_and_port(text: &str) -> Result<String, String> {
    match text.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0) => Ok(text.to_owned()),
        _ => Err("expected HOST:PORT, such as 127.0.0.1:14158".to_string()),
    }
}

fn exposure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if stops.abs() <= 100.0 => Ok(stops),
        _ => Err("expected a number of stops from -100 to 100".to_string()),
    }
}
