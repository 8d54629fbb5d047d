//! Cuts the boxes of long thin faces that lie across the axes. Small boxes along such a face have far less surface than one around all of
//! it, so that fewer rays meet them (Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies", IEEE Symposium on
//! Interactive Ray Tracing 2007). The face is then in several leaves.

use glam::{DVec3, Vec3};

use super::coverage::clip;
use super::pairs::Pair;
use crate::bvh::Bounds;
use crate::threads::{cores, each};

/// The halves of a box that is cut have at most this share of its surface. The halves around a face of even sides have 0.83 of it. Those
/// around a thin face that lies across two or three axes have half of it.
const SHARE: f32 = 0.7;

/// A cut saves more than this share of the mean surface of the boxes. So there are at most eleven times as many leaves.
const LEAST_SAVED: f32 = 0.1;

/// The most leaves of a mesh that is cut: its nodes then take half of the 128 MiB that every device gives a buffer.
pub const MOST_LEAVES: usize = 1 << 21;

/// The pairs that a thread cuts in a batch.
const PAIRS_AT_ONCE: usize = 4096;

/// A bound of the rounding in f64 of a corner of a clipped face, if no coordinate is above 1.
const ROUNDING: f64 = 1e-14;

/// A box, and the index of the pair whose faces, or parts of them, are in it.
pub type PairBox = (Bounds, u32);

/// Cuts the boxes of pairs, which together still hold all faces. No box is cut if there would be more than `most` of them.
/// Coordinates are at most 1.
pub fn boxes(
    uncut: Vec<PairBox>,
    most: usize,
    pairs: &[Pair],
    triangles: &[[u32; 3]],
    positions: &[Vec3],
) -> Vec<PairBox> {
    if uncut.len() > most {
        return uncut;
    }
    let mean = uncut.iter().map(|(bounds, _)| f64::from(bounds.half_area())).sum::<f64>() / uncut.len().max(1) as f64;
    let least = LEAST_SAVED * mean as f32;
    let corners_of = |face: u32| triangles[face as usize].map(|corner| positions[corner as usize].as_dvec3());
    let cut_some = |some: &[PairBox]| -> Vec<PairBox> {
        let cut_one = |&(bounds, pair): &PairBox| {
            let faces: Vec<[DVec3; 3]> = pairs[pair as usize].faces().map(corners_of).collect();
            cut(bounds, &faces, least).into_iter().map(move |part| (part, pair))
        };
        some.iter().flat_map(cut_one).collect()
    };
    let chunks = uncut.chunks(PAIRS_AT_ONCE);
    let parts = each(cores().min(chunks.len()), chunks, cut_some).concat();
    if parts.len() <= most { parts } else { uncut }
}

/// The parts that the box of some faces is cut into.
fn cut(bounds: Bounds, faces: &[[DVec3; 3]], least_saved: f32) -> Vec<Bounds> {
    let (mut done, mut open) = (Vec::new(), vec![bounds]);
    while let Some(bounds) = open.pop() {
        let pays = |halves: &[Bounds; 2]| {
            let [all, low, high] = [bounds, halves[0], halves[1]].map(Bounds::half_area);
            low + high <= SHARE * all && all - (low + high) > least_saved
        };
        match halves(bounds, faces).filter(pays) {
            Some(halves) => open.extend(halves),
            None => done.push(bounds),
        }
    }
    done
}

/// The boxes around the parts of faces in either half of a box. None if a half holds no part.
fn halves(bounds: Bounds, faces: &[[DVec3; 3]]) -> Option<[Bounds; 2]> {
    let axis = (bounds.max - bounds.min).max_position();
    let middle = bounds.min[axis].midpoint(bounds.max[axis]);
    let (mut low, mut high) = (bounds, bounds);
    low.max[axis] = middle;
    high.min[axis] = middle;
    Some([around(faces, low)?, around(faces, high)?])
}

/// The box around the parts of faces in a box. None if it holds no part.
fn around(faces: &[[DVec3; 3]], within: Bounds) -> Option<Bounds> {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let corners = faces.iter().flat_map(|face| clipped(face.to_vec(), within));
    let (min, max) = corners.fold(nothing, |(min, max), corner| (min.min(corner), max.max(corner)));
    (min.x <= max.x)
        .then(|| Bounds { min: below(min - ROUNDING).max(within.min), max: (-below(-max - ROUNDING)).min(within.max) })
}

/// The part of a polygon in a box.
fn clipped(mut polygon: Vec<DVec3>, within: Bounds) -> Vec<DVec3> {
    for axis in 0..3 {
        for (side, plane) in [(1.0, within.min[axis]), (-1.0, within.max[axis])] {
            polygon = clip(&polygon, |p| side * (p[axis] - f64::from(plane)));
        }
    }
    polygon
}

/// The largest vector of f32 that is not above a vector.
fn below(v: DVec3) -> Vec3 {
    let rounded = v.as_vec3();
    let down = |axis: usize| if f64::from(rounded[axis]) > v[axis] { rounded[axis].next_down() } else { rounded[axis] };
    Vec3::new(down(0), down(1), down(2))
}

