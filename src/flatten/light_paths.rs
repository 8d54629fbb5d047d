//! What light paths need: the boxes at which they are aimed, around what can be specular, and the lights at which they start.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::builder::Builder;
use super::finder::{Primitive, with_indices};
use super::light_tree::{LightBounds, LightKind};
use super::motion::in_space;
use super::swept::swept;
use crate::bitmap::Bitmaps;
use crate::data::{self, HIT_NOTHING, f32s};
use crate::light_distribution::alias_entries;
use crate::material::{LobeWidth, Material, ROUGHNESS};

use crate::shape::{Aabb, BoundingShape, ObjectTransform};

/// The most boxes.
const MOST_AIMS: usize = 16;

/// A light at which paths may start.
pub struct Start {
    /// The code of its primitive.
    pub code: u32,
    /// Its area; 0 without one.
    pub area: f64,
    /// Whether paths start there: not at a large sphere, whose points are too far apart for f32, and not at the sky.
    pub is_possible: bool,
}

/// The weight of boxes around panes, beside that of others: a pane reflects about a twelfth of the light, and what passes is no event.
const WEIGHT_OF_PANES: f64 = 0.1;

/// The share of the largest coordinate of a box by which it is larger than what it is around: a light path that starts on a face, or in the plane of
/// a flat box, starts strictly inside then, however its point is rounded (by at most 12 units of roundoff: shaders/geometry/cuboid.wgsl).
const PADDING: f64 = 1.0 / (1 << 19) as f64;

/// A shape that can be specular, with the code of its primitive; of a mesh [`HIT_NOTHING`], since its faces have codes of their own.
type Aimed = (BoundingShape, u32);

/// A box, in render space.
#[derive(Clone, Copy)]
struct Aim {
    /// The code of the primitive that it is around, if there is one alone. A light does not aim at the box around itself: it is flat or convex.
    around: u32,
    /// How likely it is aimed at, beside other boxes of its size.
    weight: f64,
    center: DVec3,
    half: DVec3,
    axes: DMat3,
}

impl Builder<'_> {
    /// Adds the tables of light paths, if the scene has lights at which they can start, and something specular.
    pub fn add_light_paths(&mut self, primitives: &[Primitive<'_>], lights: &[LightBounds], starts: &[Start]) {
        let (mut solid, mut panes, mut reason) = (Vec::new(), Vec::new(), None);
        // Once for each material, since a roughness may be an image, whose least texel counts.
        let aimed: Vec<bool> = self.scene.materials.iter().map(|(_, m)| is_aimed_at(m, &self.scene.bitmaps)).collect();
        let aimed: Vec<bool> = self.needed.iter().map(|numbers| numbers.iter().any(|number| aimed[*number])).collect();
        for (index, primitive) in with_indices(primitives).filter(|(_, primitive)| aimed[primitive.material as usize]) {
            let (name, material) = &self.scene.materials[primitive.material as usize];
            if primitive.shape.large_sphere().is_none() {
                reason.get_or_insert_with(|| format!("\"{name}\" at {}", self.scene.material_location(name)));
                let at = ObjectTransform { to_world: &primitive.to_world, space: self.space };
                let is_pane = matches!(material, Material::ThinDielectric(_));
                let shapes = if is_pane { &mut panes } else { &mut solid };
                let shape = primitive.shape.bounding_shape(&at);
                let is_alone = primitive.shape.fills_bounding_shape();
                let code = if is_alone { primitive.shape.code(index as usize) } else { HIT_NOTHING };
                let shape = match primitive.motion.is_empty() {
                    true => shape,
                    false => swept(&shape, &in_space(&primitive.motion, self.space)).into(),
                };
                shapes.push((shape, code));
            }
        }
        let aims = aims(vec![(1.0, solid), (WEIGHT_OF_PANES, panes)]);
        // The variance of BSDF sampling is a sum over the lights: a light adds the square of its power over its solid angle.
        let (mut powers, mut squares) = (vec![0.0; lights.len()], 0.0);
        for ((power, light), start) in powers.iter_mut().zip(lights).zip(starts).filter(|(_, start)| start.is_possible)
        {
            let aimed_at = aims.iter().filter(|aim| aim.around != start.code);
            let received = aimed_at.map(|aim| (aim, light.intensity * aim.weight * aim.received_share(light)));
            let received: Vec<_> = received.filter(|(_, received)| *received > 0.0).collect();
            *power = received.iter().map(|(_, received)| received).sum();
            let per_solid_angle = |(aim, received): &(&Aim, f64)| received / aim.solid_angle_of(light, start.area);
            squares += *power * received.iter().map(per_solid_angle).sum::<f64>();
        }
        let sizes: Vec<f64> = starts.iter().map(|start| if start.area > 0.0 { start.area } else { 1.0 }).collect();
        if let Some(emitters) = alias_entries(&powers, &sizes) {
            self.flat.emitters = emitters;
            self.flat.features.quantities.solid_angle_of_lights = powers.iter().sum::<f64>().powi(2) / squares;
            self.flat.features.quantities.aims = aims.len() as u32;
            if let Some(reason) = reason {
                self.flat.features.require("light_paths", || reason);
            }
            self.flat.aims = aims.iter().map(Aim::on_device).collect();
        }
    }
}

