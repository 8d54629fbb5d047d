//! `gpu-rt check`: a scene's errors and warnings, without a GPU.

use serde_json::json;

use super::{flatten_for, path_text, print_json, print_line};
use crate::cli::CheckArgs;
use crate::error::{Error, Result};
use crate::flatten::Quality;
use crate::plan::{Plan, Scatter};
use crate::scene::Scene;

/// Reads, validates and flattens the scene, and links its kernels.
pub fn run(args: &CheckArgs) -> Result<()> {
    match examine(args) {
        Ok((primitives, warnings)) => {
            if args.json {
                let file = path_text(&args.scene);
                print_json(&json!({"scene": file, "valid": true, "primitives": primitives, "warnings": warnings}));
            } else {
                warnings.iter().for_each(|warning| print_line(&format!("warning: {warning}")));
                let warned = match warnings.len() {
                    0 => "no warnings".to_string(),
                    1 => "1 warning".to_string(),
                    n => format!("{n} warnings"),
                };
                print_line(&format!("{}: valid, {primitives} primitives, {warned}", args.scene.display()));
            }
            Ok(())
        }
        Err(error) => {
            if args.json {
                print_json(&json!({"scene": path_text(&args.scene), "valid": false, "error": describe(&error)}));
            }
            Err(error)
        }
    }
}

fn examine(args: &CheckArgs) -> Result<(usize, Vec<String>)> {
    let scene = Scene::load(&args.scene)?;
    let (_, flat) = flatten_for(&scene, None, Quality::default())?;
    Plan::new(&flat.features, Scatter::Linked)?;
    Ok((flat.primitives as usize, scene.warnings()))
}

fn describe(error: &Error) -> serde_json::Value {
    match error {
        Error::Scene { location, field, message } => json!({
            "file": path_text(&location.file),
            "line": location.line,
            "column": location.column,
            "field": field,
            "message": message,
        }),
        other => json!({"message": other.to_string()}),
    }
}
