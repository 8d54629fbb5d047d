//! Transforms of objects to render space, and bounding boxes.

use glam::{DVec3, Vec3};

use super::similarity::Similarity;

/// A space with the camera at the origin and lengths scaled by a power of two.
#[derive(Clone, Copy)]
pub struct RenderSpace {
    pub eye: DVec3,
    pub scale: f64,
}

impl RenderSpace {
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.eye) * self.scale
    }
}

/// The transform from a shape's own space to render space, or (with a scale of 1) to a space with the world's lengths.
#[derive(Clone, Copy)]
pub struct ObjectTransform<'a> {
    pub to_world: &'a Similarity,
    pub space: RenderSpace,
}

impl ObjectTransform<'_> {
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.space.point(self.to_world.point(p))
    }

    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.to_world.vector(v) * self.space.scale
    }

    pub fn scale(&self) -> f64 {
        self.to_world.scale * self.space.scale
    }
}

/// A box whose sides are parallel to the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub min: DVec3,
    pub max: DVec3,
}

impl Aabb {
    /// The smallest one around points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        Aabb::around_all(points.into_iter().map(|p| Aabb { min: p, max: p }))
    }

    /// The smallest one around others.
    pub fn around_all(all: impl IntoIterator<Item = Aabb>) -> Aabb {
        let nothing = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        all.into_iter().fold(nothing, Aabb::union)
    }

    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Half the surface area.
    pub fn half_area(&self) -> f64 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }
}

/// A bound of the rounding error of a point that is a sum of such vectors, and of the tests made with it: eight
/// roundings of the largest intermediate coordinates.
pub fn error_bound(summands: &[Vec3]) -> f32 {
    const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;
    8.0 * UNIT_ROUNDOFF * summands.iter().map(|v| v.abs().max_element()).sum::<f32>()
}

pub fn padded(min: Vec3, max: Vec3, by: f32) -> (Vec3, Vec3) {
    (min - by, max + by)
}

/// The least e with x < 2^e, for a normal x > 0.
pub fn binary_exponent(x: f64) -> i32 {
    const BIAS: i32 = 1022;
    ((x.to_bits() >> 52) & 0x7ff) as i32 - BIAS
}

/// 2^e, exactly.
pub fn exp2(e: i32) -> f64 {
    2.0_f64.powi(e)
}
