//! The shapes: sphere, quad, box, mesh and disk, and the large sphere, which is a sphere to scene files; one file each.
//!
//! `shapes!` has the one list of them. Everything about a shape is a field of `ShapeKind` or a method of `Geometry`.

mod bounding_shape;
mod closed;
pub mod cuboid;
pub mod disk;
mod geometry;
pub mod large_sphere;
pub mod mesh;
pub mod quad;
pub mod similarity;
mod space;
pub mod sphere;

use std::ops::Deref;
use std::sync::LazyLock;

use glam::DVec3;

use crate::data::{KIND_DELTA_LIGHT, KIND_INSTANCE, KIND_TRIANGLE, primitive_code};
use crate::source::form::kinds;
pub use bounding_shape::{BoundingShape, half_extent_of, normal};
pub use cuboid::Cuboid;
pub use disk::Disk;
pub use geometry::{Element, Emitter, Geometry, MeshLayout, ShapeKind, Table};
pub use large_sphere::LargeSphere;
use mesh::MeshShape;
pub use quad::Quad;
use similarity::Similarity;
pub use space::{Aabb, ObjectTransform, RenderSpace, binary_exponent, error_bound, exp2, padded};
pub use sphere::Sphere;

/// Declares the shapes, each by its variant, its struct and its kind.
macro_rules! shapes {
    ($($variant:ident($shape:ty) => $kind:expr),* $(,)?) => {
        /// A shape in its own space.
        #[derive(Clone, Copy)]
        pub enum Shape<'a> {
            $($variant($shape)),*
        }

        kinds!(Shape<'_>: ShapeKind; $($variant => $kind),*);

        impl<'a> Deref for Shape<'a> {
            type Target = dyn Geometry + 'a;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Shape::$variant(shape) => shape),*
                }
            }
        }
    };
}

shapes! {
    Sphere(Sphere) => sphere::KIND,
    Quad(Quad) => quad::KIND,
    Cuboid(Cuboid) => cuboid::KIND,
    Mesh(&'a MeshShape<'a>) => mesh::KIND,
    LargeSphere(LargeSphere) => large_sphere::KIND,
    Disk(Disk) => disk::KIND,
}

/// The kinds of shape by number.
pub const KINDS: &[ShapeKind] = Shape::KINDS;

/// The names of those that scene files have.
pub fn kinds_in_files() -> impl Iterator<Item = (&'static str, &'static ShapeKind)> {
    KINDS.iter().filter_map(|kind| Some((kind.name?, kind)))
}

impl<'a> Shape<'a> {
    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<&'a MeshShape<'a>> {
        match self {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// The form in which kernels get it if the camera is at `eye`: a sphere may be a large sphere.
    pub fn seen_from(self, to_world: &Similarity, eye: DVec3) -> Shape<'a> {
        match self {
            Shape::Sphere(sphere) => LargeSphere::new(sphere, to_world, eye).map_or(self, Shape::LargeSphere),
            _ => self,
        }
    }

    /// The large sphere, if it is one.
    pub fn large_sphere(&self) -> Option<&LargeSphere> {
        match self {
            Shape::LargeSphere(large_sphere) => Some(large_sphere),
            _ => None,
        }
    }

    /// Whether it is its bounding shape; of a disk, that is the square around it.
    pub fn fills_bounding_shape(&self) -> bool {
        self.kind().covered > 0.0
    }

    pub fn code_kind(&self) -> u32 {
        code_kind(self.number())
    }

    /// The code of the shape at this index of its table.
    pub fn code(&self, index: usize) -> u32 {
        primitive_code(self.code_kind(), index as u32)
    }
}

/// The kind in the codes of shapes of this number. It is the number itself, except for a mesh: in the scene it is an instance.
pub(crate) fn code_kind(number: usize) -> u32 {
    if number == KIND_TRIANGLE as usize { KIND_INSTANCE } else { number as u32 }
}

/// The names of the kinds' shader files, by number. For a mesh it is the file of its triangles.
pub const PRIMITIVES: &[&str] = Shape::SHADERS;
const _: () = {
    assert!(
        KINDS.len() <= KIND_DELTA_LIGHT as usize,
        "too many shapes: the number of the last one is that of a light without size"
    );
    assert!(
        matches!(PRIMITIVES[KIND_TRIANGLE as usize].as_bytes(), b"triangle"),
        "the number of the mesh is not the kind of triangles in codes"
    );
};

/// The shapes that can bound media, with the kinds in their codes and the names of their files under shaders/medium.
pub static BOUNDARIES: LazyLock<Vec<(&str, u32)>> = LazyLock::new(|| {
    let boundary =
        |(number, kind): (usize, &'static ShapeKind)| Some((kind.boundary.as_ref()?.name, code_kind(number)));
    KINDS.iter().enumerate().filter_map(boundary).collect()
});
