//! A sphere that is large against its distance from the camera, such as a ground or a planet.
//!
//! In f32, its centre and radius would be rounded by a visible part of that distance. So the kernels get its point nearest to the
//! camera, the normal there and the curvature, which keep their digits near the camera whatever the radius is. Scene files
//! write a sphere; the host chooses the form (`Shape::seen_from`).

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::geometry::{Boundary, Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::similarity::Similarity;
use super::space::{ObjectTransform, error_bound, padded};
use super::sphere::{self, Sphere};
use crate::data::{self, Tables, f32s};
use crate::error::Result;
use crate::source::ValuePath;

pub const KIND: ShapeKind = ShapeKind {
    name: None,
    shader: "large_sphere",
    word: sphere::KIND.word,
    sizes: sphere::KIND.sizes,
    table: table!(large_spheres of data::LargeSphere, light, "spheres that are large against their distance from the camera"),
    boundary: Some(Boundary { name: "large_sphere", is_convex: true, words: "a" }),
    covered: 1.0,
    has_parts: false,
};

/// A sphere is a large sphere if its radius is more than this many times its distance from the camera. As `data::Sphere`, its
/// surface would be off by 8 u of the radius (shaders/geometry/sphere), which is 2^-11 of the distance at this limit:
/// less than half a pixel of an image that is a thousand pixels wide.
const LEAST_RADIUS: f64 = 1024.0;

/// The largest radius in units of render space. Areas of boxes around such large spheres, multiplied by numbers of primitives,
/// are within the range of f32.
const LARGEST_RADIUS: f64 = (1u64 << 48) as f64;

/// In the sphere's own space.
#[derive(Clone, Copy)]
pub struct LargeSphere {
    sphere: Sphere,
    eye: DVec3,
    /// The unit vector from the eye to the centre: the inward normal at the point nearest to the eye.
    inward: DVec3,
    /// The distance from the eye to that point; negative if the eye is inside.
    height: f64,
}

impl LargeSphere {
    /// The sphere as a large sphere, if it is large enough.
    pub fn new(sphere: Sphere, to_world: &Similarity, eye: DVec3) -> Option<LargeSphere> {
        let Sphere { center, radius } = sphere;
        // The eye in the sphere's own space, and the rest that its rounding leaves.
        let (moved, rest) = difference(eye, to_world.translation);
        let own = |v: DVec3| to_world.rotation.transpose() * v / to_world.scale;
        let (eye, eye_rest) = (own(moved), own(rest));
        let (to_center, rest) = difference(center, eye);
        // Most spheres are far from the limit.
        if radius < 0.5 * LEAST_RADIUS * (to_center.length() - radius).abs() {
            return None;
        }
        // D² - r² keeps the digits that D - r would lose: a ground of 1e12 is known to 1e-4 by its centre's distance in f64.
        let power = difference_of_squares(to_center, rest - eye_rest, radius);
        let height = power / (to_center.length() + radius);
        let inward = to_center.normalize_or_zero();
        (radius > LEAST_RADIUS * height.abs()).then_some(LargeSphere { sphere, eye, inward, height })
    }

    /// From the eye to the nearest point, in the world.
    fn offset(&self, to_world: &Similarity) -> DVec3 {
        to_world.vector(self.height * self.inward)
    }

    /// The point nearest to the eye, in the world.
    pub fn nearest(&self, to_world: &Similarity, eye: DVec3) -> DVec3 {
        eye + self.offset(to_world)
    }

    /// The unit normal at that point, in the sphere's own space.
    pub fn outward(&self) -> DVec3 {
        -self.inward
    }

    /// The distance from the eye to that point in the world, but at least so much that render space can hold the radius.
    pub fn extent(&self, to_world: &Similarity) -> f64 {
        to_world.scale * self.height.abs().max(self.sphere.radius / LARGEST_RADIUS)
    }

    /// The distance from the eye to that point in the world.
    pub fn distance(&self, to_world: &Similarity) -> f64 {
        to_world.scale * self.height.abs()
    }
}

impl Geometry for LargeSphere {
    fn check(&self, _: &ValuePath) -> Result<()> {
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        self.sphere.span()
    }

    /// The coordinates of a large sphere's point are its offset from the nearest point, in radii.
    fn texture_frame(&self, rotation: &DMat3) -> (DVec3, DMat3) {
        (self.eye + self.height * self.inward, rotation.transpose() * self.sphere.radius)
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let inward = at.to_world.rotation * self.inward;
        let nearest = at.space.scale * self.offset(at.to_world);
        let radius = at.scale() * self.sphere.radius;
        let Element { order, material, frame, .. } = element;
        tables.large_spheres.push(data::LargeSphere {
            nearest: f32s(nearest),
            curvature: (1.0 / radius) as f32,
            inward: f32s(inward),
            order,
            material,
            frame,
            light: 0,
            follows_nearest: 0,
        });
        let (center, radius) = ((nearest + radius * inward).as_vec3(), radius as f32);
        padded(center - radius, center + radius, error_bound(&[center, Vec3::splat(radius)]))
    }

    fn emitters(&self, at: &ObjectTransform, _: u32, code: u32, _: MeshLayout) -> Vec<Emitter> {
        vec![self.sphere.emitter(at, code)]
    }

    fn faces(&self, _: &ObjectTransform, _: u32, _: &mut dyn FnMut(&[DVec3])) {}

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        self.sphere.bounding_shape(at)
    }
}