#[cfg(test)]
mod tests {
    use super::super::pairs::pairs;
    use super::*;
    use crate::bvh::unit_numbers;

    /// So many faces along random directions.
    fn faces(count: usize, length: f32, width: f32) -> (Vec<[u32; 3]>, Vec<Vec3>) {
        let mut random = unit_numbers();
        let mut vector = |size: f32| size * (2.0 * Vec3::new(random(), random(), random()) - 1.0);
        let corners = |_| {
            let (at, along, across) = (vector(0.5), vector(length), vector(width));
            [at - along, at + along, at + along + across]
        };
        let positions: Vec<Vec3> = (0..count).flat_map(corners).collect();
        ((0..count as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(), positions)
    }

    fn uncut(pairs: &[Pair], triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<PairBox> {
        pairs.iter().map(|pair| pair.bounds(triangles, positions)).zip(0..).collect()
    }

    /// The number of boxes of faces, and of pairs.
    fn count(triangles: &[[u32; 3]], positions: &[Vec3]) -> (usize, usize) {
        let pairs = pairs(triangles, positions);
        let uncut = uncut(&pairs, triangles, positions);
        (boxes(uncut, MOST_LEAVES, &pairs, triangles, positions).len(), pairs.len())
    }

    /// How many points of the faces, on a grid, are in no box of their pair. `shrink` moves the sides of the boxes inwards.
    fn points_outside(
        boxes: &[PairBox],
        pairs: &[Pair],
        triangles: &[[u32; 3]],
        positions: &[Vec3],
        shrink: f64,
    ) -> usize {
        let mut outside = 0;
        for (index, pair) in (0..).zip(pairs) {
            let own: Vec<&Bounds> = boxes.iter().filter(|(_, of)| *of == index).map(|(bounds, _)| bounds).collect();
            for face in pair.faces() {
                let [a, b, c] = triangles[face as usize].map(|corner| positions[corner as usize].as_dvec3());
                for (i, j) in (0..=64).flat_map(|i| (0..=64 - i).map(move |j| (i, j))) {
                    let point = a + f64::from(i) / 64.0 * (b - a) + f64::from(j) / 64.0 * (c - a);
                    // The point itself is rounded by less than this.
                    let slack = 1e-15 - shrink;
                    let holds = |bounds: &&Bounds| {
                        (point + slack).cmpge(bounds.min.as_dvec3()).all()
                            && (point - slack).cmple(bounds.max.as_dvec3()).all()
                    };
                    outside += usize::from(!own.iter().any(holds));
                }
            }
        }
        outside
    }

    #[test]
    fn boxes_of_thin_faces_are_cut_and_hold_them() {
        let (triangles, positions) = faces(200, 0.3, 0.001);
        let pairs = pairs(&triangles, &positions);
        let uncut = uncut(&pairs, &triangles, &positions);
        let room = |most: usize| boxes(uncut.clone(), most, &pairs, &triangles, &positions);
        let cut = room(MOST_LEAVES);
        let outside = |shrink: f64| points_outside(&cut, &pairs, &triangles, &positions, shrink);
        assert_eq!(outside(0.0), 0);
        assert!(cut.len() > 400, "{} boxes", cut.len());
        // Boxes that are smaller by a millionth do not hold the faces.
        assert!(outside(1e-6) > 1000);
        // In the order of the pairs, whatever thread has cut them.
        assert!(cut.is_sorted_by_key(|(_, pair)| *pair));
        let surface = |boxes: &[PairBox]| boxes.iter().map(|(bounds, _)| bounds.half_area()).sum::<f32>();
        assert!(surface(&cut) < 0.6 * surface(&uncut), "{} of {}", surface(&cut), surface(&uncut));
        assert!(room(cut.len()) == cut && room(cut.len() - 1) == uncut && room(0) == uncut);
    }

    #[test]
    fn boxes_of_other_faces_are_not_cut() {
        let mut random = unit_numbers();
        let side = 20u32;
        let grid: Vec<Vec3> =
            (0..side * side).map(|i| Vec3::new((i % side) as f32, (i / side) as f32, random()) / side as f32).collect();
        let squares = (0..side - 1).flat_map(|x| (0..side - 1).map(move |y| x + y * side));
        let hills: Vec<[u32; 3]> =
            squares.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + 1 + side, i + side]]).collect();
        let (boxes, pairs) = count(&hills, &grid);
        assert_eq!(boxes, pairs);
        // Along an axis a box has no surface to save; and points and lines have none at all.
        let line = |to: Vec3| (vec![[0, 1, 2]], vec![Vec3::ZERO, 0.5 * to, to]);
        for (triangles, positions) in [line(Vec3::X), line(Vec3::ONE), line(Vec3::ZERO)] {
            let (boxes, _) = count(&triangles, &positions);
            assert!((1..=11).contains(&boxes), "{boxes} boxes");
        }
        assert_eq!(count(&[], &[]), (0, 0));
    }
}
