//! `gpu-rt plan`: what a scene requires.

use std::path::Path;

use serde_json::json;

use super::{Target, flatten_for, path_text, planned, print_json, print_line, wish_of};
use crate::cli::{FeaturesArg, PlanArgs};
use crate::error::{Error, Result};
use crate::flatten::Wish;
use crate::output::atomic;
use crate::plan::{Bounce, Plan, Scatter, Tuning};
use crate::render::TuningWish;
use crate::scene::Scene;

/// Prints the kernels and buffers, and why each is there.
pub fn run(args: &PlanArgs) -> Result<()> {
    let scene = Scene::load(&args.scene)?;
    let wish = Wish { every_feature: args.features == FeaturesArg::All, ..wish_of(&args.trade) };
    let (size, flat) = flatten_for(&scene, args.size, wish)?;
    let target = Target::find(args.device.as_deref())?;
    let wish = TuningWish { scatter: args.scatter.map(Into::into), ..TuningWish::default() };
    let (plan, tuning) = planned(&scene, size, &flat, &target, wish)?;
    let device = &target.name;
    if let Some(folder) = &args.wgsl {
        write_shaders(folder, &plan)?;
    }
    let buffers = plan.buffers(&flat, &tuning);
    let total: u64 = buffers.iter().map(|buffer| buffer.allocated()).sum();
    if args.json {
        let kernels: Vec<_> = plan
            .kernels()
            .iter()
            .map(|kernel| {
                json!({
                    "name": kernel.name,
                    "why": kernel.why,
                    "modules": kernel.linked.modules,
                    "wgsl_bytes": kernel.linked.text.len(),
                    "bindings": kernel.bindings.keys().collect::<Vec<_>>(),
                })
            })
            .collect();
        let buffers: Vec<_> = buffers
            .iter()
            .map(|buffer| json!({"name": buffer.name, "bytes": buffer.allocated(), "why": buffer.why}))
            .collect();
        print_json(&json!({
            "scene": path_text(&args.scene),
            "device": device,
            "slots": tuning.slots,
            "path_bytes_per_slot": plan.path_bytes(),
            "scatter": scatter_words(&plan, &tuning),
            "kernels": kernels,
            "buffers": buffers,
            "gpu_bytes": total,
        }));
        return Ok(());
    }
    print_line(&format!("{} on {device}", args.scene.display()));
    print_line("kernels");
    for kernel in plan.kernels() {
        let modules = kernel.linked.modules.len();
        let bytes = kernel.linked.text.len();
        print_line(&format!(
            "  {:<22} {modules:>2} modules, {bytes:>6} bytes of WGSL; for {}",
            kernel.name, kernel.why
        ));
    }
    print_line(&format!("scatter: {}", scatter_words(&plan, &tuning)));
    print_line(&format!("path state: {} bytes a slot, {} slots", plan.path_bytes(), tuning.slots));
    print_line("buffers");
    for buffer in &buffers {
        print_line(&format!("  {:<12} {:>12} bytes  {}", buffer.name, buffer.allocated(), buffer.why));
    }
    print_line(&format!("  {:<12} {total:>12} bytes", "in all"));
    Ok(())
}

fn scatter_words(plan: &Plan, tuning: &Tuning) -> String {
    match (&plan.bounce, tuning.scatter) {
        (Bounce::Fused(_), _) => {
            "fused: a processor pays more for storing a path's state than for its divergence (docs/performance.md)"
                .to_string()
        }
        (Bounce::Staged(staged), _) if staged.scatter.is_empty() => "none: there is nothing to hit".to_string(),
        (Bounce::Staged(staged), _) if staged.dispatch.is_some() => {
            format!("queues: a kernel and a queue for each of {} materials", staged.scatter.len())
        }
        (Bounce::Staged(_), Scatter::Queues) => "linked: with one material there is nothing to sort".to_string(),
        (Bounce::Staged(_), _) => "linked: one kernel for all materials".to_string(),
    }
}

fn write_shaders(folder: &Path, plan: &Plan) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| Error::File {
        path: folder.to_path_buf(),
        action: "create",
        reason: error.to_string(),
    })?;
    for kernel in plan.kernels() {
        let path = folder.join(format!("{}.wgsl", kernel.name));
        atomic::replace(&path, |file| std::io::Write::write_all(file, kernel.linked.text.as_bytes()))?;
    }
    Ok(())
}
