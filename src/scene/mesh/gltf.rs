//! glTF 2.0, as JSON and as GLB: the triangles of the default scene, with its nodes' transforms applied in f64.
//!
//! The crate `gltf` reads and validates the JSON. Its readers of accessors trust offsets and counts; those here do not.

use std::collections::HashSet;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};

use super::draft::Draft;
use super::input::{Input, quote};

pub fn parse(path: &Path, input: &mut Input) -> Result<Draft, String> {
    let bytes = input.take(input.rest().len()).unwrap_or_default();
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(explain)?;
    let scene = document.default_scene().or_else(|| document.scenes().next()).ok_or("expected a scene in it")?;
    let file = File { buffers: buffers(&document, blob, path)? };
    let mut draft = Draft::default();
    // Every node once: a hostile file may make its nodes each other's children.
    let mut seen = HashSet::new();
    let mut nodes: Vec<(Node, DAffine3)> = scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect();
    // Taken from the end: the first one is the last.
    nodes.reverse();
    while let Some((node, parent)) = nodes.pop() {
        if !seen.insert(node.index()) {
            return Err(format!("node {} occurs twice: expected a tree of nodes", node.index()));
        }
        let to_scene = parent * local(&node);
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                file.add(&primitive, &to_scene, &mut draft).map_err(|reason| {
                    format!("mesh {}, primitive {} (counted from 0): {reason}", mesh.index(), primitive.index())
                })?;
            }
        }
        let first_child = nodes.len();
        nodes.extend(node.children().map(|child| (child, to_scene)));
        if let Some(children) = nodes.get_mut(first_child..) {
            children.reverse();
        }
    }
    Ok(draft)
}

fn explain(error: gltf::Error) -> String {
    let reason = match &error {
        gltf::Error::Validation(faults) => match faults.first() {
            Some((path, fault)) => format!("{}: {fault}", path.as_str()),
            None => error.to_string(),
        },
        error => error.to_string(),
    };
    format!("expected a glTF 2.0 file: {reason}")
}

/// A node's own transform.
fn local(node: &Node) -> DAffine3 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))))
        }
        Transform::Decomposed { translation, rotation, scale } => DAffine3::from_scale_rotation_translation(
            DVec3::from_array(scale.map(f64::from)),
            DQuat::from_array(rotation.map(f64::from)).normalize(),
            DVec3::from_array(translation.map(f64::from)),
        ),
    }
}

/// The bytes of all buffers.
fn buffers(document: &Document, mut blob: Option<Vec<u8>>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let read = |buffer: gltf::Buffer| {
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| "expected a binary chunk, or a uri".to_owned()),
            Source::Uri(uri) => read_uri(uri, path),
        };
        let whole = bytes.and_then(|bytes| match bytes.len() >= buffer.length() {
            true => Ok(bytes),
            false => Err(format!("expected {} bytes, found {}: it is not complete", buffer.length(), bytes.len())),
        });
        whole.map_err(|reason| format!("buffer {}: {reason}", buffer.index()))
    };
    document.buffers().map(read).collect()
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
    buffers: Vec<Vec<u8>>,
}

impl File {
    /// Adds a primitive's triangles; points and lines have none.
    fn add(&self, primitive: &Primitive, to_scene: &DAffine3, draft: &mut Draft) -> Result<(), String> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let floats = |semantic: Semantic, dimensions| match primitive.get(&semantic) {
            Some(accessor) if accessor.dimensions() == dimensions => Ok(Some(accessor)),
            Some(_) => Err(format!("expected {semantic:?} to be {dimensions:?}")),
            None => Ok(None),
        };
        let positions = floats(Semantic::Positions, Dimensions::Vec3)?.ok_or("expected an attribute POSITION")?;
        let normals = floats(Semantic::Normals, Dimensions::Vec3)?;
        let uvs = floats(Semantic::TexCoords(0), Dimensions::Vec2)?;

