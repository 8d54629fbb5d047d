//! A kernel as SPIR-V, the input of Vulkan drivers: its size, which does not depend on names or on a driver; and without contraction.

use naga::back::spv::{self, BindingInfo, BindingMap};
use naga::back::{PipelineConstants, pipeline_constants};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ResourceBinding};

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
    let words = written(module, entry_point, overrides, BindingMap::default(), BoundsCheckPolicy::Restrict)?;
    Ok(KernelSize { instructions: instructions_of(&words).count() as u64, bytes: words.len() as u64 * 4 })
}

/// A kernel with these values of its overrides, in which no product is fused with a sum, for a device that checks buffers itself. (Mesa 22.3.6
/// writes beyond its own memory while it compiles checks of buffers.) Its bindings, of which these are the numbers, are numbered
/// from 0 in their order, as wgpu has it.
///
/// # Errors
/// As of [`size`].
pub fn uncontracted(
    module: &Module,
    entry_point: &str,
    overrides: &[(&str, f64)],
    mut bindings: Vec<u32>,
) -> Result<Vec<u32>> {
    bindings.sort_unstable();
    let numbered = (0..).zip(bindings).map(|(number, binding)| {
        let info = BindingInfo { descriptor_set: 0, binding: number, binding_array_size: None };
        (ResourceBinding { group: 0, binding }, info)
    });
    let words = written(module, entry_point, overrides, numbered.collect(), BoundsCheckPolicy::Unchecked)?;
    Ok(with_no_contraction(&words))
}

/// A kernel as naga writes it with wgpu's own settings: with checks of indices, those of buffers as given, and without names for debuggers.
fn written(
    module: &Module,
    entry_point: &str,
    overrides: &[(&str, f64)],
    binding_map: BindingMap,
    buffer: BoundsCheckPolicy,
) -> Result<Vec<u32>> {
    let (module, info) = resolved(module, entry_point, overrides)?;
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer,
            ..BoundsCheckPolicies::default()
        },
        binding_map,
        ..spv::Options::default()
    };
    let (shader_stage, entry_point) = (naga::ShaderStage::Compute, entry_point.to_string());
    let what = format!("{entry_point} as SPIR-V");
    let pipeline = spv::PipelineOptions { shader_stage, entry_point };
    spv::write_vec(&module, &info, &options, Some(&pipeline)).map_err(|error| fault(&what, &error))
}

/// The words of a module before its first instruction.
const HEADER: usize = 5;

// Numbers of the SPIR-V specification, sections 3.20 and 3.49.
const DECORATE: u32 = 71;
const NO_CONTRACTION: u32 = 42;
/// Types, which stand behind all decorations.
const TYPES: std::ops::RangeInclusive<u32> = 19..=39;
/// Arithmetic of floats: negation, the four rules, remainders, products of vectors and matrices.
const ARITHMETIC: [u32; 14] = [127, 129, 131, 133, 136, 140, 141, 142, 143, 144, 145, 146, 147, 148];

/// A module's instructions: where each begins, its opcode, and its number of words. The upper half of its first word is that
/// number (section 2.3).
fn instructions_of(words: &[u32]) -> impl Iterator<Item = (usize, u32, usize)> {
    let mut at = HEADER;
    std::iter::from_fn(move || {
        let first = *words.get(at)?;
        let (begin, length) = (at, (first >> 16).max(1) as usize);
        at += length;
        Some((begin, first & 0xffff, length))
    })
}

/// The module with the decoration NoContraction on all of its arithmetic.
pub fn with_no_contraction(words: &[u32]) -> Vec<u32> {
    let is_type = |(_, opcode, _): &(usize, u32, usize)| TYPES.contains(opcode);
    let first_type = instructions_of(words).find(is_type).map_or(words.len(), |(begin, ..)| begin);
    // The second word of arithmetic is its type, the third its result.
    let results = instructions_of(words).filter(|(_, opcode, _)| ARITHMETIC.contains(opcode));
    let decorations = results.filter_map(|(begin, ..)| {
        let result = *words.get(begin + 2)?;
        Some([3 << 16 | DECORATE, result, NO_CONTRACTION])
    });
    let (before, after) = words.split_at(first_type);
    before.iter().copied().chain(decorations.flatten()).chain(after.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_arithmetic_of_floats_is_decorated() {
        let text = "@group(0) @binding(7) var<storage, read_write> a: array<vec4<f32>>;
            @group(0) @binding(3) var<uniform> m: mat4x4<f32>;
            @compute @workgroup_size(1) fn main() {
                a[0] = -(m * a[1]) * 2.0 + a[2] / a[3] - dot(a[4], a[5]);
            }";
        let module = naga::front::wgsl::parse_str(text).expect("it parses");
        let policy = BoundsCheckPolicy::Unchecked;
        let plain = written(&module, "main", &[], BindingMap::default(), policy).expect("it is written");
        let exact = uncontracted(&module, "main", &[], vec![7, 3]).expect("it is written");
        let count = |words: &[u32], of: &dyn Fn(u32, &[u32]) -> bool| {
            let all = instructions_of(words);
            all.filter(|(begin, opcode, length)| of(*opcode, &words[*begin..begin + length])).count()
        };
        let arithmetic = count(&plain, &|opcode, _| ARITHMETIC.contains(&opcode));
        let decorated = |words: &[u32]| count(words, &|opcode, own| opcode == DECORATE && own[2] == NO_CONTRACTION);
        // A negation, the product of a matrix, that by a number, a sum, a quotient, a dot product and a difference.
        assert_eq!((arithmetic, decorated(&plain), decorated(&exact)), (7, 0, 7));
        assert_eq!(instructions_of(&exact).count(), instructions_of(&plain).count() + 7);
        // Bindings 3 and 7 are 0 and 1.
        let of_binding = |own: &[u32]| own.get(2) == Some(&33);
        let mut bindings: Vec<u32> = instructions_of(&exact)
            .map(|(begin, opcode, length)| (opcode, &exact[begin..begin + length]))
            .filter(|(opcode, own)| *opcode == DECORATE && of_binding(own))
            .map(|(_, own)| own[3])
            .collect();
        bindings.sort_unstable();
        assert_eq!(bindings, [0, 1]);
    }
}
