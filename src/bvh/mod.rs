//! The bounding volume hierarchy: a binary tree built by `obvhs` (PLOC and reinsertion), gathered into nodes of four
//! children with quantised boxes. Few words a node is what counts: loads by lane are the cost of a walk.

mod wide;

use std::time::Duration;

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use crate::data::{HIT_NOTHING, Node};

/// The deepest binary tree that is taken as built. Many coincident boxes can make a deeper one, and then a balanced tree
/// over the same order serves instead: the kernels' stack is a private array.
const DEEPEST: usize = 64;

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

    /// Half the surface.
    fn half_area(self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl From<&Aabb> for Bounds {
    fn from(aabb: &Aabb) -> Bounds {
        Bounds { min: aabb.min.into(), max: aabb.max.into() }
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb { min: self.min.into(), max: self.max.into() }
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

/// Builds the hierarchy over boxes; `codes[i]` is the primitive code of box i.
pub fn build(bounds: &[Bounds], codes: &[u32]) -> Bvh {
    if bounds.is_empty() {
        return Bvh { nodes: Vec::new(), root: HIT_NOTHING, stack_size: 0 };
    }
    let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
    let tree = build_bvh2(bounds, params, &mut Duration::default());
    // A binary tree's depth counts its leaves' level too.
    if tree.depth(0) <= DEEPEST {
        return wide::gather(0, |&at| {
            let node = &tree.nodes[at];
            let first = node.first_index as usize;
            if node.is_leaf() {
                return Branch::Leaf(codes[tree.primitive_indices[first] as usize]);
            }
            let child = |at: usize| (Bounds::from(tree.nodes[at].aabb()), at);
            Branch::Inner(child(first), child(first + 1))
        });
    }
    wide::gather(tree.primitive_indices.as_slice(), |range| match range {
        [only] => Branch::Leaf(codes[*only as usize]),
        _ => {
            let child = |range| (bound(range, bounds), range);
            let (low, high) = range.split_at(range.len() / 2);
            Branch::Inner(child(low), child(high))
        }
    })
}

/// The union of the boxes named by a range that is not empty.
fn bound(range: &[u32], bounds: &[Bounds]) -> Bounds {
    let first = bounds[range[0] as usize];
    range.iter().fold(first, |all, &i| all.union(bounds[i as usize]))
}

/// A place in a binary tree: a primitive's code, or two boxes with the places under them.
enum Branch<T> {
    Leaf(u32),
    Inner((Bounds, T), (Bounds, T)),
}
