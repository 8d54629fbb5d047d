//! The buffers of a render, by the names of the variables that bind them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use super::device::Device;
use crate::bitmap::size_that_fits;
use crate::error::{Error, Result};

/// A buffer to be made.
#[derive(Clone, Debug)]
pub struct BufferSpec<'a> {
    pub name: &'static str,
    pub bytes: u64,
    /// The parts of its contents, one after the other, each a multiple of four bytes long. A buffer without parts holds zeros.
    pub contents: Vec<Cow<'a, [u8]>>,
    pub usage: wgpu::BufferUsages,
    /// What it is for.
    pub why: &'static str,
    /// The make-up of its bytes: "485 x 32 bytes".
    pub size: String,
    /// What makes it smaller, where the scene's author can.
    pub remedy: Option<String>,
    /// The size and the bytes of the largest image in it.
    pub largest: Option<((u32, u32), u64)>,
}

impl<'a> BufferSpec<'a> {
    fn new(name: &'static str, bytes: u64, usage: wgpu::BufferUsages, why: &'static str) -> BufferSpec<'a> {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let size = format!("{bytes} bytes");
        BufferSpec { name, bytes, contents: Vec::new(), usage, why, size, remedy: None, largest: None }
    }

    /// This buffer with the make-up of its bytes.
    #[must_use]
    pub fn made_of(self, size: String) -> BufferSpec<'a> {
        BufferSpec { size, ..self }
    }

    /// Small, read by all kernels, written by the host.
    pub fn uniform(name: &'static str, bytes: u64, why: &'static str) -> BufferSpec<'a> {
        BufferSpec::new(name, bytes, wgpu::BufferUsages::UNIFORM, why)
    }

    /// Written by kernels, read back by the host.
    pub fn working(name: &'static str, bytes: u64, why: &'static str) -> BufferSpec<'a> {
        BufferSpec::new(name, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC, why)
    }

    /// Sizes of dispatches, written by a kernel.
    pub fn indirect(name: &'static str, bytes: u64, why: &'static str) -> BufferSpec<'a> {
        BufferSpec::new(name, bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT, why)
    }

    /// Filled once, only read after.
    pub fn scene(name: &'static str, contents: Vec<Cow<'a, [u8]>>, why: &'static str) -> BufferSpec<'a> {
        let bytes = contents.iter().map(|part| part.len() as u64).sum();
        let spec = BufferSpec::new(name, bytes, wgpu::BufferUsages::STORAGE, why);
        BufferSpec { contents, ..spec }
    }

    /// Filled once, only read after, small enough for a uniform binding; with room for `bytes`.
    pub fn table(name: &'static str, contents: Cow<'a, [u8]>, bytes: u64, why: &'static str) -> BufferSpec<'a> {
        let spec = BufferSpec::new(name, bytes, wgpu::BufferUsages::UNIFORM, why);
        BufferSpec { contents: vec![contents], ..spec }
    }

    /// The bytes allocated: a binding may not be empty, and copies go by fours.
    pub fn allocated(&self) -> u64 {
        self.bytes.max(LEAST).next_multiple_of(4)
    }

    /// This buffer without contents, and as small as kernels can bind it.
    #[must_use]
    pub fn emptied(&self) -> BufferSpec<'static> {
        let bytes = if self.usage.contains(wgpu::BufferUsages::UNIFORM) { self.bytes } else { LEAST };
        BufferSpec::new(self.name, bytes, self.usage, self.why)
    }

    /// How it is bound: "uniform" or "storage".
    pub fn binding(&self) -> &'static str {
        match self.usage.contains(wgpu::BufferUsages::UNIFORM) {
            true => "uniform",
            false => "storage",
        }
    }

    /// The bytes that a device allows to its binding.
    pub fn limit(&self, limits: &wgpu::Limits) -> u64 {
        let binding = match self.usage.contains(wgpu::BufferUsages::UNIFORM) {
            true => limits.max_uniform_buffer_binding_size,
            false => limits.max_storage_buffer_binding_size,
        };
        binding.min(limits.max_buffer_size)
    }
}

