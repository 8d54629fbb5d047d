//! Lays out motions for the kernels, in render space (shaders/data/motion).

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::motion::{Motion, MotionStep, Shutter, StepKind, Track, in_space};
use super::swept::farthest_of;
use crate::data::{KEYS_SHIFT, MOVES, RESIZE, SHIFT, SPIN, TURN, f32s};
use crate::scene::Camera;
use crate::shape::similarity::Similarity;
use crate::shape::{ObjectTransform, RenderSpace, Shape};

pub type Row = [u32; 4];

/// The table under construction.
pub struct Motions {
    /// The head, and a row for each object.
    heads: Vec<Row>,
    rows: Vec<Row>,
    /// The first rows of the keys of steps, by motion and by the step's index in it.
    keys: HashMap<(*const MotionStep, usize), u32>,
    /// The loop iterations of the longest motion.
    pub iterations: u32,
    space: RenderSpace,
}

/// The row of a boundary of a medium, by the medium's index; that of its texture follows.
pub fn row_of_boundary(primitives: usize, medium: usize) -> usize {
    primitives + 2 * medium
}

/// The order of an object in its element, with the bit that says whether it moves.
pub fn order_of(order: u32, motion: &Motion) -> u32 {
    order | if motion.is_empty() { 0 } else { MOVES }
}

/// Whether the camera moves while the shutter is open.
pub fn camera_moves(camera: &Camera) -> bool {
    let track = Shutter::new(camera)
        .track(&camera.moving, |a, b, share| (a.look_from.lerp(b.look_from, share), a.look_at.lerp(b.look_at, share)));
    track.windows(2).any(|pair| pair[0].1 != pair[1].1)
}

fn row_of(v: DVec3, last: u32) -> Row {
    let [x, y, z] = f32s(v).map(f32::to_bits);
    [x, y, z, last]
}

fn of_time(v: DVec3, time: f64) -> Row {
    row_of(v, (time as f32).to_bits())
}

impl Motions {
    /// A table of so many primitives, media and lights without size, none of which moves yet.
    pub fn new(primitives: usize, media: usize, lights: usize, space: RenderSpace) -> Motions {
        let before_lights = row_of_boundary(primitives, media);
        // Kernels with all features look at the rows of one medium that the scene may lack.
        let mut heads = vec![[0; 4]; 1 + before_lights + lights + 2];
        heads[0][2] = before_lights as u32;
        Motions { heads, rows: Vec::new(), keys: HashMap::new(), iterations: 0, space }
    }

    /// The number of the light without size that has this index in its table.
    pub fn number_of_light(&self, index: usize) -> usize {
        self.heads[0][2] as usize + index
    }

    pub fn into_rows(self) -> Vec<Row> {
        self.heads.into_iter().chain(self.rows).collect()
    }

    fn first_of_rows(&self) -> u32 {
        (self.heads.len() + self.rows.len()) as u32
    }

    /// Adds the motion of the object of this number, whose own point is at this place in render space, in its pose where the shutter opens.
    pub fn add(&mut self, object: usize, motion: &Motion, own_point: DVec3, space: RenderSpace) {
        if motion.is_empty() {
            return;
        }
        let steps = in_space(motion, space);
        let mut iterations = 0;
        let heads: Vec<[Row; 2]> = (0..)
            .zip(&steps)
            .map(|(index, step)| {
                let (kind, keys, axis) = match &step.kind {
                    StepKind::Shift(track) => (SHIFT, track.len(), DVec3::ZERO),
                    StepKind::Spin { axis, degrees } => (SPIN, degrees.len(), *axis),
                    StepKind::Scale(track) => (RESIZE, track.len(), DVec3::ZERO),
                    StepKind::Turn(track) => (TURN, track.len(), DVec3::ZERO),
                };
                iterations += 1 + keys.next_power_of_two().ilog2();
                // Other spaces than that of all others have keys of their own.
                let key = (Arc::as_ptr(motion).cast::<MotionStep>(), index);
                let known = self.keys.get(&key).copied().filter(|_| space.scale == self.space.scale);
                let first_key = known.unwrap_or_else(|| {
                    let first = self.first_of_rows();
                    self.rows.extend(rows_of_keys(&step.kind));
                    self.keys.insert(key, first);
                    first
                });
                [row_of(own_point - step.center, kind | (keys as u32) << KEYS_SHIFT), row_of(axis, first_key)]
            })
            .collect();
        self.iterations = self.iterations.max(iterations);
        self.heads[1 + object] = [self.first_of_rows(), heads.len() as u32, 0, 0];
        self.rows.extend(heads.into_iter().flatten());
    }

