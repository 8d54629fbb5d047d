//! Boxes of many sizes, what they are in f64, and rays at them.

use glam::{DMat3, DVec3};
use gpu_rt::data::Cuboid;

use super::scenes::{flat, triple};
use super::stats::Random;
use super::trace::In;
use super::vectors::{U, decades, exact, unit};

/// Boxes turned any way, with a longest edge of 1e-4 to 1e5 and, of half of them, the others down to 10^-`aspect` of it, their centres
/// at distances from the origin of space within these decades of such an edge. Every fourth is not turned.
pub fn assorted(random: &mut Random, count: usize, aspect: f64, distance: (f64, f64)) -> Vec<Cuboid> {
    let texts: Vec<String> = (0..count)
        .map(|i| {
            let size = decades(random, -4.0, 5.0);
            let mut edge = |from: f64| size * decades(random, from, 0.0);
            let from = if i % 2 == 0 { 0.0 } else { -aspect };
            let edges = DVec3::new(edge(from), edge(from), edge(from));
            let low = size * decades(random, distance.0, distance.1) * unit(random);
            let cuboid = format!("Box(min: {}, max: {}, material: \"m\")", triple(low), triple(low + edges));
            if i % 4 == 0 {
                return cuboid;
            }
            // About the box's own middle, to keep it where it is.
            let (middle, axis, degrees) = (low + 0.5 * edges, unit(random), 360.0 * random.uniform());
            format!(
                "Transformed(by: [Translate({}), Rotate(axis: {}, degrees: {degrees:?}), Translate({})], object: {cuboid})",
                triple(-middle),
                triple(axis),
                triple(middle)
            )
        })
        .collect();
    flat(&texts).shapes.cuboids
}

/// A cuboid in f64: its axes as columns, the centre and half its edges.
pub struct Exact {
    pub axes: DMat3,
    pub center: DVec3,
    pub half: DVec3,
}

impl Exact {
    pub fn new(cuboid: &Cuboid) -> Exact {
        let (x, y) = (exact(cuboid.x_axis), exact(cuboid.y_axis));
        let axes = DMat3::from_cols(x, y, x.cross(y));
        Exact { axes, center: exact(cuboid.center), half: exact(cuboid.half_extent) }
    }

    /// Along the axes from the centre.
    pub fn local(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.center)
    }

    /// Where a line is within the box with its faces moved out by `grown`: the distances of entry and exit, or nothing.
    pub fn span(&self, origin: DVec3, direction: DVec3, grown: f64) -> Option<(f64, f64)> {
        let (o, d) = (self.local(origin), self.axes.transpose() * direction);
        let half = self.half + grown;
        within(o, d, -half, half, f64::NEG_INFINITY)
    }

    /// How far f32 may misplace the faces along a ray: the rounding of the origin and of t times the direction in the
    /// box's axes. Each is a difference, a cross product and a dot product, 6 u of its length, and a division.
    pub fn blur(&self, origin: DVec3) -> f64 {
        8.0 * U * (2.0 * (origin - self.center).length() + 2.0 * self.half.length())
    }
}

/// Where a line from `o` along `d` is between two corners, beyond the distance `from`.
pub fn within(o: DVec3, d: DVec3, low: DVec3, high: DVec3, from: f64) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (from, f64::INFINITY);
    for i in 0..3 {
        if d[i] == 0.0 {
            if o[i] < low[i] || o[i] > high[i] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[i] - o[i]) / d[i], (high[i] - o[i]) / d[i]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some((enter, leave))
}

/// Rays at points in and a little outside boxes, from outside and inside.
pub fn rays_at(random: &mut Random, cuboids: &[Cuboid], count: usize) -> Vec<In> {
    let mut cube = |reach: f64| (2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0) * reach;
    let pairs: Vec<(DVec3, DVec3)> = (0..count).map(|_| (cube(1.05), cube(0.95))).collect();
    pairs
        .into_iter()
        .enumerate()
        .map(|(i, (target, inside))| {
            let at = Exact::new(&cuboids[i % cuboids.len()]);
            let target = at.center + at.axes * (target * at.half);
            let origin = match i % 3 {
                0 => at.center + at.axes * (inside * at.half),
                _ => target + at.half.length() * decades(random, -1.0, 3.0) * unit(random),
            };
            In::new(i % cuboids.len(), origin, (target - origin).normalize())
        })
        .collect()
}

/// The bound of the error of its points, as the shader has it.
pub fn error_of(cuboid: &Cuboid) -> f64 {
    8.0 * U * (exact(cuboid.center).abs().max_element() + exact(cuboid.half_extent).element_sum())
}
