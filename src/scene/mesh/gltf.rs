//! glTF 2.0, as JSON and as GLB: the triangles of the default scene, with its nodes' transforms applied in f64.
//!
//! A file is not trusted: every index, offset and count in it is checked where it is used.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::draft::Draft;
use super::input::{Input, quote};

/// What of the format concerns triangles; serde passes over all else.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Scene>,
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    meshes: Vec<Mesh>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<View>,
    #[serde(default)]
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    children: Vec<usize>,
    mesh: Option<usize>,
    /// By columns.
    matrix: Option<[f64; 16]>,
    translation: Option<DVec3>,
    /// A quaternion, its real part last.
    rotation: Option<[f64; 4]>,
    scale: Option<DVec3>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: BTreeMap<String, usize>,
    indices: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
}

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

fn triangles() -> u32 {
    TRIANGLES
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    shape: String,
    sparse: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    uri: Option<String>,
    byte_length: usize,
}

pub fn parse(path: &Path, input: &mut Input) -> Result<Draft, String> {
    let bytes = input.take(input.rest().len()).unwrap_or_default();
    let (json, binary) = chunks(bytes).ok_or("expected a GLB file of version 2: it is not complete")?;
    let document: Document =
        serde_json::from_slice(json).map_err(|error| format!("expected the JSON of a glTF 2.0 file: {error}"))?;
    document.check()?;
    let file = File { buffers: buffers(&document, binary, path)?, document };
    let mut draft = Draft::default();
    file.add_scene(&mut draft)?;
    Ok(draft)
}

/// The JSON and, of a GLB file that has it, the binary chunk.
fn chunks(bytes: &[u8]) -> Option<(&[u8], Option<&[u8]>)> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Some((bytes, None)) };
    let number = |rest: &[u8]| rest.first_chunk().map(|bytes| u32::from_le_bytes(*bytes) as usize);
    if number(rest)? != 2 || number(rest.get(4..)?)? > bytes.len() {
        return None;
    }
    let chunk = |rest: &[u8]| Some(8..number(rest)?.checked_add(8)?);
    let json = chunk(rest.get(8..)?)?;
    let rest = rest.get(8..)?;
    let after = rest.get(json.end..)?;
    let json = rest.get(4..8).filter(|name| name == b"JSON").and_then(|_| rest.get(json))?;
    let binary = match after.get(4..8) {
        Some(b"BIN\0") => Some(after.get(chunk(after)?)?),
        _ => None,
    };
    Some((json, binary))
}

impl Document {
    fn check(&self) -> Result<(), String> {
        /// Extensions that may be passed over, and one that is what `File::elements` does anyway.
        const HARMLESS: [&str; 5] =
            ["KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "KHR_mesh_quantization"];
        if !self.asset.version.starts_with("2.") {
            return Err(format!("expected glTF of version 2.0, found {}", quote(self.asset.version.as_bytes())));
        }
        let is_harmless = |name: &String| HARMLESS.iter().any(|start| name.starts_with(start));
        match self.extensions_required.iter().find(|name| !is_harmless(name)) {
            Some(name) => Err(format!(
                "it requires the extension {}, which is not supported: export it without",
                quote(name.as_bytes())
            )),
            None => Ok(()),
        }
    }
}

impl Node {
    fn to_parent(&self) -> DAffine3 {
        if let Some(matrix) = &self.matrix {
            return DAffine3::from_mat4(DMat4::from_cols_array(matrix));
        }
        DAffine3::from_scale_rotation_translation(
            self.scale.unwrap_or(DVec3::ONE),
            self.rotation.map_or(DQuat::IDENTITY, |rotation| DQuat::from_array(rotation).normalize()),
            self.translation.unwrap_or(DVec3::ZERO),
        )
    }
}

/// The bytes of all buffers.
fn buffers(document: &Document, binary: Option<&[u8]>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let read = |(index, buffer): (usize, &Buffer)| {
        let bytes = match &buffer.uri {
            None => binary.map(<[u8]>::to_vec).ok_or_else(|| "expected a uri, or a binary chunk".to_owned()),
            Some(uri) => read_uri(uri, path),
        };
        let whole = bytes.and_then(|bytes| match bytes.len() >= buffer.byte_length {
            true => Ok(bytes),
            false => Err(format!("expected {} bytes, found {}: it is not complete", buffer.byte_length, bytes.len())),
        });
        whole.map_err(|reason| format!("buffer {index}: {reason}"))
    };
    document.buffers.iter().enumerate().map(read).collect()
}

/// The bytes that stand in the uri itself, or in a file beside this one.
fn read_uri(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("expected ;base64, in its data")?;
        return BASE64.decode(text).map_err(|error| format!("expected base64: {error}"));
    }
    if uri.contains(':') {
        return Err(format!("expected the path of a file, relative to this one, found {}", quote(uri.as_bytes())));
    }
    let beside = path.parent().unwrap_or(Path::new("")).join(unescape(uri));
    super::read(&beside).map_err(|reason| format!("{}: {reason}", beside.display()))
}

