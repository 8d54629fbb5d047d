//! A box along the axes of its own space. Code calls it a cuboid, because `Box` has another meaning in Rust.

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::geometry::{Boundary, Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::space::{Aabb, ObjectTransform, error_bound, padded};
use crate::data::{self, Tables, f32s};
use crate::error::Result;
use crate::source::{SMALLEST, ValuePath};

pub const KIND: ShapeKind = ShapeKind {
    name: Some("Box"),
    shader: "cuboid",
    word: "box",
    sizes: &[("a side", "")],
    table: table!(cuboids of data::Cuboid, light, "boxes"),
    boundary: Some(Boundary { name: "cuboid", is_convex: true, words: "a" }),
    covered: 1.0,
    has_parts: false,
};

#[derive(Clone, Copy)]
pub struct Cuboid {
    pub min: DVec3,
    pub max: DVec3,
}

impl Cuboid {
    fn middle(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }
}

impl Geometry for Cuboid {
    fn check(&self, at: &ValuePath) -> Result<()> {
        let Cuboid { min, max } = *self;
        for (axis, (low, high)) in ["x", "y", "z"].into_iter().zip(min.to_array().into_iter().zip(max.to_array())) {
            if high - low < SMALLEST {
                let message =
                    format!("the box has no extent along {axis}: expected min below max, found {low:?} and {high:?}");
                return Err(at.error(message));
            }
        }
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        ((self.max - self.min).min_element(), self.min.length().max(self.max.length()))
    }

    fn texture_frame(&self, _: &DMat3) -> (DVec3, DMat3) {
        (self.min, DMat3::from_diagonal(self.max - self.min))
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let center = at.point(self.middle()).as_vec3();
        let half = (0.5 * (self.max - self.min) * at.to_world.scale * at.space.scale).as_vec3();
        let axes = at.to_world.rotation;
        let extent = half.x * axes.x_axis.as_vec3().abs()
            + half.y * axes.y_axis.as_vec3().abs()
            + half.z * axes.z_axis.as_vec3().abs();
        let error = error_bound(&[center, Vec3::splat(half.x + half.y + half.z)]);
        tables.cuboids.push(data::Cuboid {
            center: center.to_array(),
            order: element.order,
            half_extent: half.to_array(),
            material: element.material,
            x_axis: f32s(axes.x_axis),
            frame: element.frame,
            y_axis: f32s(axes.y_axis),
            light: 0,
        });
        padded(center - extent, center + extent, error)
    }

    fn emitters(&self, at: &ObjectTransform, _: u32, code: u32, _: MeshLayout) -> Vec<Emitter> {
        let Cuboid { min, max } = *self;
        let d = (max - min) * at.scale();
        let around = Aabb::around(Aabb { min, max }.corners().map(|p| at.point(p)));
        vec![Emitter::of_body(code, 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x), around, None)]
    }

    fn faces(&self, at: &ObjectTransform, _: u32, add: &mut dyn FnMut(&[DVec3])) {
        // The bits of a corner's number are its coordinates.
        let corners = Aabb { min: self.min, max: self.max }.corners().map(|p| at.point(p));
        const FACES: [[usize; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        FACES.iter().for_each(|face| add(&face.map(|corner| corners[corner])));
    }

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        let half = 0.5 * at.scale() * (self.max - self.min);
        BoundingShape::Cuboid { center: at.point(self.middle()), half, axes: at.to_world.rotation }
    }
}
