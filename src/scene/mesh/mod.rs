//! Triangle meshes as their files say them.

use glam::{DVec3, Vec2, Vec3};

/// A triangle mesh in its own space, in the file's units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub positions: Vec<DVec3>,
    /// Indices of vertices, counter-clockwise seen from outside; in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// A unit vector for each vertex; empty where the file has none, and then the mesh is flat-shaded.
    pub normals: Vec<Vec3>,
    /// Texture coordinates for each vertex, u to the right and v up; empty where the file has none.
    pub uvs: Vec<Vec2>,
}
