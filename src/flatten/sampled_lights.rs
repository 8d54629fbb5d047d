//! Selects the lights that are sampled: all emitters whose surface or directions can be sampled.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::builder::Builder;
use super::features::{NotSampled, PRIMITIVES};
use super::finder::{MovingLight, Primitive};
use super::light_paths::Start;
use super::light_tree::{LightBounds, LightKind, LightTree};
use super::motion::in_space;
use super::swept::{changes_size, largest_scale, largest_turn, swept};
use crate::data::{self, HIT_NOTHING, KIND_DELTA_LIGHT, NOT_SAMPLED, luminance, primitive_code};
use crate::light_distribution::SkyDistribution;
use crate::material::Emission;
use crate::scene::{Background, Bitmap};
use crate::shape::{Aabb, BoundingShape, Emitter, KINDS, ObjectTransform, exp2};

/// The most lights. The tree's nodes then take 64 MiB, half of the largest binding of software drivers.
pub const MOST_LIGHTS: usize = 1 << 20;

/// A primitive that emits. It is one light, or one light for each face of a mesh.
struct LightGroup<'a> {
    primitive: &'a Primitive<'a>,
    /// Its index among the primitives of its kind.
    index: u32,
    /// The lights, each with its intensity (`LightBounds::intensity`).
    emitters: Vec<(Emitter, f64)>,
    two_sided: bool,
    /// The sum of the intensities of its lights.
    intensity: f64,
}

