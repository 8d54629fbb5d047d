//! Lays out each mesh once, in its own space and with its own hierarchy. Instances place it any number of times.
//!
//! The origin of a mesh's space is the middle of its box, and a power of two scales its coordinates to -1..1. The rounding to
//! f32 is therefore relative to the size of the mesh, and does not depend on its position in the file or on the scene.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::Builder;
use crate::bvh::{self, Bounds, Bvh, Quality};
use crate::data::{self, HIT_NOTHING, KIND_TRIANGLE, NO_NORMAL, NO_UVS, PRIMITIVE_BIT, primitive_code};
use crate::scene::Mesh;
use crate::shape::mesh::{Laid, MeshShape};

impl Builder<'_> {
    /// The place of a mesh in the tables. Lays it out on the first call.
    pub fn laid(&mut self, mesh: &MeshShape) -> Laid {
        if let Some(laid) = self.laid[mesh.number] {
            return laid;
        }
        let laid = self.lay_out(mesh);
        self.laid[mesh.number] = Some(laid);
        laid
    }

    fn lay_out(&mut self, shape: &MeshShape) -> Laid {
        let (center, unit, mesh) = (shape.around.center(), shape.unit(), shape.mesh);
        let words = &mut self.flat.meshes;
        let first_face = words.len() as u32;
        let first_vertex = first_face + mesh.triangles.len() as u32;
        let vertices = mesh.positions.len() as u32;
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| ((*p - center) / unit).as_vec3()).collect();
        let has_more = !mesh.uvs.is_empty() || !mesh.colours.is_empty();
        words.reserve(mesh.triangles.len() + positions.len() * if has_more { 2 } else { 1 });
        words.extend(
            (0..)
                .zip(&mesh.triangles)
                .map(|(number, [a, b, c])| [first_vertex + a, first_vertex + b, first_vertex + c, number]),
        );
        let normals = mesh.normals.iter().map(|n| octahedral(*n)).chain(std::iter::repeat(NO_NORMAL));
        words.extend(positions.iter().zip(normals).map(|(p, normal)| {
            let [x, y, z] = p.to_array().map(f32::to_bits);
            [x, y, z, normal]
        }));
        if has_more {
            let uvs = mesh.uvs.iter().copied().chain(std::iter::repeat(Vec2::ZERO));
            let colours = mesh.colours.iter().copied().chain(std::iter::repeat([u16::MAX; 3]));
            words.extend(uvs.zip(colours).take(positions.len()).map(|(uv, [r, g, b])| {
                [uv.x.to_bits(), uv.y.to_bits(), u32::from(r) | u32::from(g) << 16, u32::from(b)]
            }));
        }

        let quality = self.quality;
        let build = || hierarchy(mesh, &positions, quality);
        let bvh = match &mut self.hierarchies {
            Some(hierarchies) => hierarchies.of(self.scene, mesh, quality, build),
            None => Arc::new(build()),
        };
        let root = self.flat.add_nodes(&bvh, first_face);
        let to_uvs = if has_more { vertices } else { NO_UVS };
        Laid { root, first_face, to_uvs, stack_size: bvh.stack_size }
    }
}

/// The hierarchy over the faces of a mesh, which are numbered from 0 on.
fn hierarchy(mesh: &Mesh, positions: &[Vec3], quality: Quality) -> Bvh {
    let corner = |i: u32| positions[i as usize];
    let bounds = |&[a, b, c]: &[u32; 3]| {
        let (a, b, c) = (corner(a), corner(b), corner(c));
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    };
    let bounds: Vec<Bounds> = mesh.triangles.iter().map(bounds).collect();
    let codes: Vec<u32> = (0..mesh.triangles.len() as u32).map(|face| primitive_code(KIND_TRIANGLE, face)).collect();
    bvh::build(&bounds, &codes, quality)
}

impl super::DeviceScene {
    /// Appends a hierarchy to the table of nodes. Its primitives are numbered from `first_primitive` on. Returns the code of its root.
    pub fn add_nodes(&mut self, bvh: &Bvh, first_primitive: u32) -> u32 {
        let first = self.nodes.len() as u32;
        let moved = |code: u32| match code {
            HIT_NOTHING => code,
            _ if code & PRIMITIVE_BIT == 0 => code + first,
            _ => code + first_primitive,
        };
        self.nodes.extend(bvh.nodes.iter().map(|node| data::Node { children: node.children.map(moved), ..*node }));
        moved(bvh.root)
    }
}

/// Encodes a unit vector with the octahedral map. shaders/lib/octahedral decodes it.
pub fn octahedral(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = match n.z < 0.0 {
        true => ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)),
        false => (n.x, n.y),
    };
    let word = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16;
    u32::from(word(x)) | u32::from(word(y)) << 16
}
