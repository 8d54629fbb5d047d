//! Lays out each mesh once, in its own space and with its own hierarchy. Instances refer to it any number of times.
//!
//! The origin of a mesh's space is the middle of its box, and a power of two scales its coordinates to -1..1. The rounding to
//! f32 is therefore relative to the size of the mesh, and does not depend on its position in the file or on the scene.

use std::collections::HashSet;
use std::sync::Arc;

use glam::Vec3;

use super::builder::Builder;
use super::finder::Primitive;
use super::hierarchies::Hierarchy;
use super::mesh_tables::Table;
use super::octahedral::octahedral;
use super::pairs::Pair;
use super::tangents::Split;
use crate::bvh::Quality;
use crate::data::{NO_NORMAL, NO_UVS};
use crate::material::Slot;
use crate::options::Walk;
use crate::scene::Mesh;
use crate::shape::MeshLayout;
use crate::shape::mesh::MeshShape;
use crate::texture::Wrap;

impl Builder<'_> {
    /// Finds the tables that textures need on meshes. All but the first are features, with the material that needs them.
    pub fn find_tables(&mut self, primitives: &[Primitive<'_>]) {
        let mut known = HashSet::new();
        for primitive in primitives {
            let Some(shape) = primitive.shape.mesh() else { continue };
            if !known.insert((shape.number, primitive.material)) {
                continue;
            }
            let (name, _) = &self.scene.materials[primitive.material as usize];
            let at_material = || format!("\"{name}\" at {}", self.scene.material_location(name));
            for slot in &self.framed[primitive.material as usize] {
                if slot.texture.wrap() != Wrap::Repeat {
                    self.flat.features.require("image_wrap", at_material);
                }
                let table = Table::for_texture(slot, shape.mesh);
                let tables = &mut self.tables[shape.number];
                if tables.contains(&table) {
                    continue;
                }
                tables.push(table);
                self.flat.features.require("uv_tables", at_material);
                if table.has_tangents {
                    self.flat.features.require("vertex_tangents", at_material);
                }
            }
        }
    }

    /// The phase of the frame of a texture on a mesh: the number of its table, and a quarter for each wrap after the first.
    pub fn phase_on(&self, slot: &Slot<'_>, mesh: &MeshShape) -> f32 {
        let table = Table::for_texture(slot, mesh.mesh);
        let number = self.tables[mesh.number].iter().position(|known| *known == table).unwrap_or(0);
        number as f32 + 0.25 * f32::from(slot.texture.wrap() as u8)
    }

    /// The layout of a mesh in the tables. The first call adds the mesh.
    pub fn layout_of_mesh(&mut self, mesh: &MeshShape) -> MeshLayout {
        if let Some(layout) = self.layouts[mesh.number] {
            return layout;
        }
        let layout = self.lay_out(mesh);
        self.layouts[mesh.number] = Some(layout);
        layout
    }

    fn lay_out(&mut self, shape: &MeshShape) -> MeshLayout {
        let (center, unit, mesh) = (shape.around.center(), shape.unit(), shape.mesh);
        let tables = &self.tables[shape.number];
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| ((*p - center) / unit).as_vec3()).collect();
        let split = split(mesh, &positions, tables);
        let (triangles, copies) = match &split {
            Some(split) => (split.triangles.as_slice(), split.copies(positions.len())),
            None => (mesh.triangles.as_slice(), [].as_slice()),
        };
        // For each vertex, the vertex of the mesh that it is or copies.
        let vertices = || (0..positions.len()).chain(copies.iter().map(|vertex| *vertex as usize));
        let count = positions.len() + copies.len();
        let words = &mut self.flat.meshes;
        let first_face = words.len() as u32;
        let first_vertex = first_face + triangles.len() as u32;
        let has_more = !mesh.uvs.is_empty() || !mesh.colours.is_empty() || !mesh.alphas.is_empty();
        let tables = if has_more { tables.as_slice() } else { &[] };
        words.reserve(triangles.len() + count * (1 + tables.len()));
        words.extend(
            (0..)
                .zip(triangles)
                .map(|(number, [a, b, c])| [first_vertex + a, first_vertex + b, first_vertex + c, number]),
        );
        words.extend(vertices().map(|vertex| {
            let [x, y, z] = positions[vertex].to_array().map(f32::to_bits);
            [x, y, z, mesh.normals.get(vertex).map_or(NO_NORMAL, |normal| octahedral(*normal))]
        }));
        let mut tangents = split.iter().flat_map(|split| &split.tangents);
        for table in tables {
            let uvs = mesh.uvs_of(table.uv_set);
            let uvs =
                vertices().map(|vertex| uvs.get(vertex).copied().unwrap_or_default().to_array().map(f32::to_bits));
            if table.has_tangents {
                let tangents = tangents.next().into_iter().flatten();
                words.extend(uvs.zip(tangents).map(|([u, v], [along, sign])| [u, v, *along, *sign]));
                continue;
            }
            words.extend(uvs.zip(vertices()).map(|([u, v], vertex)| {
                let [r, g, b] = mesh.colours.get(vertex).copied().unwrap_or([u16::MAX; 3]);
                let missing = u16::MAX - mesh.alphas.get(vertex).copied().unwrap_or(u16::MAX);
                [u, v, u32::from(r) | u32::from(g) << 16, u32::from(b) | u32::from(missing) << 16]
            }));
        }

        // `best` puts faces into several leaves. The walk that finds the ends of a medium would then count them twice.
        let quality = match self.quality {
            Quality::Best if self.around_media.contains(&shape.number) => Quality::Medium,
            quality => quality,
        };
        let build = || Hierarchy::over(mesh, &positions, quality);
        let hierarchy = match &mut self.hierarchies {
            Some(hierarchies) => hierarchies.get_or_build(self.scene, mesh, quality, build),
            None => Arc::new(build()),
        };
        let bvh = &hierarchy.bvh;
        let laid_out = |pair: &Pair| pair.laid_out(&mesh.triangles, &positions, first_face);
        let pairs = hierarchy.pairs.iter().map(laid_out);
        let root = match self.walk {
            Walk::Coded => self.flat.add_mesh(bvh, pairs),
            Walk::Siblings => self.flat.add_siblings(bvh, &pairs.collect::<Vec<_>>()),
        };
        let to_uvs = if has_more { count as u32 } else { NO_UVS };
        MeshLayout { root, first_face, to_uvs, stack_size: bvh.stack_size }
    }
}

/// The mesh with its vertices split where tangents differ, if a table has tangents.
fn split(mesh: &Mesh, positions: &[Vec3], tables: &[Table]) -> Option<Split> {
    let sets: Vec<u32> = tables.iter().filter(|table| table.has_tangents).map(|table| table.uv_set).collect();
    let mut split = (!sets.is_empty()).then(|| Split::new(mesh))?;
    sets.into_iter().for_each(|uv_set| split.add(mesh, positions, mesh.uvs_of(uv_set)));
    Some(split)
}
