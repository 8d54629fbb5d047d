//! `gpu-rt devices`: what there is to render on.

use serde_json::json;

use super::{print_json, print_line};
use crate::cli::DevicesArgs;
use crate::error::Result;
use crate::gpu::device::Adapters;

/// Lists the adapters, their drivers and the limits that decide whether a scene fits.
pub fn run(args: &DevicesArgs) -> Result<()> {
    let adapters = Adapters::find();
    // The error of choosing says what to install.
    let chosen = adapters.index_of_choice(None)?;
    let names = adapters.names();
    if args.json {
        let devices: Vec<_> = (0..)
            .zip(&names)
            .map(|(index, (name, limits)): (usize, _)| {
                json!({
                    "index": index,
                    "name": name.name,
                    "kind": name.kind,
                    "software": name.software,
                    "backend": name.backend,
                    "driver": name.driver,
                    "default": index == chosen,
                    "limits": {
                        "storage_buffer_binding_bytes": limits.max_storage_buffer_binding_size,
                        "buffer_bytes": limits.max_buffer_size,
                        "storage_buffers_per_stage": limits.max_storage_buffers_per_shader_stage,
                        "workgroup_invocations": limits.max_compute_invocations_per_workgroup,
                    },
                })
            })
            .collect();
        print_json(&json!({ "devices": devices }));
        return Ok(());
    }
    for (index, (name, limits)) in names.iter().enumerate() {
        let mark = if index == chosen { "  (default)" } else { "" };
        print_line(&format!("{index}: {name}{mark}"));
        print_line(&format!(
            "   {} MiB a storage binding, {} MiB a buffer, {} storage buffers a stage, {} invocations a workgroup",
            limits.max_storage_buffer_binding_size >> 20,
            limits.max_buffer_size >> 20,
            limits.max_storage_buffers_per_shader_stage,
            limits.max_compute_invocations_per_workgroup,
        ));
    }
    Ok(())
}
