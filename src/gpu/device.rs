//! Adapters and devices.

use std::fmt;
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use super::compile_progress::CompileProgress;
use super::kernel_cache::KernelCache;
use super::numerics::Numerics;
use super::unseen::unseen_gpu;
use crate::error::{Error, Result};
use crate::guard;

/// The adapters of this machine, in the order of `--device INDEX`.
pub struct Adapters {
    list: Vec<wgpu::Adapter>,
}

/// The name of an adapter, and what it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterName {
    pub name: String,
    /// Driver and version.
    pub driver: String,
    pub backend: String,
    /// The address on the PCI bus, which distinguishes equal adapters; empty if the backend knows none.
    pub pci_bus_id: String,
    pub kind: &'static str,
    /// Whether it is a software driver, which computes on the processor.
    pub software: bool,
}

impl fmt::Display for AdapterName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}, {}", self.name, self.kind, self.backend, self.driver)?;
        match self.pci_bus_id.as_str() {
            "" => write!(f, ")"),
            id => write!(f, ", PCI {id})"),
        }
    }
}

impl AdapterName {
    /// The name of an adapter.
    pub fn from_adapter(adapter: &wgpu::Adapter) -> AdapterName {
        let info = adapter.get_info();
        let (_, kind) = KINDS[rank(info.device_type)];
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_string();
        let backend = info.backend.to_string();
        AdapterName { name: info.name, driver, backend, pci_bus_id: info.device_pci_bus_id, kind, software }
    }
}

/// The kinds of adapters, the most capable ones first.
const KINDS: [(wgpu::DeviceType, &str); 5] = [
    (wgpu::DeviceType::DiscreteGpu, "discrete GPU"),
    (wgpu::DeviceType::IntegratedGpu, "integrated GPU"),
    (wgpu::DeviceType::VirtualGpu, "virtual GPU"),
    (wgpu::DeviceType::Other, "other"),
    (wgpu::DeviceType::Cpu, "software"),
];

fn rank(kind: wgpu::DeviceType) -> usize {
    KINDS.iter().position(|(known, _)| *known == kind).unwrap_or_default()
}

impl Adapters {
    /// Finds the adapters of all backends.
    pub fn find() -> Adapters {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            // Only this program's kernels write indirect sizes, and a check of them costs a dispatch each.
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let list = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        Adapters { list }
    }

    /// The missing driver, in words, if the system has a GPU and no adapter is one.
    pub fn unseen_gpu(&self) -> Option<String> {
        let are_software = self.list.iter().all(|adapter| AdapterName::from_adapter(adapter).software);
        if are_software { unseen_gpu() } else { None }
    }

    /// The names of all adapters, with their limits.
    pub fn names(&self) -> Vec<(AdapterName, wgpu::Limits)> {
        self.list.iter().map(|adapter| (AdapterName::from_adapter(adapter), adapter.limits())).collect()
    }

    /// The adapter that [`Adapters::index_of_choice`] selects.
    pub fn choose(&self, spec: Option<&str>) -> Result<&wgpu::Adapter> {
        let index = self.index_of_choice(spec)?;
        self.list.get(index).ok_or_else(|| Error::Device("no device".to_string()))
    }

    /// The adapter of this name.
    ///
    /// # Errors
    /// `Error::Device` if it is gone.
    pub fn like(&self, name: &AdapterName) -> Result<&wgpu::Adapter> {
        let found = self.list.iter().find(|adapter| AdapterName::from_adapter(adapter) == *name);
        found.ok_or_else(|| Error::Device(format!("{name} is gone")))
    }

    /// The adapters that render one film: those of a list `A,B,…` of device specs, all of a machine, or the one that
    /// [`Adapters::index_of_choice`] selects.
    pub fn choose_several(&self, spec: Option<&str>) -> Result<Vec<&wgpu::Adapter>> {
        let first = self.index_of_choice(None)?;
        let names: Vec<_> = self.list.iter().map(AdapterName::from_adapter).collect();
        let indices = spec.map_or(Ok(Vec::from([first])), |spec| indices_by_spec(&names, first, spec))?;
        Ok(indices.into_iter().filter_map(|index| self.list.get(index)).collect())
    }

