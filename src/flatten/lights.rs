//! What is sampled as a light: everything that emits and can be aimed at, each chosen in proportion to its power.

use std::f64::consts::PI;

use glam::DVec3;

use super::light_tree::{Bounded, LightTree};
use super::place::{AxisBox, Placed, Shape};
use super::{Builder, PRIMITIVES};
use crate::data::{self, HIT_NOTHING, KIND_TRIANGLE, luminance, primitive_code};
use crate::lights::{AliasTable, SkyDistribution};
use crate::scene::{Background, Bitmap, Material, Scene, Texture};

/// From so many lights on one is chosen by the tree (docs/performance.md): the fewest of which two are at a place, whether or not one is
/// the sky.
pub const TREE_LIGHTS: u32 = 3;

/// By the tree, the sky is chosen at least and at most so often where there are other lights.
const SKY_SHARES: (f64, f64) = (0.1, 0.9);

/// A light before it has its place in the table.
struct Emitter {
    code: u32,
    instance: u32,
    power: f64,
    /// Where it is; nothing of the sky.
    place: Option<Place>,
}

/// The box around a light, in render space, and its normal; none where it shines to all sides.
struct Place {
    around: AxisBox,
    normal: Option<DVec3>,
    two_sided: bool,
}

impl Place {
    fn of(points: impl IntoIterator<Item = DVec3>, normal: Option<DVec3>, two_sided: bool) -> Place {
        Place { around: AxisBox::around(points), normal: normal.and_then(DVec3::try_normalize), two_sided }
    }
}

