//! Sets of samples of a pixel.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

/// A set of sample indices: ranges that are sorted, apart and not empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[u32; 2]>", into = "Vec<[u32; 2]>")]
pub struct Samples(Vec<Range<u32>>);

impl Samples {
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.0
    }

    /// The number of samples.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|range| range.len() as u64).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The least range that holds all of them; empty if there are none.
    pub fn range(&self) -> Range<u32> {
        match (self.0.first(), self.0.last()) {
            (Some(first), Some(last)) => first.start..last.end,
            _ => 0..0,
        }
    }

    /// Adds a range; what is there already stays.
    pub fn add(&mut self, range: Range<u32>) {
        if range.is_empty() {
            return;
        }
        let first = self.0.partition_point(|known| known.end < range.start);
        let end = self.0.partition_point(|known| known.start <= range.end);
        let mut joined = range;
        for known in &self.0[first..end] {
            joined = joined.start.min(known.start)..joined.end.max(known.end);
        }
        self.0.splice(first..end, [joined]);
    }

    /// Adds all samples of another set.
    pub fn join(&mut self, other: &Samples) {
        other.0.iter().for_each(|range| self.add(range.clone()));
    }

    /// The first range that both have.
    pub fn overlap(&self, other: &Samples) -> Option<Range<u32>> {
        let common = |a: &Range<u32>| {
            let b = other.0.get(other.0.partition_point(|b| b.end <= a.start))?;
            let both = a.start.max(b.start)..a.end.min(b.end);
            (!both.is_empty()).then_some(both)
        };
        self.0.iter().find_map(common)
    }

    /// The parts of a range that are not in the set.
    pub fn missing(&self, wanted: Range<u32>) -> Samples {
        let mut missing = Vec::new();
        let mut at = wanted.start;
        for known in &self.0 {
            let gap = at..known.start.min(wanted.end);
            if !gap.is_empty() {
                missing.push(gap);
            }
            at = at.max(known.end);
        }
        if at < wanted.end {
            missing.push(at..wanted.end);
        }
        Samples(missing)
    }
}

impl From<Range<u32>> for Samples {
    fn from(range: Range<u32>) -> Samples {
        let mut samples = Samples::default();
        samples.add(range);
        samples
    }
}

impl From<Samples> for Vec<[u32; 2]> {
    fn from(samples: Samples) -> Vec<[u32; 2]> {
        samples.0.into_iter().map(|range| [range.start, range.end]).collect()
    }
}

impl TryFrom<Vec<[u32; 2]>> for Samples {
    type Error = &'static str;

    fn try_from(ranges: Vec<[u32; 2]>) -> Result<Samples, &'static str> {
        let ranges: Vec<Range<u32>> = ranges.into_iter().map(|[start, end]| start..end).collect();
        let sorted = ranges.windows(2).all(|pair| pair[0].end < pair[1].start);
        match sorted && ranges.iter().all(|range| !range.is_empty()) {
            true => Ok(Samples(ranges)),
            false => Err("expected ranges of samples in order"),
        }
    }
}

/// `0..64, 128..256`
impl fmt::Display for Samples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ranges: Vec<String> = self.0.iter().map(|range| format!("{}..{}", range.start, range.end)).collect();
        f.write_str(&ranges.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against sets of single numbers, for all sets of a few ranges.
    #[test]
    fn sets_are_those_of_their_numbers() {
        let set = |bits: u32| {
            let mut samples = Samples::default();
            (0..12).filter(|bit| bits >> bit & 1 == 1).for_each(|bit| samples.add(bit..bit + 1));
            samples
        };
        let bits = |samples: &Samples| samples.ranges().iter().flat_map(Clone::clone).fold(0, |bits, n| bits | 1 << n);
        for a in (0..4096).step_by(37).chain([4095]) {
            let samples = set(a);
            assert_eq!(bits(&samples), a);
            assert_eq!(samples.count(), u64::from(a.count_ones()));
            assert!(samples.ranges().windows(2).all(|pair| pair[0].end < pair[1].start), "{samples}");
            let text = serde_json::to_string(&samples).unwrap();
            assert_eq!(serde_json::from_str::<Samples>(&text).unwrap(), samples);
            for (start, end) in [(0, 12), (3, 9), (5, 6), (7, 7)] {
                let range = (start..end).fold(0, |bits, n| bits | 1u32 << n);
                assert_eq!(bits(&samples.missing(start..end)), range & !a, "{samples}: {start}..{end}");
                let mut joined = samples.clone();
                joined.add(start..end);
                assert_eq!(bits(&joined), range | a);
                assert_eq!(joined, set(range | a));
            }
            for b in (0..4096).step_by(411) {
                let common = samples.overlap(&set(b));
                assert_eq!(common.is_some(), a & b != 0, "{samples} and {}", set(b));
                assert!(common.is_none_or(|common| common.into_iter().all(|n| a & b & 1 << n != 0)));
            }
        }
    }

    #[test]
    fn ranges_are_written_in_words_and_damaged_ones_are_refused() {
        let mut samples = Samples::from(0..64);
        samples.add(128..256);
        assert_eq!((samples.to_string().as_str(), samples.range()), ("0..64, 128..256", 0..256));
        for text in ["[[4,4]]", "[[5,4]]", "[[0,8],[8,16]]", "[[8,16],[0,4]]", "[[0,8],[4,16]]", "[[0]]", "[[-1,4]]"] {
            assert!(serde_json::from_str::<Samples>(text).is_err(), "{text}");
        }
    }
}
