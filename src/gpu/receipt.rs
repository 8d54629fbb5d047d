//! A receipt for every submission: its number, which is uploaded with it and comes back with it. A driver may give a submission up and report
//! it as finished, as that of Metal does when its watchdog ends one (<https://github.com/gfx-rs/wgpu/issues/9545>). Then the number that comes
//! back is an earlier one.

use std::sync::atomic::{AtomicU32, Ordering};

/// The bytes of a number.
pub const RECEIPT_BYTES: u64 = size_of::<u32>() as u64;

/// The receipts of a device.
pub struct Receipts {
    last: AtomicU32,
    /// The number of the present submission, on the device.
    pub number: wgpu::Buffer,
}

/// Commands that are recorded for one submission. A device has one at a time.
pub struct Commands {
    pub encoder: wgpu::CommandEncoder,
    pub receipt: u32,
}

/// Commands that have been submitted.
#[derive(Clone)]
pub struct Submission {
    pub index: wgpu::SubmissionIndex,
    pub receipt: u32,
}

impl Receipts {
    pub fn new(device: &wgpu::Device) -> Receipts {
        let number = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("receipt"),
            size: RECEIPT_BYTES,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Receipts { last: AtomicU32::new(0), number }
    }

    /// The number of the next submission. None is 0, which fresh memory may hold.
    pub fn next(&self) -> u32 {
        let last = self.last.fetch_add(1, Ordering::Relaxed);
        (last % u32::MAX) + 1
    }
}
