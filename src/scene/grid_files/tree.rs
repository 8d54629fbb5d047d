//! The tree of a grid: a root, nodes of 32^3 nodes of 16^3 leaves of 8^3 voxels. In place of a node there may be a tile of one value.

use std::collections::BTreeMap;

use glam::{DAffine3, IVec3};

use super::packed::{Coding, bit};
use super::{Input, Result};
use crate::volume::grid::{Grid, Leaf, Tile};

/// The voxels along an edge of a leaf, of a node of leaves, and of a node of such nodes.
const LEAF: i32 = 8;
const LOWER: i32 = 128;
const UPPER: i32 = 4096;
/// The bytes of the mask of a leaf.
const MASK: usize = 64;
const TOO_LARGE: &str = "its values take more memory than grids may take: save it with larger voxels";

/// Reads a tree, whose leaves and tiles may take `most_bytes`.
pub fn read(input: Input, coding: Coding, to_own: DAffine3, most_bytes: usize) -> Result<Grid> {
    let grid = Grid { to_own, ..Grid::default() };
    let mut tree = Tree { input, coding, grid, room: most_bytes };
    tree.root()?;
    Ok(tree.grid)
}

struct Tree<'a> {
    input: Input<'a>,
    coding: Coding,
    grid: Grid,
    /// The bytes that are left for leaves and tiles.
    room: usize,
}

impl Tree<'_> {
    fn root(&mut self) -> Result<()> {
        // A number of buffers comes first, which is always 1.
        let (_, background): (u32, f32) = (self.input.read()?, self.input.read()?);
        let [tiles, children]: [u32; 2] = self.input.read()?;
        if !background.is_finite() {
            return Err(format!("its background is {background}, expected a finite number"));
        }
        (self.grid.background, self.coding.background) = (background, background);
        let mut nodes = BTreeMap::new();
        for index in 0..u64::from(tiles) + u64::from(children) {
            // On multiples of their size, boxes do not reach beyond the numbers that there are.
            let lower = self.input.read::<IVec3>()? & -UPPER;
            let mut leaves = Vec::new();
            if index < tiles.into() {
                let (value, active): (f32, u8) = (self.input.read()?, self.input.read()?);
                self.tile(lower, UPPER, value, active != 0)?;
            } else {
                self.node(lower, UPPER, &mut leaves)?;
            }
            if nodes.insert(lower.to_array(), leaves).is_some() {
                return Err(format!("two nodes of its tree are at {lower}: it is damaged"));
            }
        }
        // The values of the leaves come behind all nodes, in the order of the places of the root's children.
        nodes.into_values().flatten().try_for_each(|lower| self.leaf(lower))
    }

    /// Reads a node and all below it but the values of leaves. Adds the corners of its leaves in the order of their values.
    fn node(&mut self, lower: IVec3, size: i32, leaves: &mut Vec<IVec3>) -> Result<()> {
        let child = if size == UPPER { LOWER } else { LEAF };
        let edge = size / child;
        let places =
            (0..edge.pow(3)).map(|at| lower + child * IVec3::new(at / (edge * edge), at / edge % edge, at % edge));
        let mut values = vec![0.0; places.len()];
        let children = self.input.take(values.len() / 8)?;
        let active = self.input.take(values.len() / 8)?;
        self.coding.values(&mut self.input, active, &mut values)?;
        for (index, place) in places.enumerate() {
            if !bit(children, index) {
                self.tile(place, child, values[index], bit(active, index))?;
            } else if child == LEAF {
                // The mask of a leaf comes again before its values.
                self.input.take(MASK)?;
                leaves.push(place);
            } else {
                self.node(place, child, leaves)?;
            }
        }
        Ok(())
    }

    fn leaf(&mut self, lower: IVec3) -> Result<()> {
        self.room = self.room.checked_sub(size_of::<Leaf>() + size_of::<[f32; 512]>()).ok_or(TOO_LARGE)?;
        let active = self.input.take(MASK)?;
        let mut values = Box::new([0.0; 512]);
        self.coding.values(&mut self.input, active, values.as_mut_slice())?;
        for (index, place) in (0..512).enumerate() {
            let voxel = lower + IVec3::new(place / 64, place / 8 % 8, place % 8);
            self.check(voxel, 1, values[index], bit(active, index))?;
        }
        self.grid.leaves.push(Leaf { lower, values });
        Ok(())
    }

    fn tile(&mut self, lower: IVec3, size: i32, value: f32, is_active: bool) -> Result<()> {
        self.check(lower, size, value, is_active)?;
        if value != self.grid.background {
            self.room = self.room.checked_sub(size_of::<Tile>()).ok_or(TOO_LARGE)?;
            self.grid.tiles.push(Tile { lower, size, value });
        }
        Ok(())
    }

    /// Checks the value of a box, and extends the box around all that is active.
    fn check(&mut self, lower: IVec3, size: i32, value: f32, is_active: bool) -> Result<()> {
        if !value.is_finite() {
            return Err(format!("its value at voxel {lower} is {value}, expected a finite number"));
        }
        if is_active {
            let (first, last) = self.grid.active.unwrap_or((lower, lower));
            self.grid.active = Some((first.min(lower), last.max(lower + (size - 1))));
        }
        Ok(())
    }
}
