//! A mesh: triangles in a space of their own, instanced in the scene any number of times.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec3, Vec2, Vec3, Vec4};

use super::bounding_shape::BoundingShape;
use super::geometry::{Boundary, Element, Emitter, Geometry, MeshLayout, ShapeKind, table};
use super::space::{Aabb, ObjectTransform, binary_exponent, error_bound, exp2, padded};
use crate::data::{self, KIND_TRIANGLE, Tables, f32s, primitive_code};
use crate::error::Result;
use crate::source::ValuePath;

/// Rays hit the triangles, so that the shader files are those of the triangle.
pub const KIND: ShapeKind = ShapeKind {
    name: Some("Mesh"),
    shader: "triangle",
    word: "mesh",
    sizes: &[("a size", "")],
    table: table!(instances of data::Instance, to_light, "where meshes stand"),
    boundary: Some(Boundary { name: "mesh", is_convex: false, words: "a closed" }),
    covered: 0.0,
    has_parts: true,
};

/// The end of a warning that says why a mesh has no texture coordinates, although its file has some.
pub const UVS_IGNORED: &str = "all texture coordinates are ignored";

/// The open edges of a mesh: no neighbouring face runs along them in the other direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenEdges {
    /// The first face of the file, counted from 0, that has such an edge.
    pub face: u32,
    /// The number of open edges.
    pub count: usize,
}

/// A triangle mesh in its own space, in the file's units. Every vertex belongs to a triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Each coordinate is finite, at most 1e100 in magnitude.
    pub positions: Vec<DVec3>,
    /// Indices of vertices, counter-clockwise seen from outside. Triangles are in the file's order. The three positions differ.
    pub triangles: Vec<[u32; 3]>,
    /// A unit vector for each vertex. Empty if the file has none; the mesh is then flat-shaded.
    pub normals: Vec<Vec3>,
    /// Texture coordinates for each vertex, u to the right and v up, all finite. Empty if the file has none.
    pub uvs: Vec<Vec2>,
    /// Further sets of them, each like the first.
    pub further_uvs: Vec<Vec<Vec2>>,
    /// The direction of u on the surface at each vertex, a unit vector, with the sign of normal × u that v has. Empty if the file has none;
    /// MikkTSpace then finds them where a normal map needs them.
    pub tangents: Vec<Vec4>,
    /// A linear colour for each vertex, in steps of 1/65535. Empty if the file has none, or white ones alone.
    pub colours: Vec<[u16; 3]>,
    /// An alpha for each vertex, in steps of 1/65535. Empty if the file has none, or 1 alone.
    pub alphas: Vec<u16>,
    /// The face of the file, counted from 0, that each triangle is part of.
    pub faces: Vec<u32>,
    /// Warnings about parts of the file that are not used.
    pub warnings: Vec<String>,
}

impl Mesh {
    /// The number in its file of the face that a triangle is part of, counted from 0.
    pub fn face(&self, triangle: usize) -> u32 {
        self.faces.get(triangle).copied().unwrap_or(triangle as u32)
    }

    /// A set of its texture coordinates.
    pub fn uvs_of(&self, set: u32) -> &[Vec2] {
        match set.checked_sub(1) {
            None => &self.uvs,
            Some(further) => self.further_uvs.get(further as usize).map_or(&[], Vec::as_slice),
        }
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.positions.iter().copied())
    }
}

/// A mesh of the scene. Objects are instances of it.
pub struct MeshShape<'a> {
    /// Its index among the scene's meshes.
    pub number: usize,
    /// As the scene file writes it.
    pub path: &'a str,
    pub mesh: &'a Mesh,
    /// The smallest box around it, in its own space.
    pub around: Aabb,
    open: OnceLock<Option<OpenEdges>>,
}

/// The meshes of a scene as shapes, by their paths.
pub fn shapes(meshes: &BTreeMap<String, Arc<Mesh>>) -> BTreeMap<&str, MeshShape<'_>> {
    meshes
        .iter()
        .enumerate()
        .map(|(number, (path, mesh))| (path.as_str(), MeshShape::new(number, path, mesh)))
        .collect()
}

