//! The commands of the program, one a file.

mod check;
mod compare;
mod devices;
mod plan;
mod render;

use std::path::Path;

use crate::cli::{BuildArg, Cli, Command, Integrator, LightArgs, Switch};
use crate::error::{Error, Result};
use crate::flatten::{Flat, Wish, flatten_with};
use crate::gpu::device::{AdapterName, Adapters, DeviceClass};
use crate::plan::{Plan, Tables, Tuning};
use crate::render::{Goal, Job, TuningWish, tuning};
use crate::scene::Scene;

/// Runs the command.
pub fn run(cli: &Cli, start: std::time::Instant) -> Result<()> {
    match &cli.command {
        Command::Render(args) => render::run(args, start),
        Command::Compare(args) => compare::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Check(args) => check::run(args),
        Command::Devices(args) => devices::run(args),
    }
}

/// The size of the image asked for, and the scene flattened for it.
fn flatten_for(scene: &Scene, size: Option<(u32, u32)>, wish: Wish) -> Result<((u32, u32), Flat)> {
    let size = size.unwrap_or((scene.image.width, scene.image.height));
    Ok((size, flatten_with(scene, size, wish)?))
}

/// What the command line asks of flattening.
fn wish_of(build: BuildArg, light: &LightArgs) -> Wish {
    let sample_lights = light.integrator == Integrator::Mis;
    Wish { quality: build.into(), sample_lights, roulette: light.roulette == Switch::On, sampler: light.sampler.into() }
}

/// The device that a scene is planned for: the one that would render it, or none.
struct Target {
    name: String,
    class: DeviceClass,
    limits: wgpu::Limits,
}

impl Target {
    /// The device of this index or name, or the default one; where there is none, the least that WebGPU promises.
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

/// The plan of a scene for a device, and the sizes that suit it.
fn planned(scene: &Scene, size: (u32, u32), flat: &Flat, target: &Target, wish: TuningWish) -> Result<(Plan, Tuning)> {
    let goal = Goal::Samples(scene.render.samples);
    let job = Job { size, max_depth: scene.render.max_depth, seed: 0, first_sample: 0, goal };
    let tuning = tuning(target.class, &job, wish);
    let tables = Tables::new(flat, target.class.table_bytes());
    Ok((Plan::with_tables(&flat.features, tuning.scatter, &tables)?, tuning))
}

/// Whether a file can be put there. What has not been done yet is said where it cannot.
fn check_place(path: &Path, undone: &str) -> Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if path.file_name().is_none() || path.is_dir() || !folder.is_dir() {
        return Err(Error::Usage(format!(
            "{}: expected the name of a file in a folder that exists; {undone}",
            path.display()
        )));
    }
    // Devices and pipes are written as they are; a file is made anew beside the old one.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(error) => {
            Err(Error::File { path: path.to_path_buf(), action: "write", reason: format!("{error}; {undone}") })
        }
    }
}

/// Whether two paths are one file. Files that exist are compared as files, so that two spellings of one path are found out.
fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => a == b,
    }
}

/// A path as JSON holds it.
fn path_text(path: &Path) -> String {
    path.display().to_string()
}

/// Prints one JSON object on stdout. A closed pipe is the reader's choice, not a failure.
fn print_json(object: &serde_json::Value) {
    print_line(&format!("{object:#}"));
}

fn print_line(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Prints a line on stderr. Nobody may be listening, which is no failure.
pub fn tell(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{text}");
}
