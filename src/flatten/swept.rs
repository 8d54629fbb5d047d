//! Bounds of what moves, over the whole time in which the shutter is open.
//!
//! The way of a point is sampled at even times between two keys. Between two of these times it leaves the straight line by at most h²/8 times
//! the largest acceleration, with h the time between them (the error of linear interpolation). The boxes are widened by that.

use glam::DVec3;

use super::motion::{MotionStep, StepKind};
use crate::scene::{keys_around, keys_up_to};
use crate::shape::{Aabb, BoundingShape};

/// The boxes are widened by at most this share of their size, unless that takes too many times.
const WIDENED: f64 = 0.01;
const MOST_TIMES: usize = 256;

/// A track's values where a part of the time begins and where it ends, without a jump at the end.
fn ends<'a, T>(track: &'a [(f64, T)], part: (f64, f64), between: impl Fn(&'a T, &'a T, f64) -> T) -> Option<(T, T)> {
    let value = |(before, after, share): (&'a T, &'a T, f64)| between(before, after, share);
    Some((keys_around(track, part.0).map(&value)?, keys_up_to(track, part.1).map(&value)?))
}

/// How much a step changes in a part of the time: the length of a shift, the angle of a turn in radians, the difference of factors.
fn change(step: &MotionStep, part: (f64, f64)) -> f64 {
    let found = match &step.kind {
        StepKind::Shift(track) => ends(track, part, |a, b, share| a.lerp(*b, share)).map(|(a, b)| (b - a).length()),
        StepKind::Spin { degrees, .. } => {
            ends(degrees, part, |a, b, share| a + share * (b - a)).map(|(a, b)| (b - a).to_radians().abs())
        }
        StepKind::Turn(track) => ends(track, part, |a, b, share| a.slerp(*b, share))
            .map(|(a, b)| 2.0 * a.dot(b).abs().clamp(0.0, 1.0).acos()),
        StepKind::Scale(track) => ends(track, part, |a, b, share| a + share * (b - a)).map(|(a, b)| (b - a).abs()),
    };
    found.unwrap_or(0.0)
}

/// The farthest that a step moves a point with this arm.
fn farthest(step: &MotionStep, arm: f64) -> f64 {
    match &step.kind {
        StepKind::Shift(track) => track.iter().map(|(_, by)| by.length()).fold(0.0, f64::max),
        StepKind::Spin { .. } | StepKind::Turn(_) => arm * step.largest_turn().min(2.0),
        StepKind::Scale(track) => arm * track.iter().map(|(_, factor)| (factor - 1.0).abs()).fold(0.0, f64::max),
    }
}

/// A bound of how far a point gets from its place at rest.
pub fn farthest_of(steps: &[MotionStep], point: DVec3) -> f64 {
    let more = |shift: f64, step: &MotionStep| shift + farthest(step, (point - step.center).length() + shift);
    steps.iter().fold(0.0, more)
}

