//! glTF 2.0, as JSON and as GLB, with the crate `gltf`: what a file has becomes the objects, materials and cameras of the scene file.
//!
//! The crate's own validation is skipped, because it panics. Every index is looked up where it is used. `accessors` checks the span of
//! an accessor against its buffer before the crate's iterators see it, because they trust offsets and counts.
//!
//! An object names a part of a glTF file as a path with a number sign: `room.glb#meshes/0/primitives/1`.

mod accessors;
mod camera;
mod contents;
mod generator;
mod geometry;
mod light;
mod material;
mod nodes;

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::DAffine3;
use gltf::json::{Index, Root, buffer};
use gltf::{Document, binary};
use serde_json::{Value, json};

use super::file;
use super::mesh::{OnProgress, quote};
use crate::guard::guarded;

pub use camera::framing;
pub use contents::{Asker, Reading, bounds};
pub use light::sun;

/// The longest JSON, in bytes. A file with more has its buffers in base64, and a copy of them in memory.
const LONGEST_JSON: usize = 1 << 28;
/// The most objects in the JSON. An object of three bytes becomes a struct of hundreds.
const MOST_OBJECTS: usize = 1 << 20;

/// What is wrong with a file, and where in its JSON: `materials[2].pbrMetallicRoughness.baseColorTexture.index`.
#[derive(Debug, PartialEq)]
pub struct Broken {
    /// Nothing where the file as a whole is wrong.
    pub at: String,
    pub reason: String,
}

pub type Result<T> = std::result::Result<T, Broken>;

impl Broken {
    pub fn new(at: impl Into<String>, reason: impl Into<String>) -> Broken {
        Broken { at: at.into(), reason: reason.into() }
    }
}

impl From<String> for Broken {
    fn from(reason: String) -> Broken {
        Broken { at: String::new(), reason }
    }
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.at.is_empty() {
            true => f.write_str(&self.reason),
            false => write!(f, "{}: {}", self.at, self.reason),
        }
    }
}

/// Whether the ending of a path says glTF.
pub fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ["gltf", "glb"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// A part of a glTF file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A primitive of a mesh, in the mesh's own space.
    OfMesh {
        mesh: usize,
        primitive: usize,
    },
    /// A primitive of the mesh of a node, with the transforms of the node and of those around it.
    OfNode {
        node: usize,
        primitive: usize,
    },
    Image(usize),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Part::OfMesh { mesh, primitive } => write!(f, "meshes/{mesh}/primitives/{primitive}"),
            Part::OfNode { node, primitive } => write!(f, "nodes/{node}/primitives/{primitive}"),
            Part::Image(image) => write!(f, "images/{image}"),
        }
    }
}

impl Part {
    /// Its place in the JSON.
    pub fn to_json(self) -> String {
        match self {
            Part::OfMesh { mesh, primitive } => format!("meshes[{mesh}].primitives[{primitive}]"),
            Part::OfNode { node, .. } => format!("nodes[{node}]"),
            Part::Image(image) => format!("images[{image}]"),
        }
    }
}

/// The file that a path names, and the part of it behind the number sign.
pub fn split(path: &Path) -> (Cow<'_, Path>, Option<Part>) {
    let whole = (Cow::Borrowed(path), None);
    let Some((file, part)) = path.to_str().and_then(|text| text.rsplit_once('#')) else { return whole };
    let words: Vec<&str> = part.split('/').collect();
    let part = match *words {
        ["meshes", mesh, "primitives", primitive] => {
            mesh.parse().ok().zip(primitive.parse().ok()).map(|(mesh, primitive)| Part::OfMesh { mesh, primitive })
        }
        ["nodes", node, "primitives", primitive] => {
            node.parse().ok().zip(primitive.parse().ok()).map(|(node, primitive)| Part::OfNode { node, primitive })
        }
        ["images", image] => image.parse().ok().map(Part::Image),
        _ => None,
    };
    match part.filter(|_| is_gltf(Path::new(file))) {
        Some(part) => (Cow::Owned(PathBuf::from(file)), Some(part)),
        None => whole,
    }
}

/// The files that are open while a scene is read, so that each is read once, however many of its parts the scene names.
#[derive(Default)]
pub struct Files(HashMap<PathBuf, Arc<File>>);

impl Files {
    pub fn open(&mut self, path: &Path, progress: &mut OnProgress) -> Result<Arc<File>> {
        if let Some(file) = self.0.get(path) {
            return Ok(Arc::clone(file));
        }
        let file = Arc::new(File::open(path, progress)?);
        self.0.insert(path.to_owned(), Arc::clone(&file));
        Ok(file)
    }
}

/// The bytes of a buffer. Buffers may share them.
type Bytes = Arc<Vec<u8>>;

