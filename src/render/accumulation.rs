//! What is left of a job for a film.

use std::ops::Range;

use super::noise::{Noise, check_error, samples_at_check};
use crate::film::Accumulation;
use crate::job::{Goal, Job};
use crate::samples::Samples;

impl Accumulation {
    /// The result of the last check of this film, if it ended a render until an error.
    pub fn noise_reached(&self, job: &Job) -> Option<Noise> {
        let Goal::Noise { error, .. } = job.goal else { return None };
        let last = self.checks.checked_sub(1)?;
        let samples = samples_at_check(last);
        if self.samples.count() != u64::from(samples) {
            return None;
        }
        Some(check_error(&self.film, samples, last, error).0).filter(|noise| noise.reached)
    }

    /// What is left of a job.
    pub fn jobs(&self, job: &Job, reached: Option<Noise>) -> Vec<Job> {
        let missing = match reached {
            Some(_) => Samples::default(),
            None => self.samples.missing(job.first_sample..job.goal.end()),
        };
        // Several devices that were stopped leave gaps. They are filled before a goal is aimed at.
        let is_gap = |range: &Range<u32>| range.start < self.samples.range().end;
        let part = |range: &Range<u32>| {
            let goal = match job.goal {
                Goal::Until { deadline, .. } | Goal::Noise { deadline: Some(deadline), .. } if is_gap(range) => {
                    Goal::Until { deadline, end: range.end }
                }
                Goal::Noise { error, deadline, end, begun, .. } if !is_gap(range) => {
                    Goal::Noise { error, deadline, end, begun, checks: self.checks }
                }
                until @ Goal::Until { .. } => until,
                Goal::Samples(_) | Goal::Noise { .. } => Goal::Samples(range.end),
            };
            Job { first_sample: range.start, goal, ..job.clone() }
        };
        missing.ranges().iter().map(part).collect()
    }
}
