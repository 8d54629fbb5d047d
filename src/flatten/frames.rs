//! Where textured things stand in their textures.

use glam::{DMat3, DVec3};

use super::place::{Aabb, Shape};

/// The place of a shape's own coordinates in the object's own space: base + columns · local.
pub fn local_to_object(shape: &Shape, rotation: &DMat3, boxes: &[Aabb]) -> (DVec3, DMat3) {
    match *shape {
        // A sphere's own coordinates are its normal in the world.
        Shape::Sphere { center, radius } => (center, rotation.transpose() * radius),
        Shape::Quad { corner, u, v } => (corner, DMat3::from_cols(u, v, DVec3::ZERO)),
        Shape::Cuboid { min, max } => (min, DMat3::from_diagonal(max - min)),
        Shape::Mesh(mesh) => (boxes[mesh].center(), DMat3::from_diagonal(DVec3::splat(boxes[mesh].unit()))),
    }
}