/// a - b, rounded, and the rounding error, exactly (Knuth, TAOCP 2, section 4.2.2, theorem B).
fn difference(a: DVec3, b: DVec3) -> (DVec3, DVec3) {
    let rounded = a - b;
    let of_b = rounded - a;
    (rounded, (a - (rounded - of_b)) - (b + of_b))
}

/// |d + rest|² - r², with a small `rest`. The products and sums are exact (Ogita, Rump and Oishi, "Accurate sum and dot
/// product", SIAM J. Sci. Comput. 26(6), 2005); what is rounded is the sum of their errors.
fn difference_of_squares(d: DVec3, rest: DVec3, r: f64) -> f64 {
    let mut sum = 0.0;
    let mut errors = 2.0 * d.dot(rest);
    for (x, sign) in [(d.x, 1.0), (d.y, 1.0), (d.z, 1.0), (r, -1.0)] {
        let square = sign * x * x;
        errors += (sign * x).mul_add(x, -square);
        let before: f64 = sum;
        sum += square;
        let added = sum - before;
        errors += (before - (sum - added)) + (square - added);
    }
    sum + errors
}

#[cfg(test)]
mod tests {
    use super::*;

    fn height(center: DVec3, radius: f64, to_world: &Similarity, eye: DVec3) -> f64 {
        let large_sphere = LargeSphere::new(Sphere { center, radius }, to_world, eye).expect("it is large");
        to_world.scale * large_sphere.height
    }

    #[test]
    fn a_huge_ground_is_known_to_the_last_digits_of_the_height() {
        let eye = DVec3::new(3.0, 1.3, -4.0);
        for exponent in 4..=15 {
            let radius = 10f64.powi(exponent);
            let ground = -radius * DVec3::Y;
            // |eye - centre| - r, without its cancellation.
            let power = 25.0 + 1.3 * (1.3 + 2.0 * radius);
            let expected = power / ((power + radius * radius).sqrt() + radius);
            let lowered = Similarity::translation(ground);
            let turned = Similarity::rotation(DVec3::X, 30.0);
            let scaled = Similarity { scale: 3.0, ..turned };
            for (to_world, center, eye) in [
                (Similarity::IDENTITY, ground, eye),
                (lowered, DVec3::ZERO, eye),
                (turned, ground, turned.point(eye)),
                (scaled, ground, scaled.point(eye)),
            ] {
                let found = height(center, radius, &to_world, eye) / to_world.scale;
                assert!((found / expected - 1.0).abs() < 1e-14, "1e{exponent}: {found} for {expected}");
            }
            // The plain difference is no such height.
            let plain = (ground - eye).length() - radius;
            assert!(exponent < 8 || (plain / expected - 1.0).abs() > 1e-14, "1e{exponent}: {plain}");
        }
    }

    #[test]
    fn the_radius_over_the_height_decides() {
        let is_large_sphere = |radius: f64, height: f64| {
            let sphere = Sphere { center: -(radius + height) * DVec3::Y, radius };
            LargeSphere::new(sphere, &Similarity::IDENTITY, DVec3::ZERO).is_some()
        };
        assert!(is_large_sphere(1025.0, 1.0) && is_large_sphere(1025.0, -1.0) && is_large_sphere(1.0, 0.0));
        assert!(!is_large_sphere(1023.0, 1.0) && !is_large_sphere(1023.0, -1.0));
    }
}
