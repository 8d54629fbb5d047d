//! Writes a mesh as a binary PLY.

use std::io::{Result, Write};

use crate::shape::mesh::Mesh;

pub fn write_ply(mesh: &Mesh, to: &mut dyn Write) -> Result<()> {
    let property = |names: &[&str], kind: &str| -> String {
        names.iter().map(|name| format!("property {kind} {name}\n")).collect()
    };
    let normals = if mesh.normals.is_empty() { String::new() } else { property(&["nx", "ny", "nz"], "float") };
    let uvs = if mesh.uvs.is_empty() { String::new() } else { property(&["s", "t"], "float") };
    write!(
        to,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{}{normals}{uvs}element face {}\nproperty list uchar int vertex_indices\n\
         end_header\n",
        mesh.positions.len(),
        property(&["x", "y", "z"], "double"),
        mesh.triangles.len()
    )?;
    for (number, position) in mesh.positions.iter().enumerate() {
        for x in position.to_array() {
            to.write_all(&x.to_le_bytes())?;
        }
        let normal = mesh.normals.get(number).map(|normal| normal.to_array());
        let uv = mesh.uvs.get(number).map(|uv| uv.to_array());
        for x in normal.iter().flatten().chain(uv.iter().flatten()) {
            to.write_all(&x.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        to.write_all(&[3])?;
        for corner in triangle {
            to.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}
