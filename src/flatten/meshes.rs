//! Lays out each mesh once, in its own space and with its own hierarchy. Instances place it any number of times.
//!
//! The origin of a mesh's space is the middle of its box, and a power of two scales its coordinates to -1..1. The rounding to
//! f32 is therefore relative to the size of the mesh, and does not depend on its position in the file or on the scene.

use glam::Vec3;

use super::Builder;
use crate::bvh::{self, Bounds};
use crate::data::{self, KIND_TRIANGLE, NO_NORMAL, NO_UVS, PRIMITIVE_BIT, primitive_code};
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
        words.reserve(mesh.triangles.len() + positions.len() * if mesh.uvs.is_empty() { 1 } else { 2 });
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
        words.extend(mesh.uvs.iter().map(|uv| [uv.x.to_bits(), uv.y.to_bits(), 0, 0]));

        let corner = |i: u32| positions[i as usize];
        let bounds: Vec<Bounds> = mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| {
                let (a, b, c) = (corner(a), corner(b), corner(c));
                Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
            })
            .collect();
        let codes: Vec<u32> = (first_face..first_vertex).map(|face| primitive_code(KIND_TRIANGLE, face)).collect();
        let bvh = bvh::build(&bounds, &codes, self.quality);
        let root = self.flat.add_nodes(bvh.root, bvh.nodes);
        let to_uvs = if mesh.uvs.is_empty() { NO_UVS } else { vertices };
        Laid { root, first_face, to_uvs, stack_size: bvh.stack_size }
    }
}

impl super::DeviceScene {
    /// Appends a hierarchy to the table of nodes. Returns the code of its root.
    pub fn add_nodes(&mut self, root: u32, nodes: Vec<data::Node>) -> u32 {
        let first = self.nodes.len() as u32;
        let moved = |code: u32| if code & PRIMITIVE_BIT == 0 { code + first } else { code };
        self.nodes.reserve(nodes.len());
        self.nodes.extend(nodes.into_iter().map(|node| data::Node { children: node.children.map(moved), ..node }));
        moved(root)
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
