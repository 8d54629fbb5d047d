//! Sizes for a device and a job. They do not change the image.

use super::most_path_bytes;
use crate::film::{device_bytes, record_bytes};
use crate::gpu::device::DeviceClass;
use crate::job::Job;
use crate::options::{RenderOptions, Scatter};
use crate::threads::cores;

/// The most memory of a device that the film takes. A larger film is rendered in tiles.
const MOST_FILM_BYTES: u64 = 512 << 20;

/// Sizes that change only the speed, not the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Paths in flight.
    pub slots: u32,
    pub workgroup: u32,
    pub scatter: Scatter,
    /// Whether the stages are linked only because a fused kernel would take longer to compile than it saves.
    pub is_short: bool,
    /// Bounces of a submission; if absent, measured and adapted.
    pub bounces: Option<u32>,
    /// Finished runs of a slot that there is room for before they are added to the film.
    pub records_per_slot: u32,
    /// Pixels of the film that the device holds at a time.
    pub tile: u32,
}

impl Tuning {
    /// How the stages of a bounce become kernels where the time to compile does not matter. A processor pays more for storing a path's state
    /// than for its divergence (docs/dev/performance.md).
    pub fn scatter_of_long_renders(device: DeviceClass) -> Scatter {
        if device.software { Scatter::Fused } else { Scatter::Linked }
    }

    /// The sizes that options give; the others are chosen for the device.
    pub fn new(device: DeviceClass, job: &Job, options: &RenderOptions) -> Tuning {
        let runs = job.runs().unwrap_or(u64::MAX);
        // A processor wants work for each core and the slots' state in its caches; a GPU wants paths enough to hide its
        // latencies. A slot should serve several runs, or most of the render has idle slots.
        let (fewest, most) = match device.software {
            true => (2048, 4096 * cores().clamp(2, 16) as u64),
            false if device.integrated => (16_384, 1 << 18),
            false => (65_536, 1 << 20),
        };
        // Their state is one buffer.
        let most = most
            .min(device.max_binding_bytes / most_path_bytes(&options.aov, options.light_paths.count() > 0))
            .max(fewest);
        let slots = options.slots.unwrap_or(((runs / 8).clamp(fewest, most) >> device.halvings) as u32).max(1);
        let room_for_records = device.max_binding_bytes / (u64::from(slots) * record_bytes(&options.aov));
        let pixels = job.pixels();
        let room =
            device.max_binding_bytes.min(MOST_FILM_BYTES) / device_bytes(&options.aov, options.light_paths.count() > 0);
        Tuning {
            slots,
            workgroup: options.workgroup.unwrap_or(64),
            scatter: options.scatter.unwrap_or(Tuning::scatter_of_long_renders(device)),
            is_short: false,
            bounces: options.bounces,
            records_per_slot: room_for_records.clamp(2, 16) as u32,
            tile: pixels.min(room).max(1) as u32,
        }
    }
}
