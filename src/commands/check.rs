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
    match examine(args) {
        Ok((primitives, warnings)) => {
            if args.json {
                let file = path_text(&args.scene.path);
                print_json(&json!({"scene": file, "valid": true, "primitives": primitives, "warnings": warnings}))?;
            } else {
                warnings.iter().try_for_each(|warning| print_line(&format!("warning: {warning}")))?;
                let warned = match warnings.len() {
                    0 => "no warnings".to_string(),
                    number => counted(number as u64, "warning"),
                };
                let primitives = counted(primitives as u64, "primitive");
                print_line(&format!("{}: valid, {primitives}, {warned}", args.scene.path.display()))?;
            }
            Ok(())
        }
        Err(error) => {
            if args.json {
                let errors: Vec<_> = error.each().iter().map(describe).collect();
                let first = errors.first();
                print_json(
                    &json!({"scene": path_text(&args.scene.path), "valid": false, "error": first, "errors": errors}),
                )?;
            }
            Err(error)
        }
    }
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
