//! A grid in the layout of the kernels (shaders/medium/grid): tiles of 8 x 8 x 8 bricks, each of 9 x 9 x 9 texels of 16 bits.
//!
//! A texel is a share of the largest value of its brick, which is that of a texel to the bit. So a value is off by at most half a step, 1 / 131,070 of
//! the largest in its brick, and the bound on the density of a brick is exact.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::IVec3;

use super::grid::{Bricks, Grid, Leaf};

/// The cells of a brick along an edge.
pub const BRICK: i32 = 8;
/// The cells of a tile along an edge.
pub const TILE: i32 = 64;
/// The bricks of a tile along an edge.
const BRICKS: i32 = TILE / BRICK;
/// The texels of a brick along an edge.
const TEXELS: i32 = BRICK + 1;
/// The most tiles: their entries take 96 MiB.
const MOST_TILES: i64 = 1 << 23;
/// The largest index of a voxel. Indices near it have room for the lattice of tiles.
const FARTHEST: i64 = 1 << 30;
/// The most words: 4 GiB.
const MOST_WORDS: usize = 1 << 30;
/// The words of the entry of a tile or a brick.
const ENTRY: usize = 3;

impl Grid {
    /// The grid's layout for kernels; nothing if no voxel is active. Negative values count as 0, and voxels out of the box of the active ones as the
    /// background.
    ///
    /// # Errors
    /// The number of tiles, if it is too large.
    pub fn bricks(&self) -> Result<Option<Arc<Bricks>>, String> {
        self.found.bricks.get_or_init(|| Ok(self.bricks_within(MOST_WORDS)?.map(Arc::new))).clone()
    }

    fn bricks_within(&self, most_words: usize) -> Result<Option<Bricks>, String> {
        let Some((first, last)) = self.active else { return Ok(None) };
        let (first, last) = (first.as_i64vec3(), last.as_i64vec3());
        // Bricks begin where those of OpenVDB do, so that its tiles are whole ones.
        let lower = (first - 1).map(|x| x.div_euclid(BRICK.into()) * i64::from(BRICK));
        let tiles = (last + 1 - lower).map(|cells| cells.div_euclid(TILE.into()) + 1);
        if first.min_element() < -FARTHEST || last.max_element() > FARTHEST {
            return Err(format!(
                "expected voxels with indices from {} to {FARTHEST}, found {first} to {last}",
                -FARTHEST
            ));
        }
        let count = tiles.to_array().iter().try_fold(1i64, |product, n| product.checked_mul(*n));
        let Some(count) = count.filter(|count| *count <= MOST_TILES) else {
            return Err(format!(
                "expected a grid that spans at most {MOST_TILES} blocks of {TILE} x {TILE} x {TILE} voxels, found {} x {} x {}: cut off \
                 the voxels far from the others",
                tiles.x, tiles.y, tiles.z
            ));
        };
        let voxels = Voxels::of(self);
        let (lower, tiles) = (lower.as_ivec3(), tiles.as_ivec3());
        let mut words = entry_of(0, [self.background.max(0.0); 2]).repeat(count as usize);
        for tile in voxels.touched(lower, tiles) {
            let at = ENTRY * (tile.x + tiles.x * (tile.y + tiles.y * tile.z)) as usize;
            let corner = lower + tile * TILE;
            let entry = match voxels.tile_around(corner) {
                Some(value) => entry_of(0, [value; 2]),
                None => add_tile(&mut words, &voxels, corner),
            };
            if words.len() > most_words {
                return Err(format!(
                    "expected a grid that takes at most {} GiB, found more: make it coarser",
                    MOST_WORDS >> 28
                ));
            }
            words[at..at + ENTRY].copy_from_slice(&entry);
        }
        Ok(Some(Bricks { tiles, lower, words }))
    }
}

/// The words of an entry: an index, and the least and the largest value.
fn entry_of(index: u32, [least, largest]: [f32; 2]) -> [u32; ENTRY] {
    [index, least.to_bits(), largest.to_bits()]
}

/// Adds the bricks of a tile whose lower corner is this voxel. Returns its entry.
fn add_tile(words: &mut Vec<u32>, voxels: &Voxels<'_>, lower: IVec3) -> [u32; ENTRY] {
    let begin = words.len();
    words.resize(begin + ENTRY * (BRICKS * BRICKS * BRICKS) as usize, 0);
    let mut texels = [0.0; (TEXELS * TEXELS * TEXELS) as usize];
    let (mut same, mut bounds) = (true, [f32::INFINITY, 0.0]);
    for index in 0..BRICKS * BRICKS * BRICKS {
        let brick = IVec3::new(index % BRICKS, index / BRICKS % BRICKS, index / BRICKS / BRICKS);
        let one = voxels.fill(lower + brick * BRICK, &mut texels);
        let own =
            texels.iter().fold([f32::INFINITY, 0.0], |[least, most], value| [least.min(*value), most.max(*value)]);
        let entry = entry_of(if one { 0 } else { add_texels(words, &texels, own[1]) }, own);
        let at = begin + ENTRY * index as usize;
        words[at..at + ENTRY].copy_from_slice(&entry);
        same &= words[at..at + ENTRY] == words[begin..begin + ENTRY];
        bounds = [bounds[0].min(own[0]), bounds[1].max(own[1])];
    }
    if same && words[begin] == 0 {
        words.truncate(begin);
        return entry_of(0, bounds);
    }
    entry_of(begin as u32, bounds)
}

