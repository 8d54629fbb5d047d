//! The tables of a mesh for its vertices: texture coordinates and tangents.

use crate::scene::{Mesh, Texture};

/// A table of a mesh. The first one has the first set of texture coordinates, and the colours and alphas of the vertices.
#[derive(Clone, Copy, PartialEq)]
pub struct Table {
    pub uv_set: u32,
    pub has_tangents: bool,
}

impl Table {
    pub const FIRST: Table = Table { uv_set: 0, has_tangents: false };

    /// The table that a texture has on a mesh. A normal map on a smooth mesh needs tangents.
    pub fn for_texture(texture: &Texture, mesh: &Mesh) -> Table {
        let has_tangents = texture.is_normal_map() && !mesh.normals.is_empty() && !mesh.uvs.is_empty();
        Table { uv_set: texture.uv_set(), has_tangents }
    }
}
