//! `gpu-rt check`: a scene's errors and warnings, without a GPU.

use clap::Args;
use serde_json::json;

use super::console::{path_text, print_json, print_line};
use super::scene::{flatten_for, load};
use super::target::{Target, planned};
use crate::cli::SceneArgs;
use crate::error::{Error, Result};
use crate::gpu::buffers::too_large;
use crate::options::RenderOptions;
use crate::printable::counted;

#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// Reads, validates and flattens the scene, links its kernels, and compares its buffers with the limits of this machine's device.
pub fn run(args: &CheckArgs) -> Result<()> {
    let (found, file) = (examine(args), path_text(&args.scene.path));
    match (&found, args.json) {
        (Ok((primitives, warnings)), true) => {
            print_json(&json!({"scene": file, "valid": true, "primitives": primitives, "warnings": warnings}))?;
        }
        (Ok((primitives, warnings)), false) => {
            warnings.iter().try_for_each(|warning| print_line(&format!("warning: {warning}")))?;
            let warned = match warnings.len() {
                0 => "no warnings".to_string(),
                number => counted(number as u64, "warning"),
            };
            print_line(&format!("{file}: valid, {}, {warned}", counted(*primitives as u64, "primitive")))?;
        }
        (Err(error), true) => {
            let errors: Vec<_> = error.each().iter().map(describe).collect();
            print_json(&json!({"scene": file, "valid": false, "error": errors.first(), "errors": errors}))?;
        }
        (Err(_), false) => {}
    }
    found.map(|_| ())
}

fn examine(args: &CheckArgs) -> Result<(usize, Vec<String>)> {
    let scene = load(&args.scene)?;
    // With the default options of `render`.
    let (size, flat) = flatten_for(&scene, None, &RenderOptions::default())?;
    let target = Target::find(None)?;
    let plan = planned(&scene, size, &flat, &target, &RenderOptions::default())?;
    let mut warnings = scene.warnings();
    warnings.extend_from_slice(&flat.warnings);
    // A valid scene can be too large for this machine's device.
    let refused = too_large(&plan.buffers(), &target.limits);
    warnings.extend(refused.into_iter().map(|why| format!("{}: {why}", target.name)));
    Ok((flat.primitives as usize, warnings))
}

fn describe(error: &Error) -> serde_json::Value {
    match error {
        Error::Scene { location, field, message } => json!({
            "file": path_text(&location.file),
            "line": (location.line > 0).then_some(location.line),
            "column": (location.line > 0).then_some(location.column),
            "field": field,
            "message": message,
        }),
        other => json!({"message": other.to_string()}),
    }
}
