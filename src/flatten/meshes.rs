//! Meshes: laid out once each in a space of their own, with a hierarchy of their own, and placed any number of times.
//!
//! A mesh's space has the middle of its box as origin and is scaled by a power of two to coordinates within -1..1, so that
//! rounding to f32 is relative to the mesh and neither to its place in the file nor to the scene.

use glam::Vec3;

use super::place::Aabb;
use super::shapes::{error_bound, padded};
use super::similarity::Similarity;
use super::{Builder, binary_exponent, exp2};
use crate::bvh::{self, Bounds};
use crate::data::{self, KIND_TRIANGLE, NO_NORMAL, NO_UVS, PRIMITIVE_BIT, f32s, primitive_code};
use crate::scene::Mesh;

/// A mesh that has been laid out.
#[derive(Clone, Copy)]
pub struct Laid {
    /// The code of its root.
    root: u32,
    /// The index of its first face.
    pub first_face: u32,
    to_uvs: u32,
    /// Codes that wait at most in a walk through its hierarchy.
    pub stack_size: u32,
}

impl Aabb {
    /// Length of a unit of the space of a mesh with this box.
    pub fn unit(&self) -> f64 {
        let half = 0.5 * (self.max - self.min).max_element();
        if half > 0.0 { exp2(binary_exponent(half)) } else { 1.0 }
    }
}

impl Builder<'_> {
    /// Places a mesh in the scene; the result is the instance's index.
    pub fn add_instance(
        &mut self,
        mesh: usize,
        to_world: &Similarity,
        order: u32,
        material: u32,
        frame: u32,
    ) -> (usize, Bounds) {
        let laid = self.laid(mesh);
        let around = self.boxes[mesh];
        let scale = to_world.scale * around.unit() * self.space.scale;
        let place = self.space.point(to_world.point(around.center()));
        let axes = to_world.rotation;
        let error = error_bound(&[place.as_vec3(), Vec3::splat((3.0 * scale) as f32)]);
        let placed = Aabb::around(around.corners().map(|p| self.space.point(to_world.point(p))));
        self.flat.instances.push(data::Instance {
            x_axis: f32s(axes.x_axis),
            order,
            y_axis: f32s(axes.y_axis),
            material,
            place: f32s(place),
            frame,
            scale: scale as f32,
            to_light: 0,
            root: laid.root,
            to_uvs: laid.to_uvs,
        });
        (self.flat.instances.len() - 1, padded(placed.min.as_vec3(), placed.max.as_vec3(), error))
    }

    /// The mesh laid out, now or before.
    pub fn laid(&mut self, mesh: usize) -> Laid {
        if let Some(laid) = self.laid[mesh] {
            return laid;
        }
        let laid = self.lay_out(self.meshes[mesh], self.boxes[mesh]);
        self.laid[mesh] = Some(laid);
        laid
    }

    fn lay_out(&mut self, mesh: &Mesh, around: Aabb) -> Laid {
        let (center, unit) = (around.center(), around.unit());
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
    /// Appends a hierarchy to those that are there; the result is its root's code.
    pub fn add_nodes(&mut self, root: u32, nodes: Vec<data::Node>) -> u32 {
        let first = self.nodes.len() as u32;
        let moved = |code: u32| if code & PRIMITIVE_BIT == 0 { code + first } else { code };
        self.nodes.reserve(nodes.len());
        self.nodes.extend(nodes.into_iter().map(|node| data::Node { children: node.children.map(moved), ..node }));
        moved(root)
    }
}

/// A unit vector in the octahedral map, as shaders/lib/octahedral reads it.
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
