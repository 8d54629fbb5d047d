//! What is sampled as a light: everything that emits and can be aimed at.

use std::f64::consts::PI;

use glam::DVec3;

use super::features::Unsampled;
use super::light_tree::{Bounded, LightTree};
use super::place::{Aabb, Placed, Shape};
use super::{Builder, PRIMITIVES};
use crate::data::{self, HIT_NOTHING, KIND_TRIANGLE, NOT_SAMPLED, luminance, primitive_code};
use crate::lights::SkyDistribution;
use crate::material::Emission;
use crate::scene::{Background, Bitmap};

/// The most lights, which is room for the tree's nodes in 64 MiB: half of what software drivers allow a binding.
pub const MOST_LIGHTS: usize = 1 << 20;

/// A light before it has its place in the table; the sky is none.
struct Emitter {
    code: u32,
    instance: u32,
    /// The radiance that it sends out on the mean, times the area that it shows on the mean.
    intensity: f64,
    place: Place,
}

/// The box around a light, in render space, and its normal; none where it shines to all sides.
struct Place {
    around: Aabb,
    normal: Option<DVec3>,
    two_sided: bool,
}

impl Place {
    fn of(points: impl IntoIterator<Item = DVec3>, normal: Option<DVec3>, two_sided: bool) -> Place {
        Place { around: Aabb::around(points), normal: normal.and_then(DVec3::try_normalize), two_sided }
    }
}

/// A primitive that emits: a light, or of a mesh all faces.
struct Group<'a> {
    primitive: &'a Placed,
    /// Its index among its kind.
    index: u32,
    emitters: Vec<Emitter>,
    /// Of all its lights together.
    intensity: f64,
}

