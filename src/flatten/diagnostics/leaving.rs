//! How far from a surface rays start that leave it. What is nearer to it than that, they do not meet.
//!
//! The kernels move a point off its surface by a bound of its rounding, and each coordinate one float further
//! (shaders/geometry/offset). A float further is 2 u of the coordinate at most, along the normal n as often as that has it. Places are seen from
//! the camera.

use glam::{DMat3, DVec3};

use super::U;
use crate::shape::reach_of;

/// From a quad: the bound is u Σ |n_i| (2 |Q_i| + 10 |u_i| + 10 |v_i|), Q the corner, and no coordinate is larger than |Q_i| + |u_i| + |v_i|.
pub fn from_quad(normal: DVec3, corner: DVec3, u: DVec3, v: DVec3) -> f64 {
    U * normal.abs().dot(4.0 * corner.abs() + 12.0 * (u.abs() + v.abs()))
}

/// From a side of a box: u Σ |n_i| (2 |c_i| + 12 h_i), c the middle and h what the half sides reach along the axes of space, and no coordinate is
/// larger than |c_i| + h_i.
pub fn from_cuboid(normal: DVec3, middle: DVec3, half: DVec3, axes: &DMat3) -> f64 {
    U * normal.abs().dot(4.0 * middle.abs() + 14.0 * reach_of(half, axes))
}

/// From a sphere: 4 u (max |c_i| + r), and Σ |n_i p_i| is no more than |c| + r on it (Cauchy and Schwarz).
pub fn from_sphere(center: DVec3, radius: f64) -> f64 {
    U * (4.0 * (center.abs().max_element() + radius) + 2.0 * (center.length() + radius))
}

/// From a mesh with triangles of usual shapes: u (8 Σ |p_i| + 32 l) for a triangle with a longest edge l, and 16 u Σ |p_i| for its place, p seen from
/// the middle of the mesh (shaders/geometry/triangle, shaders/geometry/instance). No larger than the half sides and the diagonal of the box around it.
pub fn from_mesh(middle: DVec3, half: DVec3) -> f64 {
    U * (24.0 * half.element_sum() + 66.0 * half.length() + 2.0 * middle.length())
}
