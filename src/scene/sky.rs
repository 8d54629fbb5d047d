//! The sky of files that have none, where their own lights are not enough.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DAffine3, DVec3};

use super::model::Scene;
use super::types::*;
use crate::data::luminance;
use crate::luminance::{Area, Luminance};
use crate::printable::percent;
use crate::shape::mesh::Mesh;

/// The radiance of the default sky straight down and straight up.
const WHITE: Colour = Colour::ONE;
const BLUE: Colour = Colour::new(0.5, 0.7, 1.0);
/// The default sky.
pub const SKY: Background = Background::Gradient { bottom: WHITE, top: BLUE };

/// The share of its light under the sky from which on a file's emitters light it alone: as 2 % of the light, what is white under the sky
/// still has the code 38 of 255 in the picture.
const ENOUGH: f64 = 0.02;
/// The points on what emits and on what reflects between which light is estimated.
const POINTS: usize = 512;

/// A mesh of the file with its material.
struct Surface<'a> {
    /// The path of the mesh, and the name of the material.
    key: (&'a str, &'a str),
    mesh: &'a Mesh,
    to_scene: &'a DAffine3,
    /// The luminance of its mean emission, and where that varies with the set of texture coordinates.
    mean: f64,
    image: Option<(&'a Luminance<'a>, u32)>,
    reflects: bool,
}

/// A point on a surface.
struct Point {
    at: DVec3,
    normal: DVec3,
    /// Whether it is on a flat sheet, which has two sides wherever its normal points to.
    is_of_sheet: bool,
}

impl Scene {
    /// Gives the default sky to a scene of these meshes, unless its own lights are enough. Returns a note that says which of both it is, or
    /// nothing where lamps light it.
    pub(super) fn add_sky(&mut self, meshes: &[(String, DAffine3)]) -> Option<String> {
        let is_lamp =
            |object: &Object| object.unnamed().delta_light().is_some_and(|light| light.colour() != Colour::ZERO);
        if self.objects.iter().any(is_lamp) {
            return None;
        }
        let share = self.share_of_emitters(meshes);
        if share.is_some_and(|share| share >= ENOUGH) {
            return Some("its emitters alone light it: --sky default adds a white and blue sky".to_owned());
        }
        self.background = SKY;
        Some(match share {
            Some(share) => format!(
                "its emitters give only {} of its light, so a white and blue sky lights it too: --sky none removes the sky, --sky FILE \
                 gives another",
                percent(share)
            ),
            None => {
                "nothing in it emits light, so a white and blue sky does: --sky FILE gives another, --sun adds a sun"
                    .to_owned()
            }
        })
    }

    /// The share that emitters have of the light on the surfaces that reflect, under the sky; or of the light that leaves all surfaces, if
    /// that is more than half. Nothing casts a shadow, and surfaces count as white, since black ones need a sky too. None without emitters.
    fn share_of_emitters(&self, meshes: &[(String, DAffine3)]) -> Option<f64> {
        let materials: HashMap<&str, _> =
            self.materials.iter().map(|(name, own)| (name.as_str(), self.emission(own))).collect();
        // The meshes are those of these objects, in their order.
        let mut names = Vec::new();
        self.visit_objects(&mut |_, object| {
            if let Object::Mesh { material, .. } = object {
                names.push(material.as_deref().unwrap_or_default());
            }
        });
        let surfaces = meshes.iter().zip(names).filter_map(|((path, to_scene), name)| {
            let (mean, image, reflects) = materials.get(name)?;
            let image = image.as_ref().map(|(image, set)| (image, *set));
            Some(Surface {
                key: (path, name),
                mesh: self.meshes.get(path)?,
                to_scene,
                mean: *mean,
                image,
                reflects: *reflects,
            })
        });
        let surfaces: Vec<Surface> = surfaces.collect();
        let (emitted, from) = points(&surfaces, |surface, triangle| surface.emission(triangle));
        let (area, to) = points(&surfaces, |surface, _| f64::from(u8::from(surface.reflects)));
        // The radiosity of each point meets a disk around each other one (Wallace et al., "A Ray Tracing Algorithm for Progressive
        // Radiosity", SIGGRAPH 1989, eq. 5).
        let disk = area / POINTS as f64;
        let pairs = from.iter().flat_map(|from| to.iter().map(move |to| disk * transfer(from, to, disk)));
        let received = emitted / POINTS as f64 * pairs.sum::<f64>();
        let of_sky = area * luminance((0.5 * (WHITE + BLUE)).to_array());
        let share = |light: f64| light / (light + of_sky);
        let share = Some(share(emitted)).filter(|share| *share > 0.5).unwrap_or(share(received));
        (emitted > 0.0).then_some(share)
    }