/// The least bytes of a buffer. No struct is larger than this, so that an array without elements still satisfies its binding.
pub const LEAST: u64 = 256;

/// The buffers of a render.
pub struct Buffers {
    named: BTreeMap<&'static str, wgpu::Buffer>,
}

/// A sentence for every buffer that is larger than the device allows. Allocates nothing.
pub fn too_large(specs: &[BufferSpec<'_>], limits: &wgpu::Limits) -> Vec<String> {
    let too_large = |spec: &BufferSpec<'_>| {
        let (limit, what) = (spec.limit(limits), spec.binding());
        (spec.allocated() > limit).then(|| {
            let (name, why, bytes) = (spec.name, spec.why, spec.allocated());
            let remedy = spec.remedy.as_ref().map_or(String::new(), |remedy| format!(": {remedy}"));
            let fits =
                spec.largest.and_then(|(size, own)| size_that_fits(size, own, limit.saturating_sub(bytes - own)));
            let fits = fits.map_or(String::new(), |fits| format!("; of the first, {fits}"));
            format!(
                "the buffer `{name}` ({why}) needs {bytes} bytes, and the device allows {limit} to a {what} binding{remedy}{fits}"
            )
        })
    };
    specs.iter().filter_map(too_large).collect()
}

impl Buffers {
    /// Allocates and fills the buffers.
    ///
    /// # Errors
    /// `Error::Device` where a buffer is larger than the device allows, or all of them than its memory.
    pub fn create(device: &Device, specs: &[BufferSpec<'_>]) -> Result<Buffers> {
        let refused = too_large(specs, &device.limits);
        if !refused.is_empty() {
            return Err(Error::Device(format!(
                "{}: {}. Make the scene smaller, or choose another device (`gpu-rt devices` lists them)",
                device.name,
                refused.join("; ")
            )));
        }
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let mut named = BTreeMap::new();
        for spec in specs {
            let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(spec.name),
                size: spec.allocated(),
                usage: spec.usage,
                mapped_at_creation: false,
            });
            fill(device, &buffer, &spec.contents)?;
            named.insert(spec.name, buffer);
        }
        match pollster::block_on(scope.pop()) {
            Some(error) => {
                device.lacked_memory.store(true, Ordering::Relaxed);
                let bytes: u64 = specs.iter().map(BufferSpec::allocated).sum();
                Err(device.failed(&format!(
                    "the render needs {bytes} bytes of device memory, and the device has less: {error}. Make the scene smaller, end \
                     other programs that use the device, or choose another one (`gpu-rt devices` lists them)"
                )))
            }
            None => device.check().map(|()| Buffers { named }),
        }
    }

    /// Fills the buffers of these specs with their contents.
    ///
    /// # Errors
    /// `Error::Device` if the device has failed.
    pub fn fill<'a>(&self, device: &Device, mut specs: impl Iterator<Item = &'a BufferSpec<'a>>) -> Result<()> {
        specs.try_for_each(|spec| fill(device, self.get(spec.name)?, &spec.contents))
    }

    /// The buffer behind a variable.
    ///
    /// # Errors
    /// `Error::Shader` where no buffer has the name: a kernel binds what the plan did not list.
    pub fn get(&self, name: &str) -> Result<&wgpu::Buffer> {
        self.named
            .get(name)
            .ok_or_else(|| Error::Shader(format!("a kernel binds `{name}`, which the plan does not list")))
    }
}

/// Bytes of a buffer's contents that are on their way at a time.
const FILL_AT_ONCE: usize = 64 << 20;

