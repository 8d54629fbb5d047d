//! Finds the primitives and media of a scene, each with the transform from its own space to the world.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use crate::delta_light::WorldLight;
use crate::scene::{Object, Scene, Texture, Transform};
use crate::shape::mesh::MeshShape;
use crate::shape::similarity::Similarity;
use crate::shape::{BoundingShape, ObjectTransform, RenderSpace, Shape};

/// A primitive, with the transform that its texture needs.
pub struct Primitive<'a> {
    pub object: &'a Object,
    pub shape: Shape<'a>,
    /// The transform from the object's own space to the world.
    pub to_world: Similarity,
    pub material: u32,
}

/// A medium within its boundary.
pub struct WorldMedium<'a> {
    pub object: &'a Object,
    pub boundary: Shape<'a>,
    /// The transform from the boundary's own space to the world.
    pub to_world: Similarity,
    /// The transform from the medium's own space, which is also that of its texture, to the world.
    pub own: Similarity,
    /// The density per unit of length in the world.
    pub density: f64,
    pub albedo: &'a Texture,
    pub anisotropy: f64,
}

/// Collects the primitives and media of a scene.
pub struct Finder<'a> {
    materials: HashMap<&'a str, u32>,
    meshes: &'a BTreeMap<&'a str, MeshShape<'a>>,
    /// The camera's position.
    eye: DVec3,
    pub primitives: Vec<Primitive<'a>>,
    pub media: Vec<WorldMedium<'a>>,
    /// The lights without size, each with its object.
    pub lights: Vec<(&'a Object, WorldLight)>,
}

impl<'a> Finder<'a> {
    pub fn new(scene: &'a Scene, meshes: &'a BTreeMap<&'a str, MeshShape<'a>>, eye: DVec3) -> Finder<'a> {
        Finder {
            materials: (0..).zip(&scene.materials).map(|(i, (name, _))| (name.as_str(), i)).collect(),
            meshes,
            eye,
            primitives: Vec::new(),
            media: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Adds the primitives, media and lights of an object.
    pub fn add(&mut self, object: &'a Object, to_world: &Similarity) {
        match object {
            Object::Transformed { by, object } => self.add(object, &to_world.after(&similarity(by))),
            Object::Group(objects) | Object::Gltf { objects, .. } => {
                objects.iter().for_each(|object| self.add(object, to_world));
            }
            Object::Medium { boundary, density, albedo, anisotropy } => {
                // A medium without density has no effect.
                if *density > 0.0
                    && let Some((boundary, around)) = self.boundary(boundary, to_world)
                {
                    self.media.push(WorldMedium {
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
                self.lights.extend(object.delta_light().map(|light| (object, light.in_world(to_world))));
                let material = object.material().and_then(|name| self.materials.get(name).copied());
                if let (Some(shape), Some(material)) = (object.shape(self.meshes), material) {
                    let shape = shape.seen_from(to_world, self.eye);
                    self.primitives.push(Primitive { object, shape, to_world: *to_world, material });
                }
            }
        }
    }

    /// The shape of a boundary, and the transform from its own space to the world.
    fn boundary(&self, object: &Object, to_world: &Similarity) -> Option<(Shape<'a>, Similarity)> {
        match object {
            Object::Transformed { by, object } => self.boundary(object, &to_world.after(&similarity(by))),
            _ => object.shape(self.meshes).map(|shape| (shape.seen_from(to_world, self.eye), *to_world)),
        }
    }
}

/// A list of transforms, applied in the order listed.
fn similarity(transforms: &[Transform]) -> Similarity {
    let one = |transform: &Transform| match *transform {
        Transform::Translate(by) => Similarity::translation(by),
        Transform::Scale(scale) => Similarity::scale(scale),
        Transform::RotateX(degrees) => Similarity::rotation(DVec3::X, degrees),
        Transform::RotateY(degrees) => Similarity::rotation(DVec3::Y, degrees),
        Transform::RotateZ(degrees) => Similarity::rotation(DVec3::Z, degrees),
        Transform::Rotate { axis, degrees } => Similarity::rotation(axis, degrees),
    };
    transforms.iter().fold(Similarity::IDENTITY, |done, next| one(next).after(&done))
}

/// The largest distance of a shape's points from the eye along an axis. Of a large sphere only the nearest point counts, because rays seldom
/// get far from it.
pub fn extent_of(shape: &Shape, to_world: &Similarity, eye: DVec3) -> f64 {
    if let Some(large_sphere) = shape.large_sphere() {
        return large_sphere.extent(to_world);
    }
    let bounds = shape.bounding_shape(&ObjectTransform { to_world, space: RenderSpace { eye, scale: 1.0 } });
    match bounds {
        BoundingShape::Ball { center, radius } => center.abs().max_element() + radius,
        BoundingShape::Cuboid { center, half, .. } if shape.fills_bounding_shape() => {
            center.abs().max_element() + half.length()
        }
        _ => bounds.corners().into_iter().fold(0.0, |far, p| p.abs().max_element().max(far)),
    }
}

/// The largest distance of all primitives, media and the lens from the eye along an axis; 1 if the scene is empty.
pub fn extent(eye: DVec3, lens_radius: f64, finder: &Finder<'_>) -> f64 {
    let primitives = finder.primitives.iter().map(|primitive| extent_of(&primitive.shape, &primitive.to_world, eye));
    let media = finder.media.iter().map(|medium| extent_of(&medium.boundary, &medium.to_world, eye));
    let far = primitives.chain(media).fold(lens_radius, f64::max);
    if far > 0.0 { far } else { 1.0 }
}