/// A path of a uri: %20 is a space.
fn unescape(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        let code = code.and_then(|code| u8::from_str_radix(code, 16).ok());
        (rest, _) = match (first, code) {
            (b'%', Some(byte)) => (after.get(2..).unwrap_or_default(), bytes.push(byte)),
            _ => (after, bytes.push(first)),
        };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

struct File {
    document: Document,
    buffers: Vec<Vec<u8>>,
}

impl File {
    /// Adds the meshes of the default scene, or of the first.
    fn add_scene(&self, draft: &mut Draft) -> Result<(), String> {
        let scene = self.document.scene.unwrap_or(0);
        let scene = self.document.scenes.get(scene).ok_or_else(|| format!("expected a scene {scene} in it"))?;
        // Every node once: a hostile file may make its nodes each other's children.
        let mut seen = HashSet::new();
        // Taken from the end: the first one is the last.
        let mut nodes: Vec<(usize, DAffine3)> = scene.nodes.iter().rev().map(|&n| (n, DAffine3::IDENTITY)).collect();
        while let Some((index, parent)) = nodes.pop() {
            if !seen.insert(index) {
                return Err(format!("node {index} occurs twice: expected a tree of nodes"));
            }
            let node = self.document.nodes.get(index).ok_or_else(|| format!("there is no node {index}"))?;
            let to_scene = parent * node.to_parent();
            if let Some(index) = node.mesh {
                let mesh = self.document.meshes.get(index).ok_or_else(|| format!("there is no mesh {index}"))?;
                for (at, primitive) in mesh.primitives.iter().enumerate() {
                    self.add(primitive, &to_scene, draft)
                        .map_err(|reason| format!("mesh {index}, primitive {at} (counted from 0): {reason}"))?;
                }
            }
            nodes.extend(node.children.iter().rev().map(|&child| (child, to_scene)));
        }
        Ok(())
    }

    /// Adds a primitive's triangles; points and lines have none.
    fn add(&self, primitive: &Primitive, to_scene: &DAffine3, draft: &mut Draft) -> Result<(), String> {
        if ![TRIANGLES, STRIP, FAN].contains(&primitive.mode) {
            return Ok(());
        }
        let attribute = |name: &str| primitive.attributes.get(name).map(|&index| self.accessor(index)).transpose();
        let positions = attribute("POSITION")?.ok_or("expected an attribute POSITION")?;
        let count = positions.count;
        // Of other attributes, only whole ones.
        let whole = |name: &str| Ok::<_, String>(attribute(name)?.filter(|accessor| accessor.count == count));
        let (normals, uvs) = (whole("NORMAL")?, whole("TEXCOORD_0")?);

        let first = draft.positions.len();
        for position in self.elements::<3>(positions)? {
            draft.vertex(to_scene.transform_point3(DVec3::from_array(position)))?;
        }
        // Normals go with the inverse transpose; the cofactors are a multiple of it, and exist for flat matrices too.
        let m = to_scene.matrix3;
        let sign = m.determinant().signum();
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis) * sign,
            m.z_axis.cross(m.x_axis) * sign,
            m.x_axis.cross(m.y_axis) * sign,
        );
        if normals.is_some() || !draft.normals.is_empty() {
            draft.normals.resize(first, Vec3::NAN);
            if let Some(normals) = normals {
                let turned = |normal| (cofactors * DVec3::from_array(normal)).normalize().as_vec3();
                draft.normals.extend(self.elements::<3>(normals)?.map(turned));
            }
            draft.normals.resize(first + count, Vec3::NAN);
        }
        if uvs.is_some() || !draft.uvs.is_empty() {
            draft.uvs.resize(first, Vec2::NAN);
            if let Some(uvs) = uvs {
                // Its v runs down from the top.
                draft.uvs.extend(self.elements::<2>(uvs)?.map(|[u, v]| Vec2::new(u as f32, (1.0 - v) as f32)));
            }
            draft.uvs.resize(first + count, Vec2::NAN);
        }

        let corners: Box<dyn Iterator<Item = u64>> = match primitive.indices {
            Some(indices) => {
                let indices = self.accessor(indices)?;
                if ![U8, U16, U32].contains(&indices.component_type) {
                    return Err("expected indices of componentType 5121, 5123 or 5125".to_owned());
                }
                Box::new(self.elements::<1>(indices)?.map(|[index]| index as u64))
            }
            None => Box::new(0..count as u64),
        };
        let corners = corners.map(|index| match index < count as u64 {
            true => Ok(first as u32 + index as u32),
            false => Err(format!(
                "face {} (counted from 0) or a later one: there is no vertex {index}, for the primitive has {count}, \
                 counted from 0",
                draft.next_face()
            )),
        });
        let corners: Vec<u32> = corners.collect::<Result<_, String>>()?;
        let mut face = |a: u32, b: u32, c: u32| draft.face(&if sign < 0.0 { [a, c, b] } else { [a, b, c] });
        match primitive.mode {
            STRIP => {
                for (at, corners) in corners.windows(3).enumerate() {
                    match *corners {
                        [a, b, c] if at % 2 == 0 => face(a, b, c)?,
                        [a, b, c] => face(b, a, c)?,
                        _ => {}
                    }
                }
            }
            FAN => {
                for pair in corners.get(1..).unwrap_or_default().windows(2) {
                    if let (Some(&a), &[b, c]) = (corners.first(), pair) {
                        face(a, b, c)?;
                    }
                }
            }
            _ => {
                for corners in corners.chunks_exact(3) {
                    if let &[a, b, c] = corners {
                        face(a, b, c)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        self.document.accessors.get(index).ok_or_else(|| format!("there is no accessor {index}"))
    }

    /// The elements of an accessor, each of N numbers.
    fn elements<'a, const N: usize>(
        &'a self,
        accessor: &'a Accessor,
    ) -> Result<impl Iterator<Item = [f64; N]> + use<'a, N>, String> {
        let shape = ["SCALAR", "VEC2", "VEC3"].get(N - 1).copied().unwrap_or_default();
        if accessor.shape != shape {
            return Err(format!("expected an accessor of type {shape}, found {}", quote(accessor.shape.as_bytes())));
        }
        if accessor.sparse.is_some() {
            return Err("an accessor is sparse, which is not supported: export it dense".to_owned());
        }
        let view = accessor.buffer_view.and_then(|view| self.document.buffer_views.get(view));
        let view = view.ok_or("an accessor has no bufferView")?;
        let kind = accessor.component_type;
        let bytes = match kind {
            I8 | U8 => 1,
            I16 | U16 => 2,
            U32 | F32 => 4,
            _ => return Err(format!("expected a componentType from 5120 to 5126, found {kind}")),
        };
        let stride = view.byte_stride.unwrap_or(N * bytes);
        if stride < N * bytes {
            return Err(format!("a bufferView has a byteStride of {stride}: elements of {} bytes overlap", N * bytes));
        }
        let part = |bytes: &'a [u8], from: usize, length: usize| bytes.get(from..from.checked_add(length)?);
        let data = || {
            let length = match accessor.count.checked_sub(1) {
                Some(before_last) => stride.checked_mul(before_last)?.checked_add(N * bytes)?,
                None => 0,
            };
            let view = part(self.buffers.get(view.buffer)?, view.byte_offset, view.byte_length)?;
            part(view, accessor.byte_offset, length)
        };
        let data = data().ok_or("an accessor reaches past the end of its buffer")?;
        let is_normalized = accessor.normalized;
        Ok(data.chunks(stride).map(move |element| {
            std::array::from_fn(|at| {
                let value = element.get(at * bytes..).and_then(|bytes| scalar(bytes, kind, is_normalized));
                value.unwrap_or(f64::NAN)
            })
        }))
    }
}

/// Values of componentType.
const I8: u32 = 5120;
const U8: u32 = 5121;
const I16: u32 = 5122;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// One number; normalised integers stand for 0 to 1, or -1 to 1.
fn scalar(bytes: &[u8], kind: u32, is_normalized: bool) -> Option<f64> {
    let (value, one) = match kind {
        I8 => (f64::from(i8::from_le_bytes(*bytes.first_chunk()?)), f64::from(i8::MAX)),
        U8 => (f64::from(u8::from_le_bytes(*bytes.first_chunk()?)), f64::from(u8::MAX)),
        I16 => (f64::from(i16::from_le_bytes(*bytes.first_chunk()?)), f64::from(i16::MAX)),
        U16 => (f64::from(u16::from_le_bytes(*bytes.first_chunk()?)), f64::from(u16::MAX)),
        U32 => (f64::from(u32::from_le_bytes(*bytes.first_chunk()?)), f64::from(u32::MAX)),
        F32 => return Some(f64::from(f32::from_le_bytes(*bytes.first_chunk()?))),
        _ => return None,
    };
    Some(if is_normalized { (value / one).max(-1.0) } else { value })
}
