//! The device that a command names: opened, or only its limits.

use super::console::tell;
use crate::error::{Error, Result};
use crate::flatten::DeviceScene;
use crate::gpu::device::{AdapterName, Adapters, Device, DeviceClass};
use crate::job::{Goal, Job};
use crate::options::RenderOptions;
use crate::output::destination::is_on_path;
use crate::plan::Plan;
use crate::scene::Scene;

/// The device that a scene is planned for: a real one, or WebGPU's default limits if there is none.
pub struct Target {
    pub name: String,
    pub class: DeviceClass,
    pub limits: wgpu::Limits,
}

impl Target {
    /// The device of this index or name, or the default device. If the machine has none, the limits that WebGPU guarantees.
    pub fn find(spec: Option<&str>) -> Result<Target> {
        match Adapters::find().choose(spec) {
            Ok(adapter) => Ok(Target {
                name: AdapterName::from_adapter(adapter).to_string(),
                class: DeviceClass::from_adapter(adapter),
                limits: adapter.limits(),
            }),
            Err(Error::Device(_)) => Ok(Target {
                name: "no device here: WebGPU's default limits".to_string(),
                class: DeviceClass::default(),
                limits: wgpu::Limits::default(),
            }),
            Err(error) => Err(error),
        }
    }
}

/// The plan of a scene for a device.
pub fn planned<'a>(
    scene: &Scene,
    size: (u32, u32),
    flat: &'a DeviceScene,
    target: &Target,
    options: &RenderOptions,
) -> Result<Plan<'a>> {
    let goal = Goal::Samples(scene.render.samples);
    let job = Job { size, max_depth: scene.render.max_depth, seed: 0, first_sample: 0, goal };
    Plan::new(flat, options, target.class, &job)
}

/// Opens the device of this index or name, or the default device.
pub fn open_device(spec: Option<&str>) -> Result<Device> {
    Device::open(Adapters::find().choose(spec)?)
}

/// Prints warnings about a driver that renders on the processor, and about an old compiler, unless `quiet`.
pub fn tell_driver(device: &Device, quiet: bool) {
    if quiet {
        return;
    }
    if device.name.software {
        let gpu = Adapters::find().unseen_gpu().map_or_else(String::new, |missing| format!(". {missing}"));
        tell(&format!(
            "warning: {} is a software driver: it renders on the processor, without a GPU{gpu}",
            device.name
        ));
    }
    if device.name.backend == wgpu::Backend::Dx12.to_string() && !is_at_hand("dxcompiler.dll") {
        tell(
            "warning: without dxcompiler.dll, DirectX 12 compiles kernels by an old compiler, which takes minutes or fails. Put \
             dxcompiler.dll of Microsoft's DirectXShaderCompiler beside the program, or choose a device of Vulkan",
        );
    }
}

/// Whether a file is in the program's folder or in one of PATH.
fn is_at_hand(file: &str) -> bool {
    std::env::current_exe().is_ok_and(|program| program.with_file_name(file).is_file()) || is_on_path(file)
}
