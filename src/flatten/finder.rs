//! Finds the primitives and media of a scene, each with the transform from its own space to the world.

use std::collections::{BTreeMap, HashMap};
use std::iter;
use std::sync::Arc;

use glam::DVec3;

use super::motion::{Motion, Placement, Shutter, in_space};
use super::swept::swept;
use crate::delta_light::WorldLight;
use crate::scene::{Camera, Emission, Heat, Material, Object, Scene, Texture, Varying};
use crate::shape::mesh::MeshShape;
use crate::shape::similarity::Similarity;
use crate::shape::{BoundingShape, KINDS, ObjectTransform, RenderSpace, Shape};
use crate::volume::grid::Grid;
use crate::volume::heat;

/// The names around an object.
#[derive(Clone, Copy, Default)]
pub struct Name<'a> {
    /// The name of the innermost `Named`, if there is one.
    pub own: Option<&'a str>,
    pub outermost: Option<&'a str>,
    /// The place among the objects of the scene.
    pub place: usize,
}

/// A primitive, with the transform that its texture needs.
pub struct Primitive<'a> {
    pub object: &'a Object,
    pub name: Name<'a>,
    pub shape: Shape<'a>,
    /// The transform from the object's own space to the world, where the shutter opens.
    pub to_world: Similarity,
    pub motion: Motion,
    pub material: u32,
}

/// The primitives, each with its index among those of its kind: that in the table of the kind.
pub fn with_indices<'p, 'a>(primitives: &'p [Primitive<'a>]) -> impl Iterator<Item = (u32, &'p Primitive<'a>)> {
    let mut counts = [0; KINDS.len()];
    primitives.iter().map(move |primitive| {
        let count = &mut counts[primitive.shape.number()];
        *count += 1;
        (*count - 1, primitive)
    })
}

/// A medium within its boundary.
pub struct WorldMedium<'a> {
    pub object: &'a Object,
    pub boundary: Shape<'a>,
    /// The transform from the boundary's own space to the world, where the shutter opens.
    pub to_world: Similarity,
    pub motion: Motion,
    /// The placement of the medium's own space, which is also that of its texture.
    pub own: Placement,
    /// The largest density, per unit of length in the world.
    pub density: f64,
    pub varying: Option<&'a Varying>,
    /// The grid of the density.
    pub grid: Option<&'a Arc<Grid>>,
    /// Whether the boundary is the grid's own box.
    pub is_bare: bool,
    pub albedo: &'a Texture,
    pub anisotropy: f64,
    pub emission: Option<&'a Emission>,
    /// The grid of the temperature.
    pub temperature: Option<&'a Arc<Grid>>,
}

impl WorldMedium<'_> {
    /// The largest component of the radiance that it emits.
    pub fn brightest(&self) -> f64 {
        match self.emission {
            None => 0.0,
            Some(Emission::Colour(colour)) => colour.max_element(),
            Some(Emission::Heat(Heat::Blackbody { scale, at, luminance, .. })) => {
                let hottest = scale * self.temperature.map_or(0.0, |grid| f64::from(grid.largest()));
                luminance * (heat::radiance(hottest) * (-heat::log_luminance(*at)).exp()).max_element()
            }
        }
    }

    /// Whether something in it is a function of the point in its own space.
    pub fn reads_own_space(&self) -> bool {
        self.albedo.shader_number().is_some() || self.varying.is_some() || self.temperature.is_some()
    }
}

/// Collects the primitives and media of a scene.
pub struct Finder<'a> {
    materials: HashMap<&'a str, u32>,
    /// The numbers of the materials that each one needs: its own, and those of its parts.
    pub needed: Vec<Vec<usize>>,
    meshes: &'a BTreeMap<&'a str, MeshShape<'a>>,
    scene: &'a Scene,
    /// The camera's position.
    eye: DVec3,
    shutter: Shutter,
    /// That of the object which is added.
    name: Name<'a>,
    pub primitives: Vec<Primitive<'a>>,
    pub media: Vec<WorldMedium<'a>>,
    /// The lights without size.
    pub lights: Vec<MovingLight<'a>>,
}

/// A light without size, where the shutter opens, and its motion from there.
pub struct MovingLight<'a> {
    pub object: &'a Object,
    pub light: WorldLight,
    pub motion: Motion,
}

