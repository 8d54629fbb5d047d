//! The order in which the device renders the pixels of a film.

use std::ops::Range;

use crate::data::STRIP_ROWS;

/// The runs of a turn are counted in 32 bits, with room for each slot to ask once too often.
const MOST_RUNS: u32 = 1 << 31;
/// Blocks of samples that a tile renders in a turn at most: enough to make the transfer of its totals cheap.
const MOST_BLOCKS: u32 = 64;

/// Some blocks of samples for a tile of the film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Turn {
    /// The tile: pixels by their places in the order in which they are handed out.
    pub pixels: Range<u32>,
    pub blocks: Range<u32>,
}

/// The turns of an image of so many pixels, of which a tile has `tile` at most. A film of one tile takes all blocks in one turn. Otherwise the
/// first round has one block, so that the picture is whole early. Each later round doubles the samples, up to [`MOST_BLOCKS`].
pub fn turns(pixels: u32, tile: u32, blocks: Range<u32>) -> impl Iterator<Item = Turn> {
    let tile = tile.clamp(1, pixels.max(1));
    let most = (MOST_RUNS / tile).max(1);
    let mut rest = blocks.clone();
    let round = std::iter::from_fn(move || {
        let done = rest.start - blocks.start;
        let count = if tile >= pixels { most } else { done.clamp(1, most.min(MOST_BLOCKS)) };
        let round = rest.start..rest.end.min(rest.start.saturating_add(count));
        rest.start = round.end;
        (!round.is_empty()).then_some(round)
    });
    round.flat_map(move |blocks| {
        (0..pixels)
            .step_by(tile as usize)
            .map(move |first| Turn { pixels: first..pixels.min(first.saturating_add(tile)), blocks: blocks.clone() })
    })
}

/// The index (row 0 on top, `y * width + x`) of the pixel at a place in the order in which pixels are handed out, as shaders/step/pixel_order.wgsl
/// has it.
pub fn pixel_in_order(place: u32, (width, height): (u32, u32)) -> usize {
    // In 32 bits, which divide faster: this is called for each pixel. A strip that they do not hold is the only one.
    let strip = STRIP_ROWS.saturating_mul(width);
    let first_row = place / strip * STRIP_ROWS;
    let rows = STRIP_ROWS.min(height - first_row);
    let within = place % strip;
    (first_row + within % rows) as usize * width as usize + (within / rows) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_gets_every_block_once() {
        for (size, tile, blocks) in
            [((7, 13), 20, 3..40), ((7, 13), 91, 0..5), ((7, 13), 1000, 2..3), ((1, 1), 1, 0..300)]
        {
            let pixels = size.0 * size.1;
            let mut seen = vec![0; pixels as usize];
            let mut next = vec![blocks.start; pixels as usize];
            for turn in turns(pixels, tile, blocks.clone()) {
                assert!(turn.pixels.len() as u32 <= tile);
                for pixel in turn.pixels.clone().map(|place| pixel_in_order(place, size)) {
                    assert_eq!(next[pixel], turn.blocks.start, "blocks come in order");
                    next[pixel] = turn.blocks.end;
                    seen[pixel] += turn.blocks.len();
                }
                // No pixel is ahead of another by more than a turn.
                assert!(
                    tile >= pixels || next.iter().max() <= next.iter().min().map(|least| least + MOST_BLOCKS).as_ref()
                );
            }
            assert!(seen.iter().all(|count| *count == blocks.len()), "{size:?}, {tile}");
        }
        // The runs of a turn are numbered by 32 bits, of the largest images too.
        let runs = |turn: Turn| turn.pixels.len() as u64 * turn.blocks.len() as u64;
        assert!(turns(u32::MAX, 1 << 22, 0..u32::MAX / 8).take(5000).all(|turn| runs(turn) <= u64::from(MOST_RUNS)));
        assert!(turns(1, 1, 0..u32::MAX / 8).all(|turn| runs(turn) <= u64::from(MOST_RUNS)));
        assert_eq!(turns(100, 10, 3..3).count(), 0);
    }
}
