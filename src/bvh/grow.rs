//! Builds the tree from the root down.

use super::split::{Group, Search};
use super::wide::{WIDTH, quantised};
use super::{Bounds, Bvh};
use crate::data::{Node, PRIMITIVE_BIT};
use crate::threads::each;

/// The depth down to which the heuristic chooses cuts. Deeper groups are halved, so that at most 16 more levels follow.
/// Otherwise nested boxes would make a path as long as their number, and the kernels' stack is a private array of fixed
/// size.
const DEEPEST_SOUGHT: u32 = 32;

/// A subtree with at most 1 / `PIECES` of all primitives is a piece of work for one thread. The nodes do not depend on the
/// number of threads.
const PIECES: usize = 16;

/// A piece of fewer primitives is not worth a thread.
const LEAST_PIECE: usize = 4096;

/// A group that becomes a node, and the properties of its path from the root.
struct Branch<'a> {
    group: Group<'a>,
    depth: u32,
    /// The parent node, and the child there that gets its code.
    parent: Option<(usize, usize)>,
}

/// The nodes so far, in the order of their creation.
#[derive(Default)]
struct Grown {
    nodes: Vec<Node>,
    stack_size: u32,
}

/// Builds the tree over two primitives or more.
pub fn grow(all: Group<'_>, search: &Search, threads: usize) -> Bvh {
    let piece = (all.items.len() / PIECES).max(LEAST_PIECE);
    let mut top = Grown::default();
    let pieces = top.grow(Branch { group: all, depth: 0, parent: None }, search, piece);
    let parents: Vec<_> = pieces.iter().map(|piece| piece.parent).collect();
    for (parent, subtree) in parents.into_iter().zip(grow_all(pieces, search, threads)) {
        top.append(parent, subtree);
    }
    Bvh { nodes: top.nodes, root: 0, stack_size: top.stack_size }
}

/// Builds the subtrees of all pieces, and returns them in the order of the pieces.
fn grow_all(pieces: Vec<Branch<'_>>, search: &Search, threads: usize) -> Vec<Grown> {
    let workers = threads.clamp(1, pieces.len().max(1));
    each(workers, pieces, |piece| {
        let mut subtree = Grown::default();
        subtree.grow(Branch { parent: None, ..piece }, search, 0);
        subtree
    })
}

impl Grown {
    /// Makes the nodes of a group, depth first. Groups of at most `piece` primitives are returned instead.
    fn grow<'a>(&mut self, root: Branch<'a>, search: &Search, piece: usize) -> Vec<Branch<'a>> {
        let mut pieces = Vec::new();
        let mut open = vec![root];
        while let Some(place) = open.pop() {
            if place.group.items.len() <= piece {
                pieces.push(place);
                continue;
            }
            let here = self.nodes.len();
            if let Some((node, child)) = place.parent {
                self.nodes[node].children[child] = here as u32;
            }
            let groups = four(place.group, place.depth < DEEPEST_SOUGHT, search);
            let boxes: Vec<Bounds> = groups.iter().map(|group| group.bounds.into()).collect();
            let mut node = quantised(&boxes);
            self.stack_size = self.stack_size.max(place.depth);
            for (child, group) in groups.into_iter().enumerate() {
                match group.items {
                    [only] => node.children[child] = only.code,
                    _ => open.push(Branch { group, depth: place.depth + 1, parent: Some((here, child)) }),
                }
            }
            self.nodes.push(node);
        }
        pieces
    }

    /// Appends the nodes of a subtree, and writes its root's code into the parent.
    fn append(&mut self, parent: Option<(usize, usize)>, subtree: Grown) {
        let first = self.nodes.len() as u32;
        if let Some((node, child)) = parent {
            self.nodes[node].children[child] = first;
        }
        self.nodes.extend(subtree.nodes.into_iter().map(|mut node| {
            // The codes of absent children have the bit, too.
            for code in node.children.iter_mut().filter(|code| **code & PRIMITIVE_BIT == 0) {
                *code += first;
            }
            node
        }));
        self.stack_size = self.stack_size.max(subtree.stack_size);
    }
}

/// Splits a group of two or more primitives until there are four groups or nothing to split. The next group to split is
/// the one with the largest surface; without `seek` it is the one with the most primitives, and is halved.
fn four<'a>(group: Group<'a>, seek: bool, search: &Search) -> Vec<Group<'a>> {
    let mut groups = Vec::with_capacity(WIDTH);
    groups.push(group);
    while groups.len() < WIDTH {
        let parted = groups.iter().enumerate().filter(|(_, group)| group.items.len() > 1);
        let largest = match seek {
            true => parted.max_by(|a, b| a.1.bounds.half_area().total_cmp(&b.1.bounds.half_area())),
            false => parted.max_by_key(|(_, group)| group.items.len()),
        };
        let Some((largest, _)) = largest else { break };
        let group = groups.swap_remove(largest);
        if groups.len() + group.items.len() <= WIDTH {
            // All primitives fit into the node, so that no cut is needed.
            groups.extend(group.singles());
        } else if seek {
            groups.extend(group.split(search));
        } else {
            groups.extend(group.halve());
        }
    }
    groups
}
