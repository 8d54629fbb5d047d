//! Grows the tree from the root down.

use std::sync::{Mutex, PoisonError};

use super::split::{Group, Search};
use super::wide::{WIDTH, quantised};
use super::{Bounds, Bvh};
use crate::data::{Node, PRIMITIVE_BIT};

/// Nodes on a path from the root for which cuts are sought; from there on groups are halved, so that at most 16 more
/// follow. Boxes within boxes would else make a path as long as there are boxes, and the kernels' stack is a private
/// array.
const DEEPEST_SOUGHT: u32 = 32;

/// A subtree with this part of all primitives or fewer is a piece of work for one thread. The number of threads decides
/// nothing: the nodes are the same for any.
const PIECES: usize = 16;

/// Primitives that a thread is not started for.
const LEAST_PIECE: usize = 4096;

/// A group whose node is to be made, and what of the path from the root matters to it.
struct Branch<'a> {
    group: Group<'a>,
    depth: u32,
    /// Children that wait above while a walk is here.
    waiting: u32,
    /// The node and child that wait for its code.
    parent: Option<(usize, usize)>,
}

/// Nodes as they come.
#[derive(Default)]
struct Grown {
    nodes: Vec<Node>,
    stack_size: u32,
}

/// The tree over two primitives or more.
pub fn grow(all: Group<'_>, search: &Search, threads: usize) -> Bvh {
    let piece = (all.items.len() / PIECES).max(LEAST_PIECE);
    let mut top = Grown::default();
    let pieces = top.grow(Branch { group: all, depth: 0, waiting: 0, parent: None }, search, piece);
    let parents: Vec<_> = pieces.iter().map(|piece| piece.parent).collect();
    for (parent, subtree) in parents.into_iter().zip(grow_all(pieces, search, threads)) {
        top.append(parent, subtree);
    }
    Bvh { nodes: top.nodes, root: 0, stack_size: top.stack_size }
}

/// The subtrees of all pieces, in their order.
fn grow_all(pieces: Vec<Branch<'_>>, search: &Search, threads: usize) -> Vec<Grown> {
    let mut grown: Vec<Grown> = pieces.iter().map(|_| Grown::default()).collect();
    let workers = threads.clamp(1, pieces.len().max(1));
    let queue = Mutex::new(pieces.into_iter().zip(&mut grown));
    let work = || {
        loop {
            let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((piece, subtree)) = next else { break };
            subtree.grow(Branch { parent: None, ..piece }, search, 0);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..workers {
            scope.spawn(work);
        }
        work();
    });
    drop(queue);
    grown
}

impl Grown {
    /// Makes the nodes of a group, depth first; what groups of `piece` primitives or fewer are under it is handed back.
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
            let waiting = place.waiting + groups.len() as u32 - 1;
            self.stack_size = self.stack_size.max(waiting);
            for (child, group) in groups.into_iter().enumerate() {
                match group.items {
                    [only] => node.children[child] = only.code,
                    _ => open.push(Branch { group, depth: place.depth + 1, waiting, parent: Some((here, child)) }),
                }
            }
            self.nodes.push(node);
        }
        pieces
    }

    /// Takes over a subtree's nodes, for which a child of one that is here waits.
    fn append(&mut self, parent: Option<(usize, usize)>, subtree: Grown) {
        let first = self.nodes.len() as u32;
        if let Some((node, child)) = parent {
            self.nodes[node].children[child] = first;
        }
        self.nodes.extend(subtree.nodes.into_iter().map(|mut node| {
            // The codes of children that are not there have the bit as well.
            for code in node.children.iter_mut().filter(|code| **code & PRIMITIVE_BIT == 0) {
                *code += first;
            }
            node
        }));
        self.stack_size = self.stack_size.max(subtree.stack_size);
    }
}

/// Splits a group of two or more until there are four groups or nothing to split: always the one with the largest
/// surface, or when halving the one with the most primitives.
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
            // No need to seek where all have room.
            groups.extend(group.singles());
        } else if seek {
            groups.extend(group.split(search));
        } else {
            groups.extend(group.halve());
        }
    }
    groups
}
