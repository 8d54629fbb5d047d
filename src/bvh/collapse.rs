//! Makes nodes of four children from a binary tree: of all ways to leave nodes of that tree out, the one with the least cost under the
//! surface area heuristic (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG
//! 2017, section 3.1).

use super::bounds::Bounds;
use super::wide::WIDTH;

/// A node of a binary tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twig {
    pub bounds: Bounds,
    pub end: End,
}

/// What is below a node of a binary tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The indices of two nodes, both behind that of this one.
    Fork([u32; 2]),
    /// The number of what the tree holds here.
    Leaf(u32),
}

/// The most children of a wide node that can come from one side of a fork.
const SIDE: usize = WIDTH - 1;

/// The cost of a tree: the sum of the surfaces of its wide nodes, and their number, which decides where nodes have no surface. The
/// leaves are the same in all trees.
#[derive(Clone, Copy, Default)]
struct Cost {
    surface: f32,
    nodes: u32,
}

impl Cost {
    fn plus(self, other: Cost) -> Cost {
        Cost { surface: self.surface + other.surface, nodes: self.nodes + other.nodes }
    }

    /// The lower one of two costs.
    fn least(self, other: Cost) -> Cost {
        if self.is_below(other) { self } else { other }
    }

    fn is_below(self, other: Cost) -> bool {
        self.surface.total_cmp(&other.surface).then(self.nodes.cmp(&other.nodes)).is_lt()
    }
}

/// The least costs of what is below a node, where it becomes one child of a wide node, two at most, or three at most.
type Costs = [Cost; SIDE];

/// A binary tree with the costs of all its nodes. The root comes first.
pub struct Collapse<'a> {
    twigs: &'a [Twig],
    costs: Vec<Costs>,
}

