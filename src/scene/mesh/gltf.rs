//! glTF 2.0, as JSON and as GLB, with the crate `gltf`. Reads the triangles of the default scene, and applies its nodes' transforms
//! in f64.
//!
//! The crate's own validation is skipped, because it panics. Every index is looked up where it is used. The span of an accessor is
//! checked against its buffer before the crate's iterators see it, because they trust offsets and counts.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root, buffer};
use gltf::{Document, Gltf, binary};

use super::super::file;
use super::draft::Draft;
use super::input::{Input, quote};
use crate::guard::guarded;

/// The longest JSON, in bytes. A file with more has its buffers in base64, and a copy of them in memory.
const LONGEST_JSON: usize = 1 << 28;
/// The most objects in the JSON. An object of three bytes becomes a struct of hundreds.
const MOST_OBJECTS: usize = 1 << 20;

pub fn parse(path: &Path, input: &mut Input, draft: &mut Draft) -> Result<(), String> {
    let bytes = input.take(input.rest().len()).unwrap_or_default();
    check_json(bytes)?;
    let Gltf { document, blob } =
        guarded(|| Gltf::from_slice_without_validation(bytes))?.map_err(|error| match error {
            gltf::Error::Binary(
                binary::Error::Io(_) | binary::Error::Length { .. } | binary::Error::ChunkLength { .. },
            ) => "expected a GLB file of version 2: it is not complete".to_owned(),
            gltf::Error::Binary(error) => format!("expected a GLB file of version 2: {error}"),
            gltf::Error::Deserialize(error) => format!("expected the JSON of a glTF 2.0 file: {error}"),
            error => error.to_string(),
        })?;
    check(document.as_json())?;
    let room = file::LONGEST.saturating_sub(bytes.len() as u64);
    let file = File { buffers: buffers(document.as_json(), blob.as_deref(), path, room)?, document };
    guarded(|| file.add_scene(draft))?
}

/// Checks the size of the JSON before the crate makes structs of it.
fn check_json(bytes: &[u8]) -> Result<(), String> {
    let json = match bytes.strip_prefix(b"glTF") {
        // The JSON is the first chunk: its length stands behind the version and the length of the file.
        Some(rest) => {
            let length = rest.get(8..12).and_then(|length| length.try_into().ok()).map_or(0, u32::from_le_bytes);
            let json = rest.get(16..).unwrap_or_default();
            json.get(..length as usize).unwrap_or(json)
        }
        None => bytes,
    };
    if json.len() > LONGEST_JSON {
        return Err(format!(
            "expected at most {LONGEST_JSON} bytes of JSON, found {}: save it as .glb, or its buffers beside it",
            json.len()
        ));
    }
    let objects = json.iter().filter(|&&byte| byte == b'{').count();
    match objects > MOST_OBJECTS {
        true => Err(format!("expected at most {MOST_OBJECTS} objects in its JSON, found {objects}")),
        false => Ok(()),
    }
}

fn check(root: &Root) -> Result<(), String> {
    /// Extensions that can be ignored, and one (quantization) that `File::elements` supports.
    const HARMLESS: [&str; 5] =
        ["KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "KHR_mesh_quantization"];
    if !root.asset.version.starts_with("2.") {
        return Err(format!("expected glTF of version 2.0, found {}", quote(root.asset.version.as_bytes())));
    }
    let is_harmless = |name: &String| HARMLESS.iter().any(|start| name.starts_with(start));
    match root.extensions_required.iter().find(|name| !is_harmless(name)) {
        Some(name) => Err(format!(
            "it requires the extension {}, which is not supported: export it without",
            quote(name.as_bytes())
        )),
        None => Ok(()),
    }
}

/// A node's own transform.
fn to_parent(node: &Node) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let vector = |value: Option<[f32; 3]>, default| value.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from)).normalize(),
        vector(node.translation, DVec3::ZERO),
    )
}

/// The bytes of a buffer. Buffers may share them.
type Bytes<'a> = Rc<Cow<'a, [u8]>>;

