//! The shapes: what a sphere, a quad, a box and a mesh are, each in a file of its own.
//!
//! `kinds!` has the one list of them. What else is to be said of a shape is a field of `ShapeKind` or a method of `Geometry`. Neither has
//! defaults, so that a new shape says all of it.

mod closed;
pub mod cuboid;
mod hull;
pub mod mesh;
pub mod quad;
pub mod similarity;
mod space;
pub mod sphere;

use std::ops::Deref;

use glam::{DMat3, DVec3, Vec3};

use crate::data::{self, KIND_INSTANCE, KIND_TRIANGLE, primitive_code};
use crate::error::Result;
use crate::source::Place;
use crate::source::form::{Form, kinds};
pub use cuboid::Cuboid;
pub use hull::{Hull, normal, reach_of};
use mesh::{Laid, MeshShape};
pub use quad::Quad;
pub use space::{Aabb, Placement, RenderSpace, binary_exponent, error_bound, exp2, padded};
pub use sphere::Sphere;

/// What all shapes of a kind have in common.
pub struct ShapeKind {
    /// In the scene file.
    pub form: Form,
    /// Of its files under shaders/geometry and shaders/light.
    pub shader: &'static str,
    /// In messages.
    pub word: &'static str,
    /// Names of its sizes in messages, with the fields that hold them; the last is that of all further ones.
    pub sizes: &'static [(&'static str, &'static str)],
    pub table: Table,
    /// As the boundary of a medium, if it can be one.
    pub boundary: Option<Boundary>,
}

pub struct Boundary {
    /// Among the boundaries. A convex one has a file of this name under shaders/medium.
    pub name: &'static str,
    /// What is expected of it, before its name in the scene file.
    pub words: &'static str,
}

/// The field that all shapes have.
const MATERIAL: (&str, &str) = ("material", "a material's name in quotes");

/// The table that holds the elements of a kind on the device.
pub struct Table {
    /// Of the file under shaders/bind.
    pub name: &'static str,
    /// Names of the linker's values that say how it is bound.
    pub space: &'static str,
    pub size: &'static str,
    /// What it holds, in words.
    pub why: &'static str,
    /// Bytes of an element.
    pub stride: usize,
    pub bytes: fn(&Tables) -> &[u8],
}

impl Table {
    /// How many elements it has.
    pub fn count(&self, tables: &Tables) -> usize {
        (self.bytes)(tables).len() / self.stride
    }
}

/// A `Table` of this name over the member of `Tables` of this name.
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
}

/// What an element says of its place in the scene.
#[derive(Clone, Copy, Default)]
pub struct Element {
    pub order: u32,
    pub material: u32,
    pub frame: u32,
    /// Of a mesh, where it has been laid out.
    pub laid: Laid,
}

/// Something flat or round that can be a light.
pub struct Emitter {
    pub code: u32,
    /// Of a face, that of its mesh.
    pub instance: u32,
    pub area: f64,
    pub around: Aabb,
    /// Of what is flat.
    pub normal: Option<DVec3>,
}

/// What a shape says of itself.
pub trait Geometry {
    /// Checks its numbers.
    fn check(&self, at: &Place) -> Result<()>;

    /// Its smallest size, and a bound of how far it reaches from the origin: by these it is told what transforms may do to it.
    fn span(&self) -> (f64, f64);

    /// The place of the coordinates by which it is textured in the shape's own space: base + columns · local.
    fn texture_place(&self, rotation: &DMat3) -> (DVec3, DMat3);

    /// Adds its element to its table; the result is the lowest and the highest corner of a box around it in render space.
    fn lay_out(&self, at: &Placement, element: Element, tables: &mut Tables) -> (Vec3, Vec3);

    /// The lights that it is made of, where it is the one at this index of its table.
    fn emitters(&self, at: &Placement, index: u32, laid: Laid) -> Vec<Emitter>;

    /// Tells its element the place of its first light among all, or `NOT_SAMPLED`.
    fn set_light(&self, tables: &mut Tables, index: usize, laid: Laid, light: u32);

    /// A simple body around it, by which numbers are judged.
    fn hull(&self, at: &Placement) -> Hull;
}

/// A shape in its own space.
#[derive(Clone, Copy)]
pub enum Shape<'a> {
    Sphere(Sphere),
    Quad(Quad),
    Cuboid(Cuboid),
    Mesh(&'a MeshShape<'a>),
}

kinds! {
    Shape<'_>: ShapeKind;
    Sphere => sphere::KIND,
    Quad => quad::KIND,
    Cuboid => cuboid::KIND,
    Mesh => mesh::KIND,
}

impl<'a> Deref for Shape<'a> {
    type Target = dyn Geometry + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Shape::Sphere(shape) => shape,
            Shape::Quad(shape) => shape,
            Shape::Cuboid(shape) => shape,
            Shape::Mesh(shape) => shape,
        }
    }
}

/// The kinds of shape by number.
pub const KINDS: &[ShapeKind] = Shape::KINDS;

impl<'a> Shape<'a> {
    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<&'a MeshShape<'a>> {
        match self {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// Whether it is the surface of its hull.
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

/// The kind of the codes of shapes of this number: it is the same, but a mesh stands in the scene as an instance.
const fn code_kind(number: usize) -> u32 {
    if number == KIND_TRIANGLE as usize { KIND_INSTANCE } else { number as u32 }
}

/// The names of the kinds' shader files, by number. Of a mesh it is that of its triangles.
pub const PRIMITIVES: &[&str] = Shape::SHADERS;
const _: () = {
    assert!(KINDS.len() <= KIND_INSTANCE as usize, "a shape too many: its number is that of an instance");
    assert!(
        matches!(PRIMITIVES[KIND_TRIANGLE as usize].as_bytes(), b"triangle"),
        "meshes are not where codes have them"
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

/// The kinds of boundary that media have, with the kinds of their codes. Convex ones are files of shaders/medium; the mesh, which a ray may
/// enter many times, is `scene/medium_in_mesh`.
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