impl<'a> Collapse<'a> {
    pub fn new(twigs: &'a [Twig]) -> Collapse<'a> {
        let mut all = Collapse { twigs, costs: vec![[Cost::default(); SIDE]; twigs.len()] };
        for (index, twig) in twigs.iter().enumerate().rev() {
            if let End::Fork(sides) = twig.end {
                let apart = |children| all.parted(sides, children).1;
                let alone = apart(WIDTH).plus(Cost { surface: twig.bounds.half_area(), nodes: 1 });
                all.costs[index] = std::array::from_fn(|more| match more {
                    0 => alone,
                    _ => apart(more + 1).least(alone),
                });
            }
        }
        all
    }

    /// How many of so many children the first side gets at the least cost, and that cost.
    fn parted(&self, sides: [u32; 2], children: usize) -> (usize, Cost) {
        let [first, second] = sides.map(|side| &self.costs[side as usize]);
        let part = |count: usize| (count, first[count - 1].plus(second[children - count - 1]));
        (2..children).map(part).fold(part(1), |least, other| if other.1.is_below(least.1) { other } else { least })
    }

    /// The indices of the nodes that become the children of the wide node at `index`.
    pub fn children(&self, index: usize) -> Vec<usize> {
        let mut found = Vec::with_capacity(WIDTH);
        if let End::Fork(sides) = self.twigs[index].end {
            self.part(sides, WIDTH, &mut found);
        }
        found
    }

    fn part(&self, sides: [u32; 2], children: usize, found: &mut Vec<usize>) {
        let (first, _) = self.parted(sides, children);
        for (side, count) in sides.into_iter().zip([first, children - first]) {
            let index = side as usize;
            let costs = &self.costs[index];
            match self.twigs[index].end {
                End::Fork(sides) if costs[count - 1].is_below(costs[0]) => self.part(sides, count, found),
                _ => found.push(index),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bvh::unit_numbers;

    /// A binary tree over so many boxes at random positions.
    fn tree(leaves: usize, random: &mut impl FnMut() -> f32) -> Vec<Twig> {
        let boxes: Vec<Bounds> = (0..leaves)
            .map(|_| {
                let min = Vec3::new(random(), random(), random());
                Bounds { min, max: min + 0.3 * Vec3::new(random(), random(), random()) }
            })
            .collect();
        let mut twigs = vec![];
        grow(&boxes, 0, random, &mut twigs);
        twigs
    }

    fn grow(boxes: &[Bounds], first: u32, random: &mut impl FnMut() -> f32, twigs: &mut Vec<Twig>) -> u32 {
        let index = twigs.len();
        let bounds = boxes.iter().copied().reduce(Bounds::union).expect("a box");
        twigs.push(Twig { bounds, end: End::Leaf(first) });
        if boxes.len() > 1 {
            let cut = 1 + (random() * (boxes.len() - 1) as f32) as usize;
            let low = grow(&boxes[..cut], first, random, twigs);
            let high = grow(&boxes[cut..], first + cut as u32, random, twigs);
            twigs[index].end = End::Fork([low, high]);
        }
        index as u32
    }

    /// All sets of at most so many nodes that together hold what is below a node.
    fn all_ways(twigs: &[Twig], index: usize, most: usize) -> Vec<Vec<usize>> {
        let mut ways = vec![vec![index]];
        if let End::Fork([low, high]) = twigs[index].end {
            for count in 1..most {
                for one in all_ways(twigs, low as usize, count) {
                    let others = all_ways(twigs, high as usize, most - count);
                    ways.extend(others.into_iter().map(|other| [&one[..], &other[..]].concat()));
                }
            }
        }
        ways
    }

    /// The least cost of a wide tree, by trying all.
    fn least(twigs: &[Twig], index: usize) -> f64 {
        if let End::Leaf(_) = twigs[index].end {
            return 0.0;
        }
        let ways = all_ways(twigs, index, WIDTH).into_iter().skip(1);
        let cost = |way: Vec<usize>| way.into_iter().map(|child| least(twigs, child)).sum::<f64>();
        f64::from(twigs[index].bounds.half_area()) + ways.map(cost).fold(f64::INFINITY, f64::min)
    }

    /// The cost of the wide tree in which nodes have these children, and the leaves that it reaches.
    fn cost_of(twigs: &[Twig], index: usize, children: &impl Fn(usize) -> Vec<usize>, reached: &mut Vec<u32>) -> f64 {
        match twigs[index].end {
            End::Leaf(number) => {
                reached.push(number);
                0.0
            }
            End::Fork(_) => {
                let children_here = children(index);
                assert!((2..=WIDTH).contains(&children_here.len()));
                let below: f64 = children_here.iter().map(|&child| cost_of(twigs, child, children, reached)).sum();
                f64::from(twigs[index].bounds.half_area()) + below
            }
        }
    }

    #[test]
    fn no_other_way_to_leave_nodes_out_costs_less() {
        let mut random = unit_numbers();
        let mut dearer = 0;
        for round in 0..300 {
            let leaves = 2 + round % 9;
            let twigs = tree(leaves, &mut random);
            let collapse = Collapse::new(&twigs);
            let mut reached = vec![];
            let cost = cost_of(&twigs, 0, &|index| collapse.children(index), &mut reached);
            reached.sort_unstable();
            assert_eq!(reached, (0..leaves as u32).collect::<Vec<_>>());
            let least = least(&twigs, 0);
            // Sums of at most nine surfaces, each rounded in f32.
            assert!((cost - least).abs() <= 16.0 * f64::from(f32::EPSILON) * least, "{leaves} leaves: {cost} {least}");
            // The binary tree itself costs more.
            let both = |index: usize| match twigs[index].end {
                End::Fork(sides) => sides.map(|side| side as usize).to_vec(),
                End::Leaf(_) => vec![],
            };
            dearer += usize::from(cost_of(&twigs, 0, &both, &mut vec![]) > 1.001 * least);
        }
        assert!(dearer > 200, "{dearer}");
    }
}
