//! The test whether a mesh is closed and encloses a volume.

use std::cmp::Ordering;

use glam::DVec3;

use super::mesh::{Mesh, OpenEdges};
use super::space::Aabb;

impl Mesh {
    /// The edges at which the mesh is open or its winding changes; none if it is closed and wound one way.
    ///
    /// Vertices at the same position count as one. A mesh is closed if along every edge as many faces run in one
    /// direction as in the other. Solids that share an edge are therefore closed, too.
    pub fn open_edges(&self) -> Option<OpenEdges> {
        let numbers = self.position_numbers();
        let number = |corner: u32| numbers.get(corner as usize).copied().unwrap_or_default();
        // One entry for each edge of each triangle: the positions' numbers, the lower first, and the triangle. Sorting brings both
        // directions of an edge together.
        let mut edges: Vec<(u64, u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (number(from), number(to));
                let key = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                // There are at most 2^28 triangles: the lowest bit is free for the direction.
                edges.push((key, (triangle as u32) << 1 | u32::from(from > to)));
            }
        }
        edges.sort_unstable();
        let mut open: Option<OpenEdges> = None;
        for faces in edges.chunk_by(|a, b| a.0 == b.0) {
            let backwards = faces.iter().filter(|(_, face)| face & 1 == 1).count();
            if 2 * backwards == faces.len() {
                continue;
            }
            let face = faces.first().map_or(0, |(_, face)| self.face((face >> 1) as usize));
            let before = open.unwrap_or(OpenEdges { face, count: 0 });
            open = Some(OpenEdges { face: before.face.min(face), count: before.count + 1 });
        }
        open
    }

    /// Whether a closed mesh is wound counter-clockwise seen from outside: its signed volume is then positive.
    pub fn volume_is_positive(&self) -> bool {
        self.signed_volume().0 > 0.0
    }

    /// Whether a closed mesh encloses a volume. Two coincident sheets do not.
    pub fn has_volume(&self) -> bool {
        let (volume, rounding) = self.signed_volume();
        volume.abs() > rounding
    }

    /// Six times the signed volume, in units of the mesh's size, and the most that rounding adds to it.
    fn signed_volume(&self) -> (f64, f64) {
        let Aabb { min: low, max: high } = self.bounds();
        let extent = (high - low).max_element();
        // Coordinates relative to the middle, in units of the size, do not overflow and cancel little.
        let middle = low + 0.5 * (high - low);
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| {
                let position = self.positions.get(corner as usize).copied().unwrap_or(middle);
                (position - middle) / extent
            });
            // Seven roundings of coordinates, products and sums, of half an epsilon each.
            (a.dot(b.cross(c)), 4.0 * f64::EPSILON * a.length() * b.length() * c.length())
        };
        let (mut sum, mut magnitudes, mut rounding) = (0.0, 0.0, 0.0);
        for (term, error) in self.triangles.iter().map(volume) {
            sum += term;
            magnitudes += f64::abs(term);
            rounding += error;
        }
        // Each sum is rounded by at most half an epsilon of all magnitudes together.
        (sum, rounding + self.triangles.len() as f64 * f64::EPSILON * magnitudes)
    }

    /// For each vertex the number of its position. Vertices at the same position share the number.
    fn position_numbers(&self) -> Vec<u32> {
        let mut order: Vec<(DVec3, u32)> = self.positions.iter().copied().zip(0..).collect();
        order.sort_unstable_by(|(a, _), (b, _)| compare(*a, *b));
        let mut numbers = vec![0; self.positions.len()];
        for (number, same) in order.chunk_by(|(a, _), (b, _)| a == b).enumerate() {
            for &(_, vertex) in same {
                if let Some(own) = numbers.get_mut(vertex as usize) {
                    *own = number as u32;
                }
            }
        }
        numbers
    }
}

/// Orders by x, then y, then z. No coordinate is NaN, and -0 equals 0.
fn compare(a: DVec3, b: DVec3) -> Ordering {
    let by = |a: f64, b: f64| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
    by(a.x, b.x).then_with(|| by(a.y, b.y)).then_with(|| by(a.z, b.z))
}