    /// The index of an adapter. A spec is an index, or a part of the adapter's name, driver or address. Without a spec it is the
    /// adapter of the most capable kind.
    pub fn index_of_choice(&self, spec: Option<&str>) -> Result<usize> {
        if self.list.is_empty() {
            let gpu = self.unseen_gpu().map_or_else(String::new, |missing| format!("{missing}. "));
            return Err(Error::Device(format!(
                "no device: no Vulkan, Metal or DirectX 12 driver was found. {gpu}On Debian or Ubuntu `apt-get install \
                 mesa-vulkan-drivers` installs a software driver that needs no GPU"
            )));
        }
        let names: Vec<_> = self.list.iter().map(AdapterName::from_adapter).collect();
        match spec {
            Some(spec) => index_by_spec(&names, spec),
            None => {
                let rank = |index: &usize| rank(self.list[*index].get_info().device_type);
                Ok((0..names.len()).min_by_key(rank).unwrap_or_default())
            }
        }
    }
}

fn refused_spec<T>(names: &[AdapterName], spec: &str, why: &str) -> Result<T> {
    let listed: String = names.iter().enumerate().map(|(i, name)| format!("\n  {i}: {name}")).collect();
    Err(Error::Usage(format!("--device {spec}: {why}:{listed}")))
}

/// The indices of the adapters that a spec names: one of them, a list of such names, or `all` that are no software drivers. Another
/// backend may list the same adapters again, so that `all` has those of the backend of the most capable one.
fn indices_by_spec(names: &[AdapterName], most_capable: usize, spec: &str) -> Result<Vec<usize>> {
    if spec == "all" {
        let backend = names.get(most_capable).map(|name| &name.backend);
        let is_meant = |name: &AdapterName| !name.software && Some(&name.backend) == backend;
        let all: Vec<usize> = (0..).zip(names).filter(|(_, name)| is_meant(name)).map(|(index, _)| index).collect();
        return match all.is_empty() {
            true => refused_spec(names, spec, "there is no GPU, and software drivers are used by name or index only"),
            false => Ok(all),
        };
    }
    match index_by_spec(names, spec) {
        Err(_) if spec.contains(',') => spec.split(',').map(|part| index_by_spec(names, part.trim())).collect(),
        index => index.map(|index| Vec::from([index])),
    }
}

/// The index of the adapter that a spec names.
fn index_by_spec(names: &[AdapterName], spec: &str) -> Result<usize> {
    let refused = |expected: &str| refused_spec(names, spec, expected);
    if let Ok(index) = spec.parse::<usize>() {
        return if index < names.len() { Ok(index) } else { refused("expected an index of") };
    }
    let fits = |name: &AdapterName| !spec.is_empty() && name.to_string().to_lowercase().contains(&spec.to_lowercase());
    let mut fitting = (0..).zip(names).filter(|(_, name)| fits(name));
    let Some((index, first)) = fitting.next() else { return refused("expected part of the name of one of") };
    // A backend lists each adapter once. Of another backend, the same name may be the same adapter.
    match fitting.any(|(_, name)| (&name.name, &name.backend) == (&first.name, &first.backend)) {
        true => refused("several devices have this name; expected the index or the PCI address of one of"),
        false => Ok(index),
    }
}

/// The properties of a device that decide the sizes of buffers and dispatches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceClass {
    pub software: bool,
    /// Whether it is a GPU that shares the memory of the processor.
    pub integrated: bool,
    /// How often the work that it gets at a time is halved, because more was too much for it.
    pub halvings: u32,
    pub max_binding_bytes: u64,
    pub max_uniform_bytes: u64,
    /// Uniform bindings of a kernel at most.
    pub max_uniforms: u32,
}

impl Default for DeviceClass {
    /// The limits that WebGPU guarantees.
    fn default() -> Self {
        DeviceClass::new(wgpu::DeviceType::Other, &wgpu::Limits::default())
    }
}

