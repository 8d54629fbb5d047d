//! What is sampled as a light: everything that emits and can be aimed at, each chosen in proportion to its power.

use std::f64::consts::PI;

use glam::DVec3;

use super::Builder;
use super::place::{Placed, Shape};
use crate::data::{self, HIT_NOTHING, KIND_TRIANGLE, PRIMITIVE_BIT, PRIMITIVE_KIND_SHIFT};
use crate::lights::{AliasTable, SkyDistribution};
use crate::scene::{Background, Bitmap, Material, Scene, Texture};

/// A light before it has its place in the table.
struct Emitter {
    code: u32,
    instance: u32,
    power: f64,
}

impl Builder<'_> {
    /// Makes lights of the primitives that emit, in their order, and of the background's image.
    pub fn add_lights(&mut self, placed: &[Placed]) {
        let mut emitters = Vec::new();
        // The index of each primitive among its kind, counted as they were added.
        let mut counts = [0u32; 4];
        for primitive in placed {
            let kind = primitive.shape.kind();
            let index = counts[kind];
            counts[kind] += 1;
            let (name, material) = &self.scene.materials[primitive.material as usize];
            let Some(radiance) = mean_radiance(self.scene, material) else { continue };
            if radiance > 0.0 {
                let asked = format!("\"{name}\" at {}", self.scene.material_location(name));
                self.flat.features.emitters[kind].get_or_insert(asked);
                self.add_emitter(primitive, index, radiance, &mut emitters);
            }
        }
        if let Background::Image { path } = &self.scene.background
            && let Some(bitmap) = self.scene.bitmaps.get(path)
        {
            // What the sky sends onto a disk as large as the scene, which has an extent of 1 in render space.
            let power = PI * integral_over_directions(bitmap);
            if let Some(sky) = SkyDistribution::new(bitmap.width, bitmap.height, &bitmap.texels) {
                self.flat.features.emitting_sky = Some("the background's image".to_string());
                self.flat.features.sky_grid = (sky.columns, sky.rows);
                self.flat.sky = sky.cells;
                emitters.push(Emitter { code: HIT_NOTHING, instance: data::NO_INSTANCE, power });
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
    }

    /// Adds a primitive, or all faces of a mesh; `radiance` is the luminance that it sends out on the mean.
    fn add_emitter(&mut self, primitive: &Placed, index: u32, radiance: f64, emitters: &mut Vec<Emitter>) {
        let scale = primitive.to_world.scale * self.space.scale;
        let light = emitters.len() as u32;
        let two_sided = match &self.scene.materials[primitive.material as usize].1 {
            Material::DiffuseLight { two_sided: true, .. } => 2.0,
            _ => 1.0,
        };
        let mut push = |code, instance, area: f64, sides: f64| {
            emitters.push(Emitter { code, instance, power: PI * radiance * area * sides });
        };
        let code = primitive.shape.code(index as usize);
        match primitive.shape {
            // Closed shapes are mostly seen from outside.
            Shape::Sphere { radius, .. } => {
                self.flat.spheres[index as usize].light = light;
                push(code, data::NO_INSTANCE, 4.0 * PI * (radius * scale).powi(2), 1.0);
            }
            Shape::Quad { u, v, .. } => {
                self.flat.quads[index as usize].light = light;
                push(code, data::NO_INSTANCE, u.cross(v).length() * scale * scale, two_sided);
            }
            Shape::Cuboid { min, max } => {
                self.flat.cuboids[index as usize].light = light;
                let d = (max - min) * scale;
                push(code, data::NO_INSTANCE, 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x), 1.0);
            }
            Shape::Mesh(mesh) => {
                let first_face = self.laid(mesh).first_face;
                self.flat.instances[index as usize].to_light = light.wrapping_sub(first_face);
                let mesh = self.meshes[mesh];
                for (face, corners) in (first_face..).zip(&mesh.triangles) {
                    let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                    let area = 0.5 * (b - a).cross(c - a).length() * scale * scale;
                    push(PRIMITIVE_BIT | KIND_TRIANGLE << PRIMITIVE_KIND_SHIFT | face, index, area, two_sided);
                }
            }
        }
    }
}

/// The luminance of what a material sends out on the mean; nothing for those that send out nothing.
fn mean_radiance(scene: &Scene, material: &Material) -> Option<f64> {
    let Material::DiffuseLight { emit, .. } = material else { return None };
    Some(match emit {
        Texture::Rgb(r, g, b) => luminance(DVec3::new(*r, *g, *b)),
        Texture::Checker { even, odd, .. } => luminance(0.5 * (*even + *odd)),
        Texture::Image { path } => scene.bitmaps.get(path).map_or(0.0, |bitmap| {
            let sum: DVec3 = bitmap.texels.iter().map(|t| DVec3::from_array(t.map(f64::from))).sum();
            luminance(sum / bitmap.texels.len().max(1) as f64)
        }),
        Texture::Noise { .. } | Texture::Marble { .. } => 0.5,
    })
}

/// The luminance of a latitude-longitude image, integrated over all directions.
fn integral_over_directions(bitmap: &Bitmap) -> f64 {
    let (width, height) = (bitmap.width as usize, f64::from(bitmap.height));
    let rows = bitmap.texels.chunks(width.max(1)).enumerate().map(|(y, row)| {
        let sum: f64 = row.iter().map(|t| luminance(DVec3::from_array(t.map(f64::from)))).sum();
        let sine = (PI * (y as f64 + 0.5) / height).sin();
        sum * sine * (2.0 * PI / width as f64) * (PI / height)
    });
    rows.sum()
}

/// Of a linear Rec. 709 colour.
fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
