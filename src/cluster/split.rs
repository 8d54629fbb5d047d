//! How samples are split into parts.

use std::ops::Range;

use crate::data::RUN_LENGTH;
use crate::render::{FIRST_CHECK, samples_at_check};

/// The runs that a range of samples has. The last one may be shorter than the others.
pub fn runs(samples: &Range<u32>) -> u32 {
    samples.end.saturating_sub(samples.start).div_ceil(RUN_LENGTH)
}

/// Splits a range into at most `parts` parts, at multiples of a run from its start. Their numbers of runs differ by at most one.
pub fn even(samples: &Range<u32>, parts: u32) -> Vec<Range<u32>> {
    let runs = u64::from(runs(samples));
    let parts = u64::from(parts).min(runs);
    let at = |part: u64| {
        let run = runs * part / parts;
        let at = u64::from(samples.start) + run * u64::from(RUN_LENGTH);
        at.min(u64::from(samples.end)) as u32
    };
    (0..parts).map(|part| at(part)..at(part + 1)).collect()
}

/// The parts of the next round of a render until an error, after so many samples of at most so many. A round ends where the error is checked,
/// and its parts are cut there. The first one has a run for each part or more; each later one doubles the samples.
pub fn round(done: u32, most: u32, parts: u32) -> Vec<Range<u32>> {
    let ends = (0..).map(samples_at_check);
    let least = if done == 0 { parts.saturating_mul(RUN_LENGTH).max(FIRST_CHECK) } else { done.saturating_mul(2) };
    let end = ends.take_while(|end| *end < most).find(|end| *end >= least).unwrap_or(most);
    let mut cuts = (0..).map(samples_at_check).take_while(|check| *check < end).filter(|check| *check > done);
    let mut found = Vec::new();
    let mut cut = cuts.next();
    for mut part in even(&(done..end), parts) {
        while let Some(at) = cut.filter(|at| *at < part.end) {
            if at > part.start {
                found.push(part.start..at);
                part.start = at;
            }
            cut = cuts.next();
        }
        found.push(part);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that parts follow one another from start to end, and begin with runs.
    fn follow(parts: &[Range<u32>], samples: Range<u32>) {
        assert_eq!((parts[0].start, parts[parts.len() - 1].end), (samples.start, samples.end));
        assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start && pair[1].start.is_multiple_of(RUN_LENGTH)));
        assert!(parts.iter().all(|part| !part.is_empty()));
    }

    #[test]
    fn parts_are_even_and_complete_runs() {
        for (end, count) in [(256, 8), (100, 3), (8, 1), (7, 1), (1_000_000, 999), (1 << 31, 7), (104, 13), (97, 13)] {
            let parts = even(&(0..end), count);
            follow(&parts, 0..end);
            assert_eq!(parts.len() as u32, count);
            let runs: Vec<u32> = parts.iter().map(runs).collect();
            assert!(runs.iter().max().unwrap() - runs.iter().min().unwrap() <= 1, "{end} in {count}: {runs:?}");
        }
    }

    #[test]
    fn rounds_end_where_the_error_is_checked() {
        for (most, parts) in [(1 << 31, 1), (1 << 31, 3), (1 << 31, 100), (1000, 5), (16, 2), (20, 2), (8, 1), (5, 1)] {
            let mut done = 0;
            let mut ends = Vec::new();
            while done < most {
                let round = round(done, most, parts);
                let end = round[round.len() - 1].end;
                follow(&round, done..end);
                assert!(done == 0 || end == most || end == 2 * done);
                assert!(round.len() as u32 <= parts + 32);
                ends.extend(round.iter().map(|part| part.end));
                done = end;
            }
            let checks = (0..).map(samples_at_check).take_while(|check| *check < most);
            checks.for_each(|check| assert!(ends.contains(&check), "{check} of {most} in {parts}"));
        }
        assert_eq!(round(0, 1 << 20, 3), [0..8, 8..16, 16..32]);
        assert_eq!(round(0, 1 << 20, 1).first(), Some(&(0..16)));
        assert_eq!(round(0, 48, 2), [0..8, 8..16]);
        assert_eq!(round(0, 48, 3), [0..8, 8..16, 16..32], "32 is a check of 48 samples too");
        assert_eq!(round(32, 1 << 20, 3), [32..40, 40..48, 48..64]);
    }
}