impl DeviceClass {
    fn new(kind: wgpu::DeviceType, limits: &wgpu::Limits) -> DeviceClass {
        DeviceClass {
            software: kind == wgpu::DeviceType::Cpu,
            integrated: kind == wgpu::DeviceType::IntegratedGpu,
            halvings: 0,
            max_binding_bytes: limits.max_storage_buffer_binding_size,
            max_uniform_bytes: limits.max_uniform_buffer_binding_size,
            max_uniforms: limits.max_uniform_buffers_per_shader_stage,
        }
    }

    /// The class of an adapter that is not open.
    pub fn from_adapter(adapter: &wgpu::Adapter) -> DeviceClass {
        DeviceClass::new(adapter.get_info().device_type, &adapter.limits())
    }

    /// The largest size of a table that is bound as a uniform, in bytes; 0 if uniforms are no faster.
    pub fn table_bytes(&self) -> u64 {
        match self.software {
            true => self.max_uniform_bytes,
            false => 0,
        }
    }
}

/// An open device with its queue.
pub struct Device {
    pub name: AdapterName,
    pub device: wgpu::Device,
    /// Dropped only if the device has not failed.
    pub queue: ManuallyDrop<wgpu::Queue>,
    pub limits: wgpu::Limits,
    /// Whether timestamps can be written.
    pub timestamps: bool,
    /// The findings of [`super::probe::numerics`].
    pub numerics: OnceLock<Numerics>,
    /// The kernels that were compiled for it.
    pub kernels: KernelCache,
    /// Whether it takes SPIR-V as it is, and checks buffers itself.
    takes_spirv: bool,
    no_contraction: AtomicBool,
    class: DeviceClass,
    halvings: AtomicU32,
    pub(super) lacked_memory: AtomicBool,
    /// How far it is with those of the present render.
    pub compiling: CompileProgress,
    /// The first error that occurred outside a call that could return it.
    fault: Arc<OnceLock<String>>,
}

/// In the environment, it forbids contraction on all devices of Vulkan, as the probe does on those that contract.
const NO_CONTRACTION: &str = "GPU_RT_NO_CONTRACTION";

/// So often at most the work that a device gets at a time is halved.
const MOST_HALVINGS: u32 = 8;

/// How often a wait is begun anew, and for how long each time. Ten minutes are far more than any submission takes, also on a busy
/// machine without a GPU. Time in which the process is stopped or the machine sleeps costs one of the waits at most.
const WAITS: u32 = 10;
/// A wait whose time is over while another thread also waits for this device may panic in wgpu, so that none should be over on a busy machine.
const WAIT: Duration = Duration::from_secs(60);

/// What to do about a device that failed.
const ADVICE: &str = "If it happens again, end other programs that use the device, update its driver, or choose another one \
                      (`gpu-rt devices` lists them)";

