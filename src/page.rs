//! A page that renders a scene by itself: what a browser needs of a plan, and the player that runs it.
//!
//! The host decides here, as for a render of its own: kernels, buffers, layouts and the answers of the numerics probe. The player
//! (src/page/player) follows.

mod files;

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use crate::data::{FILM_SUMS, LIGHT_BINS, LIGHT_PATHS, PATHS, RAYS, RUN_LENGTH, SQUARE_FRACTION, STRIP_ROWS};
use crate::data::{SUM_FRACTION, TOO_DEEP_THROUGHPUT};
use crate::error::{Error, Result};
use crate::film::{Film, device_bytes};
use crate::flatten::DeviceScene;
use crate::gpu::layout::{self, Binding, BindingKind, Member};
use crate::gpu::link::{Choices, Embedded, link};
use crate::gpu::numerics::MOST_STEPS;
use crate::gpu::probe;
use crate::job::Job;
use crate::plan::{Bounce, Kernel, Plan, STEPS};
pub use files::{write_folder, write_single};

/// The storage buffers of a kernel, and the bytes of a binding, that every browser with WebGPU allows.
pub const STORAGE_BUFFERS: usize = 8;
pub const BINDING_BYTES: u64 = 128 << 20;

/// A page.
pub struct Page {
    pub title: String,
    /// Kernels, layouts and sizes, for the player.
    pub plan: Value,
    /// The contents of all buffers, one after the other.
    pub data: Vec<u8>,
    /// The picture for browsers without WebGPU, as a PNG, and its words.
    pub picture: Option<(Vec<u8>, String)>,
}

/// A scene whose camera the reader of a page moves, if it does not move by itself.
pub fn with_camera(mut scene: DeviceScene) -> DeviceScene {
    if scene.features.reason("moving_camera").is_none() {
        scene.features.require("placed", || "page".to_owned());
    }
    scene
}

fn is_placed(plan: &Plan<'_>) -> bool {
    plan.scene.features.reason("placed").is_some()
}

/// A sentence for each part of the plan that is too large for some browsers.
pub fn needs(plan: &Plan<'_>) -> Vec<String> {
    let storage = plan.most_storage_buffers();
    let kernels = (storage > STORAGE_BUFFERS)
        .then(|| format!("a kernel binds {storage} storage buffers, and WebGPU guarantees {STORAGE_BUFFERS}"));
    let large = plan.buffers().into_iter().filter(|buffer| !buffer.contents.is_empty() && buffer.bytes > BINDING_BYTES);
    let large = large
        .map(|buffer| format!("`{}` has {} bytes, and WebGPU guarantees {BINDING_BYTES}", buffer.name, buffer.bytes));
    kernels.into_iter().chain(large).collect()
}

/// The most pixels whose film every browser holds.
pub fn most_pixels(plan: &Plan<'_>) -> u64 {
    BINDING_BYTES / device_bytes(&plan.options.aov, plan.kernels.light_paths)
}

