//! Adapters and devices.

use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::probe::Numerics;
use crate::error::{Error, Result};

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
    pub kind: &'static str,
    /// Whether it is a software driver, which computes on the processor.
    pub software: bool,
}

impl fmt::Display for AdapterName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}, {})", self.name, self.kind, self.backend, self.driver)
    }
}

impl AdapterName {
    /// The name of an adapter.
    pub fn of(adapter: &wgpu::Adapter) -> AdapterName {
        let info = adapter.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete GPU",
            wgpu::DeviceType::IntegratedGpu => "integrated GPU",
            wgpu::DeviceType::VirtualGpu => "virtual GPU",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        };
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_string();
        AdapterName { name: info.name, driver, backend: info.backend.to_string(), kind, software }
    }
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

    /// The names of all adapters, with their limits.
    pub fn names(&self) -> Vec<(AdapterName, wgpu::Limits)> {
        self.list.iter().map(|adapter| (AdapterName::of(adapter), adapter.limits())).collect()
    }

    /// The adapter that [`Adapters::index_of_choice`] selects.
    pub fn choose(&self, wish: Option<&str>) -> Result<&wgpu::Adapter> {
        let index = self.index_of_choice(wish)?;
        self.list.get(index).ok_or_else(|| Error::Device("no device".to_string()))
    }

    /// The index of an adapter. A wish is an index or a part of the adapter's name or driver. Without a wish it is the adapter of
    /// the most capable kind.
    pub fn index_of_choice(&self, wish: Option<&str>) -> Result<usize> {
        if self.list.is_empty() {
            return Err(Error::Device(
                "no device: no Vulkan, Metal or DirectX 12 driver was found. On Debian or Ubuntu `apt-get install \
                 mesa-vulkan-drivers` installs a software driver that needs no GPU"
                    .to_string(),
            ));
        }
        let names: Vec<_> = self.list.iter().map(AdapterName::of).collect();
        let refused = |expected: &str, wish: &str| {
            let listed: String = names.iter().enumerate().map(|(i, name)| format!("\n  {i}: {name}")).collect();
            Error::Usage(format!("--device {wish}: expected {expected} of:{listed}"))
        };
        match wish.map(|wish| (wish, wish.parse::<usize>())) {
            Some((_, Ok(index))) if index < names.len() => Ok(index),
            Some((wish, Ok(_))) => Err(refused("an index", wish)),
            Some((wish, Err(_))) => names
                .iter()
                .position(|name| name.to_string().to_lowercase().contains(&wish.to_lowercase()))
                .ok_or_else(|| refused("part of the name of one", wish)),
            None => {
                let rank = |index: &usize| match self.list[*index].get_info().device_type {
                    wgpu::DeviceType::DiscreteGpu => 0,
                    wgpu::DeviceType::IntegratedGpu => 1,
                    wgpu::DeviceType::VirtualGpu => 2,
                    wgpu::DeviceType::Other => 3,
                    wgpu::DeviceType::Cpu => 4,
                };
                Ok((0..names.len()).min_by_key(rank).unwrap_or_default())
            }
        }
    }
}

/// The properties of a device that decide the sizes of buffers and dispatches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceClass {
    pub software: bool,
    pub max_binding_bytes: u64,
    pub max_uniform_bytes: u64,
}

impl Default for DeviceClass {
    /// The limits that WebGPU guarantees.
    fn default() -> Self {
        DeviceClass::new(false, &wgpu::Limits::default())
    }
}

impl DeviceClass {
    fn new(software: bool, limits: &wgpu::Limits) -> DeviceClass {
        DeviceClass {
            software,
            max_binding_bytes: limits.max_storage_buffer_binding_size,
            max_uniform_bytes: limits.max_uniform_buffer_binding_size,
        }
    }

    /// The class of an adapter that is not open.
    pub fn of(adapter: &wgpu::Adapter) -> DeviceClass {
        DeviceClass::new(AdapterName::of(adapter).software, &adapter.limits())
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
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    /// Whether timestamps can be written.
    pub timestamps: bool,
    /// The findings of [`super::probe::numerics`].
    pub numerics: OnceLock<Numerics>,
    /// The kernels that were compiled for it so far.
    compiled: Mutex<Vec<String>>,
    /// The first error that occurred outside a call that could return it.
    fault: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens an adapter with all of its limits.
    ///
    /// # Errors
    /// `Error::Device` if the driver refuses.
    pub fn open(adapter: &wgpu::Adapter) -> Result<Device> {
        let name = AdapterName::of(adapter);
        let limits = adapter.limits();
        let timestamps = adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("gpu-rt"),
            required_features: match timestamps {
                true => wgpu::Features::TIMESTAMP_QUERY,
                false => wgpu::Features::empty(),
            },
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::Device(format!("{name} cannot be opened: {error}")))?;
        let fault = Arc::new(Mutex::new(None));
        let keep_first = |fault: &Arc<Mutex<Option<String>>>, message: String| {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
        };
        let uncaptured = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep_first(&uncaptured, error.to_string())));
        let lost = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                keep_first(&lost, format!("the device was lost: {message}"));
            }
        });
        let (numerics, compiled) = (OnceLock::new(), Mutex::default());
        Ok(Device { name, device, queue, limits, timestamps, numerics, compiled, fault })
    }

    /// The class of this device.
    pub fn class(&self) -> DeviceClass {
        DeviceClass::new(self.name.software, &self.limits)
    }

    /// The names of all kernels that were compiled for it, one entry for each compilation. The order is not defined,
    /// because kernels are compiled in parallel.
    pub fn compiled(&self) -> Vec<String> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Records that a kernel was compiled.
    pub(super) fn note_compiled(&self, name: &str) {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner).push(name.to_string());
    }

    /// Waits until a submission has been executed, and returns any error since the last call.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        self.check()?;
        polled.map(drop).map_err(|error| self.failed(&error.to_string()))
    }

    /// Returns the recorded error, if there is one.
    pub fn check(&self) -> Result<()> {
        match &*self.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(message) => Err(self.failed(message)),
            None => Ok(()),
        }
    }

    /// An error of this device.
    pub fn failed(&self, message: &str) -> Error {
        Error::Device(format!("{}: {message}", self.name))
    }
}