/// Whether light paths are aimed at a surface: a specular one, or a near mirror, which has narrow lobes alone.
fn is_aimed_at(material: &Material, bitmaps: &Bitmaps) -> bool {
    let widths = material.widths(bitmaps);
    let varies = material.has_row(ROUGHNESS);
    let is_near_mirror = widths.contains(&LobeWidth::Narrow) && (varies || !widths.contains(&LobeWidth::Wide));
    widths.contains(&LobeWidth::Specular) || is_near_mirror
}

impl Aim {
    /// A box around a shape, along the shape's own axes.
    fn around(&(shape, around): &Aimed, weight: f64) -> Aim {
        match shape {
            BoundingShape::Ball { center, radius } => {
                Aim { around, weight, center, half: DVec3::splat(radius), axes: DMat3::IDENTITY }
            }
            BoundingShape::Parallelogram { corner, u, v } => {
                let x = u.normalize_or_zero();
                let z = u.normalize_or_zero().cross(v.normalize_or_zero()).normalize_or_zero();
                let axes = DMat3::from_cols(x, z.cross(x), z);
                let half = (axes.transpose() * u).abs() + (axes.transpose() * v).abs();
                Aim { around, weight, center: corner + 0.5 * (u + v), half: 0.5 * half.with_z(0.0), axes }
            }
            BoundingShape::Cuboid { center, half, axes } => Aim { around, weight, center, half, axes },
        }
    }

    /// The share of a light's intensity that the box receives: its solid angle, or of a directional light the area of its shadow; 0 if the
    /// light faces away from all of it.
    fn received_share(&self, light: &LightBounds) -> f64 {
        let radius = self.half.length();
        if light.kind != LightKind::Positional {
            return PI * radius * radius;
        }
        let to_box = self.center - light.around.center();
        let around = 0.5 * (light.around.max - light.around.min).length();
        let is_flat_and_one_sided = light.half_angle == 0.0 && !light.two_sided;
        if is_flat_and_one_sided && to_box.dot(light.axis) < -(radius + around) {
            return 0.0;
        }
        let sine = radius / to_box.length();
        if sine < 1.0 { 2.0 * PI * sine * sine / (1.0 + (1.0 - sine * sine).sqrt()) } else { 4.0 * PI }
    }

    /// The solid angle of a light of this area, seen from the box, or from its surface if the light is within: an estimate, which is at most a half
    /// sphere.
    fn solid_angle_of(&self, light: &LightBounds, area: f64) -> f64 {
        let to_box = self.center - light.around.center();
        // The mean projected area of a flat light over its side, and of a convex body.
        let projected = if light.half_angle == 0.0 { 0.5 * area } else { 0.25 * area };
        (projected / to_box.length_squared().max(self.half.min_element().powi(2))).min(2.0 * PI)
    }

    /// The box as kernels have it, larger by [`PADDING`].
    fn on_device(&self) -> data::Cuboid {
        let largest = self.center.abs().max_element() + self.half.length();
        data::Cuboid {
            center: f32s(self.center),
            half_extent: f32s(self.half + PADDING * largest),
            material: (self.weight as f32).to_bits(),
            light: self.around,
            x_axis: f32s(self.axes.x_axis),
            y_axis: f32s(self.axes.y_axis),
            ..data::Cuboid::default()
        }
    }
}

/// At most [`MOST_AIMS`] boxes around the shapes of each weight. Groups of shapes are halved along their longest side, the largest first.
fn aims(mut groups: Vec<(f64, Vec<Aimed>)>) -> Vec<Aim> {
    while groups.len() < MOST_AIMS {
        let size = |(weight, group): &(f64, Vec<Aimed>)| {
            if group.len() > 1 { weight * bounds_of(group).half_area() } else { -1.0 }
        };
        let largest = (0..groups.len()).max_by(|a, b| size(&groups[*a]).total_cmp(&size(&groups[*b])));
        let Some(largest) = largest.filter(|largest| groups[*largest].1.len() > 1) else { break };
        let (weight, group) = &mut groups[largest];
        let Aabb { min, max } = bounds_of(group);
        let axis = (max - min).max_position();
        let middle = |(shape, _): &Aimed| shape.ball().0[axis];
        group.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
        let rest = (*weight, group.split_off(group.len() / 2));
        groups.push(rest);
    }
    let around = |(weight, group): &(f64, Vec<Aimed>)| match group.as_slice() {
        [] => None,
        [one] => Some(Aim::around(one, *weight)),
        all => {
            let around = BoundingShape::from(bounds_of(all));
            Some(Aim::around(&(around, HIT_NOTHING), *weight))
        }
    };
    groups.iter().filter_map(around).collect()
}

/// The box around shapes along the axes.
fn bounds_of(shapes: &[Aimed]) -> Aabb {
    Aabb::around_all(shapes.iter().map(|(shape, _)| shape.bounds()))
}