/// Fills a buffer with the bytes of these parts, one after the other. The driver copies what is on its way, so that much is sent in
/// pieces, each of which is waited for.
fn fill(device: &Device, buffer: &wgpu::Buffer, contents: &[Cow<'_, [u8]>]) -> Result<()> {
    let mut offset = 0;
    for part in contents.iter().flat_map(|part| part.chunks(FILL_AT_ONCE)) {
        device.write_at(buffer, offset, part)?;
        if part.len() == FILL_AT_ONCE {
            execute(device, device.encoder("upload"))?;
        }
        offset += part.len() as u64;
    }
    Ok(())
}

/// Submits commands from which nothing but the receipt is read, with what was written before them, and waits until they are executed.
///
/// # Errors
/// As of [`Readback::read`].
pub fn execute(device: &Device, mut encoder: wgpu::CommandEncoder) -> Result<()> {
    let readback = Readback::new(device, "receipt", 0);
    readback.confirm(device, &mut encoder)?;
    readback.read(device, device.submit(encoder), 0, |_| ())
}

/// When a wait on another thread has called back at the latest.
const CALL_BACK: Duration = Duration::from_secs(60);

/// The bytes of a receipt.
const RECEIPT_BYTES: u64 = size_of::<u32>() as u64;

/// A staging buffer, through which the host reads what the device wrote in one submission at a time. Each submission has a receipt: a number that is
/// uploaded with it, and copied back after all else. A driver may give a submission up and report it as finished, as that of Metal
/// does when its watchdog ends one (<https://github.com/gfx-rs/wgpu/issues/9545>). Then the number that comes back is an earlier one.
pub struct Readback {
    /// The receipt stands behind what is read.
    staging: wgpu::Buffer,
    /// The number of the present submission on the device, and here.
    number: wgpu::Buffer,
    last: AtomicU32,
}

impl Readback {
    /// With room for so many bytes.
    pub fn new(device: &Device, label: &str, bytes: u64) -> Readback {
        let buffer = |size: u64, usage| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let bytes = bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        Readback {
            staging: buffer(bytes + RECEIPT_BYTES, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            number: buffer(RECEIPT_BYTES, wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST),
            last: AtomicU32::new(0),
        }
    }

    /// The bytes that it has room for.
    pub fn room(&self) -> u64 {
        self.staging.size() - RECEIPT_BYTES
    }

    /// The receipt of the submission that is recorded next. None is 0, which fresh memory may hold.
    pub fn next_receipt(&self) -> u32 {
        self.last.load(Ordering::Relaxed) % u32::MAX + 1
    }

    /// Records the copy of the bytes of a buffer from `offset` on, and of the receipt: the last commands of a submission.
    ///
    /// # Errors
    /// `Error::Device` if the device has failed.
    pub fn copy(
        &self,
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        from: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<()> {
        encoder.copy_buffer_to_buffer(from, offset, &self.staging, 0, bytes);
        self.confirm(device, encoder)
    }

    /// Records the copy of the receipt alone.
    fn confirm(&self, device: &Device, encoder: &mut wgpu::CommandEncoder) -> Result<()> {
        let receipt = self.next_receipt();
        self.last.store(receipt, Ordering::Relaxed);
        device.write(&self.number, &receipt.to_le_bytes())?;
        encoder.copy_buffer_to_buffer(&self.number, 0, &self.staging, self.room(), RECEIPT_BYTES);
        Ok(())
    }

    /// Waits for the submission that holds the copy, and hands its bytes to `use_bytes`.
    ///
    /// # Errors
    /// `Error::Device` if the device has failed, or the receipt is not that of the submission.
    pub fn read<T>(
        &self,
        device: &Device,
        submission: wgpu::SubmissionIndex,
        bytes: u64,
        use_bytes: impl FnOnce(&[u8]) -> T,
    ) -> Result<T> {
        let slice = self.staging.slice(..);
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if the wait below failed, and then the result is not needed.
            let _ = sender.send(result);
        });
        device.wait(submission)?;
        // The wait has called back. If another thread's wait is about to, it is a moment later.
        match receiver.recv_timeout(CALL_BACK) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(device.failed(&error.to_string())),
            Err(error) => return Err(device.failed(&error.to_string())),
        }
        let read = |view: wgpu::BufferView| {
            let (written, receipt) = view.split_at(self.room() as usize);
            device.expect_done(bytemuck::pod_read_unaligned::<u32>(receipt) == self.last.load(Ordering::Relaxed))?;
            Ok(use_bytes(written.get(..bytes as usize).unwrap_or(written)))
        };
        let view = slice.get_mapped_range().map_err(|error| device.failed(&error.to_string()));
        let result = view.and_then(read);
        self.staging.unmap();
        result
    }
}
