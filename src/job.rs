//! What is to be rendered of a scene: how large, which samples, until when.

use std::ops::Range;
use std::time::Instant;

use crate::data::RUN_LENGTH;

/// What is to be rendered of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Scattering events of a path at most.
    pub max_depth: u32,
    pub seed: u32,
    /// The first sample of each pixel.
    pub first_sample: u32,
    pub goal: Goal,
}

/// When a render has all its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// One past the last sample of each pixel.
    Samples(u32),
    /// As many as fit until then, but one at least and `end` at most.
    Until { deadline: Instant, end: u32 },
    /// Until the relative error is below `error`, but `end` at most, and no more than fit until the deadline where there is one.
    Noise { error: f64, deadline: Option<Instant>, end: u32 },
}

impl Job {
    /// How many runs it takes, where that is known before.
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

/// The blocks of RUN_LENGTH samples that a range of samples touches.
pub fn blocks(samples: Range<u32>) -> Range<u32> {
    samples.start / RUN_LENGTH..samples.end.div_ceil(RUN_LENGTH)
}
