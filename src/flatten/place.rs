//! Finds the primitives and media of a scene, each with the way from its own space to the world.

use std::collections::HashMap;

use glam::DVec3;

use super::similarity::Similarity;
use crate::data::{KIND_INSTANCE, KIND_TRIANGLE, primitive_code};
use crate::scene::{Mesh, Object, Scene, Texture};

/// A primitive in world space, and what its texture needs to know of its own space.
pub struct Placed {
    pub shape: Shape,
    /// From the object's own space to the world.
    pub to_world: Similarity,
    pub material: u32,
}

/// In the object's own space.
#[derive(Clone, Copy)]
pub enum Shape {
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Quad {
        corner: DVec3,
        u: DVec3,
        v: DVec3,
    },
    Cuboid {
        min: DVec3,
        max: DVec3,
    },
    /// The place among the scene's meshes.
    Mesh(usize),
}

impl Shape {
    /// Number among `PRIMITIVES`: of a mesh, that of its triangles.
    pub fn kind(&self) -> usize {
        match self {
            Shape::Sphere { .. } => 0,
            Shape::Quad { .. } => 1,
            Shape::Cuboid { .. } => 2,
            Shape::Mesh(_) => KIND_TRIANGLE as usize,
        }
    }

    /// The kind of its code: a mesh stands in the scene as an instance.
    pub fn code_kind(&self) -> u32 {
        match self {
            Shape::Mesh(_) => KIND_INSTANCE,
            _ => self.kind() as u32,
        }
    }

    /// The code of the shape at this index among its kind.
    pub fn code(&self, index: usize) -> u32 {
        primitive_code(self.code_kind(), index as u32)
    }
}

/// A medium within its boundary.
pub struct PlacedMedium<'a> {
    pub object: &'a Object,
    pub boundary: Shape,
    /// From the boundary's own space to the world.
    pub to_world: Similarity,
    /// From the medium's own space, in which its texture is, to the world.
    pub own: Similarity,
    /// Per unit of length in the world.
    pub density: f64,
    pub albedo: &'a Texture,
    pub anisotropy: f64,
}

/// What is found in a scene.
pub struct Finder<'a> {
    materials: HashMap<&'a str, u32>,
    meshes: HashMap<&'a str, usize>,
    pub placed: Vec<Placed>,
    /// The objects that they are.
    pub objects: Vec<&'a Object>,
    pub media: Vec<PlacedMedium<'a>>,
}

impl<'a> Finder<'a> {
    pub fn new(scene: &'a Scene) -> Finder<'a> {
        Finder {
            materials: (0..).zip(&scene.materials).map(|(i, (name, _))| (name.as_str(), i)).collect(),
            meshes: (0..).zip(scene.meshes.keys()).map(|(i, path)| (path.as_str(), i)).collect(),
            placed: Vec::new(),
            objects: Vec::new(),
            media: Vec::new(),
        }
    }

    /// Adds what an object is made of.
    pub fn place(&mut self, object: &'a Object, to_world: &Similarity) {
        match object {
            Object::Transformed { by, object } => self.place(object, &to_world.after(&Similarity::of_all(by))),
            Object::Group(objects) => objects.iter().for_each(|object| self.place(object, to_world)),
            Object::Medium { boundary, density, albedo, anisotropy } => {
                // Without density there is nothing to meet.
                if *density > 0.0
                    && let Some((boundary, around)) = self.boundary(boundary, to_world)
                {
                    self.media.push(PlacedMedium {
                        object,
                        boundary,
                        to_world: around,
                        own: *to_world,
                        density: *density,
                        albedo,
                        anisotropy: *anisotropy,
                    });
                }
            }
            _ => {
                let material = object.material().and_then(|name| self.materials.get(name).copied());
                if let (Some(shape), Some(material)) = (self.shape(object), material) {
                    self.placed.push(Placed { shape, to_world: *to_world, material });
                    self.objects.push(object);
                }
            }
        }
    }

    /// A boundary's shape and the way from there to the world.
    fn boundary(&self, object: &Object, to_world: &Similarity) -> Option<(Shape, Similarity)> {
        match object {
            Object::Transformed { by, object } => self.boundary(object, &to_world.after(&Similarity::of_all(by))),
            _ => self.shape(object).map(|shape| (shape, *to_world)),
        }
    }

    /// The shape of an object that is one; nothing for those that hold others, or a mesh that has not been loaded.
    fn shape(&self, object: &Object) -> Option<Shape> {
        match object {
            Object::Sphere { center, radius, .. } => Some(Shape::Sphere { center: *center, radius: *radius }),
            Object::Quad { corner, u, v, .. } => Some(Shape::Quad { corner: *corner, u: *u, v: *v }),
            Object::Box { min, max, .. } => Some(Shape::Cuboid { min: *min, max: *max }),
            Object::Mesh { path, .. } => self.meshes.get(path.as_str()).map(|&mesh| Shape::Mesh(mesh)),
            Object::Transformed { .. } | Object::Group(_) | Object::Medium { .. } => None,
        }
    }
}

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub min: DVec3,
    pub max: DVec3,
}

impl Aabb {
    /// The smallest one around a mesh, in the mesh's own space.
    pub fn of(mesh: &Mesh) -> Aabb {
        let (min, max) = mesh.bounds();
        Aabb { min, max }
    }

    /// The smallest one around points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        let nothing = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        points.into_iter().fold(nothing, |around, p| around.union(Aabb { min: p, max: p }))
    }

    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }
}

/// The farthest that a shape reaches from the eye along an axis.
pub fn reach(shape: &Shape, to_world: &Similarity, eye: DVec3, boxes: &[Aabb]) -> f64 {
    let from_eye = |p: DVec3| (to_world.point(p) - eye).abs().max_element();
    let farthest = |points: &[DVec3]| points.iter().fold(0.0, |far, p| from_eye(*p).max(far));
    match *shape {
        Shape::Sphere { center, radius } => from_eye(center) + to_world.scale * radius,
        Shape::Quad { corner, u, v } => farthest(&[corner, corner + u, corner + v, corner + u + v]),
        Shape::Cuboid { min, max } => from_eye(0.5 * (min + max)) + to_world.scale * (0.5 * (max - min)).length(),
        Shape::Mesh(mesh) => farthest(&boxes[mesh].corners()),
    }
}

/// The same of all that there is, the lens included; 1 where there is nothing.
pub fn extent(eye: DVec3, lens_radius: f64, finder: &Finder<'_>, boxes: &[Aabb]) -> f64 {
    let primitives = finder.placed.iter().map(|placed| reach(&placed.shape, &placed.to_world, eye, boxes));
    let media = finder.media.iter().map(|medium| reach(&medium.boundary, &medium.to_world, eye, boxes));
    let far = primitives.chain(media).fold(lens_radius, f64::max);
    if far > 0.0 { far } else { 1.0 }
}
