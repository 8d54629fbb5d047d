//! Kernels that another device compiles meanwhile. A software driver compiles a kernel at its first dispatch, in the one thread of a device's
//! queue. All devices of the driver share its cache on disk, so that this device loads the kernels afterwards.

use super::buffers::{BufferSpec, Buffers};
use super::device::{Adapters, Device};
use super::pipeline::{Pipeline, PipelineSpec};
use crate::error::Result;
use crate::threads::cores;

/// Whether the driver compiles at the first dispatch, has a cache, and a core is free.
pub fn is_worth_it(device: &Device) -> bool {
    device.name.software && cores() > 1 && std::env::var_os("MESA_SHADER_CACHE_DISABLE").is_none()
}

/// Compiles kernels by a device of the same driver, with buffers that hold nothing. The cache has them once that device is gone.
///
/// # Errors
/// `Error::Device` where that device does not open or fails. The caller then compiles the kernels itself.
pub fn compile_beside(device: &Device, specs: &[&PipelineSpec<'_>], buffers: &[BufferSpec<'_>]) -> Result<()> {
    let adapters = Adapters::find();
    let other = Device::open(adapters.like(&device.name)?)?;
    let empty: Vec<_> = buffers.iter().map(BufferSpec::emptied).collect();
    let buffers = Buffers::create(&other, &empty)?;
    specs.iter().try_for_each(|spec| Pipeline::new(&other, spec, &buffers)?.warm_up(&other))
}
