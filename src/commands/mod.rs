//! The commands of the program, one file each.

mod check;
mod compare;
mod completions;
mod converge;
mod convert;
mod denoise;
mod develop;
mod devices;
mod man;
mod merge;
mod outputs;
mod plan;
mod render;
mod scene;
mod signals;
mod status;
mod submit;
mod tradeoff;

use std::path::Path;

use clap::{Parser, Subcommand};

use crate::error::{Error, Result};
use crate::flatten::{DeviceScene, flatten};
use crate::gpu::device::{AdapterName, Adapters, Device, DeviceClass};
use crate::job::{Goal, Job, Size};
use crate::jobs::scripts::line;
use crate::options::{MAX_DEPTH, RenderOptions};
use crate::output::exr::ExrImage;
use crate::plan::Plan;
use crate::printable::printable;
use crate::scene::Scene;
use crate::terminal::{columns_of_stderr, columns_of_stdout, shown};

/// A path tracer for GPUs, and for machines without one.
#[derive(Debug, Parser)]
#[command(name = "gpu-rt", version, about, max_term_width = 80)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to a linear EXR.
    Render(render::RenderArgs),
    /// Join renders of disjoint samples of one scene, in any order: the image is that of one render.
    Merge(merge::MergeArgs),
    /// Make a PNG of an EXR, whichever program wrote it.
    Develop(develop::DevelopArgs),
    /// Remove the noise of an EXR by Intel's Open Image Denoise, which biases the result. The EXR stays as it is.
    Denoise(denoise::DenoiseArgs),
    /// Report the progress of a render that `gpu-rt submit` shares: samples, parts, time left. It changes no file.
    Status(status::StatusArgs),
    /// Share one render among many processes or machines.
    #[command(subcommand)]
    Submit(submit::Scheduler),
    /// Measure the error of an image against a reference, and separate it from noise.
    Compare(compare::CompareArgs),
    /// Measure the trade of render's settings on a scene: seconds against noise and bias.
    Tradeoff(tradeoff::TradeoffArgs),
    /// Measure how the error falls with samples and seconds, against a reference: CSV and plot.
    Converge(converge::ConvergeArgs),
    /// Show what a scene requires: kernels, buffers and bytes, and which object asked for each.
    Plan(plan::PlanArgs),
    /// Validate a scene without a GPU.
    Check(check::CheckArgs),
    /// Write a glTF scene as a scene file of our own form, which renders to the same image.
    Convert(convert::ConvertArgs),
    /// List the devices, their drivers and limits.
    Devices(devices::DevicesArgs),
    /// Print what a shell needs to complete command lines.
    #[command(hide = true)]
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write the pages of all commands into a folder.
    #[command(hide = true)]
    Man(man::ManArgs),
}

/// Runs the command.
pub fn run(cli: &Cli, start: std::time::Instant) -> Result<()> {
    match &cli.command {
        Command::Render(args) => render::run(args, start),
        Command::Merge(args) => merge::run(args),
        Command::Develop(args) => develop::run(args),
        Command::Denoise(args) => denoise::run(args),
        Command::Status(args) => status::run(args),
        Command::Submit(submit::Scheduler::Slurm(args)) => submit::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Converge(args) => converge::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Check(args) => check::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Tradeoff(args) => tradeoff::run(args, start),
        Command::Devices(args) => devices::run(args),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
    }
}

/// The size of the image, and the scene flattened for it.
fn flatten_for(scene: &Scene, size: Option<Size>, options: &RenderOptions) -> Result<((u32, u32), DeviceScene)> {
    let size = size_of(scene, size);
    Ok((size, flatten(scene, size, options)?))
}

/// The size of the image: the one asked for, or the scene's.
fn size_of(scene: &Scene, asked: Option<Size>) -> (u32, u32) {
    let of_scene = (scene.image.width, scene.image.height);
    asked.map_or(of_scene, |size| size.in_pixels(of_scene))
}

/// Prints warnings about settings that bias the result or are less exact, unless `quiet`. Returns these options as the
/// user gave them.
fn tell_biases(options: &RenderOptions, max_depth: Option<u32>, scene: &Scene, quiet: bool) -> Vec<String> {
    let cut = max_depth.filter(|depth| *depth < scene.render.max_depth);
    let biases: Vec<_> = cut.map(|depth| (&MAX_DEPTH, depth.to_string())).into_iter().chain(options.biases()).collect();
    if !quiet {
        biases.iter().for_each(|(knob, value)| tell(&format!("warning: {}", knob.warning(value))));
    }
    biases.iter().map(|(knob, value)| knob.option(value)).collect()
}

