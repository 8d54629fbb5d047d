//! The motions of a scene: of its objects, the boundaries and textures of its media, its lights without size, and its camera.

use glam::DVec3;

use super::builder::Builder;
use super::finder::Finder;
use super::motion::Motion;
use super::motion_tables::{Motions, camera_moves, own_point, row_of_boundary};
use crate::scene::{Camera, Step};
use crate::shape::similarity::Similarity;
use crate::shape::{ObjectTransform, PRIMITIVES, RenderSpace};

/// Whether anything in the scene moves.
fn moves(finder: &Finder<'_>, camera: &Camera) -> bool {
    let bodies = finder.bodies().map(|(_, _, motion)| motion);
    let others =
        finder.media.iter().map(|medium| &medium.own.motion).chain(finder.lights.iter().map(|light| &light.motion));
    bodies.chain(others).any(|motion| !motion.is_empty()) || camera_moves(camera)
}

impl Builder<'_> {
    /// Adds the motions of all objects and of the camera. `everything`: also if nothing moves.
    pub fn add_motions(&mut self, finder: &Finder<'_>, to_space: &Similarity, everything: bool) {
        let scene = self.scene;
        if !everything && !moves(finder, &scene.camera) {
            return;
        }
        let (primitives, media) = (finder.primitives.len(), finder.media.len());
        let space = self.space;
        let mut motions = Motions::new(primitives, media, finder.lights.len(), space);
        let features = &mut self.flat.features;
        for (order, primitive) in finder.primitives.iter().enumerate() {
            let at = ObjectTransform { to_world: &primitive.to_world, space };
            motions.add(order, &primitive.motion, own_point(&primitive.shape, &at, &primitive.motion), space);
            if !primitive.motion.is_empty() {
                let reason = || format!("{} that moves", scene.location_of(primitive.object));
                features.require(format!("moves.{}", PRIMITIVES[primitive.shape.number()]), reason);
            }
        }
        for (index, medium) in finder.media.iter().enumerate() {
            let row = row_of_boundary(primitives, index);
            let reason = || format!("{} that moves", scene.location_of(medium.object));
            let at = ObjectTransform { to_world: &medium.to_world, space };
            let center = own_point(&medium.boundary, &at, &medium.motion);
            motions.add(row, &medium.motion, center, space);
            if !medium.motion.is_empty() {
                features.require(format!("boundary_moves.{}", PRIMITIVES[medium.boundary.number()]), reason);
            }
            // Of a large sphere, the texture is evaluated relative to its nearest point.
            let texture = match medium.boundary.large_sphere() {
                Some(large_sphere) => space.point(large_sphere.nearest(&medium.to_world, space.eye)),
                None => medium.boundary.bounding_shape(&at).position(),
            };
            motions.add(row + 1, &medium.own.motion, texture, space);
            if !medium.own.motion.is_empty() && medium.reads_own_space() {
                features.require("moving_medium", reason);
            }
        }
        if camera_moves(&scene.camera) {
            motions.add_camera(&scene.camera, to_space);
            let reason =
                || format!("camera.moving at {}", scene.location(&[Step::Field("camera"), Step::Field("moving")]));
            features.require("moving_camera", reason);
        }
        features.quantities.motion_iterations = motions.iterations;
        self.motions = Some(motions);
    }

    /// Adds the motion of a light without size, which has this index in its table.
    pub fn add_motion_of_light(&mut self, index: usize, motion: &Motion, position: DVec3, space: RenderSpace) {
        if let Some(motions) = &mut self.motions {
            motions.add(motions.number_of_light(index), motion, position, space);
            self.flat.features.quantities.motion_iterations = motions.iterations;
        }
    }
}
