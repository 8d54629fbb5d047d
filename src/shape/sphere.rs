//! A sphere.

use std::f64::consts::PI;

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::disk;
use super::geometry::{Boundary, Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::space::{Aabb, ObjectTransform, error_bound, padded};
use crate::data::{self, Tables};
use crate::error::Result;
use crate::source::ValuePath;

pub const KIND: ShapeKind = ShapeKind {
    name: Some("Sphere"),
    shader: "sphere",
    word: "sphere",
    sizes: &[("a radius", "radius")],
    table: table!(spheres of data::Sphere, light, "spheres"),
    boundary: Some(Boundary { name: "sphere", is_convex: true, words: "a" }),
    covered: 1.0,
    has_parts: false,
};

#[derive(Clone, Copy)]
pub struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

impl Sphere {
    /// As a light with this code.
    pub fn emitter(&self, at: &ObjectTransform, code: u32) -> Emitter {
        let (middle, radius) = (at.point(self.center), self.radius * at.scale());
        let extent = DVec3::splat(radius);
        let area = 4.0 * PI * radius.powi(2);
        let around = Aabb::around([middle - extent, middle + extent]);
        Emitter::of_body(code, area, around, None)
    }
}

impl Geometry for Sphere {
    fn check(&self, _: &ValuePath) -> Result<()> {
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        (self.radius, self.center.length() + self.radius)
    }

    /// The texture coordinates of a sphere's point are the components of its normal in the world.
    fn texture_frame(&self, rotation: &DMat3) -> (DVec3, DMat3) {
        (self.center, rotation.transpose() * self.radius)
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let center = at.point(self.center).as_vec3();
        let radius = (at.to_world.scale * self.radius * at.space.scale) as f32;
        let Element { order, material, frame, .. } = element;
        tables.spheres.push(data::Sphere { center: center.to_array(), radius, order, material, frame, light: 0 });
        padded(center - radius, center + radius, error_bound(&[center, Vec3::splat(radius)]))
    }

    fn emitters(&self, at: &ObjectTransform, _: u32, code: u32, _: MeshLayout) -> Vec<Emitter> {
        vec![self.emitter(at, code)]
    }

    /// The disk within the circle at which lines from the origin touch the sphere.
    fn faces(&self, at: &ObjectTransform, corners: u32, add: &mut dyn FnMut(&[DVec3])) {
        let (center, radius) = (at.point(self.center), at.scale() * self.radius);
        let sine = radius / center.length();
        if sine < 1.0 {
            let cosine = (1.0 - sine * sine).sqrt();
            add(&disk::corners((center * cosine) * cosine, -center.normalize_or_zero(), radius * cosine, corners));
        }
    }

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        BoundingShape::Ball { center: at.point(self.center), radius: at.scale() * self.radius }
    }
}
