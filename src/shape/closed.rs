//! Whether a mesh bounds a body.

use std::cmp::Ordering;

use glam::DVec3;

use super::mesh::Mesh;

/// Why a mesh bounds no body: edges that no neighbouring face runs along in the other direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenEdges {
    /// The first face of the file, counted from 0, that has such an edge.
    pub face: u32,
    /// How many there are.
    pub count: usize,
}

impl Mesh {
    /// The edges at which the mesh is open or its winding changes; none if it is closed and wound one way.
    ///
    /// Vertices at the same place are one. Closed means that along every edge as many faces run one way as the other, so
    /// that bodies that touch in an edge are closed, too.
    pub fn open_edges(&self) -> Option<OpenEdges> {
        let places = self.places();
        let place = |corner: u32| places.get(corner as usize).copied().unwrap_or_default();
        // Both directions of an edge, side by side after sorting: its places, the lower first, and the triangle.
        let mut edges: Vec<(u64, u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (place(from), place(to));
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

    /// Whether a closed mesh is wound counter-clockwise seen from outside: the sign of its volume.
    pub fn volume_is_positive(&self) -> bool {
        let (low, high) = self.bounds();
        let extent = (high - low).max_element();
        // From its middle and in units of its size nothing overflows, and little cancels.
        let middle = low + 0.5 * (high - low);
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| {
                let position = self.positions.get(corner as usize).copied().unwrap_or(middle);
                (position - middle) / extent
            });
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(volume).sum::<f64>() > 0.0
    }

    /// For each vertex the number of its place: vertices at the same position share it.
    fn places(&self) -> Vec<u32> {
        let mut order: Vec<(DVec3, u32)> = self.positions.iter().copied().zip(0..).collect();
        order.sort_unstable_by(|(a, _), (b, _)| compare(*a, *b));
        let mut places = vec![0; self.positions.len()];
        for (number, same) in order.chunk_by(|(a, _), (b, _)| a == b).enumerate() {
            for &(_, vertex) in same {
                if let Some(place) = places.get_mut(vertex as usize) {
                    *place = number as u32;
                }
            }
        }
        places
    }
}

/// By x, then y, then z. No coordinate is NaN, and -0 is 0.
fn compare(a: DVec3, b: DVec3) -> Ordering {
    let by = |a: f64, b: f64| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
    by(a.x, b.x).then_with(|| by(a.y, b.y)).then_with(|| by(a.z, b.z))
}
