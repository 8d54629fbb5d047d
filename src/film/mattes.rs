//! The mattes of pixels: the ids that camera samples have seen, with the number of samples of each.

use std::cmp::Reverse;

use crate::aov::{Aovs, MatteValue};
use crate::data::{MATTE_SLOTS, MATTE_WORDS};
use crate::error::{Error, Result};
use crate::memory;

const SLOTS: usize = MATTE_SLOTS as usize;
const WORDS: usize = MATTE_WORDS as usize;

/// The table of each pixel and kind of matte: ids with their samples, then the samples of further ids, as on the device (shaders/data/film). The
/// ids are sorted: the order in which the device met them means nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mattes {
    /// The words of a pixel.
    count: usize,
    words: Vec<u32>,
}

/// Adds a table of a pixel to another. Where they have more ids than a table holds, those with the fewest samples are lost.
fn join(mine: &mut [u32; WORDS], theirs: &[u32; WORDS]) {
    if theirs.iter().all(|word| *word == 0) {
        return;
    }
    let (mut all, mut count) = ([[0; 2]; 2 * SLOTS], 0);
    let ids = mine.as_chunks().0.iter().chain(theirs.as_chunks().0).filter(|[id, _]| *id != 0);
    for [id, samples] in ids {
        match all[..count].iter_mut().find(|known| known[0] == *id) {
            Some(known) => known[1] = samples.saturating_add(known[1]),
            None => {
                all[count] = [*id, *samples];
                count += 1;
            }
        }
    }
    all[..count].sort_unstable_by_key(|[id, samples]| (Reverse(*samples), *id));
    let lost = all[SLOTS..].iter().map(|[_, samples]| *samples).chain([mine[WORDS - 1], theirs[WORDS - 1]]);
    let lost = lost.fold(0, u32::saturating_add);
    mine[..WORDS - 1].copy_from_slice(all[..SLOTS].as_flattened());
    mine[WORDS - 1] = lost;
}

impl Mattes {
    /// # Errors
    /// `Error::Usage` if memory does not hold them.
    pub fn new(pixels: usize, aovs: &Aovs) -> Result<Mattes> {
        let count = aovs.matte_words();
        let all = pixels.saturating_mul(count);
        let needs = |memory: String| Error::Usage(format!("--aov cryptomatte needs {memory}; use a smaller --size"));
        if all > 0 {
            memory::check((all as u64).saturating_mul(size_of::<u32>() as u64)).map_err(needs)?;
        }
        let cannot = |_| needs("more memory than can be had".to_string());
        Ok(Mattes { count, words: bytemuck::allocation::try_zeroed_vec(all).map_err(cannot)? })
    }

    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// The words of a pixel; empty if the film has no mattes.
    pub fn of_pixel(&self, index: usize) -> &[u32] {
        self.words.get(index * self.count..(index + 1) * self.count).unwrap_or_default()
    }

    /// Adds the words of a pixel of another film, or of a device's.
    pub fn add(&mut self, index: usize, words: &[u32]) {
        let mine = self.words.get_mut(index * self.count..(index + 1) * self.count).unwrap_or_default();
        mine.as_chunks_mut().0.iter_mut().zip(words.as_chunks().0).for_each(|(mine, theirs)| join(mine, theirs));
    }

    pub fn merge(&mut self, other: &Mattes) {
        let tables = self.words.as_chunks_mut().0.iter_mut();
        tables.zip(other.words.as_chunks().0).for_each(|(mine, theirs)| join(mine, theirs));
    }

    /// A channel of a pixel, of so many camera samples in all. Samples that were rejected have their share, so that the mattes of a pixel without
    /// background add up to 1.
    pub fn value(&self, index: usize, value: MatteValue, samples: f64) -> f64 {
        let ranked = |kind, rank| self.ranked(index, kind, rank);
        match value {
            MatteValue::Id(kind, rank) => f64::from(f32::from_bits(ranked(kind, rank)[0])),
            // A film that a device has left before its end lacks samples that have hit.
            MatteValue::Share(kind, rank) => (f64::from(ranked(kind, rank)[1]) / samples.max(1.0)).min(1.0),
            MatteValue::Lost => f64::from(self.lost(index)),
        }
    }

    /// The number of pixels that lack samples; `None` if the film has no mattes.
    pub fn pixels_lost(&self) -> Option<u64> {
        let pixels = self.words.len().checked_div(self.count)?;
        Some((0..pixels).filter(|index| self.lost(*index) > 0).count() as u64)
    }

    /// The id of this rank, and its samples; zeros where there is none.
    fn ranked(&self, index: usize, kind: usize, rank: usize) -> [u32; 2] {
        let first = kind * WORDS + 2 * rank;
        self.of_pixel(index).get(first..first + 2).map_or([0; 2], |found| [found[0], found[1]])
    }

    /// The samples that no matte has, of the kind that lacks the most.
    fn lost(&self, index: usize) -> u32 {
        self.of_pixel(index).as_chunks::<WORDS>().0.iter().map(|table| table[WORDS - 1]).max().unwrap_or(0)
    }
}

/// The names of a pixel's words, two halves each.
pub(super) fn names(aovs: &Aovs) -> Vec<String> {
    let of_kind = |kind: usize| {
        let slots =
            (0..SLOTS).flat_map(move |slot| [format!("matte{kind}.id{slot}"), format!("matte{kind}.samples{slot}")]);
        slots.chain([format!("matte{kind}.lost")])
    };
    (0..aovs.mattes().len()).flat_map(of_kind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(entries: &[[u32; 2]], lost: u32) -> [u32; WORDS] {
        let mut table = [0; WORDS];
        table[..2 * entries.len()].copy_from_slice(entries.as_flattened());
        table[WORDS - 1] = lost;
        table
    }

    #[test]
    fn tables_of_sixteen_ids_join_in_any_order() {
        let (a, b) = (table(&[[7, 2], [3, 5]], 0), table(&[[3, 1], [9, 2], [4, 2]], 0));
        let joined = |tables: &[[u32; WORDS]]| {
            let mut all = [0; WORDS];
            tables.iter().for_each(|table| join(&mut all, table));
            all
        };
        let expected = table(&[[3, 6], [4, 2], [7, 2], [9, 2]], 0);
        assert_eq!([joined(&[a, b]), joined(&[b, a])], [expected; 2]);
        assert_ne!(joined(&[a, a]), expected);
        // The seventeenth id is that of the fewest samples, and of these the largest.
        let full: Vec<[u32; 2]> = (1..=16).map(|id| [id, 4]).collect();
        let with_more = joined(&[table(&full, 1), table(&[[20, 9], [21, 1]], 2)]);
        assert_eq!((with_more[..2].to_vec(), with_more[30..].to_vec()), (vec![20, 9], vec![15, 4, 1 + 2 + 1 + 4]));
    }
}