impl<'a> MeshShape<'a> {
    fn new(number: usize, path: &'a str, mesh: &'a Mesh) -> MeshShape<'a> {
        MeshShape { number, path, mesh, around: mesh.bounds(), open: OnceLock::new() }
    }

    /// Its open edges. The result is cached, because it takes a sort of all edges.
    pub fn open_edges(&self) -> Option<OpenEdges> {
        *self.open.get_or_init(|| self.mesh.open_edges())
    }

    /// Checks that it has the texture coordinates that the images of a material of this name need, up to this set of them.
    pub fn check_image(&self, at: &ValuePath, material: &str, uv_set: u32) -> Result<()> {
        if !self.mesh.uvs.is_empty() {
            let has = 1 + self.mesh.further_uvs.len();
            if (uv_set as usize) < has {
                return Ok(());
            }
            return Err(at.field("material").error(format!(
                "the material {material:?} has an image with uv_set: {uv_set}, and the mesh {:?} has no such set of texture coordinates: \
                 expected a set from 0 to {}",
                self.path,
                has - 1
            )));
        }
        let ignored = self.mesh.warnings.iter().find(|warning| warning.ends_with(UVS_IGNORED));
        let reason = ignored.map_or(String::new(), |warning| format!(" ({warning})"));
        Err(at.field("material").error(format!(
            "the material {material:?} has an image, and the mesh {:?} has no texture coordinates for it{reason}: \
             expected a mesh that has them at every corner, or another texture",
            self.path
        )))
    }

    /// Checks that it is closed.
    pub fn check_closed(&self, at: &ValuePath) -> Result<()> {
        let Some(open) = self.open_edges() else { return Ok(()) };
        let edges = if open.count == 1 { "edge" } else { "edges" };
        Err(at.field("path").error(format!(
            "{}: expected a closed mesh, wound one way, as a medium's boundary: no neighbour shares an edge of face {} (counted from 0) \
             in the other direction; there are {} such {edges}",
            self.path, open.face, open.count
        )))
    }

    /// The length of the device's unit for the mesh's own space.
    pub fn unit(&self) -> f64 {
        let half = 0.5 * (self.around.max - self.around.min).max_element();
        if half > 0.0 { exp2(binary_exponent(half)) } else { 1.0 }
    }
}

impl<'a> Geometry for &'a MeshShape<'a> {
    /// Nothing to check: the numbers were checked when the file was read.
    fn check(&self, _: &ValuePath) -> Result<()> {
        Ok(())
    }

    fn span(&self) -> (f64, f64) {
        let Aabb { min, max } = self.around;
        ((max - min).max_element(), min.abs().max(max.abs()).length())
    }

    fn texture_frame(&self, _: &DMat3) -> (DVec3, DMat3) {
        (self.around.center(), DMat3::from_diagonal(DVec3::splat(self.unit())))
    }

    fn lay_out(&self, at: &ObjectTransform, element: Element, tables: &mut Tables) -> (Vec3, Vec3) {
        let scale = at.to_world.scale * self.unit() * at.space.scale;
        let translation = at.point(self.around.center());
        let axes = at.to_world.rotation;
        let error = error_bound(&[translation.as_vec3(), Vec3::splat((3.0 * scale) as f32)]);
        let bounds = Aabb::around(self.around.corners().map(|p| at.point(p)));
        tables.instances.push(data::Instance {
            x_axis: f32s(axes.x_axis),
            order: element.order,
            y_axis: f32s(axes.y_axis),
            material: element.material,
            translation: f32s(translation),
            frame: element.frame,
            scale: scale as f32,
            to_light: 0,
            root: element.layout.root,
            to_uvs: element.layout.to_uvs,
        });
        padded(bounds.min.as_vec3(), bounds.max.as_vec3(), error)
    }

    /// Each triangle is a light.
    fn emitters(&self, at: &ObjectTransform, index: u32, _: u32, layout: MeshLayout) -> Vec<Emitter> {
        let face = |(face, corners): (u32, &[u32; 3])| {
            let [a, b, c] = corners.map(|corner| self.mesh.positions[corner as usize]);
            let across = (b - a).cross(c - a);
            Emitter {
                code: primitive_code(KIND_TRIANGLE, face),
                instance: index,
                area: 0.5 * across.length() * at.scale() * at.scale(),
                around: Aabb::around([a, b, c].map(|p| at.point(p))),
                normal: Some(at.to_world.vector(across)),
            }
        };
        (layout.first_face..).zip(&self.mesh.triangles).map(face).collect()
    }

    fn faces(&self, at: &ObjectTransform, _: u32, add: &mut dyn FnMut(&[DVec3])) {
        let position = |corner: u32| self.mesh.positions.get(corner as usize).map_or(DVec3::ZERO, |p| at.point(*p));
        self.mesh.triangles.iter().for_each(|triangle| add(&triangle.map(position)));
    }

    fn bounding_shape(&self, at: &ObjectTransform) -> BoundingShape {
        let half = 0.5 * at.scale() * (self.around.max - self.around.min);
        BoundingShape::Cuboid { center: at.point(self.around.center()), half, axes: at.to_world.rotation }
    }
}