    /// The luminance of a material's mean emission, where that varies, and whether it also reflects.
    fn emission<'a>(&'a self, material: &'a Material) -> (f64, Option<(Luminance<'a>, u32)>, bool) {
        let model = material.model();
        let is_seen = model.most_emitted(&self.bitmaps, || [1.0; 2]).is_seen();
        let emission = model.emission().filter(|_| is_seen).map(|emission| emission.slot.texture);
        let is_black = matches!(material, Material::Lambertian(own) if own.albedo.plain() == Some(Colour::ZERO));
        let mean = emission.map_or(0.0, |texture| texture.mean_luminance(&self.bitmaps));
        let image = emission
            .filter(|_| mean > 0.0)
            .and_then(|texture| Some((Luminance::new(texture, &self.bitmaps, true)?, texture.uv_set())));
        (mean, image, model.light().is_none() && !is_black)
    }
}

impl Surface<'_> {
    /// Half the cross product of two edges of a triangle, in the mesh's own space: its area along its normal.
    fn area(&self, triangle: &[u32; 3]) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }

    fn corners(&self, triangle: &[u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.mesh.positions.get(corner as usize).copied().unwrap_or_default())
    }

    /// The luminance of a triangle's mean emission.
    fn emission(&self, triangle: &[u32; 3]) -> f64 {
        let Some((image, set)) = self.image else { return self.mean };
        let uvs = self.mesh.uvs_of(set);
        let uv = |corner: u32| uvs.get(corner as usize).copied().unwrap_or_default().as_dvec2();
        let [a, b, c] = triangle.map(uv);
        image.mean(&Area { low: a.min(b).min(c), high: a.max(b).max(c), middle: DVec3::ZERO })
    }
}

/// The area of all triangles times a weight, and points that are as dense as the weight.
fn points(surfaces: &[Surface], weight: impl Fn(&Surface, &[u32; 3]) -> f64) -> (f64, Vec<Point>) {
    let mut known = HashMap::new();
    // The transform of a mesh keeps its angles.
    let scale = |surface: &Surface| surface.to_scene.matrix3.determinant().abs().powf(2.0 / 3.0);
    let of_surface = |surface: &Surface<'_>| {
        let areas = surface.mesh.triangles.iter().map(|triangle| weight(surface, triangle) * surface.area(triangle));
        areas.fold((0.0, DVec3::ZERO), |(sum, along), area| (sum + area.length(), along + area))
    };
    let own: Vec<(f64, DVec3)> =
        surfaces.iter().map(|surface| *known.entry(surface.key).or_insert_with(|| of_surface(surface))).collect();
    let total: f64 = surfaces.iter().zip(&own).map(|(surface, (area, _))| scale(surface) * area).sum();
    let (mut found, mut before) = (Vec::new(), 0.0);
    let next = |count: usize| (count as f64 + 0.5) / POINTS as f64 * total;
    for (surface, (all, along)) in surfaces.iter().zip(own) {
        let scale = scale(surface);
        let after = before + scale * all;
        // Most surfaces of a large file have no point.
        let triangles = if next(found.len()) < after { surface.mesh.triangles.as_slice() } else { &[] };
        for triangle in triangles {
            let area = surface.area(triangle);
            before += scale * weight(surface, triangle) * area.length();
            while next(found.len()) < before && found.len() < POINTS {
                let [a, b, c] = surface.corners(triangle);
                // Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.
                let [s, t] = [0.754_877_666, 0.569_840_291].map(|step: f64| (found.len() as f64 * step).fract());
                let [s, t] = if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] };
                found.push(Point {
                    at: surface.to_scene.transform_point3(a + s * (b - a) + t * (c - a)),
                    normal: surface.to_scene.transform_vector3(area).normalize_or_zero(),
                    is_of_sheet: along.length() > 0.99 * all,
                });
            }
        }
        before = after;
    }
    (total, found)
}

/// The share of a point's light that a disk of this area receives around another point, for each unit of the area.
fn transfer(from: &Point, to: &Point, disk: f64) -> f64 {
    let way = to.at - from.at;
    let squared = way.length_squared();
    let cosine = |point: &Point, way: DVec3| {
        let along = way.dot(point.normal);
        if point.is_of_sheet { along.abs() } else { along.max(0.0) }
    };
    let cosines = cosine(from, way) * cosine(to, -way);
    if squared > 0.0 { cosines / (squared * (PI * squared + disk)) } else { 0.0 }
}
