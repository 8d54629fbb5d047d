//! Simple bounding volumes of shapes, for the warnings about sizes and distances.

use glam::{DMat3, DVec3};

use super::space::Aabb;

/// A simple bounding volume of a transformed shape.
#[derive(Clone, Copy)]
pub enum BoundingShape {
    Ball { center: DVec3, radius: f64 },
    Parallelogram { corner: DVec3, u: DVec3, v: DVec3 },
    Cuboid { center: DVec3, half: DVec3, axes: DMat3 },
}

impl BoundingShape {
    /// The centre of a ball or box; the corner of a parallelogram.
    pub fn position(&self) -> DVec3 {
        match *self {
            BoundingShape::Ball { center, .. } | BoundingShape::Cuboid { center, .. } => center,
            BoundingShape::Parallelogram { corner, .. } => corner,
        }
    }

    /// The centre and the radius of a ball around it.
    pub fn ball(&self) -> (DVec3, f64) {
        match *self {
            BoundingShape::Ball { center, radius } => (center, radius),
            BoundingShape::Parallelogram { corner, u, v } => {
                (corner + 0.5 * (u + v), 0.5 * (u + v).length().max((u - v).length()))
            }
            BoundingShape::Cuboid { center, half, .. } => (center, half.length()),
        }
    }

    /// The distance of a point from its surface, or less.
    pub fn distance(&self, p: DVec3) -> f64 {
        match *self {
            BoundingShape::Ball { center, radius } => ((p - center).length() - radius).abs(),
            BoundingShape::Parallelogram { corner, u, v } => {
                let (n, q) = (normal(u, v), p - corner);
                // Beside it, the ball around it is nearer than it is.
                let (middle, radius) = self.ball();
                n.dot(q).abs().max((p - middle).length() - radius)
            }
            BoundingShape::Cuboid { center, half, axes } => {
                let beyond = (axes.transpose() * (p - center)).abs() - half;
                match beyond.max_element() <= 0.0 {
                    true => -beyond.max_element(),
                    false => beyond.max(DVec3::ZERO).length(),
                }
            }
        }
    }

    /// The corners; a ball has none.
    pub fn corners(&self) -> Vec<DVec3> {
        match *self {
            BoundingShape::Ball { .. } => Vec::new(),
            BoundingShape::Parallelogram { corner, u, v } => vec![corner, corner + u, corner + u + v, corner + v],
            BoundingShape::Cuboid { center, half, axes } => {
                Aabb { min: -half, max: half }.corners().map(|p| center + axes * p).into()
            }
        }
    }

    /// The box around it along the axes.
    pub fn bounds(&self) -> Aabb {
        let (center, extent) = match *self {
            BoundingShape::Ball { center, radius } => (center, DVec3::splat(radius)),
            BoundingShape::Parallelogram { corner, u, v } => (corner + 0.5 * (u + v), 0.5 * (u.abs() + v.abs())),
            BoundingShape::Cuboid { center, half, axes } => (center, half_extent_of(half, &axes)),
        };
        Aabb { min: center - extent, max: center + extent }
    }
}

impl From<Aabb> for BoundingShape {
    fn from(around: Aabb) -> BoundingShape {
        let half = 0.5 * (around.max - around.min);
        BoundingShape::Cuboid { center: around.center(), half, axes: DMat3::IDENTITY }
    }
}

/// Half the extent of a rotated box along each axis of space.
pub fn half_extent_of(half: DVec3, axes: &DMat3) -> DVec3 {
    half.x * axes.x_axis.abs() + half.y * axes.y_axis.abs() + half.z * axes.z_axis.abs()
}

/// The unit normal of a parallelogram. It is accurate however large or small the edges are.
pub fn normal(u: DVec3, v: DVec3) -> DVec3 {
    u.normalize_or_zero().cross(v.normalize_or_zero()).normalize_or_zero()
}
