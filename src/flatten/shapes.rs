//! Shapes as the kernels read them, in render space, each with the bound of its rounding.

use glam::{DVec3, Vec3};

use super::Builder;
use super::frames::local_to_object;
use super::place::{Aabb, Placed, Shape};
use super::similarity::Similarity;
use crate::bvh::Bounds;
use crate::data::{self, f32s};

impl Builder<'_> {
    /// Adds a primitive; the result is its code and its bounds.
    pub fn add_primitive(&mut self, primitive: &Placed, order: u32) -> (u32, Bounds) {
        let Placed { shape, to_world, material } = primitive;
        let frame = self.frame_of(primitive);
        let material = self.materials[*material as usize];
        let (index, bounds) = self.add_shape(shape, to_world, order, material, frame);
        (shape.code(index), bounds)
    }

    /// Adds a shape that is part of the scene, or the boundary of a medium; the result is its index among its kind.
    pub fn add_shape(
        &mut self,
        shape: &Shape,
        to_world: &Similarity,
        order: u32,
        material: u32,
        frame: u32,
    ) -> (usize, Bounds) {
        let space = self.space;
        let vector = |v: DVec3| to_world.vector(v) * space.scale;
        match *shape {
            Shape::Sphere { center, radius } => {
                let center = space.point(to_world.point(center)).as_vec3();
                let radius = (to_world.scale * radius * space.scale) as f32;
                let bounds = padded(center - radius, center + radius, error_bound(&[center, Vec3::splat(radius)]));
                self.flat.spheres.push(data::Sphere {
                    center: center.to_array(),
                    radius,
                    order,
                    material,
                    frame,
                    light: 0,
                });
                (self.flat.spheres.len() - 1, bounds)
            }
            Shape::Quad { corner, u, v } => {
                let corner = space.point(to_world.point(corner));
                let (u, v) = (vector(u), vector(v));
                let (normal, a_axis, b_axis) = quad_axes(u, v);
                let around = Aabb::around([corner, corner + u, corner + v, corner + u + v]);
                let error = error_bound(&[corner.as_vec3(), u.as_vec3(), v.as_vec3()]);
                let error_across = error_across(corner.as_vec3(), u.as_vec3(), v.as_vec3(), normal);
                let bounds = padded(around.min.as_vec3(), around.max.as_vec3(), error);
                self.flat.quads.push(data::Quad {
                    corner: f32s(corner),
                    order,
                    normal: f32s(normal),
                    material,
                    a_axis: f32s(a_axis),
                    frame,
                    light: 0,
                    b_axis: f32s(b_axis),
                    error,
                    u: f32s(u),
                    v: f32s(v),
                    error_across,
                });
                (self.flat.quads.len() - 1, bounds)
            }
            Shape::Cuboid { min, max } => {
                let center = space.point(to_world.point(0.5 * (min + max))).as_vec3();
                let half = (0.5 * (max - min) * to_world.scale * space.scale).as_vec3();
                let axes = to_world.rotation;
                let reach = half.x * axes.x_axis.as_vec3().abs()
                    + half.y * axes.y_axis.as_vec3().abs()
                    + half.z * axes.z_axis.as_vec3().abs();
                let error = error_bound(&[center, Vec3::splat(half.x + half.y + half.z)]);
                let bounds = padded(center - reach, center + reach, error);
                self.flat.cuboids.push(data::Cuboid {
                    center: center.to_array(),
                    order,
                    half_extent: half.to_array(),
                    material,
                    x_axis: f32s(axes.x_axis),
                    frame,
                    y_axis: f32s(axes.y_axis),
                    light: 0,
                });
                (self.flat.cuboids.len() - 1, bounds)
            }
            Shape::Mesh(mesh) => self.add_instance(mesh, to_world, order, material, frame),
        }
    }

    /// The index of the first frame of a primitive, which has one for each texture of its material; 0 where it needs none.
    fn frame_of(&mut self, primitive: &Placed) -> u32 {
        let Placed { shape, to_world, material } = primitive;
        let textures = &self.textures[*material as usize];
        if textures.is_empty() {
            return 0;
        }
        // All instances of a mesh stand alike in a texture, for it is evaluated in the mesh's own space.
        let shared = match shape {
            Shape::Mesh(mesh) => Some((*mesh, *material)),
            _ => None,
        };
        if let Some(&frame) = shared.and_then(|key| self.mesh_frames.get(&key)) {
            return frame;
        }
        let place = local_to_object(shape, &to_world.rotation, self.boxes);
        let index = self.flat.frames.len() as u32;
        self.flat.frames.extend(textures.iter().filter_map(|texture| texture.frame(place, &to_world.rotation)));
        if let Some(key) = shared {
            self.mesh_frames.insert(key, index);
        }
        index
    }
}

/// A bound of the rounding of a point that is a sum of such vectors, and of the tests made with it: eight roundings of
/// the largest coordinates that can occur on the way.
pub fn error_bound(summands: &[Vec3]) -> f32 {
    const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;
    8.0 * UNIT_ROUNDOFF * summands.iter().map(|v| v.abs().max_element()).sum::<f32>()
}

/// A bound of the rounding of a quad's point along its normal, and of the next distance's from there. Own derivation, in units of
/// roundoff, each component as often as the normal has it: `u` and `v` are rounded, multiplied, added, and added to the corner (4 of both
/// and 1 of the corner); the next difference, its product with a rounded normal, and two sums (5 of both). One more of the corner for what
/// the sum of both does to a last digit. A floor has nothing of its length in it: its normal has nothing along that.
fn error_across(corner: Vec3, u: Vec3, v: Vec3, normal: DVec3) -> f32 {
    let reach = 2.0 * corner.abs() + 10.0 * (u.abs() + v.abs());
    (0.5 * f32::EPSILON) * normal.as_vec3().abs().dot(reach)
}

pub fn padded(min: Vec3, max: Vec3, by: f32) -> Bounds {
    Bounds { min: min - by, max: max + by }
}

/// The unit normal u × v, and the vectors whose products with a point's offset from the corner are the point's a and b.
/// Computed on u and v scaled to unit length, so that neither tiny nor needle-like quads lose digits.
fn quad_axes(u: DVec3, v: DVec3) -> (DVec3, DVec3, DVec3) {
    let (u_length, v_length) = (u.length(), v.length());
    let (u, v) = (u / u_length, v / v_length);
    let n = u.cross(v);
    let w = n / n.length_squared();
    (n.normalize(), v.cross(w) / u_length, w.cross(u) / v_length)
}
