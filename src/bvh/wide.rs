//! Hierarchies as the kernels walk them: nodes of four children with quantised boxes.

use super::bounds::Bounds;
use crate::data::{HIT_NOTHING, Node};

/// The number of children of a node.
pub const WIDTH: usize = 4;

/// A hierarchy as the kernels walk it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    pub nodes: Vec<Node>,
    /// The root's code: a node's index, the only primitive's code, or `HIT_NOTHING`.
    pub root: u32,
    /// The largest number of nodes on the stack during a walk: those on the longest path from the root, without its last node.
    pub stack_size: u32,
}

/// A node over these boxes. Its codes are filled in later.
pub fn quantised(boxes: &[Bounds]) -> Node {
    let all = boxes.iter().skip(1).fold(boxes[0], |all, bounds| all.union(*bounds));
    let mut node = Node {
        grid: [all.min.x.to_bits(), all.min.y.to_bits(), all.min.z.to_bits(), (boxes.len() as u32) << 24],
        // Absent children have an empty box: the lower planes are above the upper ones.
        low: [u32::MAX; 3],
        children: [HIT_NOTHING; WIDTH],
        ..Node::default()
    };
    for axis in 0..3 {
        let origin = all.min[axis];
        let mut exponent = least_exponent(all.max[axis] - origin);
        // The grid becomes twice as coarse if rounding puts the last plane inside a box.
        while !quantise_axis(&mut node, boxes, axis, origin, exponent) {
            exponent += 1;
        }
        node.grid[3] |= exponent << (8 * axis);
    }
    node
}

/// The biased exponent of the smallest power of two of which 255 steps span the extent. At least 1.
fn least_exponent(extent: f32) -> u32 {
    let exponent = (extent / 255.0).to_bits() >> 23;
    // The exponent rounds down. Any value above the power itself needs the next exponent.
    (exponent + 1).clamp(1, 254)
}

/// Sets the planes of one axis. Returns false if the grid does not span all boxes.
fn quantise_axis(node: &mut Node, boxes: &[Bounds], axis: usize, origin: f32, exponent: u32) -> bool {
    let scale = f32::from_bits(exponent << 23);
    // The kernel's own arithmetic: the product is exact, and the sum is rounded once.
    let plane = |byte: i64| origin + byte as f32 * scale;
    let (mut lows, mut highs) = (u32::MAX, 0);
    for (child, bounds) in boxes.iter().enumerate() {
        let step = |x: f32| (f64::from(x) - f64::from(origin)) / f64::from(scale);
        // Not negative, so that truncation rounds down.
        let mut low = step(bounds.min[axis]) as i64;
        while low > 0 && plane(low) > bounds.min[axis] {
            low -= 1;
        }
        let last = step(bounds.max[axis]);
        let mut high = last as i64 + i64::from(last.fract() > 0.0);
        while high <= 255 && plane(high) < bounds.max[axis] {
            high += 1;
        }
        if high > 255 {
            return false;
        }
        let shift = 8 * child;
        lows = lows & !(255 << shift) | (low.max(0) as u32) << shift;
        highs |= (high as u32) << shift;
    }
    (node.low[axis], node.high[axis]) = (lows, highs);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::unit_numbers;
    use glam::Vec3;

    /// The box that a kernel decodes, in the kernel's arithmetic.
    fn decoded(node: &Node, child: usize) -> Bounds {
        let plane = |packed: &[u32; 3], axis: usize| {
            let byte = packed[axis] >> (8 * child) & 255;
            f32::from_bits(node.grid[axis]) + byte as f32 * f32::from_bits((node.grid[3] >> (8 * axis) & 255) << 23)
        };
        Bounds {
            min: Vec3::from_array([0, 1, 2].map(|axis| plane(&node.low, axis))),
            max: Vec3::from_array([0, 1, 2].map(|axis| plane(&node.high, axis))),
        }
    }

    /// Numbers over many decades, of both signs and zero.
    fn numbers() -> impl FnMut() -> f32 {
        let mut unit = unit_numbers();
        move || {
            let (exponent, sign, zero) = (12.0 * unit() - 10.0, (unit() - 0.5).signum(), unit() < 1.0 / 16.0);
            if zero { 0.0 } else { sign * 10f32.powf(exponent) }
        }
    }

    #[test]
    fn decoded_boxes_contain_what_they_bound() {
        let mut number = numbers();
        let mut vector = || Vec3::new(number(), number(), number());
        let mut loose = 0;
        for _ in 0..20_000 {
            let base = vector();
            let boxes: Vec<_> = (0..4)
                .map(|_| {
                    let (a, b) = (base + vector(), base + vector());
                    Bounds { min: a.min(b), max: a.max(b) }
                })
                .collect();
            let node = quantised(&boxes);
            for (child, bounds) in boxes.iter().enumerate() {
                let box_read = decoded(&node, child);
                assert!(box_read.min.cmple(bounds.min).all(), "{bounds:?} reads as {box_read:?}");
                assert!(box_read.max.cmpge(bounds.max).all(), "{bounds:?} reads as {box_read:?}");
                // The grid is at most twice as coarse as necessary: 255 steps span at most twice the extent.
                let all = boxes.iter().fold(boxes[0], |all, b| all.union(*b));
                let step = (all.max - all.min) / 127.0;
                loose += u32::from(!(bounds.min - box_read.min).cmple(step + 1e-6 * base.abs().max_element()).all());
            }
        }
        assert_eq!(loose, 0, "boxes that read as larger than their grid explains");
    }

    #[test]
    fn absent_children_are_empty_and_named_so() {
        let one = Bounds { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        let node = quantised(&[one, one]);
        assert_eq!(node.children, [HIT_NOTHING; 4]);
        assert!(decoded(&node, 2).min.x > decoded(&node, 2).max.x);
    }
}