impl Device {
    /// Opens an adapter with all of its limits.
    ///
    /// # Errors
    /// `Error::Device` if the driver refuses.
    pub fn open(adapter: &wgpu::Adapter) -> Result<Device> {
        let name = AdapterName::from_adapter(adapter);
        let limits = adapter.limits();
        let timestamps = adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PASSTHROUGH_SHADERS;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("gpu-rt"),
            required_features: adapter.features() & wanted,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        // wgpu panics where it cannot make its own buffers: it drops a layout of bindings that it has not unregistered.
        let opened = caught(|| pollster::block_on(adapter.request_device(&descriptor)));
        let opened = opened.and_then(|opened| opened.map_err(|error| error.to_string()));
        let (device, queue) =
            opened.map_err(|error| Error::Device(format!("{name} cannot be opened: {}. {ADVICE}", line(&error))))?;
        let queue = ManuallyDrop::new(queue);
        let takes_spirv = device.features().contains(wgpu::Features::PASSTHROUGH_SHADERS) && checks_buffers(&device);
        let fault = Arc::new(OnceLock::new());
        let uncaptured = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            // The first one stays.
            let _ = uncaptured.set(error.to_string());
        }));
        let lost = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                let _ = lost.set(format!("the device was lost: {message}"));
            }
        });
        let (numerics, kernels, compiling) = (OnceLock::new(), KernelCache::default(), CompileProgress::default());
        Ok(Device {
            name,
            device,
            queue,
            limits,
            timestamps,
            numerics,
            kernels,
            takes_spirv,
            no_contraction: AtomicBool::new(takes_spirv && std::env::var_os(NO_CONTRACTION).is_some()),
            class: DeviceClass::from_adapter(adapter),
            halvings: AtomicU32::new(0),
            lacked_memory: AtomicBool::new(false),
            compiling,
            fault,
        })
    }

    /// The class of this device.
    pub fn class(&self) -> DeviceClass {
        DeviceClass { halvings: self.halvings.load(Ordering::Relaxed), ..self.class }
    }

    /// Has kernels compiled from now on round each product before it is added to something, so that a kernel's bytes do not depend on what it
    /// is linked with. Returns false where that was so before, or the driver cannot be told.
    pub fn forbid_contraction(&self) -> bool {
        self.takes_spirv && !self.no_contraction.swap(true, Ordering::Relaxed)
    }

    pub fn forbids_contraction(&self) -> bool {
        self.no_contraction.load(Ordering::Relaxed)
    }

    /// Halves the work that it gets at a time so many times more. Returns whether there is still less to give.
    pub fn halve(&self, times: u32) -> bool {
        self.halvings.fetch_add(times, Ordering::Relaxed) + times <= MOST_HALVINGS
    }

    /// Whether it has lacked memory for buffers since the last call, which forgets it.
    pub fn take_lacked_memory(&self) -> bool {
        self.lacked_memory.swap(false, Ordering::Relaxed)
    }

    /// Writes the first bytes of a buffer, before the next submission.
    pub fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) -> Result<()> {
        self.write_at(buffer, 0, bytes)
    }

    pub(super) fn write_at(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) -> Result<()> {
        // wgpu panics where the driver has no memory for the commands that copy the bytes.
        caught(|| self.queue.write_buffer(buffer, offset, bytes)).or_else(|panic| self.fail(panic))
    }

    /// Begins to record commands. `label` names them in the driver's messages.
    pub fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    /// Submits commands, and what was written before them.
    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        self.queue.submit([encoder.finish()])
    }

    /// Fails the device unless it has done work that its driver reported as done.
    ///
    /// # Errors
    /// `Error::Device` if it has not.
    pub fn expect_done(&self, is_done: bool) -> Result<()> {
        match is_done {
            true => Ok(()),
            false => self.fail("the driver reported work as done that the device has not done".to_string()),
        }
    }

    /// Waits until a submission has been executed.
    ///
    /// # Errors
    /// `Error::Device` if the device has failed since it was opened, or executes nothing for ten minutes.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        for _ in 0..WAITS {
            let poll = wgpu::PollType::Wait { submission_index: Some(submission.clone()), timeout: Some(WAIT) };
            // `Device::poll` panics where the driver reports that the device is lost, or out of memory.
            let polled = caught(|| self.device.poll(poll));
            self.check()?;
            match polled {
                Ok(Ok(_)) => return Ok(()),
                Ok(Err(wgpu::PollError::Timeout)) => {}
                Ok(Err(error)) => return self.fail(error.to_string()),
                Err(panic) => return self.fail(panic),
            }
        }
        self.fail(format!("the device hangs: it has executed nothing for {} seconds", (WAITS * WAIT).as_secs()))
    }

    /// Records an error, and returns the first one.
    fn fail(&self, message: String) -> Result<()> {
        let _ = self.fault.set(message);
        self.check()
    }

    /// Returns the recorded error, if there is one.
    pub fn check(&self) -> Result<()> {
        match self.fault.get() {
            Some(message) => Err(self.failed(&format!("{}. {ADVICE}", line(message)))),
            None => Ok(()),
        }
    }

    /// An error of this device.
    pub fn failed(&self, message: &str) -> Error {
        Error::Device(format!("{}: {message}", self.name))
    }
}

/// Whether this is a device of Vulkan whose driver checks the indices of buffers, so that kernels need not.
#[cfg(any(windows, all(unix, not(target_vendor = "apple"))))]
fn checks_buffers(device: &wgpu::Device) -> bool {
    // SAFETY: nothing is done with the device but to read what it was opened with.
    let vulkan = unsafe { device.as_hal::<wgpu::hal::api::Vulkan>() };
    vulkan.is_some_and(|device| device.enabled_device_extensions().contains(&c"VK_EXT_robustness2"))
}

