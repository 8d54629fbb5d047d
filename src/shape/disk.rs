//! A disk. Kernels get it as the square around it.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::geometry::{Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::quad::Quad;
use super::space::{Aabb, ObjectTransform, padded};
use crate::data::{self, Tables};
use crate::error::Result;
use crate::source::{SMALLEST, ValuePath, parallel};

pub const KIND: ShapeKind = ShapeKind {
    name: Some("Disk"),
    shader: "disk",
    word: "disk",
    sizes: &[("a diameter", "radius")],
    table: table!(disks of data::Quad, light, "disks"),
    boundary: None,
    // The square inside.
    covered: FRAC_1_SQRT_2,
    has_parts: true,
};

#[derive(Clone, Copy)]
pub struct Disk {
    pub center: DVec3,
    /// Of any length but 0.
    pub normal: DVec3,
    pub radius: f64,
}

impl Disk {
    /// The square around it, along the axes of its texture coordinates.
    pub fn square(&self) -> Quad {
        let normal = self.normal.normalize();
        let up = if parallel(normal, DVec3::Y) { DVec3::NEG_Z } else { DVec3::Y.reject_from_normalized(normal) };
        let v = self.radius * up.normalize();
        let u = v.cross(normal);
        Quad { corner: self.center - u - v, u: 2.0 * u, v: 2.0 * v }
    }

    /// The box around it in render space.
    fn bounds(&self, at: &ObjectTransform) -> Aabb {
        let (center, normal) = (at.point(self.center), at.to_world.vector(self.normal).normalize());
        let extent = self.radius * at.scale() * (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt);
        Aabb { min: center - extent, max: center + extent }
    }
}

impl Geometry for Disk {
    fn check(&self, at: &ValuePath) -> Result<()> {
        if self.normal.length() < SMALLEST {
            let message = "the normal has no length: expected a direction such as (0, 1, 0)";
            return Err(at.field("normal").error(message));
        }
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        (self.radius, self.center.length() + self.radius)
    }

    fn texture_frame(&self, rotation: &DMat3) -> (DVec3, DMat3) {
        self.square().texture_frame(rotation)
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let square = self.square().on_device(at, element);
        let bounds = self.bounds(at);
        tables.disks.push(square);
        padded(bounds.min.as_vec3(), bounds.max.as_vec3(), square.error)
    }

    fn emitters(&self, at: &ObjectTransform, _: u32, code: u32, _: MeshLayout) -> Vec<Emitter> {
        let area = PI * (self.radius * at.scale()).powi(2);
        vec![Emitter::of_body(code, area, self.bounds(at), Some(at.to_world.vector(self.normal)))]
    }

    fn faces(&self, at: &ObjectTransform, corners: u32, add: &mut dyn FnMut(&[DVec3])) {
        let normal = at.to_world.vector(self.normal).normalize_or_zero();
        add(&self::corners(at.point(self.center), normal, self.radius * at.scale(), corners));
    }

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        self.square().bounding_shape(at)
    }
}

/// The corners of a polygon in the place of a disk, with its area.
pub(super) fn corners(center: DVec3, normal: DVec3, radius: f64, count: u32) -> Vec<DVec3> {
    let (u, v) = normal.any_orthonormal_pair();
    let turn = 2.0 * PI / f64::from(count);
    let radius = radius * (turn / turn.sin()).sqrt();
    let corner = |i: u32| {
        let (sine, cosine) = (turn * f64::from(i)).sin_cos();
        center + radius * (cosine * u + sine * v)
    };
    (0..count).map(corner).collect()
}