        let first = draft.positions.len();
        let count = positions.count();
        for position in self.elements::<3>(&positions)? {
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
        let missing = |accessor: &Option<Accessor>| accessor.as_ref().is_none_or(|accessor| accessor.count() != count);
        if !missing(&normals) || !draft.normals.is_empty() {
            draft.normals.resize(first, Vec3::NAN);
            if let Some(normals) = normals.filter(|normals| normals.count() == count) {
                let turned = |normal| (cofactors * DVec3::from_array(normal)).normalize().as_vec3();
                draft.normals.extend(self.elements::<3>(&normals)?.map(turned));
            }
            draft.normals.resize(first + count, Vec3::NAN);
        }
        if !missing(&uvs) || !draft.uvs.is_empty() {
            draft.uvs.resize(first, Vec2::NAN);
            if let Some(uvs) = uvs.filter(|uvs| uvs.count() == count) {
                // Its v runs down from the top.
                draft.uvs.extend(self.elements::<2>(&uvs)?.map(|[u, v]| Vec2::new(u as f32, (1.0 - v) as f32)));
            }
            draft.uvs.resize(first + count, Vec2::NAN);
        }

        let corners: Box<dyn Iterator<Item = u64>> = match primitive.indices() {
            Some(indices) if indices.dimensions() == Dimensions::Scalar => {
                Box::new(self.elements::<1>(&indices)?.map(|[index]| index as u64))
            }
            Some(_) => return Err("expected indices that are scalars".to_owned()),
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
        match mode {
            Mode::TriangleStrip => {
                for (at, corners) in corners.windows(3).enumerate() {
                    match *corners {
                        [a, b, c] if at % 2 == 0 => face(a, b, c)?,
                        [a, b, c] => face(b, a, c)?,
                        _ => {}
                    }
                }
            }
            Mode::TriangleFan => {
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

    /// The elements of an accessor, each of N numbers.
    fn elements<'a, const N: usize>(
        &'a self,
        accessor: &Accessor,
    ) -> Result<impl Iterator<Item = [f64; N]> + use<'a, N>, String> {
        let wrong = |reason: &str| format!("accessor {}: {reason}", accessor.index());
        if accessor.sparse().is_some() {
            return Err(wrong("it is sparse, which is not supported: export it dense"));
        }
        let view = accessor.view().ok_or_else(|| wrong("expected a bufferView"))?;
        let kind = accessor.data_type();
        let bytes = match kind {
            DataType::I8 | DataType::U8 => 1,
            DataType::I16 | DataType::U16 => 2,
            DataType::U32 | DataType::F32 => 4,
        };
        let stride = view.stride().unwrap_or(N * bytes);
        if stride < N * bytes {
            return Err(wrong("its elements overlap"));
        }
        let count = accessor.count();
        let data = || {
            let buffer = self.buffers.get(view.buffer().index())?;
            let view = buffer.get(view.offset()..view.offset().checked_add(view.length())?)?;
            let length = match count.checked_sub(1) {
                Some(before_last) => stride.checked_mul(before_last)?.checked_add(N * bytes)?,
                None => 0,
            };
            view.get(accessor.offset()..accessor.offset().checked_add(length)?)
        };
        let data = data().ok_or_else(|| wrong("it reaches past the end of its buffer"))?;
        let is_normalized = accessor.normalized();
        Ok(data.chunks(stride).map(move |element| {
            std::array::from_fn(|at| {
                let value = element.get(at * bytes..).and_then(|bytes| scalar(bytes, kind, is_normalized));
                value.unwrap_or(f64::NAN)
            })
        }))
    }
}

/// One number; normalised integers stand for 0 to 1, or -1 to 1.
fn scalar(bytes: &[u8], kind: DataType, is_normalized: bool) -> Option<f64> {
    let (value, one) = match kind {
        DataType::I8 => (f64::from(i8::from_le_bytes(*bytes.first_chunk()?)), f64::from(i8::MAX)),
        DataType::U8 => (f64::from(u8::from_le_bytes(*bytes.first_chunk()?)), f64::from(u8::MAX)),
        DataType::I16 => (f64::from(i16::from_le_bytes(*bytes.first_chunk()?)), f64::from(i16::MAX)),
        DataType::U16 => (f64::from(u16::from_le_bytes(*bytes.first_chunk()?)), f64::from(u16::MAX)),
        DataType::U32 => (f64::from(u32::from_le_bytes(*bytes.first_chunk()?)), f64::from(u32::MAX)),
        DataType::F32 => return Some(f64::from(f32::from_le_bytes(*bytes.first_chunk()?))),
    };
    Some(if is_normalized { (value / one).max(-1.0) } else { value })
}
