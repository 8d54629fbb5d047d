//! What a scene consists of, and the shapes and lights that its objects are.

use std::collections::BTreeMap;

pub use super::declared::{Background, Camera, ImageSize, Object, RenderDefaults, Thin, Transform};
pub use crate::bitmap::{Bitmap, Bitmaps};
use crate::delta_light::DeltaLight;
pub use crate::material::Material;
use crate::shape::mesh::{self, MeshShape};
use crate::shape::{Shape, ShapeKind, cuboid, disk, quad, sphere};
pub use crate::texture::{Colour, Texture, Use};

impl Object {
    /// Its kind of shape; none for lights without size and for objects that contain others.
    pub fn kind(&self) -> Option<&'static ShapeKind> {
        match self {
            Object::Sphere { .. } => Some(&sphere::KIND),
            Object::Quad { .. } => Some(&quad::KIND),
            Object::Box { .. } => Some(&cuboid::KIND),
            Object::Disk { .. } => Some(&disk::KIND),
            Object::Mesh { .. } => Some(&mesh::KIND),
            _ => None,
        }
    }

    /// The light without size that it is, if it is one.
    pub fn delta_light(&self) -> Option<DeltaLight> {
        match *self {
            Object::PointLight { at, intensity } => Some(DeltaLight::Point { at, intensity }),
            Object::SpotLight { at, towards, intensity, inner, outer } => {
                Some(DeltaLight::Spot { at, towards, intensity, inner, outer })
            }
            Object::DirectionalLight { direction, irradiance } => {
                Some(DeltaLight::Directional { direction, irradiance })
            }
            _ => None,
        }
    }

    /// Its shape; none for lights without size, for objects that contain others, and for a mesh that is not in `meshes`.
    pub fn shape<'a>(&self, meshes: &'a BTreeMap<&str, MeshShape<'a>>) -> Option<Shape<'a>> {
        match self {
            Object::Sphere { center, radius, .. } => {
                Some(Shape::Sphere(sphere::Sphere { center: *center, radius: *radius }))
            }
            Object::Quad { corner, u, v, .. } => Some(Shape::Quad(quad::Quad { corner: *corner, u: *u, v: *v })),
            Object::Box { min, max, .. } => Some(Shape::Cuboid(cuboid::Cuboid { min: *min, max: *max })),
            Object::Disk { center, normal, radius, .. } => {
                Some(Shape::Disk(disk::Disk { center: *center, normal: *normal, radius: *radius }))
            }
            Object::Mesh { path, .. } => meshes.get(path.as_str()).map(Shape::Mesh),
            _ => None,
        }
    }

    /// The name of the object's own material. Lights without size and objects that contain others have none.
    pub fn material(&self) -> Option<&str> {
        match self {
            Object::Sphere { material, .. }
            | Object::Quad { material, .. }
            | Object::Box { material, .. }
            | Object::Disk { material, .. }
            | Object::Mesh { material, .. } => material.as_deref(),
            _ => None,
        }
    }
}
