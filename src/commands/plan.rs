//! `gpu-rt plan`: the kernels and buffers that a scene requires.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Map, Value, json};

use super::console::{path_text, print_json, print_text, tell};
use super::outputs::{check_name, make_folder};
use super::scene::{flatten_for, load};
use super::target::{Target, open_device, planned};
use crate::cli::SceneArgs;
use crate::error::{Error, Result};
use crate::gpu::probe::numerics;
use crate::job::Size;
use crate::options::{RenderOptions, SIZE};
use crate::output::atomic;
use crate::plan::{Buffer, Constant, KernelReport, Module, PathField, Plan, Report, STEPS};

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Write the linked shaders into this folder.
    #[arg(long, value_name = "DIR")]
    pub wgsl: Option<PathBuf>,
    /// Explain one kernel: its modules, with the user of each and the object or option that asked for it; its bindings,
    /// path state and constants. With --json: list this kernel only.
    #[arg(long, value_name = "KERNEL")]
    pub why: Option<String>,
    #[arg(long, value_name = "WxH|W|N%", help = SIZE.about, long_help = SIZE.help(), help_heading = SIZE.class.heading())]
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

/// Prints the kernels and buffers, and the reason for each.
pub fn run(args: &PlanArgs) -> Result<()> {
    args.wgsl.iter().try_for_each(|path| check_name(path, "a folder"))?;
    let scene = load(&args.scene)?;
    let (size, flat) = flatten_for(&scene, args.size, &args.options)?;
    let target = Target::find(args.device.as_deref())?;
    let plan = planned(&scene, size, &flat, &target, &args.options)?;
    let mut report = Report::new(&plan, &target.limits);
    let why = args.why.as_deref();
    if let Some(name) = why.filter(|name| report.kernels.iter().all(|kernel| kernel.name != *name)) {
        let names: Vec<&str> = report.kernels.iter().map(|kernel| kernel.name.as_str()).collect();
        return Err(Error::Usage(format!("--why {name}: expected a kernel of this plan: {}", names.join(", "))));
    }
    if let Some(folder) = &args.wgsl {
        write_shaders(folder, &plan)?;
    }
    report.measure(&plan)?;
    if report.constants.iter().any(|constant| STEPS.contains(&constant.name.as_str())) {
        report.allow_steps(steps_of(args.device.as_deref()));
    }
    if args.json {
        return print_json(&as_json(&report, &path_text(&args.scene.path), &target.name, why));
    }
    let text = why.and_then(|kernel| report.why(kernel)).unwrap_or_else(|| report.text());
    print_text(&format!("{} on {}\n{text}", args.scene.path.display(), target.name))
}

/// The limit on a walk's steps on the device, if there is one and its numerics are known.
fn steps_of(device: Option<&str>) -> Option<u32> {
    let device = open_device(device).ok()?;
    numerics(&device).ok()?.most_steps()
}

/// The full report; with `why`, only that kernel.
fn as_json(report: &Report, scene: &str, device: &str, why: Option<&str>) -> Value {
    let is_listed = |kernel: &&KernelReport| why.is_none_or(|name| kernel.name == name);
    let kernels: Vec<_> = report.kernels.iter().filter(is_listed).map(|kernel| kernel_json(report, kernel)).collect();
    let choices: Map<String, Value> =
        report.choices.iter().map(|choice| (choice.name.to_string(), json!(choice.module))).collect();
    let features: Vec<_> =
        report.features.iter().map(|(name, reason)| json!({"name": name, "asked_by": reason})).collect();
    json!({
        "scene": scene,
        "device": device,
        "features": features,
        "left_out": report.left_out,
        "choices": choices,
        "slots": report.slots,
        "path_bytes_per_slot": report.path_bytes(),
        "path_fields": report.path_fields.iter().map(field_json).collect::<Vec<_>>(),
        "integrator": report.integrator,
        "scatter": report.scatter,
        "kernels": kernels,
        "constants": report.constants.iter().map(constant_json).collect::<Vec<_>>(),
        "buffers": report.buffers.iter().map(buffer_json).collect::<Vec<_>>(),
        "gpu_bytes": report.gpu_bytes(),
    })
}

fn kernel_json(report: &Report, kernel: &KernelReport) -> Value {
    let module = |module: &Module| json!({"name": module.name, "used_by": module.used_by, "asked_by": module.reason});
    json!({
        "name": kernel.name,
        "why": kernel.why,
        "features": kernel.features,
        "modules": kernel.modules.iter().map(module).collect::<Vec<_>>(),
        "wgsl_bytes": kernel.wgsl_bytes,
        "spirv_bytes": kernel.size.map(|size| size.bytes),
        "spirv_instructions": kernel.size.map(|size| size.instructions),
        "bindings": kernel.bindings.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "storage_buffers": kernel.storage_buffers(),
        "storage_buffers_limit": kernel.storage_limit,
        "path_fields": kernel.path_fields.iter().map(PathField::label).collect::<Vec<_>>(),
        "constants": report.constants_of(&kernel.name).iter().map(|constant| &constant.name).collect::<Vec<_>>(),
    })
}

fn field_json(field: &PathField) -> Value {
    json!({"name": field.label(), "bytes": field.bytes(), "what": field.what, "asked_by": field.why})
}

fn constant_json(constant: &Constant) -> Value {
    let value = constant.value.parse::<u64>().map_or_else(|_| json!(constant.value), |value| json!(value));
    json!({
        "name": constant.name,
        "value": value,
        "what": constant.what,
        "override": constant.is_override,
        "asked_by": constant.reason,
        "kernels": constant.kernels,
    })
}

fn buffer_json(buffer: &Buffer) -> Value {
    json!({
        "name": buffer.name,
        "bytes": buffer.bytes,
        "why": buffer.what,
        "size": buffer.size,
        "binding": buffer.binding,
        "limit": buffer.limit,
        "fits": buffer.fits(),
        "asked_by": buffer.reason,
    })
}

/// The shaders in a folder that are not kernels of this plan, for example those of an earlier plan.
fn other_shaders(folder: &Path, plan: &Plan<'_>) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let own: Vec<String> = plan.kernels().iter().map(|kernel| format!("{}.wgsl", kernel.name)).collect();
    let mut others: Vec<String> = names.filter(|name| name.ends_with(".wgsl") && !own.contains(name)).collect();
    others.sort_unstable();
    others
}

fn write_shaders(folder: &Path, plan: &Plan<'_>) -> Result<()> {
    make_folder(folder, "no shader has been written")?;
    for kernel in plan.kernels() {
        let path = folder.join(format!("{}.wgsl", kernel.name));
        atomic::write(&path, kernel.linked.text.as_bytes())?;
    }
    let others = other_shaders(folder, plan);
    if !others.is_empty() {
        tell(&format!("warning: {} also holds {}; this plan did not write them", folder.display(), others.join(", ")));
    }
    Ok(())
}
