//! A hierarchy over the lights. With it, shaders/scene/light_tree prefers lights that are near a point and face it:
//! Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};

use super::octahedral::octahedral;
use crate::data::{self, LIGHT_NODE_LEAF, LIGHT_NODE_SKY, LIGHT_NODE_TWO_SIDED};
use crate::shape::Aabb;

/// The trail of a light is one word, with a bit for each level.
const DEEPEST: u32 = 32;
const BINS: usize = 12;

/// The kinds of lights. Each kind has a subtree of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    /// At a position, such as emitters and point lights.
    Positional,
    /// Directional lights, which are equally bright from every point.
    Directional,
    /// The sky, which is all around, and equally bright from every point.
    Sky,
}

/// The bounds of some lights: a box, and a cone around all their normals. They emit up to 90 degrees beyond the cone.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    pub around: Aabb,
    pub axis: DVec3,
    /// The half angle of the cone; pi if they emit in all directions.
    pub half_angle: f64,
    /// Whether they emit to both sides.
    pub two_sided: bool,
    /// Whether they emit nothing beyond the cone, as spot lights do.
    pub is_beam: bool,
    pub kind: LightKind,
    /// The mean radiance times the area; for a convex body, times its mean projected area. For directional lights, the irradiance.
    pub intensity: f64,
}

impl LightBounds {
    fn joined(&self, other: &LightBounds) -> LightBounds {
        let (mut a, mut b) = (*self, *other);
        // A two-sided light has two axes; the nearer one counts.
        if a.axis.dot(b.axis) < 0.0 {
            match (a.two_sided, b.two_sided) {
                (_, true) => b.axis = -b.axis,
                (true, _) => a.axis = -a.axis,
                _ => {}
            }
        }
        let (axis, half_angle) = joined_cone((a.axis, a.half_angle), (b.axis, b.half_angle));
        LightBounds {
            around: a.around.union(b.around),
            axis,
            half_angle,
            two_sided: a.two_sided || b.two_sided,
            is_beam: a.is_beam && b.is_beam,
            kind: a.kind,
            intensity: a.intensity + b.intensity,
        }
    }

    /// The cost that a cut minimises: intensity times surface times the solid angle of emission (section 4.4).
    fn cost(&self) -> f64 {
        let surface = self.around.half_area();
        let (sine, cosine) = self.half_angle.sin_cos();
        let emission_angle = if self.is_beam { self.half_angle } else { (self.half_angle + FRAC_PI_2).min(PI) };
        let beyond =
            2.0 * emission_angle * sine - (self.half_angle - 2.0 * emission_angle).cos() - 2.0 * self.half_angle * sine
                + cosine;
        let directions = 2.0 * PI * (1.0 - cosine) + FRAC_PI_2 * beyond;
        self.intensity * surface * directions * if self.two_sided { 2.0 } else { 1.0 }
    }
}

/// The smallest cone around two.
fn joined_cone((a, a_half_angle): (DVec3, f64), (b, b_half_angle): (DVec3, f64)) -> (DVec3, f64) {
    let between = a.dot(b).clamp(-1.0, 1.0).acos();
    if (between + b_half_angle).min(PI) <= a_half_angle {
        return (a, a_half_angle);
    }
    if (between + a_half_angle).min(PI) <= b_half_angle {
        return (b, b_half_angle);
    }
    let half_angle = 0.5 * (a_half_angle + between + b_half_angle);
    let rotation_axis = a.cross(b).normalize_or_zero();
    if half_angle >= PI || rotation_axis == DVec3::ZERO {
        return (a, PI);
    }
    (DQuat::from_axis_angle(rotation_axis, half_angle - a_half_angle) * a, half_angle)
}

/// The hierarchy as the device reads it.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// Pairs of siblings. The root's children are first. Empty if there are fewer than two lights.
    pub nodes: Vec<data::LightNode>,
    /// The path to each light, from the lowest bit on. A set bit goes to the second node of a pair.
    pub trails: Vec<u32>,
}

impl LightTree {
    /// Builds the tree over lights: those at a position, directional lights, and the sky if it is a light, in this order.
    pub fn new(lights: &[LightBounds]) -> LightTree {
        let mut tree = LightTree { nodes: Vec::new(), trails: vec![0; lights.len()] };
        let mut order: Vec<usize> = (0..lights.len()).collect();
        let unit = 1.0 / lights.iter().map(|light| light.intensity).fold(0.0, f64::max);
        if lights.len() > 1 {
            tree.grow(lights, &mut order, unit, (0, 0));
        }
        tree
    }

    /// Builds the subtree of a node: a light or a pair of nodes. Returns its code and its bounds. `at` is the node's depth
    /// and trail.
    fn under(&mut self, lights: &[LightBounds], order: &mut [usize], unit: f64, at: (u32, u32)) -> (u32, LightBounds) {
        match order {
            [light] => {
                self.trails[*light] = at.1;
                (LIGHT_NODE_LEAF | *light as u32, lights[*light])
            }
            _ => self.grow(lights, order, unit, at),
        }
    }

