//! Finds textures that are finer than f32 resolves: images where the texture coordinates of a mesh are far from 0, and patterns of cells that
//! are small beside their object. A part of the surface, or all of it, then has the colour of one texel or cell.

use std::collections::HashMap;

use glam::{DMat3, DVec3};

use super::{At, Body, Diagnostic, Found, U, Worst, short};
use crate::scene::Bitmaps;
use crate::shape::mesh::Mesh;
use crate::texture::Texture;

/// The largest step from one coordinate in f32 to the next: a texel, or half a cell, so that each cell has coordinates of its own.
const LARGEST_STEP: f64 = 1.0;
const LARGEST_STEP_OF_CELLS: f64 = 0.5;
/// How far a large sphere is seen, in distances from its nearest point.
const SEEN: f64 = 4.0;

/// A texture, and the number of its texels or cells in a unit of its coordinates.
#[derive(Clone, Copy)]
struct Pattern<'a> {
    texture: &'a Texture,
    detail: f64,
}

impl<'a> Pattern<'a> {
    /// None for a plain colour.
    fn of(texture: &'a Texture, bitmaps: &Bitmaps) -> Option<Pattern<'a>> {
        let detail = match texture {
            Texture::Rgb(..) => return None,
            Texture::Image { .. } => texture.bitmap(bitmaps).map(|image| f64::from(image.width.max(image.height)))?,
            Texture::Checker { scale, .. } => 1.0 / scale,
            Texture::Noise { scale } | Texture::Marble { scale } => *scale,
        };
        Some(Pattern { texture, detail })
    }
}

/// A pattern on an object or in a medium, the largest coordinate there, and the step from it to the next.
struct Coarse<'a> {
    at: At,
    pattern: Pattern<'a>,
    largest: f64,
    step: f64,
}

/// The warnings about images and about cells.
pub fn diagnostics(found: &Found) -> Vec<Diagnostic> {
    let bitmaps = &found.scene.bitmaps;
    let materials = found.scene.materials.iter().map(|(_, material)| material.textures());
    let of_materials: Vec<Vec<Pattern>> = materials
        .map(|textures| textures.into_iter().filter_map(|texture| Pattern::of(texture, bitmaps)).collect())
        .collect();
    let mut coarse = Coarsest::default();
    let mut known: HashMap<(usize, u32), f64> = HashMap::new();
    for (number, placed) in found.placed.iter().enumerate() {
        for pattern in &of_materials[placed.material as usize] {
            let largest = match (pattern.texture.image(), placed.shape.mesh()) {
                (Some(_), Some(mesh)) => {
                    let set = pattern.texture.uv_set();
                    *known.entry((mesh.number, set)).or_insert_with(|| largest_uv(mesh.mesh, set))
                }
                // All other shapes have texture coordinates from 0 to 1.
                (Some(_), None) => continue,
                (None, _) => extent(&Body::new(found, &placed.shape, &placed.to_world)),
            };
            coarse.see(At::Primitive(number), *pattern, largest);
        }
    }
    for (number, medium) in found.media.iter().enumerate() {
        if let Some(pattern) = Pattern::of(medium.albedo, bitmaps) {
            coarse.see(At::Medium(number), pattern, extent(&Body::new(found, &medium.boundary, &medium.to_world)));
        }
    }
    let mesh = |at: At| match at {
        At::Primitive(number) => found.placed[number].shape.mesh().map_or("", |mesh| mesh.path),
        _ => "",
    };
    let images = coarse.images.diagnostic(|coarse| tell_image(mesh(coarse.at), coarse));
    [images, coarse.cells.diagnostic(tell_cells)].into_iter().flatten().collect()
}

/// The patterns that are too fine.
#[derive(Default)]
struct Coarsest<'a> {
    images: Worst<Coarse<'a>>,
    cells: Worst<Coarse<'a>>,
}

impl<'a> Coarsest<'a> {
    fn see(&mut self, at: At, pattern: Pattern<'a>, largest: f64) {
        let step = step_at(largest);
        let (most, worst) = match pattern.texture.image() {
            Some(_) => (LARGEST_STEP, &mut self.images),
            None => (LARGEST_STEP_OF_CELLS, &mut self.cells),
        };
        if step * pattern.detail > most {
            worst.note(step * pattern.detail, Coarse { at, pattern, largest, step });
        }
    }
}

/// The largest texture coordinate of a set.
fn largest_uv(mesh: &Mesh, set: u32) -> f64 {
    let uvs = match set.checked_sub(1) {
        None => Some(&mesh.uvs),
        Some(further) => mesh.further_uvs.get(further as usize),
    };
    uvs.into_iter().flatten().fold(0.0, |most: f64, uv| most.max(f64::from(uv.abs().max_element())))
}

/// The largest coordinate of a point of an object, in its own space and from its base point.
fn extent(body: &Body) -> f64 {
    if let Some(large_sphere) = body.shape.large_sphere() {
        return SEEN * large_sphere.distance(body.to_world) / body.to_world.scale;
    }
    let (_, columns): (DVec3, DMat3) = body.shape.texture_place(&body.to_world.rotation);
    (columns.x_axis.abs() + columns.y_axis.abs() + columns.z_axis.abs()).max_element()
}

/// From a coordinate in f32 to the next.
fn step_at(x: f64) -> f64 {
    if x > 0.0 { 2.0 * U * x.log2().floor().exp2() } else { 0.0 }
}

fn tell_image(mesh: &str, Coarse { at, pattern, largest, step }: Coarse) -> Diagnostic {
    let path = pattern.texture.image().map_or("", String::as_str);
    let message = format!(
        "the texture coordinates of the mesh {mesh:?} reach {}, where f32 has one in {}, and {path:?} has {} texels there: whole areas show one of \
         them: move the coordinates towards 0 by whole numbers, since the image repeats, or make them smaller",
        short(largest),
        short(step),
        short(step * pattern.detail)
    );
    Diagnostic::of(at, "", message)
}

fn tell_cells(Coarse { at, pattern: Pattern { texture, detail }, largest, step }: Coarse) -> Diagnostic {
    let advice = match texture {
        Texture::Checker { .. } => format!("{} or more", short(step / LARGEST_STEP_OF_CELLS)),
        _ => format!("{} or less", short(LARGEST_STEP_OF_CELLS / step)),
    };
    let message = format!(
        "the cells of its {} are {}, but it reaches {} in its own space, where f32 has one coordinate in {}: whole areas show one cell: write a \
         scale of {advice}, or the mean colour",
        texture.kind().form.name,
        short(1.0 / detail),
        short(largest),
        short(step)
    );
    Diagnostic::of(at, if matches!(at, At::Medium(_)) { "albedo" } else { "" }, message)
}