/// The times at which some step has a key.
fn key_times(steps: &[MotionStep]) -> Vec<f64> {
    fn of<T>(track: &[(f64, T)]) -> Vec<f64> {
        track.iter().map(|(time, _)| *time).collect()
    }
    let mut times: Vec<f64> = Vec::new();
    for step in steps {
        times.extend(match &step.kind {
            StepKind::Shift(track) => of(track),
            StepKind::Spin { degrees, .. } => of(degrees),
            StepKind::Turn(track) => of(track),
            StepKind::Scale(track) => of(track),
        });
    }
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// A bound of the acceleration of all points of a ball in a part of the time, which counts as 1 here. A turn of p + c with the velocity v and the
/// acceleration a, by the angle w, adds 2 w v + w² |p| to a and w |p| to v; a factor with the derivative s adds 2 s v and s |p|.
fn acceleration(steps: &[MotionStep], center: DVec3, radius: f64, part: (f64, f64)) -> f64 {
    let (mut shift, mut velocity, mut acceleration) = (0.0, 0.0, 0.0);
    for step in steps {
        // The farthest that a point can be from the step's centre.
        let arm = (center - step.center).length() + radius + shift;
        let pace = change(step, part);
        match &step.kind {
            StepKind::Shift(_) => velocity += pace,
            StepKind::Spin { .. } | StepKind::Turn(_) => {
                acceleration += 2.0 * pace * velocity + pace * pace * arm;
                velocity += pace * arm;
            }
            StepKind::Scale(_) => {
                let most = step.largest_scale();
                acceleration = most * acceleration + 2.0 * pace * velocity;
                velocity = most * velocity + pace * arm;
            }
        }
        shift += farthest(step, arm);
    }
    acceleration
}

/// A box around a shape on all its way. The shape and the steps are in one space.
pub fn swept(shape: &BoundingShape, steps: &[MotionStep]) -> Aabb {
    let rest = shape.bounds();
    if steps.is_empty() {
        return rest;
    }
    // Of a ball, the centre moves.
    let half = 0.5 * (rest.max - rest.min).length();
    let (points, radius, around_points) = match *shape {
        BoundingShape::Ball { center, radius } => (vec![center], 0.0, radius * largest_scale(steps)),
        _ => (shape.corners(), half, 0.0),
    };
    let at = |time: f64| points.iter().map(move |point| steps.iter().fold(*point, |p, step| step.point_at(p, time)));
    let times = key_times(steps);
    // The size of the way, for how much wider a box may be.
    let ends = Aabb::around(times.iter().flat_map(|time| at(*time)));
    let size = half + 0.5 * (ends.max - ends.min).length();
    let mut way = ends;
    for part in times.windows(2).map(|pair| (pair[0], pair[1])) {
        let acceleration = acceleration(steps, rest.center(), radius, part);
        let wanted = (acceleration / (8.0 * WIDENED * size)).sqrt().ceil();
        let count = if wanted.is_finite() { (wanted as usize).clamp(1, MOST_TIMES) } else { MOST_TIMES };
        // The last time is just before a jump.
        let time = |i: usize| (part.0 + (part.1 - part.0) * i as f64 / count as f64).min(part.1.next_down());
        let around = Aabb::around((0..=count).flat_map(|i| at(time(i))));
        let wider = acceleration / (8.0 * (count * count) as f64);
        way = way.union(Aabb { min: around.min - wider, max: around.max + wider });
    }
    Aabb { min: way.min - around_points, max: way.max + around_points }
}

/// The angle, in radians, by which a motion turns directions at most.
pub fn largest_turn(steps: &[MotionStep]) -> f64 {
    steps.iter().map(MotionStep::largest_turn).sum()
}

/// The largest factor of size of a motion.
pub fn largest_scale(steps: &[MotionStep]) -> f64 {
    steps.iter().map(MotionStep::largest_scale).product()
}

/// Whether a motion changes the size of what it moves.
pub fn changes_size(steps: &[MotionStep]) -> bool {
    steps.iter().any(|step| matches!(step.kind, StepKind::Scale(_)))
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    fn spin(center: DVec3, axis: DVec3, turns: f64) -> MotionStep {
        let degrees = vec![(0.0, 0.0), (0.3, 100.0 * turns), (1.0, 360.0 * turns)];
        MotionStep { center, kind: StepKind::Spin { axis: axis.normalize(), degrees } }
    }

    /// Points of a shape on all its way are in the box, at many times that are not those of the search. A box around the shape at its ends is not.
    #[test]
    fn the_box_holds_the_whole_way() {
        let shift = |track| MotionStep { center: DVec3::ZERO, kind: StepKind::Shift(track) };
        let scale = |center, most| MotionStep { center, kind: StepKind::Scale(vec![(0.0, 1.0), (1.0, most)]) };
        let there_and_back = vec![(0.0, DVec3::ZERO), (0.5, DVec3::new(3.0, 1.0, 0.0)), (1.0, DVec3::ZERO)];
        let jump = vec![(0.0, DVec3::ZERO), (0.5, DVec3::X), (0.5, DVec3::new(0.0, 4.0, 0.0)), (1.0, DVec3::Y)];
        let far = DVec3::new(50.0, 0.0, -20.0);
        let motions = [
            vec![spin(DVec3::ZERO, DVec3::Z, 10.0)],
            vec![spin(DVec3::ONE, DVec3::new(1.0, 2.0, 0.5), 0.2), shift(there_and_back)],
            vec![shift(jump), spin(far, DVec3::Y, 0.5)],
            vec![scale(DVec3::NEG_ONE, 3.0), spin(DVec3::X, DVec3::X, 3.0), spin(far, DVec3::Z, 1.0)],
        ];
        let shapes = [
            BoundingShape::Ball { center: DVec3::X, radius: 0.5 },
            BoundingShape::Parallelogram { corner: DVec3::ZERO, u: DVec3::X, v: DVec3::new(0.0, 0.3, 2.0) },
            BoundingShape::Cuboid { center: DVec3::Y, half: DVec3::new(2.0, 0.1, 0.4), axes: DMat3::IDENTITY },
        ];
        for (number, motion) in motions.iter().enumerate() {
            for shape in &shapes {
                let corners = match *shape {
                    BoundingShape::Ball { center, radius } => {
                        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
                        axes.into_iter().flat_map(|axis| [center + radius * axis, center - radius * axis]).collect()
                    }
                    _ => shape.corners(),
                };
                let at =
                    |time: f64| corners.iter().map(move |p| motion.iter().fold(*p, |p, step| step.point_at(p, time)));
                let way = Aabb::around((0..=10_007).flat_map(|i| at(f64::from(i) / 10_007.0)));
                let found = swept(shape, motion);
                let slack = 1e-12 * (way.max - way.min).max_element();
                assert!(
                    (found.min - slack).cmple(way.min).all() && (found.max + slack).cmpge(way.max).all(),
                    "motion {number}: {way:?} leaves {found:?}"
                );
                // Wider by some hundredths.
                let wider = (found.max - found.min) / (way.max - way.min);
                assert!(wider.max_element() < 1.8, "motion {number}: {wider}");
                let ends = Aabb::around(at(0.0).chain(at(1.0)));
                assert!(!(ends.min.cmple(way.min).all() && ends.max.cmpge(way.max).all()), "motion {number}");
            }
        }
    }
}
