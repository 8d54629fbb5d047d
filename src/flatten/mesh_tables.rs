//! The tables of a mesh for its vertices: texture coordinates and tangents.

use crate::material::Slot;
use crate::scene::Mesh;
use crate::texture::Use;

/// A table of a mesh. The first one has the first set of texture coordinates, and the colours and alphas of the vertices.
#[derive(Clone, Copy, PartialEq)]
pub struct Table {
    pub uv_set: u32,
    pub has_tangents: bool,
}

impl Table {
    pub const FIRST: Table = Table { uv_set: 0, has_tangents: false };

    /// The table that a texture has on a mesh. A normal map or a direction on a smooth mesh needs tangents.
    pub fn for_texture(slot: &Slot<'_>, mesh: &Mesh) -> Table {
        let is_turned = matches!(slot.usage, Use::Normal | Use::Direction);
        let has_tangents = is_turned && !mesh.normals.is_empty() && !mesh.uvs.is_empty();
        Table { uv_set: slot.texture.uv_set(), has_tangents }
    }
}