/// The plan for the player, and the contents of its buffers. `film` is an empty one of the render. `fixed`: the size is not that of the reader's
/// view.
///
/// # Errors
/// `Error::Shader` if the probe does not link: a defect of gpu-rt.
pub fn plan_and_data(plan: &Plan<'_>, job: &Job, film: &Film, fixed: bool) -> Result<(Value, Vec<u8>)> {
    let mut data = Vec::new();
    let buffers = buffers(plan, &mut data);
    let kernels: Vec<Value> = plan.kernels().into_iter().map(|kernel| kernel_json(kernel)).collect();
    let name = |kernel: &Kernel| kernel.name.clone();
    let bounce: Vec<String> = match &plan.kernels.bounce {
        Bounce::Fused(kernel) => vec![name(kernel)],
        Bounce::Staged(staged) => {
            let first = std::iter::once(&staged.intersect).chain(&staged.medium).chain(&staged.scatter);
            first.chain(&staged.shadow).chain([&staged.refill]).map(|kernel| name(kernel)).collect()
        }
    };
    let module = &plan.kernels.accumulate.module;
    let members_of = |name: &str| Ok::<_, Error>(layout::members(module, name)?.unwrap_or_default());
    let (window, window_bytes) = members_of("Window")?;
    // Not all kernels count the light of narrow lobes.
    let all = plan.kernels().into_iter().map(|kernel| layout::members(&kernel.module, "Counters"));
    let all = all.collect::<Result<Vec<_>>>()?.into_iter().flatten();
    let (counters, counters_bytes) = all.max_by_key(|(members, _)| members.len()).unwrap_or_default();
    let (pixel, pixel_bytes) = members_of("PixelTotals")?;
    let settings = plan.settings(job);
    let sections = json!({
        "size": [job.size.0, job.size.1],
        "fixed": fixed,
        "kernels": kernels,
        "stages": {
            "generate": plan.kernels.generate.name,
            "bounce": bounce,
            "light_path": plan.kernels.light_path.as_ref().map(|kernel| &kernel.name),
            "accumulate": plan.kernels.accumulate.name,
            "receipt": plan.kernels.receipt.name,
        },
        "buffers": buffers,
        "slots": plan.tuning.slots,
        "workgroup": plan.tuning.workgroup,
        "records_per_slot": plan.tuning.records_per_slot,
        "run_length": RUN_LENGTH,
        "strip_rows": STRIP_ROWS,
        "light_paths": settings.light_paths,
        "camera": is_placed(plan).then_some(&plan.scene.placement),
        "settings": {
            "members": offsets(plan.kernels.settings.members()),
            "bytes": STANDARD.encode(plan.kernels.settings.bytes(&settings)),
        },
        "window": {"members": offsets(&window), "bytes": window_bytes},
        "counters": {
            "members": offsets(&counters),
            "bytes": counters_bytes,
            "counts": {"paths": PATHS, "rays": RAYS, "too_deep_throughput": TOO_DEEP_THROUGHPUT, "light_paths": LIGHT_PATHS},
            "light_bins": LIGHT_BINS,
        },
        "film": {
            "members": offsets(&pixel),
            "bytes": pixel_bytes,
            "splats": plan.kernels.light_path.as_ref().map(|_| FILM_SUMS),
            "sum_fraction": SUM_FRACTION,
            "square_fraction": SQUARE_FRACTION,
            "exponent": film.exponent,
            "independent": film.sampler.is_independent(),
            "not_sampled": film.bound.not_sampled,
            "lamps": film.bound.lamps,
        },
        "probe": probe_json()?,
        "show": include_str!("page/show.wgsl"),
    });
    Ok((sections, data))
}

/// The buffers: those of the scene with the place of their contents, and the others with the slots or pixels that their sizes are for.
fn buffers(plan: &Plan<'_>, data: &mut Vec<u8>) -> Vec<Value> {
    let mut found = Vec::new();
    for buffer in plan.buffers() {
        let per = match buffer.name {
            "paths" | "path_words" | "records" => ("slot", buffer.bytes / u64::from(plan.tuning.slots)),
            "film" => ("pixel", device_bytes(&plan.options.aov, plan.kernels.light_paths)),
            _ => ("", buffer.allocated()),
        };
        let first = data.len();
        buffer.contents.iter().for_each(|part| data.extend_from_slice(part));
        let mut json = json!({"name": buffer.name, "binding": buffer.binding(), "per": per.0, "bytes": per.1});
        if data.len() > first {
            json["contents"] = json!([first, data.len() - first]);
        }
        found.push(json);
    }
    found
}

fn kernel_json(kernel: &Kernel) -> Value {
    let has = |name: &&&str| layout::has_override(&kernel.module, name);
    let relies: Vec<&String> = kernel.linked.relies.iter().map(|(property, _)| property).collect();
    json!({
        "name": kernel.name,
        "entry": kernel.stage,
        "wgsl": kernel.linked.text,
        "bindings": bindings(&kernel.bindings),
        "steps": STEPS.iter().filter(has).collect::<Vec<_>>(),
        "relies": relies,
    })
}

fn bindings(all: &BTreeMap<String, Binding>) -> Vec<Value> {
    let kind = |binding: &Binding| match binding.kind {
        BindingKind::Uniform => "uniform",
        BindingKind::Read => "read-only-storage",
        BindingKind::ReadWrite => "storage",
    };
    all.iter().map(|(name, binding)| json!([binding.number, kind(binding), name])).collect()
}

/// Offsets and sizes in bytes, by name.
fn offsets(members: &[Member]) -> Map<String, Value> {
    members.iter().map(|member| (member.name.clone(), json!([member.offset, member.bytes]))).collect()
}

fn probe_json() -> Result<Value> {
    let linked = link(&Embedded, "stage/probe", &Choices::default())?;
    let (module, _) = linked.validate()?;
    let (answer, bytes) = layout::members(&module, "Answer")?.unwrap_or_default();
    let trials = probe::trials();
    Ok(json!({
        "wgsl": linked.text,
        "bindings": bindings(&layout::bindings(&module)?),
        "trials": STANDARD.encode(bytemuck::cast_slice::<_, u8>(&trials)),
        "count": trials.len(),
        "answer": {"members": offsets(&answer), "bytes": bytes},
        "most_steps": MOST_STEPS,
        "expected": probe::expected(&trials),
    }))
}
