//! Compute pipelines from linked shaders, with bind groups by the variables' names.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::buffers::{Buffers, execute};
use super::device::Device;
use super::kernel_cache::{Compiled, CompiledFrom};
use super::layout::{Binding, BindingKind, has_override};
use super::spirv::uncontracted;
use crate::error::Result;
use crate::threads::{cores, each};

/// A kernel on the device, bound to its buffers.
pub struct Pipeline {
    pub name: String,
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
}

/// What a pipeline is made from.
pub struct PipelineSpec<'a> {
    pub name: &'a str,
    pub entry_point: &'a str,
    pub module: &'a naga::Module,
    /// The text that the module was parsed from.
    pub text: &'a str,
    pub bindings: &'a BTreeMap<String, Binding>,
    pub workgroup: u32,
    /// Values of override constants; of those that the kernel lacks nothing comes.
    pub constants: &'a [(&'a str, f64)],
}

impl PipelineSpec<'_> {
    fn compiled_from(&self, device: &Device) -> CompiledFrom {
        let contraction = ("no contraction".to_string(), u64::from(device.forbids_contraction()));
        let constants = self.constants.iter().map(|(name, value)| (name.to_string(), value.to_bits()));
        let constants = constants.chain([contraction]).collect();
        (self.text.to_string(), self.entry_point.to_string(), self.workgroup, constants)
    }
}

impl Pipeline {
    /// Compiles and binds kernels, as many at a time as there are cores, the first ones first. They come in the order of `specs`.
    ///
    /// # Errors
    /// That of the first kernel that has one.
    pub fn all(device: &Device, specs: &[PipelineSpec<'_>], buffers: &Buffers) -> Result<Vec<Pipeline>> {
        device.compiling.begin(specs.len());
        let create = |spec| {
            let pipeline = Pipeline::new(device, spec, buffers);
            device.compiling.advance();
            pipeline
        };
        each(cores().min(specs.len()), specs, create).into_iter().collect()
    }

    /// Compiles and binds a kernel. One that the device has compiled before is not compiled again.
    pub fn new(device: &Device, spec: &PipelineSpec<'_>, buffers: &Buffers) -> Result<Pipeline> {
        let Compiled { pipeline, layout } =
            device.kernels.compiled_once(spec.compiled_from(device), || compile(device, spec))?;
        let bound = spec
            .bindings
            .iter()
            .map(|(name, binding)| {
                let resource = buffers.get(name)?.as_entire_binding();
                Ok(wgpu::BindGroupEntry { binding: binding.number, resource })
            })
            .collect::<Result<Vec<_>>>()?;
        let bind_group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(spec.name),
            layout: &layout,
            entries: &bound,
        });
        device.check()?;
        Ok(Pipeline { name: spec.name.to_string(), pipeline, bind_group })
    }

    /// Dispatches the kernel with no workgroups, because some drivers compile at the first dispatch.
    pub fn warm_up(&self, device: &Device) -> Result<()> {
        let mut encoder = device.encoder("warm-up");
        self.dispatch(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()), 0);
        execute(device, encoder)
    }

    /// Records a dispatch of so many workgroups.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, groups: u32) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(groups, 1, 1);
    }

    /// Records a dispatch whose size stands at `offset` bytes of a buffer.
    pub fn dispatch_indirect(&self, pass: &mut wgpu::ComputePass<'_>, sizes: &wgpu::Buffer, offset: u64) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups_indirect(sizes, offset);
    }
}

/// Compiles a kernel.
fn compile(device: &Device, spec: &PipelineSpec<'_>) -> Result<Compiled> {
    let wgpu_device = &device.device;
    let storage = spec.bindings.values().filter(|binding| binding.kind != BindingKind::Uniform).count();
    let limit = device.limits.max_storage_buffers_per_shader_stage;
    if storage as u64 > u64::from(limit) {
        // A stage as a kernel of its own binds no more than it must.
        let is_alone = spec.entry_point != "bounce" && !spec.bindings.contains_key("queues");
        return Err(device.failed(&format!(
            "the kernel {} binds {storage} storage buffers, and the device allows {limit} a stage{}",
            spec.name,
            if is_alone { "" } else { "; try --scatter linked" }
        )));
    }
    device.kernels.note_compiled(spec.name);
    let workgroup = ("WORKGROUP_SIZE", f64::from(spec.workgroup));
    let given = spec.constants.iter().copied().filter(|(name, _)| has_override(spec.module, name));
    let mut constants: Vec<_> = std::iter::once(workgroup).chain(given).collect();
    let module = if device.forbids_contraction() {
        let bindings = spec.bindings.values().map(|binding| binding.number).collect();
        let words = uncontracted(spec.module, spec.entry_point, &constants, bindings)?;
        constants.clear();
        let workgroup_size = (spec.workgroup, 1, 1);
        let entry_points = [wgpu::PassthroughShaderEntryPoint { name: spec.entry_point.into(), workgroup_size }];
        let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
            label: Some(spec.name),
            entry_points: Cow::Borrowed(&entry_points),
            spirv: Some(Cow::Owned(words)),
            ..wgpu::ShaderModuleDescriptorPassthrough::default()
        };
        // SAFETY: naga wrote the words of a module that it has validated, with checks of indices and bounds of loops; the driver checks buffers.
        unsafe { wgpu_device.create_shader_module_passthrough(descriptor) }
    } else {
        wgpu_device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(spec.name),
            source: wgpu::ShaderSource::Naga(Cow::Owned(spec.module.clone())),
        })
    };
    let entries: Vec<_> = spec.bindings.values().map(layout_entry).collect();
    let layout = wgpu_device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(spec.name), entries: &entries });
    let pipeline_layout = wgpu_device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(spec.name),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = wgpu_device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(spec.name),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some(spec.entry_point),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    });
    device.check()?;
    Ok(Compiled { pipeline, layout })
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding.kind {
        BindingKind::Uniform => wgpu::BufferBindingType::Uniform,
        BindingKind::Read => wgpu::BufferBindingType::Storage { read_only: true },
        BindingKind::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding: binding.number,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}