/// The device that a scene is planned for: a real one, or WebGPU's default limits if there is none.
struct Target {
    name: String,
    class: DeviceClass,
    limits: wgpu::Limits,
}

impl Target {
    /// The device of this index or name, or the default device. If the machine has none, the limits that WebGPU guarantees.
    fn find(wish: Option<&str>) -> Result<Target> {
        match Adapters::find().choose(wish) {
            Ok(adapter) => Ok(Target {
                name: AdapterName::of(adapter).to_string(),
                class: DeviceClass::of(adapter),
                limits: adapter.limits(),
            }),
            Err(Error::Device(_)) => Ok(Target {
                name: "no device here: WebGPU's default limits".to_string(),
                class: DeviceClass::default(),
                limits: wgpu::Limits::default(),
            }),
            Err(error) => Err(error),
        }
    }
}

/// The plan of a scene for a device.
fn planned<'a>(
    scene: &Scene,
    size: (u32, u32),
    flat: &'a DeviceScene,
    target: &Target,
    options: &RenderOptions,
) -> Result<Plan<'a>> {
    let goal = Goal::Samples(scene.render.samples);
    let job = Job { size, max_depth: scene.render.max_depth, seed: 0, first_sample: 0, goal };
    Plan::new(flat, options, target.class, &job)
}

/// Opens the device of this index or name, or the default device.
fn open_device(wish: Option<&str>) -> Result<Device> {
    Device::open(Adapters::find().choose(wish)?)
}

/// Opens the devices of these indices or names, or the default device.
fn open_devices(wish: Option<&str>) -> Result<Vec<Device>> {
    Adapters::find().choose_several(wish)?.into_iter().map(Device::open).collect()
}

/// Prints a warning about a software driver, unless `quiet`.
fn tell_software(device: &Device, quiet: bool) {
    if device.name.software && !quiet {
        tell(&format!("warning: {} is a software driver: it renders on the processor, without a GPU", device.name));
    }
}

/// Creates a folder unless it exists. If that fails, the error includes `undone`: the work that has not been done.
fn make_folder(folder: &Path, undone: &str) -> Result<()> {
    let failed = |error: std::io::Error| Error::File {
        path: folder.to_path_buf(),
        action: "write",
        reason: format!("{error}; {undone}"),
    };
    std::fs::create_dir_all(folder).map_err(failed)
}

/// The command line as it was typed, as the shell reads it. The folder of the program is left out.
fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    line(&std::iter::once("gpu-rt".to_string()).chain(words).collect::<Vec<_>>())
}

/// Warns of an image that is denoised, where errors are measured: those of its pixels are not independent.
fn tell_denoised(path: &Path, image: &ExrImage) {
    if let Some(denoiser) = image.denoiser() {
        let name = path.display();
        tell(&format!(
            "warning: {name} is denoised ({denoiser}): it is biased, and its pixels share errors, so that intervals are too narrow"
        ));
    }
}

/// Tells where the colours of an image were converted.
fn tell_colours(path: &Path, colours: Option<&str>) {
    if let Some(words) = colours {
        tell(&format!("{}: {words}", path.display()));
    }
}

/// A path as text for JSON.
fn path_text(path: &Path) -> String {
    path.display().to_string()
}

/// Prints one JSON object on stdout. No line of it is broken.
fn print_json(object: &serde_json::Value) -> Result<()> {
    write_stdout(&format!("{}\n", printable(&format!("{object:#}"))))
}

fn print_line(text: &str) -> Result<()> {
    print_text(&format!("{text}\n"))
}

/// Prints text on stdout as a terminal shows it, without an additional line end.
fn print_text(text: &str) -> Result<()> {
    write_stdout(&shown(text, columns_of_stdout()))
}

/// Writes on stdout. A closed pipe is not an error, because the reader chose to close it.
fn write_stdout(text: &str) -> Result<()> {
    use std::io::{ErrorKind, Write};
    let mut stdout = std::io::stdout();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::File { path: "stdout".into(), action: "write", reason: error.to_string() })
        }
        _ => Ok(()),
    }
}

/// Prints a line on stderr as a terminal shows it. A closed stderr is not an error.
pub fn tell(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{}", shown(text, columns_of_stderr()));
}