/// A glTF file with its buffers.
pub struct File {
    path: PathBuf,
    document: Document,
    /// Each is at least as long as the document says.
    buffers: Vec<Bytes>,
    /// The numbers and transforms of the nodes of the default scene.
    nodes: Vec<(usize, DAffine3)>,
}

impl File {
    fn open(path: &Path, progress: &mut OnProgress) -> Result<File> {
        let bytes = file::read(path, "glTF file", file::LONGEST)?;
        if bytes.is_empty() {
            return Err("the file is empty: expected a glTF file".to_owned().into());
        }
        let whole = bytes.len() as u64;
        progress(path, 0, whole);
        let incomplete = "expected a GLB file of version 2: it is not complete";
        let (json, binary) = match bytes.starts_with(b"glTF") {
            true => {
                let glb = guarded(|| binary::Glb::from_slice(&bytes))?.map_err(|error| match error {
                    gltf::Error::Binary(
                        binary::Error::Io(_) | binary::Error::Length { .. } | binary::Error::ChunkLength { .. },
                    ) => incomplete.to_owned(),
                    gltf::Error::Binary(error) => format!("expected a GLB file of version 2: {error}"),
                    error => error.to_string(),
                })?;
                (glb.json, glb.bin.map(Cow::into_owned))
            }
            false => (Cow::Borrowed(bytes.as_slice()), None),
        };
        check_json(&json)?;
        let root = guarded(|| parse(&json))??;
        check(&root)?;
        drop(json);
        drop(bytes);
        let room = file::LONGEST.saturating_sub(whole);
        let buffers = buffers(&root, binary, path, room)?;
        progress(path, whole, whole);
        let nodes = nodes::nodes(&root)?;
        let document = Document::from_json_without_validation(root);
        Ok(File { path: path.to_owned(), document, buffers, nodes })
    }

    fn root(&self) -> &Root {
        self.document.as_json()
    }

    /// The bytes of an image that lies in the file.
    pub fn image(&self, index: usize) -> Result<Cow<'_, [u8]>> {
        let at = format!("images[{index}]");
        let wrong = |reason: String| Broken::new(&at, reason);
        let image =
            self.root().images.get(index).ok_or_else(|| Broken::new("images", format!("there is no image {index}")))?;
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => read_uri(uri, &self.path, "image", file::LONGEST).map(Cow::Owned).map_err(wrong),
            (None, Some(view)) => self.bytes_of(view).map(Cow::Borrowed).map_err(wrong),
            (None, None) => Err(wrong("expected a uri or a bufferView".to_owned())),
        }
    }

    /// The bytes of a view of a buffer.
    fn bytes_of(&self, index: Index<buffer::View>) -> std::result::Result<&[u8], String> {
        let number = index.value();
        let view = self.root().get(index).ok_or_else(|| format!("there is no bufferView {number}"))?;
        let buffer = self.buffers.get(view.buffer.value());
        let start = view.byte_offset.unwrap_or_default().0;
        let bytes = start.checked_add(view.byte_length.0).and_then(|end| {
            let range = usize::try_from(start).ok()?..usize::try_from(end).ok()?;
            buffer?.get(range)
        });
        bytes.ok_or_else(|| format!("bufferView {number} reaches past the end of its buffer"))
    }
}

/// Checks the size of the JSON before it becomes structs.
fn check_json(json: &[u8]) -> std::result::Result<(), String> {
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

/// The structs of the JSON. What the standard leaves out or open, and the crate's structs do not, is brought into their form if they refuse it.
fn parse(json: &[u8]) -> Result<Root> {
    /// A tree of longer JSON would need much memory.
    const LONGEST: usize = 1 << 22;
    let broken = match parse_strictly(json) {
        Ok(root) => return Ok(root),
        Err(broken) => broken,
    };
    let Some(tree) = (json.len() <= LONGEST).then(|| serde_json::from_slice::<Value>(json).ok()).flatten() else {
        return Err(broken);
    };
    // Files of version 1 have maps where those of version 2 have lists.
    tree.pointer("/asset/version").and_then(Value::as_str).map_or(Ok(()), check_version)?;
    without_options(tree).ok_or(broken)
}

/// The structs of JSON without its extras, which may be anything; of scenes without nodes; and of animations without their contents, whose
/// targets need not be nodes. Nothing where that does not help.
fn without_options(mut root: Value) -> Option<Root> {
    fn drop_extras(value: &mut Value) {
        match value {
            Value::Array(list) => list.iter_mut().for_each(drop_extras),
            Value::Object(members) => {
                members.remove("extras");
                members.values_mut().for_each(drop_extras);
            }
            _ => {}
        }
    }
    drop_extras(&mut root);
    for scene in root.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    if let Some(animations) = root.get_mut("animations").and_then(Value::as_array_mut) {
        animations.fill(json!({"channels": [], "samplers": []}));
    }
    serde_json::from_value(root).ok()
}

fn parse_strictly(json: &[u8]) -> Result<Root> {
    let wrong = |error: serde_json::Error| format!("expected the JSON of a glTF 2.0 file: {error}");
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let root = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let at = error.path().to_string();
        Broken::new(if at == "." { String::new() } else { at }, wrong(error.into_inner()))
    })?;
    deserializer.end().map_err(wrong)?;
    Ok(root)
}

