//! The scene as its file writes it: in f64 and in scene units, before flattening.

use std::collections::BTreeMap;

use clap::ValueEnum;
use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use crate::bitmap::{Bitmap, Bitmaps};
use crate::delta_light::{DeltaLight, default_inner, default_outer};
pub use crate::material::Material;
use crate::shape::mesh::{self, MeshShape};
use crate::shape::{Shape, ShapeKind, cuboid, disk, quad, sphere};
pub use crate::texture::{Colour, Texture, Use};

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSize {
    pub width: u32,
    pub height: u32,
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub look_from: DVec3,
    pub look_at: DVec3,
    #[serde(default = "up")]
    pub up: DVec3,
    /// Degrees, strictly between 0 and 180.
    pub vertical_fov: f64,
    /// Diameter of the lens; 0 is a pinhole camera.
    #[serde(default)]
    pub aperture: f64,
    /// Distance from the eye to the plane in focus. The default is the distance to `look_at`.
    #[serde(default)]
    pub focus_distance: Option<f64>,
}

fn up() -> DVec3 {
    DVec3::Y
}

#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Background {
    Solid(Colour),
    /// Blended by 0.5 (y + 1) of the unit direction.
    Gradient {
        bottom: Colour,
        top: Colour,
    },
    /// Radiance in a latitude-longitude map, with +y at the top and -z in the middle.
    Image {
        path: String,
    },
}

/// Rotations are right-handed about their axis, in degrees.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Transform {
    Translate(DVec3),
    Scale(f64),
    RotateX(f64),
    RotateY(f64),
    RotateZ(f64),
    Rotate { axis: DVec3, degrees: f64 },
}

/// An object of the scene. `material` is absent only on the boundary of a `Medium`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Object {
    Sphere {
        center: DVec3,
        radius: f64,
        #[serde(default)]
        material: Option<String>,
    },
    /// The normal is u × v.
    Quad {
        corner: DVec3,
        u: DVec3,
        v: DVec3,
        #[serde(default)]
        material: Option<String>,
    },
    Box {
        min: DVec3,
        max: DVec3,
        #[serde(default)]
        material: Option<String>,
    },
    Mesh {
        #[serde(skip_serializing)]
        path: String,
        #[serde(default)]
        material: Option<String>,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
        #[serde(default)]
        material: Option<String>,
    },
    PointLight {
        at: DVec3,
        intensity: Colour,
    },
    /// Angles are in degrees, from the middle of the beam.
    SpotLight {
        at: DVec3,
        towards: DVec3,
        intensity: Colour,
        #[serde(default = "default_inner")]
        inner: f64,
        #[serde(default = "default_outer")]
        outer: f64,
    },
    DirectionalLight {
        direction: DVec3,
        irradiance: Colour,
    },
    /// Transforms are applied in the order listed.
    Transformed {
        by: Vec<Transform>,
        object: Box<Object>,
    },
    Group(Vec<Object>),
    /// What a glTF file has, with materials of its own.
    Gltf {
        #[serde(skip_serializing)]
        path: String,
        /// Whether its lights are in Blender's watts; if it is not given, the file's generator decides.
        #[serde(default, skip_serializing)]
        watts: Option<bool>,
        #[serde(default, skip_serializing)]
        thin: Thin,
        #[serde(default, skip_deserializing)]
        objects: Vec<Object>,
    },
    Medium {
        boundary: Box<Object>,
        /// The extinction coefficient, per unit of length.
        density: f64,
        albedo: Texture,
        /// Henyey-Greenstein's g.
        #[serde(default)]
        anisotropy: f64,
    },
}

/// Which glass of a glTF file is thin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ValueEnum)]
pub enum Thin {
    /// Of files by Blender what is open, as it renders them; of others as they say.
    #[default]
    Auto,
    /// What has no thickness in the file, as glTF says.
    Pane,
}

/// Defaults of the render; the command line overrides them.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderDefaults {
    pub samples: u32,
    pub max_depth: u32,
}

impl Default for RenderDefaults {
    fn default() -> Self {
        RenderDefaults { samples: 100, max_depth: 50 }
    }
}

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

    /// The variant's name, as the scene file writes it.
    pub fn name(&self) -> &'static str {
        match self {
            Object::Transformed { .. } => "Transformed",
            Object::Group(_) => "Group",
            Object::Gltf { .. } => "Gltf",
            Object::Medium { .. } => "Medium",
            Object::PointLight { .. } => "PointLight",
            Object::SpotLight { .. } => "SpotLight",
            Object::DirectionalLight { .. } => "DirectionalLight",
            shape => shape.kind().map_or("", |kind| kind.form.name),
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
