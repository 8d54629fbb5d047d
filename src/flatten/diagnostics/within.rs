//! The depth of a point within a closed shape.

use std::f64::consts::PI;

use glam::DVec3;

use super::search::Body;
use crate::shape::BoundingShape;
use crate::shape::mesh::MeshShape;

/// The limit on triangles that are tested, over all queries.
const MOST_TRIANGLES: usize = 1 << 19;

/// Computes depths of points within spheres, boxes and closed meshes.
pub struct Within {
    /// Triangles that may still be tested.
    left: usize,
}

impl Default for Within {
    fn default() -> Self {
        Within { left: MOST_TRIANGLES }
    }
}

impl Within {
    /// A lower bound of the depth of a point within a sphere, box or closed mesh. Outside it is negative, and at most
    /// the distance in magnitude. None for shapes that are not closed, and for a mesh once the limit on triangles is
    /// reached.
    pub fn depth(&mut self, wall: &Body, p: DVec3) -> Option<f64> {
        let by_bounds = match wall.bounds {
            BoundingShape::Ball { center, radius } => radius - p.distance(center),
            BoundingShape::Cuboid { center, half, axes } => {
                (half - (axes.transpose() * (p - center)).abs()).min_element()
            }
            BoundingShape::Parallelogram { .. } => return None,
        };
        match wall.shape.mesh() {
            Some(mesh) if by_bounds > 0.0 => self.depth_in_mesh(mesh, wall, p),
            _ => Some(by_bounds),
        }
    }

    fn depth_in_mesh(&mut self, shape: &MeshShape, wall: &Body, p: DVec3) -> Option<f64> {
        let mesh = shape.mesh;
        self.left = self.left.checked_sub(mesh.triangles.len())?;
        if shape.open_edges().is_some() {
            return None;
        }
        let to_own = wall.to_world.rotation.transpose();
        let p = shape.around.center() + to_own * (p - wall.position) / wall.to_world.scale;
        let (mut angle, mut nearest) = (0.0, f64::INFINITY);
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|corner| mesh.positions.get(corner as usize).copied().unwrap_or(p) - p);
            angle += solid_angle(a, b, c);
            nearest = nearest.min(distance_squared(a, b, c));
        }
        let distance = wall.to_world.scale * nearest.sqrt();
        Some(if angle.abs() > 2.0 * PI { distance } else { -distance })
    }
}

/// Whether the front of a closed light is its outside. It is not for a mesh that is wound the other way.
pub fn is_outside_in_front(wall: &Body) -> bool {
    wall.shape.mesh().is_none_or(|shape| shape.mesh.volume_is_positive())
}

/// The solid angle of a triangle seen from the origin, positive if it looks clockwise from there (Van Oosterom and
/// Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983). Over a closed mesh they sum
/// to 4 π or -4 π inside, and to 0 outside.
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

/// The square of a triangle's distance from the origin (Ericson, Real-Time Collision Detection, section 5.1.5): the
/// distance to the plane if the origin projects into the triangle, else the least distance to an edge.
fn distance_squared(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let n = (b - a).cross(c - a);
    let within = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| n.dot((*q - *p).cross(-*p)) >= 0.0);
    let nn = n.length_squared();
    if within && nn > 0.0 {
        return n.dot(a).powi(2) / nn;
    }
    let edge = |p: DVec3, q: DVec3| {
        let along = q - p;
        let t = (-p.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (p + t * along).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_all_around_its_inside() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let angle = |p: DVec3| -> f64 {
            faces.iter().map(|face| face.map(|i: usize| corners[i] - p)).map(|[a, b, c]| solid_angle(a, b, c)).sum()
        };
        assert!((angle(DVec3::splat(0.2)) - 4.0 * std::f64::consts::PI).abs() < 1e-12);
        assert!(angle(DVec3::splat(0.4)).abs() < 1e-12);
    }

    #[test]
    fn the_distance_to_a_triangle_is_that_to_its_nearest_point() {
        let from = |p: DVec3| {
            let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|q| q - p);
            distance_squared(a, b, c).sqrt()
        };
        // Over its inside, beside an edge, and beyond a corner.
        for (p, distance) in [((0.2, 0.2, 3.0), 3.0), ((0.5, -2.0, 0.0), 2.0), ((4.0, -4.0, 0.0), 5.0)] {
            assert!((from(DVec3::from(p)) - distance).abs() < 1e-12, "{p:?}");
        }
        assert!(from(DVec3::new(0.2, 0.2, 0.0)) < 1e-12);
    }
}
