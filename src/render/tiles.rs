//! The tiles of a film, the blocks of samples that they get in a round, and the order of their pixels.

use std::ops::Range;
use std::time::Duration;

use crate::data::STRIP_ROWS;

/// The runs of a tile are counted in 32 bits, with room for one request too many by each slot.
pub const MOST_RUNS: u32 = 1 << 31;
/// The most blocks of samples of a tile in a round: enough to make the transfer of its totals cheap.
const MOST_BLOCKS: u32 = 64;
/// The runs of each slot in the first round of a film with light paths.
const RUNS_OF_SLOT: u32 = 4;
/// The longest time that a round over several tiles should take. A film is complete between rounds, and only then can a render be stopped.
const ROUND: Duration = Duration::from_secs(10);

/// The tiles of an image with this number of pixels, each with at most `tile` pixels.
pub fn tiles(pixels: u32, tile: u32) -> impl Iterator<Item = Range<u32>> {
    let tile = tile.clamp(1, pixels.max(1));
    (0..pixels).step_by(tile as usize).map(move |first| first..pixels.min(first.saturating_add(tile)))
}

/// The number of blocks of samples that the tiles of a film render in a round. A film of one tile takes all blocks in one round. Otherwise the
/// first round has one block, so that the picture is complete early, and each later round doubles the blocks while it is short enough.
/// Several devices begin in the same way, because their paces are not known.
pub struct Schedule {
    next: u32,
    most: u32,
}

impl Schedule {
    /// `light_paths` is the number of those of a block. They follow the camera paths of each round, so that rounds are short, but long enough
    /// that the `slots` are seldom idle at its end.
    pub fn new(pixels: u32, tile: u32, light_paths: u32, slots: u32, several_devices: bool) -> Schedule {
        let most = (MOST_RUNS / tile.clamp(1, pixels.max(1)).max(light_paths)).max(1);
        let next = match tile >= pixels && !several_devices {
            true if light_paths > 0 => (slots.saturating_mul(RUNS_OF_SLOT) / pixels.max(1)).clamp(1, most),
            true => most,
            false => 1,
        };
        Schedule { next, most: if tile >= pixels { most } else { most.min(MOST_BLOCKS) } }
    }

    /// The blocks of the next round, of those that are left.
    pub fn next(&self, left: &Range<u32>) -> Range<u32> {
        left.start..left.end.min(left.start.saturating_add(self.next))
    }

    /// Adapts the next round to the time of the last one.
    pub fn adapt(&mut self, time: Duration) {
        self.next = match () {
            () if time > ROUND => (self.next / 2).max(1),
            () if time < ROUND / 2 => self.next.saturating_mul(2).min(self.most),
            () => self.next,
        };
    }
}

/// The index (row 0 on top, `y * width + x`) of the pixel at a position in the order of shaders/step/pixel_order.wgsl.
pub fn pixel_in_order(rank: u32, (width, height): (u32, u32)) -> usize {
    // In 32 bits, which divide faster: this runs for each pixel. A strip with more pixels than they can count is the only one.
    let strip = STRIP_ROWS.saturating_mul(width);
    let first_row = rank / strip * STRIP_ROWS;
    let rows = STRIP_ROWS.min(height - first_row);
    let within = rank % strip;
    (first_row + within % rows) as usize * width as usize + (within / rows) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pixel is in one tile, and rounds take all blocks in order.
    #[test]
    fn every_pixel_gets_every_block_once() {
        for (size, tile, blocks) in
            [((7, 13), 20, 3..40), ((7, 13), 91, 0..5), ((7, 13), 1000, 2..3), ((1, 1), 1, 0..300)]
        {
            let pixels = size.0 * size.1;
            let mut seen = vec![0; pixels as usize];
            for tile in tiles(pixels, tile) {
                tile.for_each(|rank| seen[pixel_in_order(rank, size)] += 1);
            }
            assert!(seen.iter().all(|count| *count == 1), "{size:?}, {tile}");
            let (mut schedule, mut left) = (Schedule::new(pixels, tile, 0, 0, false), blocks);
            while !left.is_empty() {
                let round = schedule.next(&left);
                assert!(!round.is_empty() && (tile >= pixels || round.len() as u32 <= MOST_BLOCKS));
                left.start = round.end;
                schedule.adapt(Duration::ZERO);
            }
        }
    }

    /// Rounds grow while they are short, and shrink while they are long. 32 bits number their runs.
    #[test]
    fn rounds_are_short() {
        let mut schedule = Schedule::new(100, 10, 0, 0, false);
        let mut lengths = Vec::new();
        for seconds in [0, 1, 2, 4, 6, 11, 11, 11, 11, 11, 1, 1, 1, 1, 1, 1, 1] {
            lengths.push(schedule.next(&(0..1000)).len());
            schedule.adapt(Duration::from_secs(seconds));
        }
        assert_eq!(lengths, [1, 2, 4, 8, 16, 16, 8, 4, 2, 1, 1, 2, 4, 8, 16, 32, 64]);
        for (pixels, tile) in [(u32::MAX, 1 << 22), (1, 1), (1 << 22, 1 << 22)] {
            let round = Schedule::new(pixels, tile, 0, 0, false).next(&(0..u32::MAX / 8));
            assert!(round.len() as u64 * u64::from(tile) <= u64::from(MOST_RUNS));
        }
        // With light paths, the first round gives each slot some runs; a film of several tiles begins with one block.
        let first = |pixels, tile, slots| Schedule::new(pixels, tile, pixels, slots, false).next(&(0..1000)).len();
        assert_eq!(
            [(100, 100, 1000), (1 << 20, 1 << 20, 1000), (100, 10, 1000)].map(|(p, t, s)| first(p, t, s)),
            [40, 1, 1]
        );
    }
}