impl Builder<'_> {
    /// Makes lights of the primitives that emit, in their order, and of the background's image.
    pub fn add_lights(&mut self, placed: &[Placed]) {
        let materials = &self.scene.materials;
        let bitmaps = &self.scene.bitmaps;
        let radiance = |emission: Emission| (emission.slot.texture.mean_luminance(bitmaps), emission.two_sided);
        let emissions: Vec<_> = materials.iter().map(|(_, m)| m.model().emission().map(radiance)).collect();
        // The index of each primitive among its kind, counted as they were added.
        let mut counts = [0u32; PRIMITIVES.len()];
        let mut groups = Vec::new();
        for primitive in placed {
            let kind = primitive.shape.kind();
            let index = counts[kind];
            counts[kind] += 1;
            if let Some((radiance, two_sided)) = emissions[primitive.material as usize]
                && radiance > 0.0
            {
                groups.push(self.group(primitive, index, radiance, two_sided));
            }
        }
        let sky = self.add_sky();
        let groups = self.that_fit(groups, MOST_LIGHTS - usize::from(sky.is_some()));
        let sum: f64 = groups.iter().map(|group| group.intensity).chain(sky).sum();
        // Nothing where there is no light.
        if sum == 0.0 || !sum.is_finite() {
            self.flat.features.emitting_sky = None;
            return;
        }
        let mut emitters = Vec::new();
        for group in groups {
            let material = group.primitive.material;
            let (name, _) = &materials[material as usize];
            let asked = || format!("\"{name}\" at {}", self.scene.material_location(name));
            self.flat.features.emitters[group.primitive.shape.kind()].get_or_insert_with(asked);
            self.set_light(&group, emitters.len() as u32);
            emitters.extend(group.emitters);
        }
        let bounded = |emitter: &Emitter| {
            let (axis, spread) = emitter.place.normal.map_or((DVec3::Z, PI), |normal| (normal, 0.0));
            let Place { around, two_sided, .. } = emitter.place;
            Bounded { around, axis, spread, two_sided, intensity: emitter.intensity }
        };
        let bounds: Vec<Bounded> = emitters.iter().map(bounded).collect();
        let tree = LightTree::new(&bounds, sky);
        let codes = emitters.iter().map(|emitter| (emitter.code, emitter.instance));
        let light = |((code, instance), trail)| data::Light { code, instance, trail, padding: 0 };
        let of_sky = sky.map(|_| (HIT_NOTHING, data::NO_INSTANCE));
        self.flat.lights = codes.chain(of_sky).zip(tree.trails).map(light).collect();
        self.flat.light_nodes = tree.nodes;
        self.flat.features.lights = self.flat.lights.len() as u32;
        self.flat.features.sky_light = self.flat.features.lights.saturating_sub(1);
    }

    /// The background's image as a light, if it is one that sends something; the result is its intensity.
    fn add_sky(&mut self) -> Option<f64> {
        let Background::Image { path } = &self.scene.background else { return None };
        let bitmap = self.scene.bitmaps.get(path)?;
        let sky = SkyDistribution::new(bitmap.width, bitmap.height, &bitmap.texels)?;
        self.flat.features.emitting_sky = self.flat.features.backgrounds[2].clone();
        self.flat.features.sky_grid = (sky.columns, sky.rows);
        self.flat.sky = sky.cells;
        // No surface sees more than half of it.
        Some(0.5 * integral_over_directions(bitmap))
    }

    /// Leaves out whole primitives until the others' lights are no more than `most`: first those whose lights are the faintest on the
    /// mean. What is left out is met by chance alone, and that is said.
    fn that_fit<'a>(&mut self, groups: Vec<Group<'a>>, most: usize) -> Vec<Group<'a>> {
        let wanted: usize = groups.iter().map(|group| group.emitters.len()).sum();
        if wanted <= most {
            return groups;
        }
        let each = |group: &Group<'_>| group.intensity / group.emitters.len().max(1) as f64;
        let mut order: Vec<usize> = (0..groups.len()).collect();
        order.sort_by(|&a, &b| each(&groups[b]).total_cmp(&each(&groups[a])).then(a.cmp(&b)));
        let mut taken = vec![false; groups.len()];
        let mut room = most;
        for i in order {
            taken[i] = groups[i].emitters.len() <= room;
            room -= if taken[i] { groups[i].emitters.len() } else { 0 };
        }
        let (fitting, left): (Vec<_>, Vec<_>) = groups.into_iter().zip(taken).partition(|(_, taken)| *taken);
        let left: Vec<Group<'_>> = left.into_iter().map(|(group, _)| group).collect();
        left.iter().for_each(|group| self.set_light(group, NOT_SAMPLED));
        if let Some(first) = left.first() {
            let (name, _) = &self.scene.materials[first.primitive.material as usize];
            let place = self.scene.material_location(name);
            let count: usize = left.iter().map(|group| group.emitters.len()).sum();
            let unsampled =
                Unsampled { lights: count as u64, wanted: wanted as u64, asked_by: format!("\"{name}\" at {place}") };
            let objects = match left.len() {
                1 => "1 object".to_string(),
                n => format!("{n} objects"),
            };
            self.flat.warnings.push(format!(
                "{place}: materials[\"{name}\"]: {wanted} faces and shapes emit, and {MOST_LIGHTS} at most are sampled as lights: \
                 {count}, of {objects}, are left to chance, which takes many more samples: give what emits fewer faces"
            ));
            self.flat.features.unsampled = Some(unsampled);
        }
        fitting.into_iter().map(|(group, _)| group).collect()
    }

    /// Tells a primitive its place among the lights, or that it has none.
    fn set_light(&mut self, group: &Group<'_>, light: u32) {
        let index = group.index as usize;
        match group.primitive.shape {
            Shape::Sphere { .. } => self.flat.spheres[index].light = light,
            Shape::Quad { .. } => self.flat.quads[index].light = light,
            Shape::Cuboid { .. } => self.flat.cuboids[index].light = light,
            Shape::Mesh(_) if light == NOT_SAMPLED => self.flat.instances[index].to_light = light,
            Shape::Mesh(mesh) => {
                self.flat.instances[index].to_light = light.wrapping_sub(self.laid(mesh).first_face);
            }
        }
    }

    /// The lights of a primitive; `radiance` is the luminance that it sends out on the mean.
    fn group<'a>(&mut self, primitive: &'a Placed, index: u32, radiance: f64, two_sided: bool) -> Group<'a> {
        let scale = primitive.to_world.scale * self.space.scale;
        let (space, to_world) = (self.space, primitive.to_world);
        let point = |p: DVec3| space.point(to_world.point(p));
        let emitter = |code, instance, area: f64, place: Place| {
            // A convex body shows a quarter of its surface on the mean, from all directions (Cauchy).
            let shown = if place.normal.is_some() { area } else { 0.25 * area };
            Emitter { code, instance, intensity: radiance * shown, place }
        };
        let code = primitive.shape.code(index as usize);
        let emitters = match primitive.shape {
            Shape::Sphere { center, radius } => {
                let (middle, reach) = (point(center), DVec3::splat(radius * scale));
                let place = Place::of([middle - reach, middle + reach], None, two_sided);
                vec![emitter(code, data::NO_INSTANCE, 4.0 * PI * (radius * scale).powi(2), place)]
            }
            Shape::Quad { corner, u, v } => {
                let corners = [corner, corner + u, corner + v, corner + u + v].map(point);
                let place = Place::of(corners, Some(to_world.vector(u).cross(to_world.vector(v))), two_sided);
                vec![emitter(code, data::NO_INSTANCE, u.cross(v).length() * scale * scale, place)]
            }
            Shape::Cuboid { min, max } => {
                let d = (max - min) * scale;
                let place = Place::of(Aabb { min, max }.corners().map(point), None, two_sided);
                vec![emitter(code, data::NO_INSTANCE, 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x), place)]
            }
            Shape::Mesh(mesh) => {
                let first_face = self.laid(mesh).first_face;
                let mesh = self.meshes[mesh];
                let face = |(face, corners): (u32, &[u32; 3])| {
                    let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                    let across = (b - a).cross(c - a);
                    let area = 0.5 * across.length() * scale * scale;
                    let place = Place::of([a, b, c].map(point), Some(to_world.vector(across)), two_sided);
                    emitter(primitive_code(KIND_TRIANGLE, face), index, area, place)
                };
                (first_face..).zip(&mesh.triangles).map(face).collect()
            }
        };
        let intensity = emitters.iter().map(|emitter| emitter.intensity).sum();
        Group { primitive, index, emitters, intensity }
    }
}

/// The luminance of a latitude-longitude image, integrated over all directions.
fn integral_over_directions(bitmap: &Bitmap) -> f64 {
    let (width, height) = (bitmap.width as usize, f64::from(bitmap.height));
    let rows = bitmap.texels.chunks(width.max(1)).enumerate().map(|(y, row)| {
        let sum: f64 = row.iter().map(|t| luminance(t.map(f64::from))).sum();
        let sine = (PI * (y as f64 + 0.5) / height).sin();
        sum * sine * (2.0 * PI / width as f64) * (PI / height)
    });
    rows.sum()
}
