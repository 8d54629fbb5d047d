//! Seconds on the device, by stage: a timestamp before and after each compute pass.

use std::collections::BTreeMap;

use super::buffers::Readback;
use super::device::Device;
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

    /// Adds the passes of these names, each with two ticks, the low byte first. Ticks that are all 0 are none.
    fn add_passes(&mut self, names: Vec<String>, ticks: &[u8], seconds_per_tick: f64) {
        let tick = |bytes: &[u8]| bytes.iter().rev().fold(0u64, |all, &byte| all << 8 | u64::from(byte));
        if ticks.iter().all(|&byte| byte == 0) {
            return;
        }
        for (name, pair) in names.into_iter().zip(ticks.chunks_exact(16)) {
            let (begin, end) = pair.split_at(8);
            let (begin, end) = (tick(begin), tick(end));
            *self.seconds.entry(name).or_default() += end.saturating_sub(begin) as f64 * seconds_per_tick;
            let (first, last) = self.span.unwrap_or((begin, begin));
            // Passes may overlap.
            self.busy += end.saturating_sub(begin.max(last));
            self.span = Some((first, last.max(end)));
        }
    }
}

/// Passes of a submission at most: two queries each, of the 4096 that a set may hold. On Metal, wgpu has two command buffers for each, of 4096 that
/// may be recorded at a time.
pub const MAX_PASSES: usize = 1024;

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
    pub fn resolve(&self, device: &Device, encoder: &mut wgpu::CommandEncoder) -> Result<()> {
        let queries = self.recorded.len() as u32 * 2;
        if queries > 0 {
            encoder.resolve_query_set(&self.queries, 0..queries, &self.resolved, 0);
            self.readback.copy(device, encoder, &self.resolved, 0, u64::from(queries) * 8)?;
        }
        Ok(())
    }

    /// Adds the times of a submission that has been executed.
    pub fn collect(
        &mut self,
        device: &Device,
        submission: wgpu::SubmissionIndex,
        times: &mut StageTimes,
    ) -> Result<()> {
        let recorded = std::mem::take(&mut self.recorded);
        if recorded.is_empty() {
            return Ok(());
        }
        let seconds_per_tick = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        self.readback.read(device, submission, recorded.len() as u64 * 16, |bytes| {
            times.add_passes(recorded, bytes, seconds_per_tick);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As on macOS 26.
    #[test]
    fn timestamps_that_are_all_0_are_none() {
        let passes = |ticks: [u64; 4]| {
            let mut times = StageTimes::default();
            let bytes: Vec<u8> = ticks.iter().flat_map(|tick| tick.to_le_bytes()).collect();
            times.add_passes(["bounce", "refill"].map(String::from).into(), &bytes, 0.5);
            times
        };
        assert_eq!(
            passes([7, 9, 10, 14]).seconds,
            BTreeMap::from([("bounce".to_string(), 1.0), ("refill".to_string(), 2.0)])
        );
        assert_eq!(passes([7, 9, 10, 14]).idle(), Some(1.0 - 6.0 / 7.0));
        let none = passes([0; 4]);
        assert!(none.seconds.is_empty() && none.idle().is_none());
    }
}