impl<'a> Finder<'a> {
    pub fn new(
        scene: &'a Scene,
        meshes: &'a BTreeMap<&'a str, MeshShape<'a>>,
        eye: DVec3,
        camera: &Camera,
    ) -> Finder<'a> {
        let materials: HashMap<&str, u32> =
            (0..).zip(&scene.materials).map(|(i, (name, _))| (name.as_str(), i)).collect();
        let with_parts = |(number, (_, material)): (usize, &(String, Material))| {
            let parts = material.parts().filter_map(|(_, name)| Some(*materials.get(name)? as usize));
            iter::once(number).chain(parts).collect()
        };
        Finder {
            needed: scene.materials.iter().enumerate().map(with_parts).collect(),
            materials,
            meshes,
            scene,
            eye,
            shutter: Shutter::new(camera),
            name: Name::default(),
            primitives: Vec::new(),
            media: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// Adds the primitives, media and lights of the scene's objects.
    pub fn add_all(&mut self, objects: &'a [Object], world: &Placement) {
        for (index, object) in objects.iter().enumerate() {
            self.name = Name { place: index, ..Name::default() };
            self.add(object, world);
        }
    }

    fn add(&mut self, object: &'a Object, at: &Placement) {
        match object {
            Object::Named { name, object } => {
                let outer = self.name;
                self.name = Name { own: Some(name), outermost: outer.outermost.or(Some(name)), ..outer };
                self.add(object, at);
                self.name = outer;
            }
            Object::Transformed { by, object } => self.add(object, &at.transformed(by)),
            Object::Moving { keys, object } => self.add(object, &at.moving(keys, self.shutter)),
            Object::Group(objects) | Object::Gltf { objects, .. } => {
                objects.iter().for_each(|object| self.add(object, at));
            }
            Object::Medium { .. } => self.media.extend(self.medium(object, at)),
            _ => {
                let Placement { to_world, motion } = at;
                let light = object.delta_light().map(|light| light.in_world(to_world));
                self.lights.extend(light.map(|light| MovingLight { object, light, motion: Arc::clone(motion) }));
                let material = object.material().and_then(|name| self.materials.get(name).copied());
                if let (Some(shape), Some(material)) = (object.shape(self.meshes), material) {
                    let shape = shape.seen_from(to_world, self.eye);
                    let (to_world, motion) = (*to_world, Arc::clone(motion));
                    let name = self.name;
                    self.primitives.push(Primitive { object, name, shape, to_world, motion, material });
                }
            }
        }
    }

    /// The medium that an object is; none if it has no density, and so no effect.
    fn medium(&self, object: &'a Object, at: &Placement) -> Option<WorldMedium<'a>> {
        let Object::Medium { boundary, density, albedo, anisotropy, emission } = object else { return None };
        let grid = self.scene.grid_of(density.grid());
        let (shape, around) = match boundary {
            Some(boundary) => self.boundary(boundary, at)?,
            None => (grid?.boundary()?.seen_from(&at.to_world, self.eye), at.clone()),
        };
        let largest = density.scale() * grid.map_or(1.0, |grid| f64::from(grid.largest()));
        (largest > 0.0).then(|| WorldMedium {
            object,
            boundary: shape,
            to_world: around.to_world,
            motion: around.motion,
            own: at.clone(),
            density: largest,
            varying: density.varying(),
            grid,
            is_bare: boundary.is_none(),
            albedo,
            anisotropy: *anisotropy,
            emission: emission.as_ref().filter(|emission| emission.is_seen()),
            temperature: self.scene.grid_of(emission.as_ref().and_then(Emission::grid)),
        })
    }

    /// The shapes of all primitives and of all media's boundaries.
    pub fn bodies(&self) -> impl Iterator<Item = (&Shape<'a>, &Similarity, &Motion)> {
        let primitives = self.primitives.iter().map(|found| (&found.shape, &found.to_world, &found.motion));
        primitives.chain(self.media.iter().map(|medium| (&medium.boundary, &medium.to_world, &medium.motion)))
    }

    /// The shape of a boundary, and its placement.
    fn boundary(&self, object: &Object, at: &Placement) -> Option<(Shape<'a>, Placement)> {
        match object {
            Object::Transformed { by, object } => self.boundary(object, &at.transformed(by)),
            Object::Moving { keys, object } => self.boundary(object, &at.moving(keys, self.shutter)),
            Object::Named { object, .. } => self.boundary(object, at),
            _ => object.shape(self.meshes).map(|shape| (shape.seen_from(&at.to_world, self.eye), at.clone())),
        }
    }
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
    let space = RenderSpace { eye, scale: 1.0 };
    let of = |(shape, to_world, motion): (&Shape, &Similarity, &Motion)| {
        let rest = extent_of(shape, to_world, eye);
        if motion.is_empty() || shape.large_sphere().is_some() {
            return rest;
        }
        let way = swept(&shape.bounding_shape(&ObjectTransform { to_world, space }), &in_space(motion, space));
        rest.max(way.min.abs().max(way.max.abs()).max_element())
    };
    let far = finder.bodies().map(of).fold(lens_radius, f64::max);
    if far > 0.0 { far } else { 1.0 }
}