/// Adds the texels of a brick. Returns the index of their first word.
fn add_texels(words: &mut Vec<u32>, texels: &[f32], bound: f32) -> u32 {
    let begin = words.len() as u32;
    let code = |value: &f32| (f64::from(*value) / f64::from(bound) * f64::from(u16::MAX)).round() as u32;
    words.extend(
        texels
            .chunks(2)
            .map(|pair| pair.iter().map(code).enumerate().fold(0, |word, (half, code)| word | code << (16 * half))),
    );
    begin
}

/// A leaf or a value that covers a block of 8 x 8 x 8 voxels.
#[derive(Clone, Copy)]
enum Block<'a> {
    Leaf(&'a [f32; 512]),
    Value(f32),
}

/// The voxels of a grid, by their indices.
struct Voxels<'a> {
    grid: &'a Grid,
    active: (IVec3, IVec3),
    leaves: HashMap<IVec3, &'a Leaf>,
    /// By the logarithm of the size, then by the lower corner.
    tiles: HashMap<(u32, IVec3), f32>,
    /// The logarithms of the sizes of the tiles.
    sizes: Vec<u32>,
}

impl<'a> Voxels<'a> {
    fn of(grid: &'a Grid) -> Voxels<'a> {
        let log = |size: i32| size.max(1).ilog2();
        let tiles: HashMap<_, _> = grid.tiles.iter().map(|tile| ((log(tile.size), tile.lower), tile.value)).collect();
        let sizes: HashSet<u32> = tiles.keys().map(|(size, _)| *size).collect();
        Voxels {
            grid,
            active: grid.active.unwrap_or_default(),
            leaves: grid.leaves.iter().map(|leaf| (leaf.lower, leaf)).collect(),
            tiles,
            sizes: sizes.into_iter().collect(),
        }
    }

    /// The tiles of the lattice whose texels are not all the background's, in order.
    fn touched(&self, lower: IVec3, tiles: IVec3) -> Vec<IVec3> {
        let leaves = self.grid.leaves.iter().map(|leaf| (leaf.lower, BRICK));
        let all = leaves.chain(self.grid.tiles.iter().map(|tile| (tile.lower, tile.size)));
        let mut found = HashSet::new();
        for (corner, size) in all {
            // A brick has the texels on its upper faces, too.
            let last = corner.saturating_add(IVec3::splat(size - 1));
            let [from, to] = [corner.saturating_sub(IVec3::splat(BRICK)), last].map(|voxel| {
                let offset = voxel.as_i64vec3() - lower.as_i64vec3();
                offset.map(|x| x.div_euclid(TILE.into())).clamp(glam::I64Vec3::splat(-1), tiles.as_i64vec3()).as_ivec3()
            });
            let (from, to) = (from.max(IVec3::ZERO), to.min(tiles - 1));
            for z in from.z..=to.z {
                for y in from.y..=to.y {
                    found.extend((from.x..=to.x).map(|x| IVec3::new(x, y, z)));
                }
            }
        }
        let mut found: Vec<IVec3> = found.into_iter().collect();
        found.sort_by_key(|tile| (tile.z, tile.y, tile.x));
        found
    }

    /// The value of the tile of OpenVDB around all texels of a tile of the lattice, if one is so large.
    fn tile_around(&self, lower: IVec3) -> Option<f32> {
        let (first, last) = self.active;
        let is_inside = lower.cmpge(first).all() && (lower + TILE).cmple(last).all();
        let around = |size: &u32| {
            let corner = lower & IVec3::splat(-1 << size);
            let is_whole = (lower + TILE) & IVec3::splat(-1 << size) == corner;
            self.tiles.get(&(*size, corner)).filter(|_| is_whole).map(|value| value.max(0.0))
        };
        self.sizes.iter().find_map(around).filter(|_| is_inside)
    }

    fn block(&self, lower: IVec3) -> Block<'a> {
        if let Some(leaf) = self.leaves.get(&lower) {
            return Block::Leaf(&leaf.values);
        }
        let tile = |size: &u32| self.tiles.get(&(*size, lower & IVec3::splat(-1 << size)));
        Block::Value(self.sizes.iter().find_map(tile).copied().unwrap_or(self.grid.background))
    }

