//! Selects the lights that are sampled: all emitters whose surface or directions can be sampled.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::builder::Builder;
use super::features::NotSampled;
use super::finder::{MovingLight, Primitive, with_indices};
use super::light_parts::{Outline, depth_for, most_parts};
use super::light_paths::Start;
use super::light_tree::{LightBounds, LightKind, LightTree};
use super::motion::in_space;
use super::square_sky::to_latitude_longitude;
use super::swept::{changes_size, largest_scale, largest_turn, swept};
use crate::data::{self, CROSSED, HIT_NOTHING, KIND_DELTA_LIGHT, NOT_SAMPLED, luminance, primitive_code};
use crate::light_distribution::SkyDistribution;
use crate::luminance::Luminance;
use crate::material::Emission;
use crate::printable::counted;
use crate::scene::{Background, Bitmap, Falloff, SkyLayout};
use crate::shape::{Aabb, BoundingShape, Emitter, KINDS, ObjectTransform, PRIMITIVES, exp2};

/// The most lights. The tree's nodes then take 64 MiB, half of the largest binding of software drivers.
pub const MOST_LIGHTS: usize = 1 << 20;

/// The part of a light that is all of its shape.
const WHOLE: u32 = 0;

/// A primitive that emits. It is one light, or one light for each face of a mesh.
struct LightGroup<'a> {
    primitive: &'a Primitive<'a>,
    /// Its index among the primitives of its kind.
    index: u32,
    emitters: Vec<PartLight>,
    two_sided: bool,
    /// The sum of the intensities of its lights.
    intensity: f64,
    /// The luminance of its mean emission.
    radiance: f64,
    /// If a light of it is cut into parts: the number of parts of each.
    parts: Option<Vec<usize>>,
}

/// A light, and its intensity (`LightBounds::intensity`).
struct PartLight {
    emitter: Emitter,
    part: u32,
    intensity: f64,
}

