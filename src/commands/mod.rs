//! The commands of the program, one a file.

mod check;
mod devices;
mod plan;
mod render;

use std::path::Path;

use crate::cli::{Cli, Command};
use crate::error::Result;
use crate::flatten::{Flat, Quality, flatten_with};
use crate::scene::Scene;

/// Runs the command.
pub fn run(cli: &Cli, start: std::time::Instant) -> Result<()> {
    match &cli.command {
        Command::Render(args) => render::run(args, start),
        Command::Plan(args) => plan::run(args),
        Command::Check(args) => check::run(args),
        Command::Devices(args) => devices::run(args),
    }
}

/// The size of the image asked for, and the scene flattened for it.
fn flatten_for(scene: &Scene, size: Option<(u32, u32)>, quality: Quality) -> Result<((u32, u32), Flat)> {
    let size = size.unwrap_or((scene.image.width, scene.image.height));
    Ok((size, flatten_with(scene, size, quality)?))
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
