//! Pairs of faces that share two corners: the leaves of a mesh's hierarchy. A walk then reads four corners for two faces, and visits half
//! as many leaves.

use glam::Vec3;

use crate::bvh::Bounds;
use crate::data::{FacePair, KIND_TRIANGLE, NO_FACE, primitive_code};

/// The numbers of two faces, or of one that found no partner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    first: u32,
    second: Option<u32>,
}

/// Puts each face into one pair. Faces join at the longest edges first: the boxes of such pairs are the smallest relative to their faces'.
pub fn pairs(triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<Pair> {
    let edge = |a: u32, b: u32| u64::from(a.min(b)) << 32 | u64::from(a.max(b));
    let edges_of = |(face, &[a, b, c]): (u32, &[u32; 3])| [edge(a, b), edge(b, c), edge(c, a)].map(|edge| (edge, face));
    let mut edges: Vec<(u64, u32)> = (0..).zip(triangles).flat_map(edges_of).collect();
    edges.sort_unstable();
    let length = |edge: u64| positions[(edge >> 32) as usize].distance_squared(positions[edge as u32 as usize]);
    let joins = |two: &[(u64, u32)]| two[0].0 == two[1].0 && two[0].1 != two[1].1;
    let mut shared: Vec<(f32, u32, u32)> =
        edges.windows(2).filter(|two| joins(two)).map(|two| (length(two[0].0), two[0].1, two[1].1)).collect();
    drop(edges);
    shared.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut partners = vec![None; triangles.len()];
    for (_, first, second) in shared {
        if partners[first as usize].is_none() && partners[second as usize].is_none() {
            partners[first as usize] = Some(second);
            partners[second as usize] = Some(first);
        }
    }
    let all = (0..).zip(partners).map(|(first, second)| Pair { first, second });
    all.filter(|pair| pair.second.is_none_or(|second| pair.first < second)).collect()
}

impl Pair {
    pub fn faces(self) -> impl Iterator<Item = u32> {
        std::iter::once(self.first).chain(self.second)
    }

    pub fn bounds(self, triangles: &[[u32; 3]], positions: &[Vec3]) -> Bounds {
        let corners = self.faces().flat_map(|face| triangles[face as usize]).map(|corner| positions[corner as usize]);
        let nothing = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
        corners.fold(nothing, |all, corner| Bounds { min: all.min.min(corner), max: all.max.max(corner) })
    }

    /// The pair in the layout of the kernels. The mesh's faces are numbered from `first_face` on.
    pub fn laid_out(self, triangles: &[[u32; 3]], positions: &[Vec3], first_face: u32) -> FacePair {
        let first @ [a, b, c] = triangles[self.first as usize];
        let second = self.second.map_or(first, |face| triangles[face as usize]);
        let d = second.into_iter().find(|corner| !first.contains(corner)).unwrap_or(c);
        let four = [a, b, c, d];
        // All corners of the second face are among the four.
        let index = |corner| four.into_iter().position(|other| other == corner).unwrap_or_default() as u32;
        let code = |face: u32| primitive_code(KIND_TRIANGLE, first_face + face);
        let of_corner = |corner: u32, word: u32| {
            let [x, y, z] = positions[corner as usize].to_array().map(f32::to_bits);
            [x, y, z, word]
        };
        FacePair {
            a: of_corner(a, code(self.first)),
            b: of_corner(b, self.second.map_or(NO_FACE, code)),
            c: of_corner(c, index(second[0]) | index(second[1]) << 2 | index(second[2]) << 4),
            d: of_corner(d, 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of two squares, each of two triangles, with a triangle that shares no edge, one that is there twice, and one of two points.
    #[test]
    fn every_face_is_in_one_pair_with_its_corners() {
        let grid = |x: u32, y: u32| Vec3::new(x as f32, y as f32, 0.25 * (x * y) as f32);
        let mut positions: Vec<Vec3> = (0..6).map(|i| grid(i / 2, i % 2)).collect();
        positions.extend([Vec3::X * 9.0, Vec3::Y * 9.0, Vec3::Z * 9.0]);
        let triangles = [[0, 2, 1], [2, 3, 1], [5, 3, 2], [2, 4, 5], [6, 7, 8], [0, 1, 2], [0, 4, 0]];
        let pairs = pairs(&triangles, &positions);
        let mut seen = vec![0; triangles.len()];
        for pair in &pairs {
            let packed = pair.laid_out(&triangles, &positions, 100);
            let corner = |i: u32| {
                let [x, y, z, _] = [packed.a, packed.b, packed.c, packed.d][i as usize];
                Vec3::from_array([x, y, z].map(f32::from_bits))
            };
            let orders = [0x24, packed.c[3]];
            for ((face, code), order) in pair.faces().zip([packed.a[3], packed.b[3]]).zip(orders) {
                assert_eq!(code, primitive_code(KIND_TRIANGLE, 100 + face));
                let found = [0, 2, 4].map(|shift| corner(order >> shift & 3));
                assert_eq!(found, triangles[face as usize].map(|i| positions[i as usize]), "{pair:?}");
                seen[face as usize] += 1;
            }
            assert_eq!(packed.b[3] == NO_FACE, pair.second.is_none());
            let bounds = pair.bounds(&triangles, &positions);
            let inside = |p: Vec3| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
            assert!((0..4).all(|i| inside(corner(i))));
        }
        assert_eq!(seen, [1; 7]);
        // The diagonals of both squares join. The face that is there twice and the one of two points are alone.
        assert!(pairs.contains(&Pair { first: 2, second: Some(3) }), "{pairs:?}");
        assert!(pairs.contains(&Pair { first: 4, second: None }), "{pairs:?}");
        assert_eq!(pairs.len(), 5, "{pairs:?}");
    }
}
