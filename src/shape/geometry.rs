//! What every shape has: the properties of its kind, and the methods of its geometry. Neither has defaults, so that a new shape cannot forget
//! one.

use glam::{DMat3, DVec3, Vec3};

use super::bounding_shape::BoundingShape;
use super::space::{Aabb, ObjectTransform};
use crate::data::{NO_INSTANCE, Tables};
use crate::error::Result;
use crate::source::ValuePath;

/// The properties that all shapes of a kind share.
pub struct ShapeKind {
    /// Its name in scene files. One without a name is chosen by the host instead of one that they have.
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
    /// The part that it covers of its bounding shape, around the middle: a share of each edge. 0 if that is not known.
    pub covered: f64,
    /// Whether it is cut into parts as a light whose radiance varies. Its parts then have a file under shaders/light, and the faces of meshes one under shaders/scene.
    pub has_parts: bool,
}

impl ShapeKind {
    /// Whether a ray that passes its surface meets it again from inside. (A mesh consists of faces, which it meets one by one.)
    pub fn encloses(&self) -> bool {
        self.boundary.as_ref().is_some_and(|boundary| boundary.is_convex)
    }
}

pub struct Boundary {
    /// Its name among the boundaries. A convex one has a file of this name under shaders/medium.
    pub name: &'static str,
    pub is_convex: bool,
    /// The words before its name in messages: an article, and what is expected of the shape.
    pub words: &'static str,
}

/// The table that holds the elements of a kind on the device.
pub struct Table {
    /// The name of the file under shaders/bind.
    pub name: &'static str,
    /// Its contents, in words.
    pub why: &'static str,
    /// Bytes of an element.
    pub stride: usize,
    pub bytes: fn(&Tables) -> &[u8],
    /// The member of an element that says which is its first light among all lights.
    pub light: fn(&mut Tables, usize) -> &mut u32,
}

impl Table {
    /// The number of its elements.
    pub fn count(&self, tables: &Tables) -> usize {
        (self.bytes)(tables).len() / self.stride
    }
}

/// The `Table` of a member of `Tables`, with the same name.
macro_rules! table {
    ($member:ident of $element:ty, $light:ident, $why:literal) => {
        $crate::shape::geometry::Table {
            name: stringify!($member),
            why: $why,
            stride: size_of::<$element>(),
            bytes: |tables| bytemuck::cast_slice(&tables.$member),
            light: |tables, index| &mut tables.$member[index].$light,
        }
    };
}
pub(super) use table;

/// Where a mesh lies in the device's tables.
#[derive(Clone, Copy, Default)]
pub struct MeshLayout {
    /// The code of its hierarchy's root.
    pub root: u32,
    /// The index of its first face.
    pub first_face: u32,
    pub to_uvs: u32,
    /// The largest number of nodes on the stack in a walk through its hierarchy.
    pub stack_size: u32,
}

/// The members that an element of any shape has: how it refers to the rest of the scene.
#[derive(Clone, Copy, Default)]
pub struct Element {
    pub order: u32,
    pub material: u32,
    pub frame: u32,
    /// Of a mesh, where it lies in the device's tables.
    pub layout: MeshLayout,
}

/// A surface that can be sampled as a light.
#[derive(Clone, Copy)]
pub struct Emitter {
    pub code: u32,
    /// Of a triangle, the instance of its mesh.
    pub instance: u32,
    pub area: f64,
    pub around: Aabb,
    /// Of a flat surface.
    pub normal: Option<DVec3>,
}

impl Emitter {
    /// A surface that is no triangle.
    pub fn of_body(code: u32, area: f64, around: Aabb, normal: Option<DVec3>) -> Emitter {
        Emitter { code, instance: NO_INSTANCE, area, around, normal }
    }
}

/// What every shape implements on the host.
pub trait Geometry {
    /// Checks its numbers, each of which is in its own range.
    fn check(&self, at: &ValuePath) -> Result<()>;

    /// Its smallest size, and a bound of its farthest distance from the origin. They limit the transforms of the shape.
    fn span(&self) -> (f64, f64);

    /// The frame of its texture coordinates in its own space: the origin, and the axes as columns.
    fn texture_frame(&self, rotation: &DMat3) -> (DVec3, DMat3);

    /// Adds its element to its table. Returns the lowest and the highest corner of a box around it in render space.
    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3);

    /// The lights that it consists of; `index` is its index in its table, and `code` its code.
    fn emitters(&self, at: &ObjectTransform, index: u32, code: u32, layout: MeshLayout) -> Vec<Emitter>;

    /// Calls `add` with flat convex polygons that cover what is seen of it from the origin of the space. From their fronts, their corners are
    /// counter-clockwise. A round one has so many corners. A shape that is huge for the origin may have none.
    fn faces(&self, at: &ObjectTransform, corners: u32, add: &mut dyn FnMut(&[DVec3]));

    /// A simple bounding volume, for the warnings about sizes and distances.
    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape;
}