    /// Writes the texels of the brick whose lower corner is this voxel. Whether all are the same.
    fn fill(&self, lower: IVec3, texels: &mut [f32]) -> bool {
        let corner = |index: i32| lower + BRICK * IVec3::new(index >> 2, index >> 1 & 1, index & 1);
        let blocks: [Block<'_>; 8] = std::array::from_fn(|index| self.block(corner(index as i32)));
        let (first, last) = self.active;
        let is_inside = lower.cmpge(first).all() && (lower + BRICK).cmple(last).all();
        if let (true, Block::Value(value)) = (is_inside, blocks[0])
            && blocks.iter().all(|block| matches!(block, Block::Value(own) if *own == value))
        {
            texels.fill(value.max(0.0));
            return true;
        }
        for (index, texel) in (0..).zip(texels.iter_mut()) {
            let at = IVec3::new(index / TEXELS / TEXELS, index / TEXELS % TEXELS, index % TEXELS);
            let (block, within) = (at / BRICK, at % BRICK);
            let voxel = lower + at;
            let value = match blocks[(block.x * 4 + block.y * 2 + block.z) as usize] {
                _ if !(voxel.cmpge(first).all() && voxel.cmple(last).all()) => self.grid.background,
                Block::Leaf(values) => values[(within.x * 64 + within.y * 8 + within.z) as usize],
                Block::Value(value) => value,
            };
            *texel = value.max(0.0);
        }
        texels.iter().all(|texel| *texel == texels[0])
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::volume::grid::{Found, Tile};

    /// The value at a voxel, as shaders/medium/grid reads it.
    fn value_at(bricks: &Bricks, voxel: IVec3) -> f32 {
        let cell = voxel - bricks.lower;
        let tile = cell / TILE;
        let word = |index: usize| bricks.words[index];
        let at = ENTRY * (tile.x + bricks.tiles.x * (tile.y + bricks.tiles.y * tile.z)) as usize;
        if word(at) == 0 {
            return f32::from_bits(word(at + 2));
        }
        let brick = (cell - tile * TILE) / BRICK;
        let at = word(at) as usize + ENTRY * (brick.x + BRICKS * (brick.y + BRICKS * brick.z)) as usize;
        let bound = f32::from_bits(word(at + 2));
        if word(at) == 0 {
            return bound;
        }
        let within = cell % BRICK;
        let index = ((within.x * TEXELS + within.y) * TEXELS + within.z) as usize;
        let pair = word(word(at) as usize + index / 2);
        f32::from((pair >> (16 * (index % 2))) as u16) / f32::from(u16::MAX) * bound
    }

    fn leaf(lower: IVec3, value: impl Fn(i32, i32, i32) -> f32) -> Leaf {
        let values = std::array::from_fn(|i| value(i as i32 / 64, i as i32 / 8 % 8, i as i32 % 8));
        Leaf { lower, values: Box::new(values) }
    }

    #[test]
    fn voxels_are_those_of_the_tree_within_half_a_step() {
        let at = IVec3::new(-16, 64, 120);
        let grid = Grid {
            background: 0.25,
            to_own: DAffine3::IDENTITY,
            active: Some((at, IVec3::new(-8, 127, 127))),
            tiles: vec![Tile { lower: IVec3::new(-8, 64, 120), size: 8, value: 2.0 }],
            leaves: vec![leaf(at, |x, y, z| (x + 2 * y + 3 * z) as f32)],
            found: Found::default(),
        };
        let bricks = grid.bricks().expect("it is small").expect("it is not empty");
        assert_eq!(grid.largest(), 42.0);
        // Another camera has the same one.
        assert!(grid.bricks().is_ok_and(|again| again.is_some_and(|again| Arc::ptr_eq(&again, &bricks))));
        for voxel in [[0, 0, 0], [7, 7, 7], [3, 0, 5], [8, 1, 2]].map(IVec3::from_array) {
            let expected = if voxel.x == 8 { 2.0 } else { (voxel.x + 2 * voxel.y + 3 * voxel.z) as f32 };
            let found = value_at(&bricks, at + voxel);
            assert!((found - expected).abs() <= 42.0 / 131_070.0 * 1.001, "{voxel}: {found}, expected {expected}");
        }
        // Out of the box of the active voxels, and where the tree has nothing.
        for voxel in [IVec3::new(-7, 64, 120), IVec3::new(-16, 90, 120), at - 1] {
            assert!((value_at(&bricks, voxel) - 0.25).abs() < 4e-4, "{voxel}");
        }
    }

    #[test]
    fn tiles_take_no_texels_and_what_is_too_large_is_refused() {
        let of = |tiles, active| Grid { tiles, active: Some(active), ..Grid::default() };
        let tile = |x: i32, value| Tile { lower: IVec3::new(x, 0, 0), size: 128, value };
        let one = of(vec![tile(0, 3.0)], (IVec3::ZERO, IVec3::splat(127)));
        let bricks = one.bricks().expect("it is small").expect("it is not empty");
        assert_eq!(value_at(&bricks, IVec3::splat(64)), 3.0);
        // Only bricks at its faces have texels.
        assert!(bricks.words.len() < 6 * 17 * 17 * 400, "{} words", bricks.words.len());
        let wide = of(vec![tile(0, 3.0)], (IVec3::splat(-(1 << 29)), IVec3::splat(1 << 29)));
        assert!(wide.bricks().is_err_and(|error| error.contains("blocks of 64")));
        let far = of(Vec::new(), (IVec3::splat(i32::MIN), IVec3::splat(i32::MIN + 8)));
        assert!(far.bricks().is_err_and(|error| error.contains("indices")));
        assert!(one.bricks_within(1 << 16).is_err_and(|error| error.contains("GiB")));
    }
}
