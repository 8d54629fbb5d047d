//! Seconds on the device, by stage: a timestamp before and after each compute pass.

use std::collections::BTreeMap;

use super::buffers::Readback;
use super::device::Device;
use super::receipt::{Commands, Submission};
use crate::error::Result;

/// Timestamps of the passes of one submission at a time.
pub struct Timing {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: Readback,
    /// Names of the passes recorded since the last reading.
    recorded: Vec<String>,
}

/// The times of the passes of a device, added up.
#[derive(Clone, Debug, Default)]
pub struct StageTimes {
    /// Seconds by the name of the pass.
    pub seconds: BTreeMap<String, f64>,
    /// Ticks in which some pass ran.
    busy: u64,
    /// From the begin of the first pass to the end of the last.
    span: Option<(u64, u64)>,
}

impl StageTimes {
    /// The share of the time in which no pass ran, from the first to the last; 0 to 1.
    pub fn idle(&self) -> Option<f64> {
        let (first, last) = self.span?;
        (last > first).then(|| 1.0 - self.busy as f64 / (last - first) as f64)
    }

    fn add(&mut self, name: String, (begin, end): (u64, u64), seconds_per_tick: f64) {
        *self.seconds.entry(name).or_default() += end.saturating_sub(begin) as f64 * seconds_per_tick;
        let (first, last) = self.span.unwrap_or((begin, begin));
        // Passes may overlap.
        self.busy += end.saturating_sub(begin.max(last));
        self.span = Some((first, last.max(end)));
    }
}

/// Passes of a submission at most: two queries each, of the 4096 that a set may hold.
pub const MAX_PASSES: usize = 2048;

impl Timing {
    /// None if the device has no timestamps.
    pub fn new(device: &Device) -> Option<Timing> {
        if !device.timestamps {
            return None;
        }
        let bytes = MAX_PASSES as u64 * 2 * 8;
        let queries = device.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stage times"),
            ty: wgpu::QueryType::Timestamp,
            count: MAX_PASSES as u32 * 2,
        });
        let resolved = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stage times"),
            size: bytes,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let readback = Readback::new(device, "stage times", bytes);
        Some(Timing { queries, resolved, readback, recorded: Vec::new() })
    }

    /// The timestamps of the next pass; nothing once a submission's queries are used up.
    pub fn next(&mut self, name: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        if self.recorded.len() == MAX_PASSES {
            return None;
        }
        let first = self.recorded.len() as u32 * 2;
        self.recorded.push(name.to_string());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Records the copy of the timestamps to the host; the last thing of a submission.
    pub fn resolve(&self, device: &Device, commands: &mut Commands) {
        let queries = self.recorded.len() as u32 * 2;
        if queries > 0 {
            commands.encoder.resolve_query_set(&self.queries, 0..queries, &self.resolved, 0);
            self.readback.copy(device, commands, &self.resolved, 0, u64::from(queries) * 8);
        }
    }

    /// Adds the times of a submission that has been executed.
    pub fn collect(&mut self, device: &Device, submission: Submission, times: &mut StageTimes) -> Result<()> {
        let recorded = std::mem::take(&mut self.recorded);
        if recorded.is_empty() {
            return Ok(());
        }
        let seconds_per_tick = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        self.readback.read(device, submission, recorded.len() as u64 * 16, |bytes| {
            for (name, pair) in recorded.into_iter().zip(bytes.chunks_exact(16)) {
                let (begin, end) = pair.split_at(8);
                let tick = |bytes: &[u8]| bytes.iter().rev().fold(0u64, |all, &byte| all << 8 | u64::from(byte));
                times.add(name, (tick(begin), tick(end)), seconds_per_tick);
            }
        })
    }
}
