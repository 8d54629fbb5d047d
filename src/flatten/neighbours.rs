//! The frames before and after the one that is rendered, for `--aov motion`: where the surface that a sample has hit is then, and where on the image.
//! All of it is in f64: kernels say only what a sample has seen.

use std::sync::Arc;

use glam::{DMat2, DMat3, DVec2, DVec3};

use super::finder::Finder;
use super::motion::Placement;
use super::projection::Film;
use super::view::axes_of;
use crate::aov::SceneSpace;
use crate::scene::{Camera, FPS, Mesh, Scene};
use crate::shape::mesh;
use crate::shape::similarity::Similarity;

/// A frame, and those around it.
#[derive(Debug)]
pub struct Neighbours {
    space: SceneSpace,
    film: Film,
    now: Moment,
    /// The frame before, and the next one.
    around: [Moment; 2],
}

/// Where everything is in a frame.
#[derive(Debug)]
struct Moment {
    camera: Camera,
    /// The objects by their numbers, with the mesh that each is an instance of.
    objects: Vec<(Placement, Option<Arc<Mesh>>)>,
}

impl Neighbours {
    /// The neighbours of a scene's frame, whose image has `size` pixels. The motion of a glTF file's frame is in [`Scene::neighbours`]; in other scenes
    /// the shutter moves.
    pub fn of(scene: &Scene, size: (u32, u32), space: SceneSpace) -> Neighbours {
        let fps = scene.frame.map_or(FPS, |frame| frame.fps);
        let around = match &scene.neighbours {
            Some(neighbours) => neighbours.each_ref().map(|scene| Moment::of(scene, &scene.camera)),
            None => [-1.0, 1.0].map(|frames| Moment::of(scene, &scene.camera.later(frames / fps))),
        };
        let film = Film::new(&scene.camera, size, scene.image);
        Neighbours { space, film, now: Moment::of(scene, &scene.camera), around }
    }

    /// The motion in pixels since the frame before, and until the next one: x to the right and y down, as the bits of f32, none of which is 0 where
    /// there is a motion. `seen` is what kernels say of a sample (shaders/truth/ray): a point, or the direction of the sky; the number of the
    /// object, or 0; that of the face; and the time while the shutter is open.
    pub fn motion(&self, seen: [u32; 6]) -> [u32; 4] {
        if seen == [0; 6] {
            return [0; 4];
        }
        let [x, y, z, object, face, time] = seen;
        let [x, y, z, time] = [x, y, z, time].map(|word| f64::from(f32::from_bits(word)));
        let seen_at = DVec3::new(x, y, z);
        // The sky is seen in the same direction from everywhere.
        let is_sky = object == 0;
        let p = if is_sky { self.space.direction(seen_at) } else { self.space.point(seen_at) };
        let from = self.point(&self.now, p, is_sky, time);
        let motion = |other: &Moment| {
            let then = if is_sky { p } else { self.now.follow(other, p, (object, face), time)? };
            Some(self.film.shortest(self.point(other, then, is_sky, time)? - from?))
        };
        let bits = |x: f64| if x == 0.0 { (-0.0f32).to_bits() } else { (x as f32).to_bits() };
        let [before, after] =
            self.around.each_ref().map(|other| motion(other).map_or([0; 2], |m| [bits(m.x), bits(m.y)]));
        [before[0], before[1], after[0], after[1]]
    }

    /// Where on the film a moment's camera sees a point, or a direction of the sky.
    fn point(&self, moment: &Moment, p: DVec3, is_sky: bool, time: f64) -> Option<DVec2> {
        if is_sky && matches!(self.film, Film::Parallel { .. }) {
            return Some(DVec2::ZERO);
        }
        let (open, close) = moment.camera.shutter;
        let camera = moment.camera.at(open + time * (close - open));
        let from_eye = if is_sky { p } else { p - camera.look_from };
        let DVec3 { x: right, y: up, z: backward } = DMat3::transpose(&axes_of(&camera)) * from_eye;
        self.film.point(DVec3::new(if camera.mirror { -right } else { right }, -up, -backward))
    }
}

impl Moment {
    /// A frame of a scene, with this camera.
    fn of(scene: &Scene, camera: &Camera) -> Moment {
        let shapes = mesh::shapes(&scene.meshes);
        let mut finder = Finder::new(scene, &shapes, camera.look_from, camera);
        finder.add_all(&scene.objects, &Placement::resting(Similarity::IDENTITY));
        let object = |found: super::finder::Primitive<'_>| {
            let mesh = found.shape.mesh().and_then(|mesh| scene.meshes.get(mesh.path));
            (Placement { to_world: found.to_world, motion: found.motion }, mesh.map(Arc::clone))
        };
        Moment { camera: camera.clone(), objects: finder.primitives.into_iter().map(object).collect() }
    }

    /// Where a point of a face of an object is in another frame; numbers count from 1.
    fn follow(&self, other: &Moment, p: DVec3, (object, face): (u32, u32), time: f64) -> Option<DVec3> {
        let index = (object as usize).checked_sub(1)?;
        let ((placement, mesh), (then, mesh_then)) = (self.objects.get(index)?, other.objects.get(index)?);
        let own = placement.own_point_at(p, time);
        let own_then = match (mesh, mesh_then) {
            (Some(mesh), Some(mesh_then)) if !Arc::ptr_eq(mesh, mesh_then) => bent(mesh, mesh_then, face, own)?,
            _ => own,
        };
        Some(then.point_at(own_then, time))
    }
}

/// Where a point of a face is after the mesh has changed its shape: between the corners as before (Ericson, "Real-Time Collision Detection", 2005,
/// section 3.4).
fn bent(mesh: &Mesh, then: &Mesh, face: u32, p: DVec3) -> Option<DVec3> {
    let corners = mesh.triangles.get((face as usize).checked_sub(1)?)?;
    let of = |mesh: &Mesh| corners.map(|corner| mesh.positions.get(corner as usize).copied());
    let ([Some(a), Some(b), Some(c)], [Some(a_then), Some(b_then), Some(c_then)]) = (of(mesh), of(then)) else {
        return None;
    };
    let (u, v, w) = (b - a, c - a, p - a);
    let products = DMat2::from_cols_array(&[u.dot(u), u.dot(v), u.dot(v), v.dot(v)]);
    let share = products.inverse() * DVec2::new(w.dot(u), w.dot(v));
    Some(a_then + share.x * (b_then - a_then) + share.y * (c_then - a_then))
}
