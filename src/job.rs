//! The job of a render: the image size, the range of samples, and when it ends.

use std::ops::Range;
use std::time::Instant;

use crate::data::RUN_LENGTH;

/// The job of a render.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The most scattering events of a path.
    pub max_depth: u32,
    pub seed: u32,
    /// The first sample of each pixel.
    pub first_sample: u32,
    pub goal: Goal,
}

/// The condition that ends a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// One past the index of the last sample of each pixel.
    Samples(u32),
    /// As many samples as fit before the deadline: at least one, and at most those below `end`.
    Until { deadline: Instant, end: u32 },
    /// Until the relative error is below `error`, the deadline is reached, or `end` is reached. A render that goes on with another says with
    /// which sample that one began, and how often the error has been looked at.
    Noise { error: f64, deadline: Option<Instant>, end: u32, begun: u32, looks: u32 },
}

impl Goal {
    /// One past the index of the last sample that a pixel may get.
    pub fn end(&self) -> u32 {
        match *self {
            Goal::Samples(end) | Goal::Until { end, .. } | Goal::Noise { end, .. } => end,
        }
    }
}

impl Job {
    /// The number of runs, if it is known in advance.
    pub fn runs(&self) -> Option<u64> {
        match self.goal {
            Goal::Samples(end) => {
                let pixels = u64::from(self.size.0) * u64::from(self.size.1);
                Some(pixels * blocks(self.first_sample..end).len() as u64)
            }
            Goal::Until { .. } | Goal::Noise { .. } => None,
        }
    }
}

/// The blocks of RUN_LENGTH samples that a range of samples overlaps.
pub fn blocks(samples: Range<u32>) -> Range<u32> {
    samples.start / RUN_LENGTH..samples.end.div_ceil(RUN_LENGTH)
}
