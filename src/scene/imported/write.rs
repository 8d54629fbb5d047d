//! Writes what no file has.

use std::fs::File;
use std::io::{BufWriter, Error, Result, Write};

use exr::math::Vec2;
use exr::prelude::{Image, SpecificChannels, WritableImage};

use crate::bitmap::Bitmap;
use crate::shape::mesh::Mesh;

/// Writes an image as an EXR of its linear values.
pub fn write_exr(image: &Bitmap, to: &mut File) -> Result<()> {
    let size = (image.width as usize, image.height as usize);
    let channels = SpecificChannels::rgb(|Vec2(x, y)| <(f32, f32, f32)>::from(image.texel(y * size.0 + x)));
    Image::from_channels(size, channels).write().to_buffered(BufWriter::new(to)).map_err(Error::other)
}

/// Writes a mesh as a binary PLY.
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