impl Builder<'_> {
    /// Makes lights of the primitives that emit, in their order, and of the background's image.
    pub fn add_lights(&mut self, placed: &[Placed]) {
        let mut emitters = Vec::new();
        let materials = &self.scene.materials;
        let radiances: Vec<_> = materials.iter().map(|(_, material)| mean_radiance(self.scene, material)).collect();
        // The index of each primitive among its kind, counted as they were added.
        let mut counts = [0u32; PRIMITIVES.len()];
        for primitive in placed {
            let kind = primitive.shape.kind();
            let index = counts[kind];
            counts[kind] += 1;
            let radiance = radiances[primitive.material as usize];
            if radiance > 0.0 {
                let (name, _) = &materials[primitive.material as usize];
                let asked = || format!("\"{name}\" at {}", self.scene.material_location(name));
                self.flat.features.emitters[kind].get_or_insert_with(asked);
                self.add_emitter(primitive, index, radiance, &mut emitters);
            }
        }
        if let Background::Image { path } = &self.scene.background
            && let Some(bitmap) = self.scene.bitmaps.get(path)
        {
            // What the sky sends onto a disk as large as the scene, which has an extent of 1 in render space.
            let power = PI * integral_over_directions(bitmap);
            if let Some(sky) = SkyDistribution::new(bitmap.width, bitmap.height, &bitmap.texels) {
                self.flat.features.emitting_sky = self.flat.features.backgrounds[2].clone();
                self.flat.features.sky_grid = (sky.columns, sky.rows);
                self.flat.sky = sky.cells;
                emitters.push(Emitter { code: HIT_NOTHING, instance: data::NO_INSTANCE, power, place: None });
            }
        }
        let powers: Vec<f64> = emitters.iter().map(|emitter| emitter.power).collect();
        // Nothing where there is no light, or where there are more than a table can tell apart.
        let Some(table) = AliasTable::new(&powers) else {
            let features = &mut self.flat.features;
            (features.emitters, features.emitting_sky) = (Default::default(), None);
            return;
        };
        self.flat.lights = emitters
            .iter()
            .zip(&table.entries)
            .map(|(emitter, entry)| data::Light {
                code: emitter.code,
                instance: emitter.instance,
                probability: entry.probability,
                threshold: entry.threshold,
                other: entry.alias,
                ..data::Light::default()
            })
            .collect();
        self.flat.features.lights = self.flat.lights.len() as u32;
        self.flat.features.sky_light = self.flat.features.lights.saturating_sub(1);
        if self.flat.features.lights >= TREE_LIGHTS {
            self.add_light_tree(&emitters);
        }
    }

    /// Builds the tree over the lights that are somewhere.
    fn add_light_tree(&mut self, emitters: &[Emitter]) {
        let bounded = |emitter: &Emitter| {
            let place = emitter.place.as_ref()?;
            let (axis, spread) = place.normal.map_or((DVec3::Z, PI), |normal| (normal, 0.0));
            let Place { around, two_sided, .. } = *place;
            Some(Bounded { around, axis, spread, two_sided, power: emitter.power })
        };
        let bounded: Vec<Bounded> = emitters.iter().filter_map(bounded).collect();
        let tree = LightTree::new(&bounded);
        for (light, trail) in self.flat.lights.iter_mut().zip(tree.trails) {
            light.trail = trail;
        }
        self.flat.light_nodes = tree.nodes;
        if let Some(Emitter { power, place: None, .. }) = emitters.last()
            && let Some(sky) = self.flat.lights.last_mut()
        {
            let all: f64 = emitters.iter().map(|emitter| emitter.power).sum();
            sky.probability = (power / all).clamp(SKY_SHARES.0, SKY_SHARES.1) as f32;
        }
    }

    /// Adds a primitive, or all faces of a mesh; `radiance` is the luminance that it sends out on the mean.
    fn add_emitter(&mut self, primitive: &Placed, index: u32, radiance: f64, emitters: &mut Vec<Emitter>) {
        let scale = primitive.to_world.scale * self.space.scale;
        let light = emitters.len() as u32;
        let two_sided = matches!(
            self.scene.materials[primitive.material as usize].1,
            Material::DiffuseLight { two_sided: true, .. }
        );
        let (space, to_world) = (self.space, primitive.to_world);
        let point = |p: DVec3| space.point(to_world.point(p));
        let mut push = |code, instance, area: f64, place: Place| {
            let sides = if place.two_sided && place.normal.is_some() { 2.0 } else { 1.0 };
            emitters.push(Emitter { code, instance, power: PI * radiance * area * sides, place: Some(place) });
        };
        let code = primitive.shape.code(index as usize);
        match primitive.shape {
            // Closed shapes are mostly seen from outside.
            Shape::Sphere { center, radius } => {
                self.flat.spheres[index as usize].light = light;
                let (middle, reach) = (point(center), DVec3::splat(radius * scale));
                let place = Place::of([middle - reach, middle + reach], None, two_sided);
                push(code, data::NO_INSTANCE, 4.0 * PI * (radius * scale).powi(2), place);
            }
            Shape::Quad { corner, u, v } => {
                self.flat.quads[index as usize].light = light;
                let corners = [corner, corner + u, corner + v, corner + u + v].map(point);
                let place = Place::of(corners, Some(to_world.vector(u).cross(to_world.vector(v))), two_sided);
                push(code, data::NO_INSTANCE, u.cross(v).length() * scale * scale, place);
            }
            Shape::Cuboid { min, max } => {
                self.flat.cuboids[index as usize].light = light;
                let d = (max - min) * scale;
                let place = Place::of(AxisBox { min, max }.corners().map(point), None, two_sided);
                push(code, data::NO_INSTANCE, 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x), place);
            }
            Shape::Mesh(mesh) => {
                let first_face = self.laid(mesh).first_face;
                self.flat.instances[index as usize].to_light = light.wrapping_sub(first_face);
                let mesh = self.meshes[mesh];
                for (face, corners) in (first_face..).zip(&mesh.triangles) {
                    let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                    let across = (b - a).cross(c - a);
                    let area = 0.5 * across.length() * scale * scale;
                    let place = Place::of([a, b, c].map(point), Some(to_world.vector(across)), two_sided);
                    push(primitive_code(KIND_TRIANGLE, face), index, area, place);
                }
            }
        }
    }
}

/// The luminance of what a material sends out on the mean.
fn mean_radiance(scene: &Scene, material: &Material) -> f64 {
    let Material::DiffuseLight { emit, .. } = material else { return 0.0 };
    match emit {
        Texture::Rgb(r, g, b) => luminance([*r, *g, *b]),
        Texture::Checker { even, odd, .. } => luminance((0.5 * (*even + *odd)).to_array()),
        Texture::Image { path } => scene.bitmaps.get(path).map_or(0.0, |bitmap| {
            let sum: DVec3 = bitmap.texels.iter().map(|t| DVec3::from_array(t.map(f64::from))).sum();
            luminance((sum / bitmap.texels.len().max(1) as f64).to_array())
        }),
        Texture::Noise { .. } | Texture::Marble { .. } => 0.5,
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
