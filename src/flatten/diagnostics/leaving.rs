//! The offset of rays: how far from a surface the rays that leave it start. They miss anything that is closer to the surface.
//!
//! The kernels move a point off its surface by a bound of its rounding error, and then move each coordinate to the next float
//! (shaders/geometry/offset). The next float is at most 2 u of the coordinate p_i away, which is 2 u |n_i p_i| along the normal n.
//! Positions are relative to the camera.

use glam::{DMat3, DVec3};

use super::U;
use crate::shape::reach_of;

/// From a quad with the corner Q: the bound is u Σ |n_i| (2 |Q_i| + 10 |u_i| + 10 |v_i|), and no coordinate is larger than
/// |Q_i| + |u_i| + |v_i|.
pub fn from_quad(normal: DVec3, corner: DVec3, u: DVec3, v: DVec3) -> f64 {
    U * normal.abs().dot(4.0 * corner.abs() + 12.0 * (u.abs() + v.abs()))
}

/// From a side of a box with the centre c: the bound is u Σ |n_i| (2 |c_i| + 12 h_i), where h is how far the half sides
/// reach along the axes of space. No coordinate is larger than |c_i| + h_i.
pub fn from_cuboid(normal: DVec3, middle: DVec3, half: DVec3, axes: &DMat3) -> f64 {
    U * normal.abs().dot(4.0 * middle.abs() + 14.0 * reach_of(half, axes))
}

/// From a sphere: the bound is 4 u (max |c_i| + r), and Σ |n_i p_i| is at most |c| + r on it (Cauchy-Schwarz).
pub fn from_sphere(center: DVec3, radius: f64) -> f64 {
    U * (4.0 * (center.abs().max_element() + radius) + 2.0 * (center.length() + radius))
}

/// From a large sphere, at points as far from the nearest one as the camera is. The bound is u (|n|.(|p| + 9 |x|)), without the
/// curvature, with |x| and |p| the distance (shaders/geometry/large_sphere), and no coordinate is larger than twice that.
pub fn from_large_sphere(distance: f64) -> f64 {
    U * 14.0 * distance
}

/// From a mesh whose triangles are not needles. The bound is u (8 Σ |p_i| + 32 l) for a triangle with a longest edge l, and 16 u Σ |p_i|
/// for the position of the instance, with p relative to the centre of the mesh (shaders/geometry/triangle, shaders/geometry/instance).
/// |p_i| is at most the half side of the box around the mesh, and l at most its diagonal.
pub fn from_mesh(middle: DVec3, half: DVec3) -> f64 {
    U * (24.0 * half.element_sum() + 66.0 * half.length() + 2.0 * middle.length())
}
