//! `gpu-rt devices`: the devices of this machine.

use clap::Args;
use serde_json::json;

use super::console::{print_json, print_line, tell};
use crate::error::Result;
use crate::gpu::device::{Adapters, Device};
use crate::gpu::numerics::{LOOPS, Numerics};
use crate::gpu::probe::numerics;

#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
    /// Also print what the numerics probe has found.
    #[arg(long, conflicts_with = "json")]
    pub verbose: bool,
}

/// Lists the adapters, their drivers, the limits that decide whether a scene fits, and the findings of the numerics probe.
pub fn run(args: &DevicesArgs) -> Result<()> {
    let adapters = Adapters::find();
    // If there is no device, the error says what to install.
    let chosen = adapters.index_of_choice(None)?;
    if let Some(missing) = adapters.unseen_gpu() {
        tell(&format!("warning: {missing}"));
    }
    let names = adapters.names();
    let found: Vec<Result<Numerics>> = (0..names.len()).map(|index| probe(&adapters, index)).collect();
    if args.json {
        let devices: Vec<_> = (0..)
            .zip(names.iter().zip(&found))
            .map(|(index, ((name, limits), found)): (usize, _)| {
                json!({
                    "index": index,
                    "name": name.name,
                    "kind": name.kind,
                    "software": name.software,
                    "backend": name.backend,
                    "pci_bus_id": Some(&name.pci_bus_id).filter(|id| !id.is_empty()),
                    "driver": name.driver,
                    "default": index == chosen,
                    "limits": {
                        "storage_buffer_binding_bytes": limits.max_storage_buffer_binding_size,
                        "buffer_bytes": limits.max_buffer_size,
                        "storage_buffers_per_stage": limits.max_storage_buffers_per_shader_stage,
                        "workgroup_invocations": limits.max_compute_invocations_per_workgroup,
                    },
                    "numerics": match found {
                        Ok(found) => json!(found),
                        Err(error) => json!({ "error": error.to_string() }),
                    },
                })
            })
            .collect();
        return print_json(&json!({ "devices": devices }));
    }
    for (index, ((name, limits), found)) in names.iter().zip(&found).enumerate() {
        let mark = if index == chosen { "  (default)" } else { "" };
        print_line(&format!("{index}: {name}{mark}"))?;
        print_line(&format!(
            "   at most {} MiB per storage binding, {} MiB per buffer, {} storage buffers per stage, {} invocations per workgroup",
            limits.max_storage_buffer_binding_size >> 20,
            limits.max_buffer_size >> 20,
            limits.max_storage_buffers_per_shader_stage,
            limits.max_compute_invocations_per_workgroup,
        ))?;
        let lines = match found {
            Ok(found) if args.verbose => [words(found), lacking(found)].concat(),
            Ok(found) if found.lacking().next().is_none() => {
                vec!["numerics: good for all kernels (--verbose lists the findings)".to_string()]
            }
            Ok(found) => lacking(found),
            Err(error) => vec![format!("numerics: {error}")],
        };
        lines.iter().try_for_each(|line| print_line(&format!("   {line}")))?;
    }
    Ok(())
}

/// Probes the numerics of one adapter.
fn probe(adapters: &Adapters, index: usize) -> Result<Numerics> {
    let device = Device::open(adapters.choose(Some(&index.to_string()))?)?;
    numerics(&device).cloned()
}

/// The properties that the driver lacks.
fn lacking(found: &Numerics) -> Vec<String> {
    let lacking = found.lacking();
    lacking
        .map(|property| format!("numerics: this driver {}; kernels that rely on this are refused", property.without))
        .collect()
}

/// The findings in words, one line for each group.
fn words(found: &Numerics) -> Vec<String> {
    let pick = |holds: bool, yes: &'static str, no: &'static str| if holds { yes } else { no };
    vec![
        format!(
            "numerics: two-sum {}; behind a uniform zero, two-sum {} and two-product {}; fma {}, x * y - z {}",
            pick(found.two_sum, "exact", "undone by the compiler"),
            pick(found.two_sum_barrier, "exact", "undone"),
            pick(found.two_product_barrier, "exact", "inexact"),
            pick(found.fma_fused, "fused", "not fused"),
            pick(found.contraction, "contracted", "not contracted"),
        ),
        format!(
            "numerics: for a NaN, x != x is {}, comparisons are {}, and its bits {}; subnormals are {}",
            found.nan_compares,
            pick(found.nan_fails_comparisons, "false", "not all false"),
            pick(found.nan_by_bits, "tell it", "do not tell it"),
            pick(found.subnormals, "kept", "flushed"),
        ),
        match found.loop_iterations >= LOOPS {
            true => format!("numerics: loops did all of {LOOPS} iterations"),
            false => format!("numerics: loops end after {} iterations", found.loop_iterations),
        },
        format!(
            "numerics: largest error of log on [0.5, 1): {:.1e}, relative {:.1e}; of sin within [-pi, pi]: {:.1e}, up to 1e6: {:.1e}",
            found.log_error, found.log_relative_error, found.sin_error, found.sin_error_far,
        ),
        format!(
            "numerics: u32 to f32 rounds {}, u * 2^-32 {} 1; 24 bits are {}; signs of edges are {}",
            found.conversion.name(),
            pick(found.words_reach_one, "reaches", "stays below"),
            pick(found.uniforms_exact, "exact", "inexact"),
            pick(found.edge_signs, "exact", "wrong"),
        ),
    ]
}
