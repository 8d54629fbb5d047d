//! The kernels that a device has compiled.

use std::sync::{Mutex, PoisonError};

use crate::error::Result;

/// How many compiled kernels a device keeps. A render has 15 at most, and one takes some 4 MiB on a software driver.
pub const KEPT_KERNELS: usize = 32;

/// A kernel that a device has compiled, without buffers.
#[derive(Clone)]
pub struct Compiled {
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// All that a compiled kernel is a function of: the text, the entry point, the workgroup's size, and the constants with the bits of their values.
pub type CompiledFrom = (String, String, u32, Vec<(String, u64)>);

/// The names of all kernels that a device has compiled, and the last of them.
#[derive(Default)]
pub struct KernelCache {
    /// In the order of their compilation.
    names: Mutex<Vec<String>>,
    /// The [`KEPT_KERNELS`] kernels that were used last, for renders that come later. The latest is at the end.
    kept: Mutex<Vec<(CompiledFrom, Compiled)>>,
}

impl KernelCache {
    /// The names of all kernels that were compiled, one entry for each compilation. The order is not defined,
    /// because kernels are compiled in parallel.
    pub fn compiled_names(&self) -> Vec<String> {
        self.names.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Records that a kernel was compiled.
    pub(super) fn note_compiled(&self, name: &str) {
        self.names.lock().unwrap_or_else(PoisonError::into_inner).push(name.to_string());
    }

    /// A kernel as `compile` makes it, or as it was made before if it is still kept.
    pub(super) fn compiled_once(
        &self,
        from: CompiledFrom,
        compile: impl FnOnce() -> Result<Compiled>,
    ) -> Result<Compiled> {
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let mut kept = lock();
        if let Some(at) = kept.iter().position(|(known, _)| *known == from) {
            let (from, compiled) = kept.remove(at);
            kept.push((from, compiled.clone()));
            return Ok(compiled);
        }
        // The lock is not held while a kernel is compiled: several are at a time.
        drop(kept);
        let compiled = compile()?;
        let mut kept = lock();
        kept.push((from, compiled.clone()));
        let too_many = kept.len().saturating_sub(KEPT_KERNELS);
        kept.drain(..too_many);
        Ok(compiled)
    }
}