impl Builder<'_> {
    /// Adds the primitives that emit as lights, in their order, then lights without size, and then the background's image.
    pub fn add_lights(&mut self, primitives: &[Primitive<'_>], delta_lights: &[MovingLight<'_>], radiance_scale: f64) {
        let materials = &self.scene.materials;
        let bitmaps = &self.scene.bitmaps;
        let radiance = |emission: Emission| (emission.slot.texture.mean_luminance(bitmaps), emission.two_sided);
        let emissions: Vec<_> = materials.iter().map(|(_, m)| m.model().emission().map(radiance)).collect();
        // The index of each primitive among its kind, in the order in which they were added.
        let mut counts = [0u32; PRIMITIVES.len()];
        let mut groups = Vec::new();
        for primitive in primitives {
            let kind = primitive.shape.number();
            let index = counts[kind];
            counts[kind] += 1;
            if let Some((radiance, two_sided)) = emissions[primitive.material as usize]
                && radiance > 0.0
            {
                groups.push(self.group(primitive, index, radiance, two_sided));
            }
        }
        let sky = self.add_sky();
        let delta_lights: Vec<_> =
            delta_lights.iter().filter(|moving| moving.light.brightness(self.space) > 0.0).collect();
        let groups = self.drop_bodies_with_alpha(groups);
        let groups = self.drop_faintest(groups, MOST_LIGHTS - usize::from(sky.is_some()) - delta_lights.len());
        let of_delta = delta_lights.iter().map(|moving| moving.light.brightness(self.space));
        let sum: f64 = groups.iter().map(|group| group.intensity).chain(of_delta).chain(sky).sum();
        // The scene has no light.
        if sum == 0.0 || !sum.is_finite() {
            self.flat.features.emitting_sky = None;
            return;
        }
        let (mut bounds, mut lights, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        for group in groups {
            let material = group.primitive.material;
            let (name, own) = &materials[material as usize];
            let reason = || format!("\"{name}\" at {}", self.scene.material_location(name));
            self.flat.features.emitters[group.primitive.shape.number()].get_or_insert_with(reason);
            if own.model().emission().is_some_and(|emission| emission.slot.is_textured()) {
                self.flat.features.textured_lights.get_or_insert_with(reason);
            }
            self.set_light(&group, lights.len() as u32);
            let steps = in_space(&group.primitive.motion, self.space);
            // Light paths start with a density that is the same at all times.
            let is_possible = group.primitive.shape.large_sphere().is_none() && !changes_size(&steps);
            let turn = largest_turn(&steps);
            for (Emitter { code, instance, around, normal, area }, intensity) in group.emitters {
                let (axis, half_angle) = normal.map_or((DVec3::Z, PI), |normal| (normal, turn.min(PI)));
                let half = 0.5 * (around.max - around.min);
                let around = match steps.is_empty() {
                    true => around,
                    false => {
                        swept(&BoundingShape::Cuboid { center: around.center(), half, axes: DMat3::IDENTITY }, &steps)
                    }
                };
                bounds.push(LightBounds {
                    around,
                    axis,
                    half_angle,
                    two_sided: group.two_sided,
                    is_beam: false,
                    kind: LightKind::Positional,
                    intensity,
                });
                lights.push((code, instance));
                starts.push(Start { area, is_possible });
            }
        }
        // Lights with a position come first, as the tree requires.
        let (positional, at_infinity): (Vec<_>, Vec<_>) =
            delta_lights.into_iter().partition(|moving| moving.light.position.is_some());
        for light in positional.into_iter().chain(at_infinity) {
            let code = primitive_code(KIND_DELTA_LIGHT, self.flat.delta_lights.len() as u32);
            bounds.push(self.add_delta_light(light, radiance_scale));
            lights.push((code, data::NO_INSTANCE));
            starts.push(Start { area: 0.0, is_possible: true });
        }
        bounds.extend(sky.map(infinite_light));
        starts.extend(sky.map(|_| Start { area: 0.0, is_possible: false }));
        self.add_light_paths(primitives, &bounds, &starts);
        let tree = LightTree::new(&bounds);
        let light = |((code, instance), trail)| data::Light { code, instance, trail, padding: 0 };
        let of_sky = sky.map(|_| (HIT_NOTHING, data::NO_INSTANCE));
        self.flat.lights = lights.into_iter().chain(of_sky).zip(tree.trails).map(light).collect();
        self.flat.light_nodes = tree.nodes;
        self.flat.features.lights = self.flat.lights.len() as u32;
        self.flat.features.sky_light = self.flat.features.lights.saturating_sub(1);
    }

    /// Adds a light without size to its table.
    fn add_delta_light(&mut self, moving: &MovingLight<'_>, radiance_scale: f64) -> LightBounds {
        let MovingLight { object, light, motion } = moving;
        let space = light.own_space(self.space);
        let steps = in_space(motion, space);
        let position = light.around(self.space).min;
        self.add_motion_of_light(self.flat.delta_lights.len(), motion, position, space);
        let features = &mut self.flat.features;
        let reason = || format!("{} at {}", object.name(), self.scene.location_of(object));
        features.delta_lights.get_or_insert_with(reason);
        if !motion.is_empty() {
            features.moving_lights.get_or_insert_with(reason);
        }
        self.flat.delta_lights.push(light.on_device(self.space, radiance_scale));
        let intensity = light.brightness(self.space);
        if light.position.is_none() {
            features.directional_lights.get_or_insert_with(reason);
            return LightBounds { kind: LightKind::Directional, ..infinite_light(intensity) };
        }
        let (axis, beam) = light.cone();
        LightBounds {
            around: swept(&BoundingShape::Ball { center: position, radius: 0.0 }, &steps),
            axis,
            half_angle: beam.map_or(PI, |beam| (beam + largest_turn(&steps)).min(PI)),
            is_beam: beam.is_some(),
            kind: LightKind::Positional,
            ..infinite_light(intensity)
        }
    }

    /// Adds the background's image as a light, unless it is black. Returns its intensity.
    fn add_sky(&mut self) -> Option<f64> {
        let Background::Image { path } = &self.scene.background else { return None };
        let bitmap = self.scene.bitmaps.colours(path)?;
        let sky = SkyDistribution::new(bitmap)?;
        self.flat.features.emitting_sky = self.flat.features.backgrounds[2].clone();
        self.flat.features.sky_grid = (sky.columns, sky.rows);
        self.flat.sky = sky.cells;
        // A surface sees at most half of the sky.
        Some(0.5 * integral_over_directions(bitmap))
    }

    /// Leaves out spheres and boxes with an alpha: their inner sides emit too, which no sample of a light shows.
    fn drop_bodies_with_alpha<'a>(&mut self, groups: Vec<LightGroup<'a>>) -> Vec<LightGroup<'a>> {
        let total: usize = groups.iter().map(|group| group.emitters.len()).sum();
        let has_alpha = |group: &LightGroup<'_>| {
            KINDS[group.primitive.shape.number()].encloses()
                && self.scene.materials[group.primitive.material as usize].1.has_alpha()
        };
        let (left, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(has_alpha);
        if let Some(first) = left.first() {
            let (name, _) = &self.scene.materials[first.primitive.material as usize];
            let at = self.scene.material_location(name);
            let reason = format!("\"{name}\" at {at}: a sphere or a box with an alpha is not sampled");
            self.flat.features.not_sampled =
                Some(NotSampled { lights: left.len() as u64, total: total as u64, reason });
        }
        self.leave_out(&left);
        others
    }

    /// Notes that these are not sampled.
    fn leave_out(&mut self, groups: &[LightGroup<'_>]) {
        for group in groups {
            self.set_light(group, NOT_SAMPLED);
            let (_, material) = &self.scene.materials[group.primitive.material as usize];
            let texture = material.model().emission().map(|emission| emission.slot.texture);
            let brightest = texture.map_or(0.0, |texture| texture.brightest(&self.scene.bitmaps));
            let scale = exp2(-self.flat.radiance_exponent);
            self.flat.not_sampled = self.flat.not_sampled.max(scale * brightest);
        }
    }

    /// Leaves out primitives with all their lights until at most `most` lights remain, first the primitives whose lights have the
    /// lowest mean intensity. Only BSDF sampling finds these, as a warning says.
    fn drop_faintest<'a>(&mut self, groups: Vec<LightGroup<'a>>, most: usize) -> Vec<LightGroup<'a>> {
        let total: usize = groups.iter().map(|group| group.emitters.len()).sum();
        if total <= most {
            return groups;
        }
        let each = |group: &LightGroup<'_>| group.intensity / group.emitters.len().max(1) as f64;
        let mut order: Vec<usize> = (0..groups.len()).collect();
        order.sort_by(|&a, &b| each(&groups[b]).total_cmp(&each(&groups[a])).then(a.cmp(&b)));
        let mut taken = vec![false; groups.len()];
        let mut room = most;
        for i in order {
            taken[i] = groups[i].emitters.len() <= room;
            room -= if taken[i] { groups[i].emitters.len() } else { 0 };
        }
        let (fitting, left): (Vec<_>, Vec<_>) = groups.into_iter().zip(taken).partition(|(_, taken)| *taken);
        let left: Vec<LightGroup<'_>> = left.into_iter().map(|(group, _)| group).collect();
        self.leave_out(&left);
        if let Some(first) = left.first() {
            let (name, _) = &self.scene.materials[first.primitive.material as usize];
            let location = self.scene.material_location(name);
            let count: usize = left.iter().map(|group| group.emitters.len()).sum();
            let not_sampled = NotSampled {
                lights: count as u64,
                total: total as u64,
                reason: format!("\"{name}\" at {location}: {MOST_LIGHTS} at most are sampled"),
            };
            let objects = match left.len() {
                1 => "1 object".to_string(),
                n => format!("{n} objects"),
            };
            self.flat.warnings.push(format!(
                "{location}: materials[\"{name}\"]: {total} faces and shapes emit, but at most {MOST_LIGHTS} are sampled as lights: \
                 {count} of them, on {objects}, are left to chance, which takes many more samples: use emitters with fewer faces"
            ));
            self.flat.features.not_sampled = Some(not_sampled);
        }
        fitting.into_iter().map(|(group, _)| group).collect()
    }

    /// Stores the index of its first light in a primitive, or that it is not sampled.
    fn set_light(&mut self, group: &LightGroup<'_>, light: u32) {
        let shape = &group.primitive.shape;
        let layout = self.layout_of(shape);
        shape.set_light(&mut self.flat.shapes, group.index as usize, layout, light);
    }

    /// The lights of a primitive. `radiance` is the luminance of its mean emission.
    fn group<'a>(
        &mut self,
        primitive: &'a Primitive<'a>,
        index: u32,
        radiance: f64,
        two_sided: bool,
    ) -> LightGroup<'a> {
        let layout = self.layout_of(&primitive.shape);
        let at = ObjectTransform { to_world: &primitive.to_world, space: self.space };
        let code = primitive.shape.code(index as usize);
        let scale = largest_scale(&primitive.motion);
        let emitters = primitive.shape.emitters(&at, index, code, layout).into_iter().map(|emitter| {
            let normal = emitter.normal.and_then(DVec3::try_normalize);
            // The mean projected area of a convex body is a quarter of its surface (Cauchy).
            let projected_area = if normal.is_some() { emitter.area } else { 0.25 * emitter.area };
            (Emitter { normal, ..emitter }, radiance * projected_area * scale * scale)
        });
        let emitters: Vec<(Emitter, f64)> = emitters.collect();
        let intensity = emitters.iter().map(|(_, intensity)| intensity).sum();
        LightGroup { primitive, index, emitters, two_sided, intensity }
    }
}

/// The sky as a light, with this irradiance.
fn infinite_light(intensity: f64) -> LightBounds {
    let around = Aabb::around([DVec3::ZERO]);
    LightBounds {
        around,
        axis: DVec3::Z,
        half_angle: PI,
        two_sided: false,
        is_beam: false,
        kind: LightKind::Sky,
        intensity,
    }
}

/// The luminance of a latitude-longitude image, integrated over all directions.
fn integral_over_directions(bitmap: &Bitmap) -> f64 {
    let (width, height) = (bitmap.width as usize, f64::from(bitmap.height));
    let rows = (0..bitmap.height as usize).map(|y| {
        let row = (y * width..(y + 1) * width).map(|at| bitmap.texel(at));
        let sum: f64 = row.map(|t| luminance(t.map(f64::from))).sum();
        let sine = (PI * (y as f64 + 0.5) / height).sin();
        sum * sine * (2.0 * PI / width as f64) * (PI / height)
    });
    rows.sum()
}