#[cfg(not(any(windows, all(unix, not(target_vendor = "apple")))))]
fn checks_buffers(_device: &wgpu::Device) -> bool {
    false
}

/// Whether the queue of any device was kept.
static FAILED: AtomicBool = AtomicBool::new(false);

/// Whether any device of this process has failed, so that its driver may still be at work.
pub fn any_failed() -> bool {
    FAILED.load(Ordering::Relaxed)
}

impl Drop for Device {
    /// wgpu waits until a queue that it drops is idle: for ever if the device hangs. It panics if the wait fails. The queue of a
    /// device that failed is therefore kept, and the end of the process frees it.
    fn drop(&mut self) {
        if self.check().is_err() {
            FAILED.store(true, Ordering::Relaxed);
            return;
        }
        // SAFETY: nothing uses the queue after this.
        let queue = unsafe { ManuallyDrop::take(&mut self.queue) };
        let _ = caught(|| drop(queue));
    }
}

/// What a call of wgpu returns, or the message of its panic. Only for calls that panic where the device fails: wgpu has unlocked what it had
/// locked, and a device that failed is used no more.
fn caught<T>(call: impl FnOnce() -> T) -> std::result::Result<T, String> {
    guard::caught(call).map_err(|message| format!("the driver failed: {message}"))
}

/// A message of wgpu in one line, without the full stop at its end.
fn line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, backend: &str, pci_bus_id: &str) -> AdapterName {
        let [name, backend, pci_bus_id] = [name, backend, pci_bus_id].map(str::to_string);
        AdapterName { name, driver: "driver 1".to_string(), backend, pci_bus_id, kind: "discrete GPU", software: false }
    }

    #[test]
    fn several_adapters_are_a_list_or_all_gpus() {
        let software = |name: &str| AdapterName { software: true, ..adapter(name, "vulkan", "") };
        let names = [
            software("Processor"),
            adapter("Small, by A", "vulkan", "0000:01:00.0"),
            adapter("Large", "vulkan", "0000:02:00.0"),
            adapter("Large", "dx12", "02:00.0"),
        ];
        let chosen = |spec| indices_by_spec(&names, 2, spec).map_err(|error| error.to_string());
        assert_eq!(chosen("all"), Ok(vec![1, 2]));
        assert_eq!(chosen("0, 2,0"), Ok(vec![0, 2, 0]));
        assert_eq!(chosen("small, by a"), Ok(vec![1]));
        assert_eq!(chosen("processor,0000:02:00.0"), Ok(vec![0, 2]));
        assert!(chosen("0,9").unwrap_err().contains("--device 9: expected an index of"));
        assert!(chosen("0,").is_err());
        let error = indices_by_spec(&names[..1], 0, "all").unwrap_err().to_string();
        assert!(error.contains("there is no GPU") && error.contains("0: Processor"), "{error}");
    }

    #[test]
    fn equal_adapters_are_distinguished_by_index_and_address() {
        let names = [
            adapter("Small", "vulkan", "0000:01:00.0"),
            adapter("Large", "vulkan", "0000:02:00.0"),
            adapter("Large", "vulkan", "0000:03:00.0"),
            adapter("Small", "dx12", "01:00.0"),
        ];
        let chosen = |spec| index_by_spec(&names, spec).map_err(|error| error.to_string());
        assert_eq!(chosen("2"), Ok(2));
        assert_eq!(chosen("0000:03:00.0"), Ok(2));
        // Of another backend it is the same adapter.
        assert_eq!(chosen("small"), Ok(0));
        // Different names: the first one, as ever.
        assert_eq!(chosen("discrete"), Ok(0));
        let error = chosen("large").unwrap_err();
        assert!(error.contains("several devices have this name") && error.contains("PCI 0000:02:00.0"), "{error}");
        assert!(chosen("4").unwrap_err().contains("expected an index of"));
        assert!(chosen("tiny").unwrap_err().contains("expected part of the name of one of"));
    }
}
