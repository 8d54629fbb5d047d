//! Unpacks views (EXT_meshopt_compression, KHR_meshopt_compression) and primitives (KHR_draco_mesh_compression) with the crate `draco-gltf`: to
//! buffers, views and accessors as those of a file without these extensions.

use std::mem::take;
use std::sync::Arc;

use draco_gltf::meshopt::decode_buffer_view;
use draco_gltf::{
    DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue, MeshoptFilter, MeshoptMode,
};
use gltf::json::buffer::{Buffer, View};
use gltf::json::mesh::{Mode, Primitive};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use serde::Deserialize;
use serde_json::{Value, json};

use super::error::{self, GltfError};
use crate::scene::file::LONGEST;

type Result<T> = std::result::Result<T, String>;

/// The bytes of a buffer. Buffers may share them.
pub type Bytes = Arc<Vec<u8>>;

pub const DRACO: &str = "KHR_draco_mesh_compression";
pub const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Whether a buffer has no bytes, or those for programs that do not unpack.
pub fn is_fallback(buffer: &Buffer) -> bool {
    let Some(found) = &buffer.extensions else { return false };
    MESHOPT.iter().any(|name| found.others.get(*name).is_some_and(|of| of["fallback"] == true))
}

/// Unpacks what is packed, to as many bytes as a file may have.
pub fn unpack(root: &mut Root, buffers: &mut Vec<Bytes>) -> error::Result<()> {
    let mut room = LONGEST as usize;
    let mut views = take(&mut root.buffer_views);
    for (number, view) in views.iter_mut().enumerate() {
        let Some(found) = &view.extensions else { continue };
        let Some((name, given)) = MESHOPT.iter().find_map(|name| Some((name, found.others.get(*name)?))) else {
            continue;
        };
        let unpacked = elements(given, buffers, room).and_then(|bytes| add(bytes, root, buffers, &mut room));
        let unpacked =
            unpacked.map_err(|reason| GltfError::new(format!("bufferViews[{number}].extensions.{name}"), reason))?;
        *view = View { byte_stride: view.byte_stride, ..unpacked };
    }
    root.buffer_views = views;
    let mut meshes = take(&mut root.meshes);
    for (mesh, primitives) in meshes.iter_mut().map(|mesh| &mut mesh.primitives).enumerate() {
        for (number, primitive) in primitives.iter_mut().enumerate() {
            let given = primitive.extensions.as_mut().and_then(|found| found.others.remove(DRACO));
            given.map_or(Ok(()), |given| triangles(&given, primitive, root, buffers, &mut room)).map_err(|reason| {
                GltfError::new(format!("meshes[{mesh}].primitives[{number}].extensions.{DRACO}"), reason)
            })?;
        }
    }
    root.meshes = meshes;
    Ok(())
}

/// A view of all of a new buffer.
fn add(bytes: Vec<u8>, root: &mut Root, buffers: &mut Vec<Bytes>, room: &mut usize) -> Result<View> {
    let length = bytes.len();
    *room = room.checked_sub(length).ok_or("it is too long unpacked")?;
    root.buffers.push(from_json(json!({ "byteLength": length }))?);
    buffers.push(bytes.into());
    from_json(json!({ "buffer": buffers.len() - 1, "byteLength": length }))
}

fn from_json<T: for<'a> Deserialize<'a>>(value: Value) -> Result<T> {
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// The elements of a view.
fn elements(given: &Value, buffers: &[Bytes], room: usize) -> Result<Vec<u8>> {
    /// The most bytes that one byte becomes: each column of 4 bytes of 256 vertices is one byte or more.
    const MOST: usize = 1024;
    let text = |error: draco_gltf::GltfError| error.to_string();
    let number = |name: &str| given[name].as_u64().and_then(|number| usize::try_from(number).ok()).unwrap_or(0);
    let bytes = part(buffers, number("buffer"), number("byteOffset"), number("byteLength"));
    let bytes = bytes.ok_or("it reaches past the end of its buffer")?;
    let (count, stride) = (number("count"), number("byteStride"));
    let length = stride.saturating_mul(count);
    if length > room.min(bytes.len().saturating_mul(MOST)) {
        return Err(format!("{} bytes cannot become {length}", bytes.len()));
    }
    let mode = MeshoptMode::from_name(given["mode"].as_str().unwrap_or_default()).map_err(text)?;
    let filter = MeshoptFilter::from_name(given["filter"].as_str().unwrap_or("NONE")).map_err(text)?;
    let mut elements = vec![0; length];
    decode_buffer_view(&mut elements, bytes, mode, filter, count, stride).map_err(text)?;
    Ok(elements)
}

/// Gives the accessors of a primitive their elements.
fn triangles(
    given: &Value,
    primitive: &mut Primitive,
    root: &mut Root,
    buffers: &mut Vec<Bytes>,
    room: &mut usize,
) -> Result<()> {
    let text = |error: draco_gltf::Error| error.to_string();
    let json = JsonValue::parse(given.to_string().as_bytes()).map_err(|error| error.to_string())?;
    let packed = DracoPrimitiveExtension::from_json(&json).map_err(text)?;
    let bytes = view_of(root, buffers, Index::new(u32::try_from(packed.buffer_view()).unwrap_or(u32::MAX)))?;
    // A triangle has 12 bytes of indices.
    let limits = DecodeLimits::default().with_max_decoded_bytes(*room as u64).with_max_faces(*room as u64 / 12);
    let mesh = packed.decode(bytes, &DracoPrimitiveContract::new().with_limits(limits)).map_err(text)?;
    let attributes = mesh.attributes().iter().filter_map(|of| {
        let index = primitive.attributes.iter().find(|(semantic, _)| semantic.to_string() == of.semantic())?.1;
        Some((*index, of.count(), of.component_type(), of.bytes()))
    });
    let indices = primitive.indices.zip(mesh.indices()).ok_or("expected indices")?;
    let indices = (indices.0, indices.1.count(), indices.1.component_type(), indices.1.bytes());
    for (index, count, kind, bytes) in attributes.chain([indices]) {
        let view = add(bytes.to_vec(), root, buffers, room)?;
        root.buffer_views.push(view);
        let accessor = root.accessors.get_mut(index.value()).ok_or("an accessor is not there")?;
        accessor.buffer_view = Some(Index::new(root.buffer_views.len() as u32 - 1));
        accessor.byte_offset = None;
        accessor.count = (count as u64).into();
        accessor.component_type = from_json(json!(kind as u32))?;
        accessor.sparse = None;
    }
    primitive.mode = Checked::Valid(Mode::Triangles);
    Ok(())
}

/// The bytes of a view of a buffer.
pub fn view_of<'a>(root: &Root, buffers: &'a [Bytes], index: Index<View>) -> Result<&'a [u8]> {
    let number = index.value();
    let view = root.get(index).ok_or_else(|| format!("there is no bufferView {number}"))?;
    let [start, length] = [view.byte_offset.unwrap_or_default(), view.byte_length]
        .map(|size| usize::try_from(size.0).unwrap_or(usize::MAX));
    part(buffers, view.buffer.value(), start, length)
        .ok_or_else(|| format!("bufferView {number} reaches past the end of its buffer"))
}

/// The bytes of a part of a buffer, if it has them.
fn part(buffers: &[Bytes], number: usize, start: usize, length: usize) -> Option<&[u8]> {
    buffers.get(number)?.get(start..)?.get(..length)
}