/// The bytes of all buffers. Any number of buffers may refer to the binary chunk, or to one file, which is read once. `room` is the
/// number of bytes that all of them may have.
fn buffers<'a, 'r>(
    root: &'r Root,
    binary: Option<&'a [u8]>,
    path: &Path,
    mut room: u64,
) -> Result<Vec<Bytes<'a>>, String> {
    let mut read = HashMap::new();
    let mut bytes_of = |buffer: &'r buffer::Buffer| {
        let uri = buffer.uri.as_deref();
        let bytes = match (read.get(&uri), uri) {
            (Some(bytes), _) => return Ok(Rc::clone(bytes)),
            (None, None) => Cow::Borrowed(binary.ok_or("expected a uri, or a binary chunk")?),
            (None, Some(uri)) => Cow::Owned(read_uri(uri, path, room)?),
        };
        room = room.saturating_sub(bytes.len() as u64);
        Ok(Rc::clone(read.entry(uri).or_insert(Rc::new(bytes))))
    };
    let whole = |(index, buffer): (usize, &'r buffer::Buffer)| {
        let bytes = bytes_of(buffer).and_then(|bytes: Bytes| {
            let (expected, found) = (buffer.byte_length.0, bytes.len());
            let whole = found as u64 >= expected;
            whole
                .then_some(bytes)
                .ok_or_else(|| format!("expected {expected} bytes, found {found}: it is not complete"))
        });
        bytes.map_err(|reason: String| format!("buffer {index}: {reason}"))
    };
    root.buffers.iter().enumerate().map(whole).collect()
}

/// The bytes of a uri: its own data, or those of a file relative to this one with at most `room` bytes.
fn read_uri(uri: &str, path: &Path, room: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("expected ;base64, in its data")?;
        return BASE64.decode(text).map_err(|error| format!("expected base64: {error}"));
    }
    if uri.contains(':') {
        return Err(format!("expected the path of a file, relative to this one, found {}", quote(uri.as_bytes())));
    }
    let beside = path.parent().unwrap_or(Path::new("")).join(unescape(uri));
    file::read(&beside, "mesh", room).map_err(|reason| format!("{}: {reason}", beside.display()))
}

/// The path in a uri, with escapes such as %20 decoded.
pub fn unescape(uri: &str) -> String {
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

/// The elements of an accessor, one by one: a list of all of them would be larger than the file.
type Elements<'a, T> = Box<dyn Iterator<Item = T> + 'a>;

struct File<'a> {
    document: Document,
    /// Each is at least as long as the document says.
    buffers: Vec<Bytes<'a>>,
}