fn check_version(version: &str) -> Result<()> {
    match version.starts_with("2.") {
        true => Ok(()),
        false => {
            let found = quote(version.as_bytes());
            Err(Broken::new("asset.version", format!("expected glTF of version 2.0, found {found}")))
        }
    }
}

fn check(root: &Root) -> Result<()> {
    /// Extensions that can be ignored, and one (quantization) that `accessors` supports.
    const HARMLESS: [&str; 5] =
        ["KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "KHR_mesh_quantization"];
    check_version(&root.asset.version)?;
    let is_harmless = |name: &String| HARMLESS.iter().any(|start| name.starts_with(start));
    match root.extensions_required.iter().enumerate().find(|(_, name)| !is_harmless(name)) {
        Some((at, name)) => Err(Broken::new(
            format!("extensionsRequired[{at}]"),
            format!("it requires the extension {}, which is not supported: export it without", quote(name.as_bytes())),
        )),
        None => Ok(()),
    }
}

/// The bytes of all buffers. Any number of buffers may refer to the binary chunk, or to one file, which is read once. `room` is the
/// number of bytes that all of them may have.
fn buffers(root: &Root, mut binary: Option<Vec<u8>>, path: &Path, mut room: u64) -> Result<Vec<Bytes>> {
    let mut read: HashMap<Option<&str>, Bytes> = HashMap::new();
    let mut all = Vec::new();
    for (index, buffer) in root.buffers.iter().enumerate() {
        let wrong = |reason: String| Broken::new(format!("buffers[{index}]"), reason);
        let uri = buffer.uri.as_deref();
        let bytes = match (read.get(&uri), uri) {
            (Some(bytes), _) => Arc::clone(bytes),
            (None, uri) => {
                let bytes = match uri {
                    Some(uri) => read_uri(uri, path, "buffer", room).map_err(wrong)?,
                    None => binary.take().ok_or_else(|| wrong("expected a uri, or a binary chunk".to_owned()))?,
                };
                room = room.saturating_sub(bytes.len() as u64);
                Arc::clone(read.entry(uri).or_insert(Arc::new(bytes)))
            }
        };
        let (expected, found) = (buffer.byte_length.0, bytes.len());
        if (found as u64) < expected {
            return Err(wrong(format!("expected {expected} bytes, found {found}: it is not complete")));
        }
        all.push(bytes);
    }
    Ok(all)
}

/// The bytes of a uri: its own data, or those of a file relative to this one with at most `room` bytes. `what` names it in errors.
fn read_uri(uri: &str, path: &Path, what: &str, room: u64) -> std::result::Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("expected ;base64, in its data")?;
        return BASE64.decode(text).map_err(|error| format!("expected base64: {error}"));
    }
    let beside = path.parent().unwrap_or(Path::new("")).join(beside(uri)?);
    file::read(&beside, what, room).map_err(|reason| format!("{}: {reason}", beside.display()))
}

/// The path of the file that a uri names, relative to the glTF file.
fn beside(uri: &str) -> std::result::Result<String, String> {
    match uri.contains(':') {
        true => Err(format!("expected the path of a file, relative to this one, found {}", quote(uri.as_bytes()))),
        false => Ok(unescape(uri)),
    }
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

/// The decimal number that an f32 was written as, so that 0.8 stays 0.8 in f64.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_may_name_a_part_of_a_gltf_file() {
        for part in [Part::OfMesh { mesh: 3, primitive: 12 }, Part::OfNode { node: 0, primitive: 1 }, Part::Image(7)] {
            let path = format!("a #1/room.GLB#{part}");
            assert_eq!(split(Path::new(&path)), (Path::new("a #1/room.GLB").into(), Some(part)));
        }
        for path in
            ["room.glb", "room.obj#images/1", "room.glb#images/x", "a.glb#b.glb", "room.glb#images", "#images/0"]
        {
            assert_eq!(split(Path::new(path)), (Path::new(path).into(), None));
        }
    }

    #[test]
    fn numbers_keep_their_decimals() {
        assert_eq!(decimal(0.8), 0.8);
        assert_eq!(decimal(1e-20), 1e-20);
    }
}
