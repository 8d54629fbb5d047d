//! A quad: a parallelogram.

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::geometry::{Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::space::{Aabb, ObjectTransform, error_bound, padded};
use crate::data::{self, Tables, f32s};
use crate::error::Result;
use crate::source::{SMALLEST, ValuePath, parallel};

pub const KIND: ShapeKind = ShapeKind {
    name: Some("Quad"),
    shader: "quad",
    word: "quad",
    sizes: &[("an edge", "u"), ("an edge", "v")],
    table: table!(quads of data::Quad, light, "quads"),
    boundary: None,
    covered: 1.0,
    has_parts: true,
};

#[derive(Clone, Copy)]
pub struct Quad {
    pub corner: DVec3,
    pub u: DVec3,
    pub v: DVec3,
}

impl Quad {
    /// As kernels read it.
    pub(super) fn on_device(&self, at: &ObjectTransform, element: Element) -> data::Quad {
        let (corner, u, v) = (at.point(self.corner), at.vector(self.u), at.vector(self.v));
        let (normal, a_axis, b_axis) = quad_axes(u, v);
        data::Quad {
            corner: f32s(corner),
            order: element.order,
            normal: f32s(normal),
            material: element.material,
            a_axis: f32s(a_axis),
            frame: element.frame,
            light: 0,
            b_axis: f32s(b_axis),
            error: error_bound(&[corner.as_vec3(), u.as_vec3(), v.as_vec3()]),
            u: f32s(u),
            v: f32s(v),
            error_across: error_across(corner.as_vec3(), u.as_vec3(), v.as_vec3(), normal),
        }
    }
}

impl Geometry for Quad {
    fn check(&self, at: &ValuePath) -> Result<()> {
        for (name, edge) in [("u", self.u), ("v", self.v)] {
            if edge.length() < SMALLEST {
                return Err(at.field(name).error(format!("the quad has no extent along {name}")));
            }
        }
        if parallel(self.u, self.v) {
            return Err(at.error("the quad has no area: u and v are parallel"));
        }
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        let (u, v) = (self.u.length(), self.v.length());
        (u.min(v), self.corner.length() + u + v)
    }

    fn texture_frame(&self, _: &DMat3) -> (DVec3, DMat3) {
        (self.corner, DMat3::from_cols(self.u, self.v, DVec3::ZERO))
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let quad = self.on_device(at, element);
        let (corner, u, v) = (at.point(self.corner), at.vector(self.u), at.vector(self.v));
        let around = Aabb::around([corner, corner + u, corner + v, corner + u + v]);
        tables.quads.push(quad);
        padded(around.min.as_vec3(), around.max.as_vec3(), quad.error)
    }

    fn emitters(&self, at: &ObjectTransform, _: u32, code: u32, _: MeshLayout) -> Vec<Emitter> {
        let Quad { corner, u, v } = *self;
        let corners = [corner, corner + u, corner + v, corner + u + v];
        let area = u.cross(v).length() * at.scale() * at.scale();
        let normal = at.to_world.vector(u).cross(at.to_world.vector(v));
        vec![Emitter::of_body(code, area, Aabb::around(corners.map(|p| at.point(p))), Some(normal))]
    }

    fn faces(&self, at: &ObjectTransform, _: u32, add: &mut dyn FnMut(&[DVec3])) {
        let Quad { corner, u, v } = *self;
        add(&[corner, corner + u, corner + u + v, corner + v].map(|p| at.point(p)));
    }

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        BoundingShape::Parallelogram { corner: at.point(self.corner), u: at.vector(self.u), v: at.vector(self.v) }
    }
}

/// A bound of the rounding error, along the normal, of a point on a quad, and of the distance that the next ray from
/// there computes. Own derivation, in units of roundoff, with each component weighted by that of the normal. The point:
/// `u` and `v` are rounded, multiplied, added, and added to the corner (4 of both and 1 of the corner). The distance: a
/// difference, its product with a rounded normal, and two sums (5 of both). One more of the corner and of both for the
/// rounding of their sum. The length of a floor does not count, because its normal has no component along it.
fn error_across(corner: Vec3, u: Vec3, v: Vec3, normal: DVec3) -> f32 {
    let sum = 2.0 * corner.abs() + 10.0 * (u.abs() + v.abs());
    (0.5 * f32::EPSILON) * normal.as_vec3().abs().dot(sum)
}

/// The unit normal u × v, and two vectors whose dot products with a point's offset from the corner are the point's
/// coordinates a and b. Computed on u and v scaled to unit length, so that neither tiny nor needle-like quads lose
/// digits.
fn quad_axes(u: DVec3, v: DVec3) -> (DVec3, DVec3, DVec3) {
    let (u_length, v_length) = (u.length(), v.length());
    let (u, v) = (u / u_length, v / v_length);
    let n = u.cross(v);
    let w = n / n.length_squared();
    (n.normalize(), v.cross(w) / u_length, w.cross(u) / v_length)
}
