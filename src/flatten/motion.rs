//! The motion of objects while the shutter is open.
//!
//! An object has a pose at the time at which the shutter opens, and steps that move it from there: shifts, turns and changes of size, in the
//! world. Transforms that do not change are part of that pose. So a step acts on the object as the steps before it have left it.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3};

use crate::scene::{Camera, Transform, keys_around, keys_up_to};
use crate::shape::RenderSpace;
use crate::shape::similarity::Similarity;

/// The values of a step: times from 0, where the shutter opens, to 1, where it closes, each with a value. The first time is 0, the last one
/// is 1, and times do not decrease.
pub type Track<T> = Vec<(f64, T)>;

/// A step, relative to its value at time 0.
#[derive(Clone, Debug)]
pub enum StepKind {
    /// A shift, in the world.
    Shift(Track<DVec3>),
    /// Turns of this axis, right-handed, in degrees.
    Spin { axis: DVec3, degrees: Track<f64> },
    /// Turns, each from the one before by the shortest arc.
    Turn(Track<DQuat>),
    /// Factors of the size.
    Scale(Track<f64>),
}

/// A step of a motion.
#[derive(Clone, Debug)]
pub struct MotionStep {
    /// The point that a turn or a change of size keeps in place, in the world.
    pub center: DVec3,
    pub kind: StepKind,
}

/// The steps of a motion, in the order in which they apply. Without steps, the object rests.
pub type Motion = Arc<[MotionStep]>;

/// The times at which the shutter opens and closes, in seconds.
#[derive(Clone, Copy)]
pub struct Shutter {
    open: f64,
    close: f64,
}

/// The pose of an object where the shutter opens, and its motion from there.
#[derive(Clone, Debug)]
pub struct Placement {
    /// The transform from its own space to the world.
    pub to_world: Similarity,
    pub motion: Motion,
}

impl Placement {
    /// Where a point of the object's own space is in the world, at a time from 0 to 1.
    pub fn point_at(&self, p: DVec3, time: f64) -> DVec3 {
        self.motion.iter().fold(self.to_world.point(p), |p, step| step.point_at(p, time))
    }

    /// The point of the object's own space that is at `p` in the world, at a time from 0 to 1.
    pub fn own_point_at(&self, p: DVec3, time: f64) -> DVec3 {
        self.to_world.inverse().point(self.motion.iter().rev().fold(p, |p, step| step.point_before(p, time)))
    }

    pub fn resting(to_world: Similarity) -> Placement {
        Placement { to_world, motion: Arc::new([]) }
    }

    /// The placement of what is inside, with this transform.
    pub fn transformed(&self, by: &[Transform]) -> Placement {
        Placement { to_world: self.to_world.after(&similarity(by)), motion: Arc::clone(&self.motion) }
    }

    /// The placement of what is inside, with these keys.
    pub fn moving(&self, keys: &[(f64, Vec<Transform>)], shutter: Shutter) -> Placement {
        let count = keys.first().map_or(0, |(_, by)| by.len());
        let mut steps = Vec::new();
        let mut to_world = self.to_world;
        // From the outside to the inside: each step moves what is inside of it, in the pose that the steps outside of it have at time 0.
        for index in (0..count).rev() {
            let values: Vec<(f64, &Transform)> =
                keys.iter().filter_map(|(time, by)| Some((*time, by.get(index)?))).collect();
            let track = shutter.track(&values, |a, b, share| between(a, b, share));
            let Some((_, first)) = track.first() else { continue };
            let first = first.clone();
            if let Some(kind) = step(&first, &track, &to_world) {
                steps.push(MotionStep { center: to_world.translation, kind });
            }
            to_world = to_world.after(&similarity(std::slice::from_ref(&first)));
        }
        steps.reverse();
        steps.extend(self.motion.iter().cloned());
        Placement { to_world, motion: steps.into() }
    }
}

impl Shutter {
    pub fn new(camera: &Camera) -> Shutter {
        let (open, close) = camera.shutter;
        Shutter { open, close }
    }

