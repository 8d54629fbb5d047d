//! Tangents of smooth meshes under normal maps: those of the file, or those of MikkTSpace, with which tools make such maps
//! (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008; glTF 2.0, 3.7.2.1).

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use super::octahedral::octahedral;
use crate::data::NO_NORMAL;
use crate::guard::guarded;
use crate::scene::Mesh;

/// A tangent in the layout of the kernels: its direction in octahedral form, and the sign of the bitangent along normal × tangent. Both are 0
/// if the texture coordinates give no direction.
pub type Words = [u32; 2];

const NONE: Words = [NO_NORMAL, 0];

fn words(tangent: Vec4) -> Words {
    let along = tangent.truncate();
    match along.is_finite() && along != Vec3::ZERO {
        true => [octahedral(along), tangent.w.to_bits()],
        false => NONE,
    }
}

/// The faces of a mesh, with copies of vertices whose corners have different tangents.
pub struct Split {
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex, the vertex of the mesh that it is a copy of. The vertices of the mesh come first.
    copy_of: Vec<u32>,
    /// The tangents of all vertices, for each set of texture coordinates that has tangents.
    pub tangents: Vec<Vec<Words>>,
}

impl Split {
    pub fn new(mesh: &Mesh) -> Split {
        let copy_of = (0..mesh.positions.len() as u32).collect();
        Split { triangles: mesh.triangles.clone(), copy_of, tangents: Vec::new() }
    }

    /// For each vertex behind those of the mesh, the vertex that it is a copy of.
    pub fn copies(&self, vertices: usize) -> &[u32] {
        self.copy_of.get(vertices..).unwrap_or_default()
    }

    /// Adds the tangents of a set of texture coordinates. `positions` are those of the mesh.
    pub fn add(&mut self, mesh: &Mesh, positions: &[Vec3], uvs: &[Vec2]) {
        if !mesh.tangents.is_empty() {
            let of = |&vertex: &u32| mesh.tangents.get(vertex as usize).map_or(NONE, |tangent| words(*tangent));
            self.tangents.push(self.copy_of.iter().map(of).collect());
            return;
        }
        let mut corners = Corners { mesh, positions, uvs, tangents: vec![[NONE; 3]; mesh.triangles.len()] };
        // If it fails, the normal is that without a map.
        let _ = guarded(|| generate_tangents(&mut corners));
        let corners = corners.tangents;
        // The tangent at each vertex, once it is known from a corner, and copies of the vertex with other tangents.
        let mut own: Vec<Option<Words>> = vec![None; self.copy_of.len()];
        let mut copies: HashMap<(u32, Words), u32> = HashMap::new();
        let corners = self.triangles.as_flattened_mut().iter_mut().zip(corners.as_flattened());
        for (corner, &tangent) in corners {
            let Some(first) = own.get_mut(*corner as usize) else { continue };
            if *first.get_or_insert(tangent) == tangent {
                continue;
            }
            *corner = *copies.entry((*corner, tangent)).or_insert_with(|| {
                let at = *corner as usize;
                self.copy_of.extend_from_within(at..=at);
                self.tangents.iter_mut().for_each(|tangents| tangents.extend_from_within(at..=at));
                own.push(Some(tangent));
                own.len() as u32 - 1
            });
        }
        self.tangents.push(own.into_iter().map(|tangent| tangent.unwrap_or(NONE)).collect());
    }
}

/// The corners of a mesh's triangles, as the crate reads them.
struct Corners<'a> {
    mesh: &'a Mesh,
    positions: &'a [Vec3],
    uvs: &'a [Vec2],
    tangents: Vec<[Words; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles.get(face).and_then(|corners| corners.get(corner)).map_or(0, |vertex| *vertex as usize)
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions.get(self.vertex(face, corner)).copied().unwrap_or_default().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals.get(self.vertex(face, corner)).copied().unwrap_or_default().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs.get(self.vertex(face, corner)).copied().unwrap_or_default().to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let own = self.tangents.get_mut(face).and_then(|corners| corners.get_mut(corner));
        if let (Some(own), Some(tangent)) = (own, tangent) {
            *own = words(Vec4::from_array(tangent.tangent_encoded()));
        }
    }
}