    /// Adds the camera's keys. They are relative to where it is when the shutter opens.
    pub fn add_camera(&mut self, camera: &Camera, to_space: &Similarity) {
        let shutter = Shutter::new(camera);
        let up = (camera.up / camera.up.abs().max_element()).normalize();
        let points = [
            shutter.track(&camera.moving, |a, b, share| a.look_from.lerp(b.look_from, share)),
            shutter.track(&camera.moving, |a, b, share| a.look_at.lerp(b.look_at, share)),
        ];
        let keys = points[0].len() as u32;
        self.heads[0][0] = self.first_of_rows();
        self.heads[0][1] = keys;
        let flags = u32::from(camera.focus_distance.is_none()) | u32::from(camera.mirror) << 1;
        self.rows.push(row_of(to_space.rotation * up, flags));
        for track in points {
            let in_space = |point: DVec3| self.space.point(to_space.point(point));
            self.rows.extend(track.into_iter().map(|(time, point)| of_time(in_space(point), time)).collect::<Vec<_>>());
        }
        self.iterations = self.iterations.max(2 * keys.next_power_of_two().ilog2());
    }
}

/// The rows of a step's keys.
fn rows_of_keys(kind: &StepKind) -> Vec<Row> {
    fn of<T>(track: &Track<T>, value: impl Fn(&T) -> DVec3) -> Vec<Row> {
        track.iter().map(|(time, key)| of_time(value(key), *time)).collect()
    }
    match kind {
        StepKind::Shift(track) => of(track, |by| *by),
        // Half the angle, in turns.
        StepKind::Spin { degrees, .. } => of(degrees, |degrees| DVec3::new(degrees / 720.0, 0.0, 0.0)),
        StepKind::Scale(track) => of(track, |factor| DVec3::new(factor - 1.0, 0.0, 0.0)),
        StepKind::Turn(track) => {
            let rows =
                |(time, turn): &(f64, glam::DQuat)| [of_time(turn.xyz(), *time), [(turn.w as f32).to_bits(), 0, 0, 0]];
            track.iter().flat_map(rows).collect()
        }
    }
}

/// The own point of a shape, around which it turns and changes its size on the device, in render space: the corner of a quad, of a large sphere
/// maybe the point nearest to the camera, the middle of any other shape.
pub fn own_point(shape: &Shape<'_>, at: &ObjectTransform<'_>, motion: &Motion) -> DVec3 {
    match shape.large_sphere() {
        Some(large_sphere) if follows_nearest(shape, at, motion) => {
            at.space.point(large_sphere.nearest(at.to_world, at.space.eye))
        }
        _ => shape.bounding_shape(at).position(),
    }
}

/// Whether the own point of a large sphere is that which is nearest to the camera, because it moves less than the centre.
pub fn follows_nearest(shape: &Shape<'_>, at: &ObjectTransform<'_>, motion: &Motion) -> bool {
    let Some(large_sphere) = shape.large_sphere() else { return false };
    let steps = in_space(motion, at.space);
    let nearest = at.space.point(large_sphere.nearest(at.to_world, at.space.eye));
    farthest_of(&steps, nearest) < farthest_of(&steps, shape.bounding_shape(at).position())
}