    /// The values while the shutter is open; `between` interpolates. Only the first value if it is open for no time.
    pub fn track<K, T>(&self, keys: &[(f64, K)], between: impl Fn(&K, &K, f64) -> T) -> Track<T> {
        let at = |time: f64| keys_around(keys, time).map(|(before, after, share)| between(before, after, share));
        let length = self.close - self.open;
        let Some(first) = at(self.open) else { return Vec::new() };
        let mut track = vec![(0.0, first)];
        if length > 0.0 {
            let inside = keys.iter().filter(|(time, _)| self.open < *time && *time < self.close);
            track.extend(inside.map(|(time, key)| ((time - self.open) / length, between(key, key, 0.0))));
            // At the end, a key at that very time does not count yet: a jump there is behind the shutter's close.
            let last = keys_up_to(keys, self.close).map(|(before, after, share)| between(before, after, share));
            track.extend(last.map(|last| (1.0, last)));
        }
        track
    }
}

/// A transform between two of one kind.
fn between(a: &Transform, b: &Transform, share: f64) -> Transform {
    let mix = |a: f64, b: f64| a + share * (b - a);
    match (a, b) {
        (Transform::Translate(a), Transform::Translate(b)) => Transform::Translate(a.lerp(*b, share)),
        (Transform::Scale(a), Transform::Scale(b)) => Transform::Scale(mix(*a, *b)),
        (Transform::RotateX(a), Transform::RotateX(b)) => Transform::RotateX(mix(*a, *b)),
        (Transform::RotateY(a), Transform::RotateY(b)) => Transform::RotateY(mix(*a, *b)),
        (Transform::RotateZ(a), Transform::RotateZ(b)) => Transform::RotateZ(mix(*a, *b)),
        (Transform::Rotate { axis, degrees: a }, Transform::Rotate { axis: other, degrees: b }) if axis == other => {
            Transform::Rotate { axis: *axis, degrees: mix(*a, *b) }
        }
        (Transform::Rotate { .. }, Transform::Rotate { .. }) => {
            let (axis, radians) = turn(a).slerp(turn(b), share).to_axis_angle();
            Transform::Rotate { axis, degrees: radians.to_degrees() }
        }
        // Keys have the same kinds, which is checked when the scene is read.
        _ => a.clone(),
    }
}

/// The rotation of a transform.
fn turn(transform: &Transform) -> DQuat {
    DQuat::from_mat3(&similarity(std::slice::from_ref(transform)).rotation).normalize()
}

/// The step of a transform inside of `outside`; nothing if its value does not change.
fn step(first: &Transform, track: &Track<Transform>, outside: &Similarity) -> Option<StepKind> {
    let spin = |own: DVec3, degrees: fn(&Transform) -> f64| {
        let axis = (own / own.abs().max_element()).normalize();
        let values = relative(track, |value| degrees(value) - degrees(first))?;
        Some(StepKind::Spin { axis: outside.rotation * axis, degrees: values })
    };
    let degrees = |value: &Transform| match value {
        Transform::RotateX(degrees) | Transform::RotateY(degrees) | Transform::RotateZ(degrees) => *degrees,
        Transform::Rotate { degrees, .. } => *degrees,
        _ => 0.0,
    };
    match first {
        Transform::Translate(start) => relative(track, |value| match value {
            Transform::Translate(by) => outside.vector(*by - *start),
            _ => DVec3::ZERO,
        })
        .map(StepKind::Shift),
        Transform::Scale(start) => {
            let factor = |value: &Transform| if let Transform::Scale(factor) = value { factor / start } else { 1.0 };
            track
                .iter()
                .any(|(_, value)| factor(value) != 1.0)
                .then(|| StepKind::Scale(track.iter().map(|(time, value)| (*time, factor(value))).collect()))
        }
        Transform::RotateX(_) => spin(DVec3::X, degrees),
        Transform::RotateY(_) => spin(DVec3::Y, degrees),
        Transform::RotateZ(_) => spin(DVec3::Z, degrees),
        Transform::Rotate { axis, .. } => {
            let is_about = |value: &Transform| matches!(value, Transform::Rotate { axis: other, .. } if other == axis);
            if track.iter().all(|(_, value)| is_about(value)) {
                return spin(*axis, degrees);
            }
            let around = DQuat::from_mat3(&outside.rotation).normalize();
            let undo = turn(first).inverse();
            let mut last = DQuat::IDENTITY;
            let turns = track.iter().map(|(time, value)| {
                let turn = around * turn(value) * undo * around.inverse();
                // Both signs are the same turn. That of the shorter arc continues the one before.
                last = if turn.dot(last) < 0.0 { -turn } else { turn };
                (*time, last)
            });
            Some(StepKind::Turn(turns.collect()))
        }
    }
}

