//! The size of a kernel as SPIR-V, the input of Vulkan drivers. It does not depend on names or on a driver.

use naga::Module;
use naga::back::{PipelineConstants, pipeline_constants, spv};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use super::layout::has_override;
use crate::error::{Error, Result};

/// The size of a module of SPIR-V.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KernelSize {
    pub instructions: u64,
    pub bytes: u64,
}

/// A kernel with these values of its overrides, as wgpu hands it to naga's back ends. Values for overrides that it lacks are ignored.
///
/// # Errors
/// `Error::Shader` if naga finds the kernel or a value invalid, which is a defect of gpu-rt.
pub fn resolved(module: &Module, entry_point: &str, overrides: &[(&str, f64)]) -> Result<(Module, ModuleInfo)> {
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module);
    let info = info.map_err(|error| fault(entry_point, &error))?;
    let given = overrides.iter().filter(|(name, _)| has_override(module, name));
    let constants: PipelineConstants = given.map(|(name, value)| (name.to_string(), *value)).collect();
    let entry = Some((naga::ShaderStage::Compute, entry_point));
    let resolved = pipeline_constants::process_overrides(module, &info, entry, &constants);
    let (module, info) = resolved.map_err(|error| fault(entry_point, &error))?;
    Ok((module.into_owned(), info.into_owned()))
}

fn fault(what: &str, error: &dyn std::fmt::Display) -> Error {
    Error::Shader(format!("{what}: {error}"))
}

/// The size of a kernel with these values of its overrides. Values for overrides that it lacks are ignored.
///
/// # Errors
/// `Error::Shader` if naga cannot write it, which is a defect of gpu-rt.
pub fn size(module: &Module, entry_point: &str, overrides: &[(&str, f64)]) -> Result<KernelSize> {
    let (module, info) = resolved(module, entry_point, overrides)?;
    // With wgpu's own settings: with checks of indices, and without names for debuggers.
    let restrict = BoundsCheckPolicy::Restrict;
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: BoundsCheckPolicies {
            index: restrict,
            buffer: restrict,
            ..BoundsCheckPolicies::default()
        },
        ..spv::Options::default()
    };
    let (shader_stage, entry_point) = (naga::ShaderStage::Compute, entry_point.to_string());
    let what = format!("{entry_point} as SPIR-V");
    let pipeline = spv::PipelineOptions { shader_stage, entry_point };
    let words = spv::write_vec(&module, &info, &options, Some(&pipeline)).map_err(|error| fault(&what, &error))?;
    Ok(KernelSize { instructions: instructions(&words), bytes: words.len() as u64 * 4 })
}

/// The number of instructions after the header of five words. The upper half of an instruction's first word is its
/// number of words (SPIR-V specification, section 2.3).
fn instructions(words: &[u32]) -> u64 {
    const HEADER: usize = 5;
    let mut at = HEADER;
    let mut count = 0;
    while let Some(first) = words.get(at) {
        at += (first >> 16).max(1) as usize;
        count += 1;
    }
    count
}
