//! The bounding volume hierarchy. A binary tree is built from the root down with the surface area heuristic. Nodes of four
//! children with quantised boxes are made from it. Nodes are small, because the cost of a walk is that of gathers from memory.

mod collapse;
mod grow;
mod split;
mod wide;

use glam::Vec3;

use crate::data::{HIT_NOTHING, Node};
use crate::threads::cores;
use split::{Group, Item};

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

    /// Half the surface area.
    pub fn half_area(self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// A hierarchy as the kernels walk it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// The root's code: a node's index, the only primitive's code, or `HIT_NOTHING`.
    pub root: u32,
    /// The largest number of nodes on the stack during a walk: those on the longest path from the root, without its last node.
    pub stack_size: u32,
}

/// The trade-off between the time of the build and the time of the walks. It does not change the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    #[default]
    Medium,
    Best,
}

/// The expected number of boxes that a line hits if it hits the box around all of them: the ratio of the sum of their
/// surfaces to its surface. The surface area heuristic uses the same ratio (Goldsmith and Salmon, IEEE CG&A 7(5),
/// 1987). 0 if there are no boxes, or if all are at one point.
pub fn crossings(bounds: &[Bounds]) -> f32 {
    let around = bounds.iter().copied().reduce(Bounds::union).map_or(0.0, Bounds::half_area);
    if around > 0.0 { bounds.iter().map(|each| each.half_area()).sum::<f32>() / around } else { 0.0 }
}

/// Builds the hierarchy over boxes; `codes[i]` is the primitive code of box i. Several boxes may have the same one.
pub fn build(bounds: &[Bounds], codes: &[u32], quality: Quality) -> Bvh {
    build_with_threads(bounds, codes, quality, cores())
}

/// [`build`] with a number of threads. The nodes do not depend on it.
pub fn build_with_threads(bounds: &[Bounds], codes: &[u32], quality: Quality, threads: usize) -> Bvh {
    let mut items: Vec<Item> = bounds.iter().zip(codes).map(|(bounds, &code)| Item::new(bounds, code)).collect();
    match &mut items[..] {
        [] => Bvh { nodes: Vec::new(), root: HIT_NOTHING, stack_size: 0 },
        [only] => Bvh { nodes: Vec::new(), root: only.code, stack_size: 0 },
        items => grow::grow(Group::new(items), quality, threads),
    }
}

/// Numbers in 0..1 for tests, the same in every run.
#[cfg(test)]
pub fn unit_numbers() -> impl FnMut() -> f32 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    }
}