/// The values of a track by a function; nothing if all are 0.
fn relative<T: Default + PartialEq>(track: &Track<Transform>, value: impl Fn(&Transform) -> T) -> Option<Track<T>> {
    let values: Track<T> = track.iter().map(|(time, of)| (*time, value(of))).collect();
    values.iter().any(|(_, value)| *value != T::default()).then_some(values)
}

/// A list of transforms, applied in the order listed.
pub fn similarity(transforms: &[Transform]) -> Similarity {
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

impl MotionStep {
    /// Where it takes a point at a time from 0 to 1.
    pub fn point_at(&self, p: DVec3, time: f64) -> DVec3 {
        self.center + self.at(time).point(p - self.center)
    }

    /// The point that it takes to `p` at a time from 0 to 1.
    pub fn point_before(&self, p: DVec3, time: f64) -> DVec3 {
        self.center + self.at(time).inverse().point(p - self.center)
    }

    /// What it does at a time from 0 to 1, relative to the point that it keeps in place.
    fn at(&self, time: f64) -> Similarity {
        let mix = |a: &f64, b: &f64, share: f64| a + share * (b - a);
        match &self.kind {
            StepKind::Shift(track) => Similarity::translation(value_at(track, time, |a, b, share| a.lerp(*b, share))),
            StepKind::Spin { axis, degrees } => Similarity::rotation(*axis, value_at(degrees, time, mix)),
            StepKind::Turn(track) => {
                let turn: DQuat = value_at(track, time, |a, b, share| a.slerp(*b, share));
                Similarity { rotation: DMat3::from_quat(turn), ..Similarity::IDENTITY }
            }
            StepKind::Scale(track) => Similarity::scale(value_at(track, time, mix)),
        }
    }

    /// The largest factor of size that it has.
    pub fn largest_scale(&self) -> f64 {
        match &self.kind {
            StepKind::Scale(track) => track.iter().map(|(_, factor)| *factor).fold(1.0, f64::max),
            _ => 1.0,
        }
    }

    /// The angle, in radians, by which it turns directions at most.
    pub fn largest_turn(&self) -> f64 {
        match &self.kind {
            StepKind::Spin { degrees, .. } => {
                degrees.iter().map(|(_, degrees)| degrees.to_radians().abs()).fold(0.0, f64::max)
            }
            StepKind::Turn(track) => {
                track.windows(2).map(|pair| 2.0 * pair[0].1.dot(pair[1].1).clamp(0.0, 1.0).acos()).sum()
            }
            _ => 0.0,
        }
    }
}

/// The steps in another space: the world, moved and scaled.
pub fn in_space(motion: &[MotionStep], space: RenderSpace) -> Vec<MotionStep> {
    let scaled = |step: &MotionStep| MotionStep {
        center: space.point(step.center),
        kind: match &step.kind {
            StepKind::Shift(track) => {
                StepKind::Shift(track.iter().map(|(time, by)| (*time, *by * space.scale)).collect())
            }
            kind => kind.clone(),
        },
    };
    motion.iter().map(scaled).collect()
}

/// A track's value at a time from 0 to 1.
fn value_at<T, U>(track: &[(f64, T)], time: f64, between: impl Fn(&T, &T, f64) -> U) -> U
where
    U: Default,
{
    keys_around(track, time).map_or_else(U::default, |(before, after, share)| between(before, after, share))
}
