//! The bounding volume hierarchy: built by `obvhs` (PLOC and reinsertion), laid out for the kernels.

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{BvhBuildParams, Boundable};
use std::time::Duration;

use crate::data::{HIT_NOTHING, Node};

/// The deepest tree that is handed to the kernels as built. Many coincident boxes can make a deeper one, and then a
/// balanced tree over the same order serves instead: the kernels' stack is a private array of this many words at most.
const DEEPEST: u32 = 64;

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
    /// Nodes on the longest way down: the size of the stack that a walk needs.
    pub depth: u32,
}

/// Builds the hierarchy over boxes; `codes[i]` is the primitive code of box i.
pub fn build(bounds: &[Bounds], codes: &[u32]) -> Bvh {
    if bounds.is_empty() {
        return Bvh { nodes: Vec::new(), root: HIT_NOTHING, depth: 0 };
    }
    let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
    let tree = build_bvh2(bounds, params, &mut Duration::default());
    let built = lay_out(0, |&at| {
        let node = &tree.nodes[at];
        let first = node.first_index as usize;
        if node.is_leaf() {
            return Branch::Leaf(codes[tree.primitive_indices[first] as usize]);
        }
        let child = |at: usize| (Bounds::from(tree.nodes[at].aabb()), at);
        Branch::Inner(child(first), child(first + 1))
    });
    if built.depth <= DEEPEST {
        return built;
    }
    lay_out(tree.primitive_indices.as_slice(), |range| match range {
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

/// A place in a tree: a primitive's code, or two boxes with the places under them.
enum Branch<T> {
    Leaf(u32),
    Inner((Bounds, T), (Bounds, T)),
}

/// Lays a tree out as device nodes, depth first, the left subtree right behind its parent.
fn lay_out<T>(root: T, look: impl Fn(&T) -> Branch<T>) -> Bvh {
    let mut out = Bvh { nodes: Vec::new(), root: 0, depth: 0 };
    // A place still to be laid out, the parent and side that wait for its code, and its depth.
    let mut waiting = vec![(root, None::<(usize, bool)>, 1u32)];
    while let Some((place, parent, depth)) = waiting.pop() {
        let code = match look(&place) {
            Branch::Leaf(code) => code,
            Branch::Inner((left_box, left), (right_box, right)) => {
                let here = out.nodes.len();
                out.nodes.push(Node {
                    left_min: left_box.min.to_array(),
                    left_max: left_box.max.to_array(),
                    right_min: right_box.min.to_array(),
                    right_max: right_box.max.to_array(),
                    ..Node::default()
                });
                out.depth = out.depth.max(depth);
                waiting.push((right, Some((here, true)), depth + 1));
                waiting.push((left, Some((here, false)), depth + 1));
                here as u32
            }
        };
        match parent {
            Some((at, true)) => out.nodes[at].right = code,
            Some((at, false)) => out.nodes[at].left = code,
            None => out.root = code,
        }
    }
    out
}
