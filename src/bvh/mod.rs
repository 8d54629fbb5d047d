//! The bounding volume hierarchy: grown from the root down by the surface area heuristic, straight into nodes of four
//! children with quantised boxes. Few words a node is what counts: loads by lane are the cost of a walk.

mod grow;
mod split;
mod wide;

use std::thread::available_parallelism;

use glam::Vec3;

use crate::data::{HIT_NOTHING, Node};
use split::{Group, Item, Search};

pub use wide::WIDTH;

/// A box in render space that bounds a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl Bounds {
    fn union(self, other: Bounds) -> Bounds {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

/// A hierarchy as the kernels walk it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// The root's code: a node's index, the only primitive's code, or `HIT_NOTHING`.
    pub root: u32,
    /// Codes that wait at most while a walk goes down: the size of its stack.
    pub stack_size: u32,
}

/// How much time a build may take for how fast a walk. It changes no image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    Fast,
    #[default]
    Medium,
    Best,
}

impl Quality {
    fn search(self) -> Search {
        match self {
            Quality::Fast => Search { bins: 16, all_axes: false },
            Quality::Medium => Search { bins: 16, all_axes: true },
            Quality::Best => Search { bins: 32, all_axes: true },
        }
    }
}

/// How many of the boxes a line that meets the box around them all meets on average: the share of its surface that theirs is, by
/// which the surface area heuristic counts too (Goldsmith and Salmon, IEEE CG&A 7(5), 1987). 0 for no boxes, and where all are in one point.
pub fn crossings(bounds: &[Bounds]) -> f32 {
    let half_area = |all: &Bounds| {
        let d = all.max - all.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let around = bounds.iter().copied().reduce(Bounds::union).map_or(0.0, |all| half_area(&all));
    if around > 0.0 { bounds.iter().map(half_area).sum::<f32>() / around } else { 0.0 }
}

/// Builds the hierarchy over boxes; `codes[i]` is the primitive code of box i.
pub fn build(bounds: &[Bounds], codes: &[u32], quality: Quality) -> Bvh {
    let threads = available_parallelism().map_or(1, usize::from);
    build_with_threads(bounds, codes, quality, threads)
}

/// [`build`] with so many threads, which change nothing in the nodes.
pub fn build_with_threads(bounds: &[Bounds], codes: &[u32], quality: Quality, threads: usize) -> Bvh {
    let mut items: Vec<Item> = bounds.iter().zip(codes).map(|(bounds, &code)| Item::new(bounds, code)).collect();
    match &mut items[..] {
        [] => Bvh { nodes: Vec::new(), root: HIT_NOTHING, stack_size: 0 },
        [only] => Bvh { nodes: Vec::new(), root: only.code, stack_size: 0 },
        items => grow::grow(Group::new(items), &quality.search(), threads),
    }
}
