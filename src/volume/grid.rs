//! A grid of numbers, most of which are one number.

use glam::{DAffine3, IVec3};

/// A grid of numbers at integer points: a tree of OpenVDB as read, in f32.
#[derive(Debug)]
pub struct Grid {
    /// The value everywhere that no leaf or tile covers.
    pub background: f32,
    /// From index space (sample i is at i) to the medium's own space: `to_own.transform_point3(index)`.
    pub to_own: DAffine3,
    /// The smallest box around the active voxels and active tiles: the first and the last voxel. None if nothing is active.
    pub active: Option<(IVec3, IVec3)>,
    /// The tiles whose value is not that of the background.
    pub tiles: Vec<Tile>,
    pub leaves: Vec<Leaf>,
}

/// A box of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile {
    /// The voxel with the least coordinates.
    pub lower: IVec3,
    /// The voxels along an edge: 8, 128 or 4096.
    pub size: i32,
    pub value: f32,
}

/// A block of 8 x 8 x 8 voxels.
#[derive(Debug)]
pub struct Leaf {
    /// The voxel with the least coordinates.
    pub lower: IVec3,
    /// All values that the file has, also of inactive voxels. That of the voxel `lower` + (x, y, z) is at 64 x + 8 y + z.
    pub values: Box<[f32; 512]>,
}
