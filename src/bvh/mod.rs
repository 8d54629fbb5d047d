//! The bounding volume hierarchy: a binary tree built by `obvhs` (PLOC and reinsertion), gathered into nodes of four
//! children with quantised boxes. Few words a node is what counts: loads by lane are the cost of a walk.

mod wide;

use std::time::Duration;

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
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

    /// Something to sort boxes by, so that equal ones meet.
    fn bits(&self) -> [u32; 6] {
        let [x, y, z] = self.min.to_array().map(f32::to_bits);
        let [u, v, w] = self.max.to_array().map(f32::to_bits);
        [x, y, z, u, v, w]
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

/// How much time a build may take for how fast a walk. It changes no image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    Fast,
    #[default]
    Medium,
    Best,
}

/// Builds the hierarchy over boxes; `codes[i]` is the primitive code of box i.
pub fn build(bounds: &[Bounds], codes: &[u32], quality: Quality) -> Bvh {
    if bounds.is_empty() {
        return Bvh { nodes: Vec::new(), root: HIT_NOTHING, stack_size: 0 };
    }
    // Equal boxes side by side, each set of them built over once: clustering many of them takes time by their square.
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    order.sort_by_key(|&i| (bounds[i as usize].bits(), i));
    let sets: Vec<&[u32]> = order.chunk_by(|&a, &b| bounds[a as usize] == bounds[b as usize]).collect();
    let boxes: Vec<Bounds> = sets.iter().map(|set| bounds[set[0] as usize]).collect();

    let params = BvhBuildParams { max_prims_per_leaf: 1, ..quality.params() };
    let tree = build_bvh2(&boxes, params, &mut Duration::default());
    let all: Vec<u32> = tree.primitive_indices.iter().flat_map(|&set| sets[set as usize]).copied().collect();
    let boxes = Boxes { tree: &tree, sets: &sets, bounds, codes };
    let root = if tree.depth(0) <= DEEPEST { Place::Node(0) } else { Place::Set(&all) };
    wide::gather(root, |place| boxes.below(place))
}

impl Quality {
    fn params(self) -> BvhBuildParams {
        match self {
            Quality::Fast => BvhBuildParams::fast_build(),
            Quality::Medium => BvhBuildParams::medium_build(),
            Quality::Best => BvhBuildParams::slow_build(),
        }
    }
}

/// A place in the binary tree over all boxes: a node of the tree that was built, or some boxes of which a balanced tree is
/// made on the way.
#[derive(Clone, Copy)]
enum Place<'a> {
    Node(usize),
    Set(&'a [u32]),
}

/// All that a binary tree over the boxes is made from.
struct Boxes<'a> {
    tree: &'a Bvh2,
    /// The boxes that are equal, by the tree's leaves.
    sets: &'a [&'a [u32]],
    bounds: &'a [Bounds],
    codes: &'a [u32],
}

impl<'a> Boxes<'a> {
    fn below(&self, place: &Place<'a>) -> Branch<Place<'a>> {
        match *place {
            Place::Node(at) => {
                let node = &self.tree.nodes[at];
                let first = node.first_index as usize;
                if node.is_leaf() {
                    return self.halve(self.sets[self.tree.primitive_indices[first] as usize]);
                }
                let child = |at: usize| (Bounds::from(self.tree.nodes[at].aabb()), Place::Node(at));
                Branch::Inner(child(first), child(first + 1))
            }
            Place::Set(set) => self.halve(set),
        }
    }

    /// The top of a balanced tree over a set of boxes that is not empty.
    fn halve(&self, set: &'a [u32]) -> Branch<Place<'a>> {
        if let [only] = set {
            return Branch::Leaf(self.codes[*only as usize]);
        }
        let child = |set| (bound(set, self.bounds), Place::Set(set));
        let (low, high) = set.split_at(set.len() / 2);
        Branch::Inner(child(low), child(high))
    }
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
