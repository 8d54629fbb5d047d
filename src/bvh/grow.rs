//! Builds the tree: a binary one from the root down, and the nodes from it.

use super::bounds::Bounds;
use super::collapse::{Collapse, End, Twig};
use super::split::{Group, Quality};
use super::wide::{Bvh, quantised};
use crate::data::{Node, PRIMITIVE_BIT};
use crate::threads::each;

/// The depth of the binary tree down to which the heuristic chooses cuts. Deeper groups are halved, so that at most as many levels follow
/// as their number of primitives has bits. Otherwise nested boxes would make a path as long as their number, and the kernels' stack
/// is a private array of fixed size.
const DEEPEST_SOUGHT: u32 = 48;

/// A subtree with at most 1 / `PIECES` of all primitives is a piece of work for one thread. The nodes do not depend on the
/// number of threads.
const PIECES: usize = 16;

/// A piece of fewer primitives is not worth a thread.
const LEAST_PIECE: usize = 4096;

/// A group that becomes a subtree, and its depth in the binary tree.
struct Branch<'a> {
    group: Group<'a>,
    depth: u32,
}

/// The index of the parent node, and which of its children a node is; none above the root.
type Above = Option<(usize, usize)>;

/// The nodes of a tree, in the order of their creation.
struct Grown {
    nodes: Vec<Node>,
    /// The depth of the deepest node.
    deepest: u32,
    /// The children that are pieces.
    pieces: Vec<PieceSlot>,
}

/// A child of a node that stands for a piece.
struct PieceSlot {
    node: usize,
    child: usize,
    depth: u32,
    /// The number of the piece.
    piece: u32,
}

/// Builds the tree over two primitives or more.
pub fn grow(all: Group<'_>, quality: Quality, threads: usize) -> Bvh {
    let most = (all.items.len() / PIECES).max(LEAST_PIECE);
    let all = Branch { group: all, depth: 0 };
    let subtree_of = |branch| Grown::from_twigs(&fork(branch, quality, 1).0);
    let grown = if all.group.items.len() <= most {
        subtree_of(all)
    } else {
        let (twigs, pieces) = fork(all, quality, most);
        let mut top = Grown::from_twigs(&twigs);
        let mut slots = std::mem::take(&mut top.pieces);
        slots.sort_unstable_by_key(|slot| slot.piece);
        let subtrees = each(threads.min(pieces.len()), pieces, subtree_of);
        for (slot, subtree) in slots.iter().zip(subtrees) {
            top.append(slot, subtree);
        }
        top
    };
    Bvh { nodes: grown.nodes, root: 0, stack_size: grown.deepest }
}

/// The binary tree over a group. Its leaves hold the codes of primitives. A group of two to `most` primitives is a leaf with the number of
/// the group, and is returned.
fn fork<'a>(all: Branch<'a>, quality: Quality, most: usize) -> (Vec<Twig>, Vec<Branch<'a>>) {
    let (mut twigs, mut pieces) = (Vec::<Twig>::new(), Vec::new());
    let mut open: Vec<(Branch<'_>, Above)> = vec![(all, None)];
    while let Some((Branch { group, depth }, above)) = open.pop() {
        let here = twigs.len();
        if let Some((parent, side)) = above
            && let End::Fork(sides) = &mut twigs[parent].end
        {
            sides[side] = here as u32;
        }
        let bounds = Bounds::from(group.bounds);
        let end = match &*group.items {
            [only] => End::Leaf(only.code),
            items if items.len() <= most => {
                pieces.push(Branch { group, depth });
                End::Leaf(pieces.len() as u32 - 1)
            }
            _ => {
                let [low, high] = if depth < DEEPEST_SOUGHT { group.split(quality) } else { group.halve() };
                for (side, group) in [(1, high), (0, low)] {
                    open.push((Branch { group, depth: depth + 1 }, Some((here, side))));
                }
                End::Fork([0; 2])
            }
        };
        twigs.push(Twig { bounds, end });
    }
    (twigs, pieces)
}

impl Grown {
    /// The nodes of a binary tree of two leaves or more, depth first.
    fn from_twigs(twigs: &[Twig]) -> Grown {
        let collapse = Collapse::new(twigs);
        let mut grown = Grown { nodes: Vec::new(), deepest: 0, pieces: Vec::new() };
        let mut open: Vec<(usize, u32, Above)> = vec![(0, 0, None)];
        while let Some((index, depth, above)) = open.pop() {
            let here = grown.nodes.len();
            if let Some((node, child)) = above {
                grown.nodes[node].children[child] = here as u32;
            }
            let children = collapse.children(index);
            let boxes: Vec<Bounds> = children.iter().map(|&below| twigs[below].bounds).collect();
            let mut node = quantised(&boxes);
            grown.deepest = grown.deepest.max(depth);
            for (child, below) in children.into_iter().enumerate() {
                match twigs[below].end {
                    End::Fork(_) => open.push((below, depth + 1, Some((here, child)))),
                    End::Leaf(code) if code & PRIMITIVE_BIT != 0 => node.children[child] = code,
                    End::Leaf(piece) => grown.pieces.push(PieceSlot { node: here, child, depth: depth + 1, piece }),
                }
            }
            grown.nodes.push(node);
        }
        grown
    }

    /// Appends the nodes of a piece, and writes its root's code into its slot.
    fn append(&mut self, slot: &PieceSlot, subtree: Grown) {
        let first = self.nodes.len() as u32;
        self.nodes[slot.node].children[slot.child] = first;
        self.nodes.extend(subtree.nodes.into_iter().map(|mut node| {
            // The codes of absent children have the bit, too.
            for code in node.children.iter_mut().filter(|code| **code & PRIMITIVE_BIT == 0) {
                *code += first;
            }
            node
        }));
        self.deepest = self.deepest.max(slot.depth + subtree.deepest);
    }
}