impl Builder<'_> {
    /// Adds the primitives that emit as lights, in their order, then lights without size, and then the background's image.
    pub fn add_lights(&mut self, primitives: &[Primitive<'_>], delta_lights: &[MovingLight<'_>], radiance_scale: f64) {
        let materials = &self.scene.materials;
        let bitmaps = &self.scene.bitmaps;
        let radiance = |emission: Emission| (emission.slot.texture.mean_luminance(bitmaps), emission.two_sided);
        let emissions: Vec<_> = materials.iter().map(|(_, m)| m.model().emission().map(radiance)).collect();
        let mut groups = Vec::new();
        for (index, primitive) in with_indices(primitives) {
            if let Some((radiance, two_sided)) = emissions[primitive.material as usize]
                && radiance > 0.0
                && self.shows_emission[primitive.material as usize]
            {
                groups.push(self.group(primitive, index, radiance, two_sided));
            }
        }
        let sky = self.add_sky();
        let delta_lights: Vec<_> =
            delta_lights.iter().filter(|moving| moving.light.brightness(self.space) > 0.0).collect();
        let most = MOST_LIGHTS - usize::from(sky.is_some()) - delta_lights.len();
        let mut groups = self.drop_faintest(groups, most);
        self.cut_lights(&mut groups, most);
        let of_delta = delta_lights.iter().map(|moving| moving.light.brightness(self.space));
        let sum: f64 = groups.iter().map(|group| group.intensity).chain(of_delta).chain(sky).sum();
        // The scene has no light.
        if sum == 0.0 || !sum.is_finite() {
            self.flat.features.forget("sky_light");
            return;
        }
        let (mut bounds, mut lights, mut starts) = (Vec::new(), Vec::new(), Vec::new());
        let mut cut = Vec::new();
        for mut group in groups {
            let material = group.primitive.material;
            let (name, own) = &materials[material as usize];
            let reason = || format!("\"{name}\" at {}", self.scene.material_location(name));
            let features = &mut self.flat.features;
            let shape = PRIMITIVES[group.primitive.shape.number()];
            features.require(format!("area_light.{shape}"), reason);
            if own.model().emission().is_some_and(|emission| emission.slot.is_textured()) {
                features.require("textured_light", reason);
            }
            if group.emitters.iter().any(|light| light.part == CROSSED) {
                features.require("crossed_light", reason);
            }
            match group.parts.take() {
                None => self.set_light(group.primitive, group.index, lights.len() as u32),
                Some(parts) => {
                    self.flat.features.require(format!("parted.{shape}"), reason);
                    cut.push((group.primitive, group.index, lights.len(), parts));
                }
            }
            let steps = in_space(&group.primitive.motion, self.space);
            // Light paths start with a density that is the same at all times.
            let is_possible = group.primitive.shape.large_sphere().is_none() && !changes_size(&steps);
            let turn = largest_turn(&steps);
            for PartLight { emitter, part, intensity } in group.emitters {
                let Emitter { code, instance, around, normal, area } = emitter;
                let (axis, half_angle) = normal.map_or((DVec3::Z, PI), |normal| (normal, turn.min(PI)));
                let around = if steps.is_empty() { around } else { swept(&around.into(), &steps) };
                let (two_sided, kind) = (group.two_sided, LightKind::Positional);
                bounds.push(LightBounds { around, axis, half_angle, two_sided, kind, ..infinite_light(intensity) });
                lights.push((code, instance, part));
                starts.push(Start { code, area, is_possible });
            }
        }
        self.flat.features.quantities.first_delta_light = lights.len() as u32;
        // Lights with a position come first, as the tree requires.
        let (positional, at_infinity): (Vec<_>, Vec<_>) =
            delta_lights.into_iter().partition(|moving| moving.light.position.is_some());
        for light in positional.into_iter().chain(at_infinity) {
            let code = primitive_code(KIND_DELTA_LIGHT, self.flat.delta_lights.len() as u32);
            bounds.push(self.add_delta_light(light, radiance_scale));
            lights.push((code, data::NO_INSTANCE, WHOLE));
            starts.push(Start { code, area: 0.0, is_possible: true });
        }
        bounds.extend(sky.map(infinite_light));
        starts.extend(sky.map(|_| Start { code: HIT_NOTHING, area: 0.0, is_possible: false }));
        self.add_light_paths(primitives, &bounds, &starts);
        let tree = LightTree::new(&bounds);
        let light = |((code, instance, part), trail)| data::Light { code, instance, trail, part };
        let of_sky = sky.map(|_| (HIT_NOTHING, data::NO_INSTANCE, WHOLE));
        self.flat.lights = lights.into_iter().chain(of_sky).zip(tree.trails).map(light).collect();
        self.flat.light_nodes = tree.nodes;
        self.flat.features.quantities.lights = self.flat.lights.len() as u32;
        self.flat.features.quantities.sky_light = self.flat.features.quantities.lights.saturating_sub(1);
        cut.into_iter().for_each(|(primitive, index, first, parts)| self.add_parts(primitive, index, first, &parts));
    }

    /// Adds entries that stand for the parts of a primitive's lights, which are lights from `first` on.
    fn add_parts(&mut self, primitive: &Primitive<'_>, index: u32, first: usize, parts: &[usize]) {
        self.set_light(primitive, index, self.flat.lights.len() as u32);
        let mut next = first as u32;
        self.flat.lights.extend(parts.iter().map(|count| {
            let trail = next;
            next += *count as u32;
            data::Light { code: HIT_NOTHING, instance: *count as u32, trail, part: data::PARTS }
        }));
    }

    /// Gives each flat light whose radiance is a texture the mean luminance of its own part of that, and cuts it into parts where it varies.
    fn cut_lights(&self, groups: &mut [LightGroup<'_>], most: usize) {
        let slot_of = |group: &LightGroup<'_>| {
            let slot = self.scene.materials[group.primitive.material as usize].1.model().emission()?.slot;
            let can_be_cut = KINDS[group.primitive.shape.number()].has_parts && slot.is_textured();
            can_be_cut.then_some((slot.texture, group.primitive.shape.mesh().is_some()))
        };
        let textured: usize = groups.iter().filter(|group| slot_of(group).is_some()).map(|g| g.emitters.len()).sum();
        let total: usize = groups.iter().map(|group| group.emitters.len()).sum();
        let depth = depth_for(textured);
        let mut known = BTreeMap::new();
        let mut varying = 0;
        for (number, group) in groups.iter_mut().enumerate() {
            let Some((texture, wraps)) = slot_of(group) else { continue };
            let luminance = known
                .entry((group.primitive.material, wraps))
                .or_insert_with(|| (Luminance::new(texture, &self.scene.bitmaps, wraps), Vec::new()));
            let (Some(luminance), in_groups) = luminance else { continue };
            let radiance = group.radiance;
            let mut varies = Vec::new();
            for (face, light) in group.emitters.iter_mut().enumerate() {
                let Some(outline) = Outline::new(&group.primitive.shape, face, texture.uv_set()) else { continue };
                let (mean, is_uneven) = outline.mean(luminance, depth);
                light.intensity *= mean / radiance;
                varies.extend(is_uneven.then_some(face));
            }
            varying += varies.len();
            in_groups.push((number, varies));
        }
        let most = most_parts(varying, most - total);
        for (luminance, in_groups) in known.into_values() {
            let Some(luminance) = luminance else { continue };
            for (number, varies) in in_groups {
                self.cut_group(&mut groups[number], &luminance, &varies, depth, most);
            }
        }
        groups.iter_mut().for_each(|group| group.intensity = group.emitters.iter().map(|light| light.intensity).sum());
    }

    /// Cuts these of the lights of a primitive into parts, at most so many each.
    fn cut_group(
        &self,
        group: &mut LightGroup<'_>,
        luminance: &Luminance<'_>,
        varies: &[usize],
        depth: u32,
        most: usize,
    ) {
        let primitive = group.primitive;
        let Some(emission) = self.scene.materials[primitive.material as usize].1.model().emission() else { return };
        let to_render = ObjectTransform { to_world: &primitive.to_world, space: self.space };
        let mut varies = varies.iter().copied().peekable();
        let (mut lights, mut counts) = (Vec::new(), Vec::new());
        for (face, light) in std::mem::take(&mut group.emitters).into_iter().enumerate() {
            let outline = varies
                .next_if_eq(&face)
                .and_then(|face| Outline::new(&primitive.shape, face, emission.slot.texture.uv_set()));
            let parts = outline.as_ref().map(|outline| outline.parts(luminance, depth, most)).unwrap_or_default();
            let power: f64 = parts.iter().map(|(part, mean)| part.share() * mean).sum();
            let parts = if power > 0.0 { parts } else { Vec::new() };
            counts.push(parts.len().max(1));
            let (Some(outline), 2..) = (outline, parts.len()) else {
                lights.push(light);
                continue;
            };
            lights.extend(parts.into_iter().map(|(part, mean)| PartLight {
                emitter: Emitter {
                    around: outline.bounds(part, &to_render),
                    area: part.share() * light.emitter.area,
                    ..light.emitter
                },
                part: part.code(),
                intensity: light.intensity * part.share() * mean / power,
            }));
        }
        group.emitters = lights;
        group.parts = counts.iter().any(|count| *count > 1).then_some(counts);
    }

    /// Adds a light without size to its table.
    fn add_delta_light(&mut self, moving: &MovingLight<'_>, radiance_scale: f64) -> LightBounds {
        let MovingLight { object, light, motion } = moving;
        let space = light.own_space(self.space);
        let steps = in_space(motion, space);
        let position = light.around(self.space).min;
        self.add_motion_of_light(self.flat.delta_lights.len(), motion, position, space);
        let group = self.flat.group_of(object.light_group());
        self.flat.groups_of_lights.push(group);
        let features = &mut self.flat.features;
        let reason = || format!("{} at {}", object.name(), self.scene.location_of(object));
        features.require("delta_light", reason);
        if !motion.is_empty() {
            features.require("moving_light", reason);
        }
        if light.beam.is_some_and(|beam| beam.falloff != Falloff::Gltf) {
            features.require("falloff", reason);
        }
        self.flat.delta_lights.push(light.on_device(self.space, radiance_scale));
        let intensity = light.brightness(self.space);
        if light.position.is_none() {
            features.require("directional_light", reason);
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
        let Background::Image { path, tint, layout, .. } = &self.scene.background else { return None };
        let bitmap = self.scene.bitmaps.colours(path)?;
        let is_square = *layout == SkyLayout::Octahedral;
        let resampled = is_square.then(|| to_latitude_longitude(bitmap));
        let bitmap = resampled.as_ref().unwrap_or(bitmap);
        // MIS compensation: BSDF sampling finds what is darker than the mean, and light sampling draws what is above it (Karlík, Šik, Vévoda,
        // Skřivan, Křivánek, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", ACM TOG 38(6), 2019).
        // A little less than the mean is subtracted, so that a sky of one radiance has a distribution too.
        let integral = integral_over_directions(bitmap);
        let base = 0.99 * integral / (4.0 * PI);
        let sky = SkyDistribution::new(bitmap, base)?;
        let largest = Some(tint.max_element()).filter(|largest| *largest > 0.0)?;
        self.flat.not_sampled = self.flat.not_sampled.max(exp2(-self.flat.radiance_exponent) * largest * base);
        let by = self.flat.features.any("background").cloned().unwrap_or_default();
        self.flat.features.require("sky_light", || by);
        self.flat.features.quantities.sky_grid = (sky.columns, sky.rows);
        self.flat.sky = sky.sums;
        // A surface sees at most half of the sky.
        Some(0.5 * largest * integral)
    }

    /// Notes that these are not sampled.
    fn leave_out(&mut self, groups: &[LightGroup<'_>]) {
        for group in groups {
            self.set_light(group.primitive, group.index, NOT_SAMPLED);
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
            let objects = counted(left.len() as u64, "object");
            self.flat.warnings.push(format!(
                "{location}: materials[\"{name}\"]: {total} faces and shapes emit, but at most {MOST_LIGHTS} are sampled as lights: \
                 {count} of them, on {objects}, are found by BSDF sampling alone, with more noise: use emitters with fewer faces"
            ));
            self.flat.features.require("not_sampled", || not_sampled.reason.clone());
            self.flat.features.not_sampled = Some(not_sampled);
        }
        fitting.into_iter().map(|(group, _)| group).collect()
    }

    /// Stores the index of its first light in a primitive, or that it is not sampled.
    fn set_light(&mut self, primitive: &Primitive<'_>, index: u32, light: u32) {
        // Kernels add it to the number of a mesh's face.
        let first_face = self.layout_of(&primitive.shape).first_face;
        let light = if light == NOT_SAMPLED { light } else { light.wrapping_sub(first_face) };
        *(primitive.shape.kind().table.light)(&mut self.flat.shapes, index as usize) = light;
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
        let lets_pass =
            KINDS[primitive.shape.number()].encloses() && self.models[primitive.material as usize].has_alpha();
        let part = if lets_pass && two_sided { CROSSED } else { WHOLE };
        let emitters = primitive.shape.emitters(&at, index, code, layout).into_iter().map(|emitter| {
            let normal = emitter.normal.and_then(DVec3::try_normalize);
            // The mean projected area of a convex body is a quarter of its surface (Cauchy).
            let projected_area = if normal.is_some() { emitter.area } else { 0.25 * emitter.area };
            let intensity = radiance * projected_area * scale * scale;
            PartLight { emitter: Emitter { normal, ..emitter }, part, intensity }
        });
        let emitters: Vec<PartLight> = emitters.collect();
        let intensity = emitters.iter().map(|light| light.intensity).sum();
        LightGroup { primitive, index, emitters, two_sided, intensity, radiance, parts: None }
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
        let height_of = |y: usize| (PI * y as f64 / height).cos();
        sum * (2.0 * PI / width as f64) * (height_of(y) - height_of(y + 1))
    });
    rows.sum()
}
