//! A grid of numbers.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DVec3, IVec3};

use crate::shape::{self, Aabb, Shape};

/// A grid of numbers at integer points: a tree of OpenVDB as read, in f32.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// The value everywhere that no leaf or tile covers.
    pub background: f32,
    /// From index space (sample i is at i) to the medium's own space.
    pub to_own: DAffine3,
    /// The smallest box around the active voxels and active tiles: the first and the last, inclusive. None if nothing is active.
    pub active: Option<(IVec3, IVec3)>,
    pub tiles: Vec<Tile>,
    pub leaves: Vec<Leaf>,
    pub found: Found,
}

/// Properties of a grid that take a walk over all of it, and are found once: a grid stays for many cameras.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// The least and the largest value.
    range: OnceLock<[f32; 2]>,
    pub(super) bricks: OnceLock<Result<Option<Arc<Bricks>>, String>>,
}

/// A box of one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    pub lower: IVec3,
    /// The voxels along an edge.
    pub size: i32,
    pub value: f32,
}

/// A block of 8 x 8 x 8 voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    pub lower: IVec3,
    /// x first: index x 64 + y 8 + z.
    pub values: Box<[f32; 512]>,
}

/// The layout of a grid for kernels (`volume::bricks`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bricks {
    /// The number of tiles along each axis.
    pub tiles: IVec3,
    /// The index of the voxel at the lower corner of the tiles.
    pub lower: IVec3,
    /// The words, in which indices of words count from the first of them.
    pub words: Vec<u32>,
}

impl Grid {
    /// The largest value.
    pub fn largest(&self) -> f32 {
        self.range()[1]
    }

    fn range(&self) -> [f32; 2] {
        *self.found.range.get_or_init(|| {
            let of_leaves = self.leaves.iter().flat_map(|leaf| leaf.values.iter().copied());
            let all = of_leaves.chain(self.tiles.iter().map(|tile| tile.value));
            all.fold([self.background; 2], |[least, largest], value| [least.min(value), largest.max(value)])
        })
    }

    /// The warning that some or all of its values are no densities.
    pub fn warning(&self) -> Option<String> {
        let [least, largest] = self.range();
        if self.active.is_none() || largest <= 0.0 {
            return Some(
                "no voxel of the grid is active and above 0, so that the medium has no effect: choose another grid"
                    .to_owned(),
            );
        }
        (least < 0.0).then(|| {
            format!(
                "the grid has values below 0, such as {least}, which count as 0: a level set has distances to a surface, and is no density; \
                 convert it to a fog volume"
            )
        })
    }

    /// The box of the active voxels, one voxel wider on each side, by the indices of its corners: between the outermost voxels and their
    /// neighbours the values are trilinear.
    pub fn around(&self) -> Option<(DVec3, DVec3)> {
        let (first, last) = self.active?;
        Some((first.as_dvec3() - 1.0, last.as_dvec3() + 1.0))
    }

    /// The smallest box in the medium's own space around that box.
    pub fn boundary(&self) -> Option<Shape<'static>> {
        let (low, high) = self.around()?;
        let corner = |i: usize| DVec3::new([low, high][i & 1].x, [low, high][i >> 1 & 1].y, [low, high][i >> 2].z);
        let around = Aabb::around((0..8).map(|i| self.to_own.transform_point3(corner(i))));
        Some(Shape::Cuboid(shape::Cuboid { min: around.min, max: around.max }))
    }

    /// The bytes of its tree.
    pub fn bytes(&self) -> usize {
        self.leaves.len() * (size_of::<Leaf>() + size_of::<[f32; 512]>()) + self.tiles.len() * size_of::<Tile>()
    }
}
