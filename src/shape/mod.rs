//! The shapes: sphere, quad, box, mesh and disk, and the large sphere, which is a sphere to scene files; one file each.
//!
//! `kinds!` has the one list of them. Everything about a shape is a field of `ShapeKind` or a method of `Geometry`.
//! Neither has defaults, so that a new shape cannot forget one.

mod closed;
pub mod cuboid;
pub mod disk;
mod hull;
pub mod large_sphere;
pub mod mesh;
pub mod quad;
pub mod similarity;
mod space;
pub mod sphere;

use std::ops::Deref;

use glam::{DMat3, DVec3, Vec3};

use crate::data::{self, KIND_DELTA_LIGHT, KIND_INSTANCE, KIND_TRIANGLE, primitive_code};
use crate::error::Result;
use crate::source::Place;
use crate::source::form::kinds;
pub use cuboid::Cuboid;
pub use disk::Disk;
pub use hull::{Hull, normal, reach_of};
pub use large_sphere::LargeSphere;
use mesh::{Laid, MeshShape};
pub use quad::Quad;
use similarity::Similarity;
pub use space::{Aabb, Placement, RenderSpace, binary_exponent, error_bound, exp2, padded};
pub use sphere::Sphere;

/// The properties that all shapes of a kind share.
pub struct ShapeKind {
    /// Its name in scene files. One without a name is chosen by the host in place of one that they have.
    pub name: Option<&'static str>,
    /// The name of its files under shaders/geometry and shaders/light.
    pub shader: &'static str,
    /// Its name in messages.
    pub word: &'static str,
    /// The names of its sizes in messages, with the fields that hold them. The last name stands for all further sizes.
    pub sizes: &'static [(&'static str, &'static str)],
    pub table: Table,
    /// Its properties as a medium's boundary, if it can be one.
    pub boundary: Option<Boundary>,
}

impl ShapeKind {
    /// Whether a ray that passes its surface meets it again from inside. (A mesh consists of faces, which it meets one by one.)
    pub fn encloses(&self) -> bool {
        self.boundary.is_some() && self.shader != mesh::KIND.shader
    }
}

pub struct Boundary {
    /// Its name among the boundaries. A convex one has a file of this name under shaders/medium.
    pub name: &'static str,
    /// The words before its name in messages: an article, and what is expected of the shape.
    pub words: &'static str,
}

/// The table that holds the elements of a kind on the device.
pub struct Table {
    /// The name of the file under shaders/bind.
    pub name: &'static str,
    /// The linker's values that say how it is bound.
    pub space: &'static str,
    pub size: &'static str,
    /// Its contents, in words.
    pub why: &'static str,
    /// Bytes of an element.
    pub stride: usize,
    pub bytes: fn(&Tables) -> &[u8],
}

impl Table {
    /// The number of its elements.
    pub fn count(&self, tables: &Tables) -> usize {
        (self.bytes)(tables).len() / self.stride
    }
}

/// The `Table` of a member of `Tables`, with the same name.
macro_rules! table {
    ($member:ident of $element:ty, $why:literal) => {
        $crate::shape::Table {
            name: stringify!($member),
            space: concat!("space_of_", stringify!($member)),
            size: concat!("size_of_", stringify!($member)),
            why: $why,
            stride: size_of::<$element>(),
            bytes: |tables| bytemuck::cast_slice(&tables.$member),
        }
    };
}
use table;

/// The elements of all shapes, as the kernels read them.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    pub spheres: Vec<data::Sphere>,
    pub quads: Vec<data::Quad>,
    pub cuboids: Vec<data::Cuboid>,
    pub instances: Vec<data::Instance>,
    pub large_spheres: Vec<data::LargeSphere>,
    pub disks: Vec<data::Quad>,
}

/// The members that an element of any shape has: how it refers to the rest of the scene.
#[derive(Clone, Copy, Default)]
pub struct Element {
    pub order: u32,
    pub material: u32,
    pub frame: u32,
    /// Of a mesh, its place in the device's tables.
    pub laid: Laid,
}

/// A surface that can be sampled as a light.
pub struct Emitter {
    pub code: u32,
    /// Of a triangle, the instance of its mesh.
    pub instance: u32,
    pub area: f64,
    pub around: Aabb,
    /// Of a flat surface.
    pub normal: Option<DVec3>,
}

/// What every shape implements on the host.
pub trait Geometry {
    /// Checks its numbers, each of which is in its own range.
    fn check(&self, at: &Place) -> Result<()>;

    /// Its smallest size, and a bound of its farthest distance from the origin. They limit the transforms of the shape.
    fn span(&self) -> (f64, f64);

    /// The map from texture coordinates to the shape's own space: base + columns · local.
    fn texture_place(&self, rotation: &DMat3) -> (DVec3, DMat3);

    /// Adds its element to its table. Returns the lowest and the highest corner of a box around it in render space.
    fn lay_out(&self, at: &Placement, element: Element, tables: &mut Tables) -> (Vec3, Vec3);

    /// The lights that it consists of; `index` is its place in its table.
    fn emitters(&self, at: &Placement, index: u32, laid: Laid) -> Vec<Emitter>;

    /// Writes into its element the index of its first light among all lights, or `NOT_SAMPLED`.
    fn set_light(&self, tables: &mut Tables, index: usize, laid: Laid, light: u32);

    /// A simple bounding volume, for the warnings about sizes and distances.
    fn hull(&self, at: &Placement) -> Hull;
}

/// A shape in its own space.
#[derive(Clone, Copy)]
pub enum Shape<'a> {
    Sphere(Sphere),
    Quad(Quad),
    Cuboid(Cuboid),
    Mesh(&'a MeshShape<'a>),
    LargeSphere(LargeSphere),
    Disk(Disk),
}

kinds! {
    Shape<'_>: ShapeKind;
    Sphere => sphere::KIND,
    Quad => quad::KIND,
    Cuboid => cuboid::KIND,
    Mesh => mesh::KIND,
    LargeSphere => large_sphere::KIND,
    Disk => disk::KIND,
}

impl<'a> Deref for Shape<'a> {
    type Target = dyn Geometry + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Shape::Sphere(shape) => shape,
            Shape::Quad(shape) => shape,
            Shape::Cuboid(shape) => shape,
            Shape::Mesh(shape) => shape,
            Shape::LargeSphere(shape) => shape,
            Shape::Disk(shape) => shape,
        }
    }
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

    /// Whether it is exactly the surface of its hull.
    pub fn is_hull(&self) -> bool {
        self.mesh().is_none()
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
const fn code_kind(number: usize) -> u32 {
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

const BOUNDARY_COUNT: usize = {
    let (mut i, mut count) = (0, 0);
    while i < KINDS.len() {
        count += KINDS[i].boundary.is_some() as usize;
        i += 1;
    }
    count
};

/// The shapes that can bound media, with the kinds in their codes. Convex ones have files under shaders/medium. A ray
/// can enter a mesh many times, so meshes have `scene/medium_in_mesh` instead.
pub const BOUNDARIES: &[(&str, u32)] = &{
    let mut found = [("", 0); BOUNDARY_COUNT];
    let (mut i, mut count) = (0, 0);
    while i < KINDS.len() {
        if let Some(boundary) = &KINDS[i].boundary {
            found[count] = (boundary.name, code_kind(i));
            count += 1;
        }
        i += 1;
    }
    found
};