    /// Builds a pair of nodes and everything below it. Returns the index of the pair's first node, and the bounds. `at`
    /// is the depth and the trail of the node above.
    fn grow(
        &mut self,
        lights: &[LightBounds],
        order: &mut [usize],
        unit: f64,
        (depth, trail): (u32, u32),
    ) -> (u32, LightBounds) {
        let pair = self.nodes.len();
        self.nodes.extend([data::LightNode::default(); 2]);
        let first_kind = first_kind(lights, order);
        let at = first_kind.unwrap_or_else(|| cut(lights, order, depth));
        let (left, right) = order.split_at_mut(at);
        let bounds = [(0, left), (1, right)].map(|(side, part)| {
            let (child, bounds) = self.under(lights, part, unit, (depth + 1, trail | side << depth));
            let child = child | if first_kind.is_some() && side == 1 { LIGHT_NODE_SKY } else { 0 };
            self.nodes[pair + side as usize] = node(&bounds, unit, child);
            bounds
        });
        (pair as u32, bounds[0].joined(&bounds[1]))
    }
}

/// The number of lights of the first kind: positional ones before lights at infinity, or directional ones before the sky. `None` if all
/// lights are of one kind.
fn first_kind(lights: &[LightBounds], order: &[usize]) -> Option<usize> {
    let count = |is_first: fn(LightKind) -> bool| {
        Some(order.iter().filter(|&&light| is_first(lights[light].kind)).count())
            .filter(|count| (1..order.len()).contains(count))
    };
    count(|kind| kind == LightKind::Positional).or_else(|| count(|kind| kind != LightKind::Sky))
}

/// Orders lights so that those of the first child come first. Returns their number, which is neither 0 nor all.
fn cut(lights: &[LightBounds], order: &mut [usize], depth: u32) -> usize {
    let half = order.len() / 2;
    let middle = |i: usize| lights[i].around.center();
    let middles = Aabb::around(order.iter().map(|&i| middle(i)));
    let extent = middles.max - middles.min;
    let bin = |axis: usize, i: usize| {
        let share = (middle(i)[axis] - middles.min[axis]) / extent[axis];
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    // From the depth at which halving just fits into the trail, groups are halved.
    let halves_left = usize::BITS - (order.len() - 1).leading_zeros();
    if depth + halves_left + 1 < DEEPEST {
        for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
            let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
            let join = |sum: Option<LightBounds>, next: &LightBounds| Some(sum.map_or(*next, |sum| sum.joined(next)));
            for &i in &*order {
                let bin = &mut bins[bin(axis, i)];
                *bin = join(*bin, &lights[i]);
            }
            // A long and thin node is worse than its surface area suggests.
            let shape = extent.max_element() / extent[axis];
            for first_right in 1..BINS {
                let side = |part: &[Option<LightBounds>]| part.iter().flatten().fold(None, join);
                if let (Some(left), Some(right)) = (side(&bins[..first_right]), side(&bins[first_right..])) {
                    let cost = shape * (left.cost() + right.cost());
                    if best.is_none_or(|(least, ..)| cost < least) {
                        best = Some((cost, axis, first_right));
                    }
                }
            }
        }
    }
    match best {
        Some((_, axis, first_right)) => {
            order.sort_by_key(|&i| (bin(axis, i) >= first_right, i));
            order.partition_point(|&i| bin(axis, i) < first_right)
        }
        None => {
            let axis = extent.max_position();
            order.sort_by(|&i, &j| middle(i)[axis].total_cmp(&middle(j)[axis]).then(i.cmp(&j)));
            half
        }
    }
}

fn node(bounds: &LightBounds, unit: f64, child: u32) -> data::LightNode {
    if bounds.kind != LightKind::Positional {
        // So large that every point is inside it. The importance there is its intensity over the squared radius.
        const RADIUS: f32 = (1u32 << 20) as f32;
        let intensity = not_lost(bounds.intensity * unit) * (RADIUS * RADIUS);
        return data::LightNode {
            radius: RADIUS,
            intensity,
            cos_half_angle: -1.0,
            child,
            ..data::LightNode::default()
        };
    }
    // A margin, so that rounding cannot exclude a light.
    const ROUNDING: f64 = 1e-4;
    const ROUNDING_OF_F32: f64 = f32::EPSILON as f64;
    // Its square is a normal number in f32, and far below the square of any distance that matters.
    const LEAST_RADIUS: f64 = 1.0 / (1u64 << 60) as f64;
    let radius = 0.5 * (bounds.around.max - bounds.around.min).length() * (1.0 + 1e-6);
    let center = bounds.around.center();
    data::LightNode {
        center: center.as_vec3().to_array(),
        // The sign marks beams. Only these need a bound of the centre's rounding, because they emit nothing beyond the cone.
        radius: if bounds.is_beam { -(radius + 2.0 * ROUNDING_OF_F32 * center.length() + LEAST_RADIUS) } else { radius }
            as f32,
        intensity: not_lost(bounds.intensity * unit),
        axis: octahedral(bounds.axis.as_vec3()),
        cos_half_angle: (bounds.half_angle + ROUNDING).min(PI).cos() as f32,
        child: child | if bounds.two_sided { LIGHT_NODE_TWO_SIDED } else { 0 },
    }
}

/// An intensity as f32, which stays positive if it is positive.
fn not_lost(intensity: f64) -> f32 {
    const LEAST: f64 = 1e-30;
    if intensity > 0.0 { intensity.max(LEAST) as f32 } else { 0.0 }
}
