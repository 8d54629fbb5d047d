//! The bounding volume hierarchy. A binary tree is built from the root down with the surface area heuristic. Nodes of four
//! children with quantised boxes are made from it. Nodes are small, because the cost of a walk is that of gathers from memory.

mod bounds;
mod collapse;
mod grow;
mod split;
mod wide;

use crate::data::HIT_NOTHING;
use crate::threads::cores;
use split::{Group, Item};

pub use bounds::Bounds;
#[cfg(test)]
pub use bounds::unit_numbers;
pub use split::Quality;
pub use wide::{Bvh, WIDTH};

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