impl File<'_> {
    /// Adds the meshes of the default scene, or of the first scene if there is no default.
    fn add_scene(&self, draft: &mut Draft) -> Result<(), String> {
        let root = self.document.as_json();
        let scene = root.scene.map_or(0, |scene| scene.value());
        let scene = root.scenes.get(scene).ok_or_else(|| format!("expected a scene {scene} in it"))?;
        // Visits every node once: in a malicious file, nodes can be each other's children.
        let mut seen = HashSet::new();
        // A stack: the first node is on top.
        let mut nodes: Vec<(usize, DAffine3)> =
            scene.nodes.iter().rev().map(|node| (node.value(), DAffine3::IDENTITY)).collect();
        while let Some((index, parent)) = nodes.pop() {
            if !seen.insert(index) {
                return Err(format!("node {index} occurs twice: expected a tree of nodes"));
            }
            let node = root.nodes.get(index).ok_or_else(|| format!("there is no node {index}"))?;
            let to_scene = parent * to_parent(node);
            if let Some(index) = node.mesh.map(|mesh| mesh.value()) {
                let mesh = root.meshes.get(index).ok_or_else(|| format!("there is no mesh {index}"))?;
                for (at, primitive) in mesh.primitives.iter().enumerate() {
                    self.add(primitive, &to_scene, draft)
                        .map_err(|reason| format!("mesh {index}, primitive {at} (counted from 0): {reason}"))?;
                }
            }
            let children = node.children.iter().flatten().rev();
            nodes.extend(children.map(|child| (child.value(), to_scene)));
        }
        Ok(())
    }

    /// Adds a primitive's triangles; points and lines have none.
    fn add(&self, primitive: &Primitive, to_scene: &DAffine3, draft: &mut Draft) -> Result<(), String> {
        let Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) = primitive.mode else {
            return Ok(());
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let positions = attribute(Semantic::Positions).ok_or("expected an attribute POSITION")?;
        let count = self.accessor(positions).map_or(0, |accessor| accessor.count.0);
        let positions = self.elements::<3>(positions)?;
        // Other attributes are used only if every vertex has them.
        let whole =
            |semantic| attribute(semantic).filter(|&index| self.accessor(index).is_none_or(|it| it.count.0 == count));
        let normals = whole(Semantic::Normals).map(|index| self.elements::<3>(index)).transpose()?;
        let uvs = whole(Semantic::TexCoords(0)).map(|index| self.elements::<2>(index)).transpose()?;

        let first = draft.positions.len();
        for position in positions {
            draft.vertex(to_scene.transform_point3(DVec3::from_array(position)))?;
        }
        let end = draft.positions.len();
        // Normals transform by the inverse transpose. The cofactor matrix is a multiple of it, and exists for singular
        // matrices too.
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
                draft.normals.extend(normals.map(turned));
            }
            draft.normals.resize(end, Vec3::NAN);
        }
        if uvs.is_some() || !draft.uvs.is_empty() {
            draft.uvs.resize(first, Vec2::NAN);
            if let Some(uvs) = uvs {
                // In glTF, v runs down from the top.
                draft.uvs.extend(uvs.map(|[u, v]| Vec2::new(u as f32, (1.0 - v) as f32)));
            }
            draft.uvs.resize(end, Vec2::NAN);
        }

        let corners = match primitive.indices {
            Some(indices) => self.indices(indices)?,
            None => Box::new(0..count),
        };
        // The corners before this one that its triangle has too.
        let mut held = [0; 2];
        for (at, index) in corners.enumerate() {
            if index >= count {
                return Err(format!(
                    "face {} (counted from 0) or a later one: there is no vertex {index}; the primitive has {count}, \
                     counted from 0",
                    draft.next_face()
                ));
            }
            let c = first as u32 + index as u32;
            let [a, b] = held;
            let (corners, next) = match mode {
                Mode::TriangleStrip => (if at % 2 == 0 { [a, b, c] } else { [b, a, c] }, [b, c]),
                Mode::TriangleFan => ([a, b, c], if at == 0 { [c, c] } else { [a, c] }),
                _ => ([a, b, c], if at % 3 == 0 { [c, c] } else { [a, c] }),
            };
            let is_last = if mode == Mode::Triangles { at % 3 == 2 } else { at >= 2 };
            if is_last {
                let [a, b, c] = corners;
                draft.face(&if sign < 0.0 { [a, c, b] } else { [a, b, c] })?;
            }
            held = next;
        }
        Ok(())
    }

    fn accessor(&self, index: Index<Accessor>) -> Option<&Accessor> {
        self.document.as_json().get(index)
    }

    /// The elements of an accessor, each of N numbers.
    fn elements<const N: usize>(&self, index: Index<Accessor>) -> Result<Elements<'_, [f64; N]>, String>
    where
        [i8; N]: Item,
        [u8; N]: Item,
        [i16; N]: Item,
        [u16; N]: Item,
        [u32; N]: Item,
        [f32; N]: Item,
    {
        let shape = if N == 2 { Dimensions::Vec2 } else { Dimensions::Vec3 };
        match self.kind(index, shape)? {
            DataType::I8 => self.numbers::<i8, N>(index),
            DataType::U8 => self.numbers::<u8, N>(index),
            DataType::I16 => self.numbers::<i16, N>(index),
            DataType::U16 => self.numbers::<u16, N>(index),
            DataType::U32 => self.numbers::<u32, N>(index),
            DataType::F32 => self.numbers::<f32, N>(index),
        }
    }

    fn numbers<T: Number, const N: usize>(&self, index: Index<Accessor>) -> Result<Elements<'_, [f64; N]>, String>
    where
        [T; N]: Item,
    {
        let is_normalized = self.accessor(index).is_some_and(|accessor| accessor.normalized);
        let elements = self.read::<[T; N]>(index)?;
        Ok(Box::new(elements.map(move |element| element.map(|number| number.value(is_normalized)))))
    }

    /// The indices of vertices.
    fn indices(&self, index: Index<Accessor>) -> Result<Elements<'_, u64>, String> {
        Ok(match self.kind(index, Dimensions::Scalar)? {
            DataType::U8 => Box::new(self.read::<u8>(index)?.map(u64::from)),
            DataType::U16 => Box::new(self.read::<u16>(index)?.map(u64::from)),
            DataType::U32 => Box::new(self.read::<u32>(index)?.map(u64::from)),
            _ => return Err("expected indices of componentType 5121, 5123 or 5125".to_owned()),
        })
    }

    /// The type of an accessor's numbers, if the accessor has this shape.
    fn kind(&self, index: Index<Accessor>, shape: Dimensions) -> Result<DataType, String> {
        let at = index.value();
        let accessor = self.accessor(index).ok_or_else(|| format!("there is no accessor {at}"))?;
        let name = |shape: Dimensions| format!("{shape:?}").to_ascii_uppercase();
        match (accessor.type_, accessor.component_type) {
            (Checked::Valid(found), Checked::Valid(kind)) if found == shape => Ok(kind.0),
            (Checked::Valid(found), _) if found == shape => {
                Err(format!("accessor {at}: expected a componentType from 5120 to 5126"))
            }
            (found, _) => {
                let found = match found {
                    Checked::Valid(found) => name(found),
                    Checked::Invalid => "none that glTF has".to_owned(),
                };
                Err(format!("accessor {at}: expected an accessor of type {}, found {found}", name(shape)))
            }
        }
    }

    /// The elements of an accessor, after a check that its buffer contains all of them.
    fn read<T: Item>(&self, index: Index<Accessor>) -> Result<impl Iterator<Item = T> + use<'_, T>, String> {
        let accessor = self.accessor(index).ok_or("there is no such accessor")?;
        let size = size_of::<T>() as u64;
        // Without a view all elements are zero, and the file could claim any number of them.
        let view = accessor.buffer_view.ok_or("an accessor has no bufferView")?;
        self.check_span(view, accessor.byte_offset.unwrap_or_default().0, accessor.count.0, size)?;
        if let Some(sparse) = &accessor.sparse {
            let (indices, values) = (&sparse.indices, &sparse.values);
            let Checked::Valid(kind) = indices.component_type else {
                return Err("expected sparse indices of componentType 5121, 5123 or 5125".to_owned());
            };
            self.check_span(indices.buffer_view, indices.byte_offset.0, sparse.count.0, kind.0.size() as u64)?;
            self.check_span(values.buffer_view, values.byte_offset.0, sparse.count.0, size)?;
        }
        let accessor = self.document.accessors().nth(index.value());
        let bytes = |buffer: gltf::Buffer| self.buffers.get(buffer.index()).map(|bytes| &***bytes);
        accessor.and_then(|accessor| Iter::new(accessor, bytes)).ok_or_else(|| "an accessor cannot be read".to_owned())
    }

    /// Checks that a view contains `count` elements, and that its buffer contains the view. The format demands at least
    /// one element.
    fn check_span(&self, view: Index<buffer::View>, offset: u64, count: u64, size: u64) -> Result<(), String> {
        let view = self.document.as_json().get(view).ok_or("an accessor's bufferView is not there")?;
        let stride = match view.byte_stride {
            Some(stride) if stride.0 > 0 => stride.0 as u64,
            _ => size,
        };
        if stride < size {
            return Err(format!("a bufferView has a byteStride of {stride}: elements of {size} bytes overlap"));
        }
        let is_inside = || {
            let end = stride.checked_mul(count.checked_sub(1)?)?.checked_add(size)?.checked_add(offset)?;
            let view_end = view.byte_offset.unwrap_or_default().0.checked_add(view.byte_length.0)?;
            let buffer = self.buffers.get(view.buffer.value())?;
            (end <= view.byte_length.0 && view_end <= buffer.len() as u64).then_some(())
        };
        is_inside().ok_or_else(|| "an accessor has no elements or reaches past the end of its buffer".to_owned())
    }
}

/// A component of an element. Normalised integers represent 0 to 1, or -1 to 1.
trait Number: Item + Copy + 'static {
    fn value(self, is_normalized: bool) -> f64;
}

macro_rules! integers {
    ($($integer:ty)*) => {
        $(impl Number for $integer {
            fn value(self, is_normalized: bool) -> f64 {
                let value = f64::from(self);
                if is_normalized { (value / f64::from(<$integer>::MAX)).max(-1.0) } else { value }
            }
        })*
    };
}

integers! { i8 u8 i16 u16 u32 }

impl Number for f32 {
    fn value(self, _: bool) -> f64 {
        f64::from(self)
    }
}
