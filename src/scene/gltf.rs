//! glTF 2.0, as JSON and as GLB, with the crate `gltf`: what a file has becomes the objects, materials and cameras of the scene file.
//!
//! The crate's own validation is skipped, because it panics. Every index is looked up where it is used. `accessors` checks the span of
//! an accessor against its buffer before the crate's iterators see it, because they trust offsets and counts.

mod accessors;
mod animation;
mod camera;
mod channels;
mod contents;
mod deformation;
mod error;
mod generator;
mod geometry;
mod instances;
mod interpolate;
mod light;
mod lobes;
mod material;
mod nodes;
mod packed;

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use gltf::json::Root;
use gltf::{Document, binary};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Value, json};

use super::file::{self, OnProgress};
use super::gltf_path::unescape;
use crate::guard::guarded;

use crate::printable::quote;
pub use camera::framing;
use channels::Animation;
pub use contents::{Contents, OBJECT, OPTIONS, Reading, bounds};
pub use error::{GltfError, Result};
pub use light::sun;
pub use material::{default_material, radiance};
use nodes::Pose;
pub use nodes::similarity;
pub use packed::MESHOPT;
use packed::{Bytes, view_of};

/// The longest JSON, in bytes. A file with more has its buffers in base64, and a copy of them in memory.
const LONGEST_JSON: usize = 1 << 28;
/// The most objects in the JSON. An object of three bytes becomes a struct of hundreds.
const MOST_OBJECTS: usize = 1 << 20;
/// The most materials. One of three bytes becomes a struct of 1.1 KiB.
const MOST_MATERIALS: usize = 1 << 17;
/// The most values in the JSON. Those of unknown extensions, such as a number of one byte, become 72 bytes each.
const MOST_VALUES: usize = 1 << 24;

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

/// A glTF file with its buffers.
pub struct File {
    path: PathBuf,
    document: Document,
    /// Each is at least as long as the document says.
    buffers: Vec<Bytes>,
    rest: Arc<Pose>,
    /// The pose that was requested last: the parts of a scene are read one by one, in one pose.
    last: Mutex<Option<Arc<Pose>>>,
    /// An error in them counts only where a pose is requested.
    animations: Result<Vec<Animation>>,
}

impl File {
    fn open(path: &Path, progress: &mut OnProgress) -> Result<File> {
        let bytes = file::read(path, "glTF file", file::LONGEST)?;
        if bytes.is_empty() {
            return Err("the file is empty: expected a glTF file".to_owned().into());
        }
        let length = bytes.len() as u64;
        progress(path, 0, length);
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
        let mut root = guarded(|| parse(&json))??;
        check(&root)?;
        let animations = if root.animations.is_empty() { Ok(Vec::new()) } else { channels::animations(&json) };
        drop(json);
        drop(bytes);
        let room = file::LONGEST.saturating_sub(length);
        let mut buffers = buffers(&root, binary, path, room)?;
        guarded(|| packed::unpack(&mut root, &mut buffers))??;
        progress(path, length, length);
        let rest = Arc::new(Pose::rest(&root)?);
        let document = Document::from_json_without_validation(root);
        Ok(File { path: path.to_owned(), document, buffers, rest, last: Mutex::new(None), animations })
    }

    fn root(&self) -> &Root {
        self.document.as_json()
    }

    /// The bytes of an image that lies in the file.
    pub fn image(&self, index: usize) -> Result<Cow<'_, [u8]>> {
        let at = format!("images[{index}]");
        let wrong = |reason: String| GltfError::new(&at, reason);
        let image = self
            .root()
            .images
            .get(index)
            .ok_or_else(|| GltfError::new("images", format!("there is no image {index}")))?;
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => read_uri(uri, &self.path, "image", file::LONGEST).map(Cow::Owned).map_err(wrong),
            (None, Some(view)) => view_of(self.root(), &self.buffers, view).map(Cow::Borrowed).map_err(wrong),
            (None, None) => Err(wrong("expected a uri or a bufferView".to_owned())),
        }
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
    let (mut objects, mut values) = (0, 0);
    for byte in json {
        objects += usize::from(*byte == b'{');
        values += usize::from(matches!(byte, b'{' | b'[' | b','));
    }
    // Broken JSON is reported where it is parsed.
    let materials = serde_json::from_slice::<Counted>(json).map_or(0, |counted| counted.materials.len());
    let limits =
        [("objects", objects, MOST_OBJECTS), ("values", values, MOST_VALUES), ("materials", materials, MOST_MATERIALS)];
    match limits.into_iter().find(|(_, found, most)| found > most) {
        Some((what, found, most)) => Err(format!("expected at most {most} {what} in its JSON, found {found}")),
        None => Ok(()),
    }
}

/// Lists whose elements are counted before they become structs. It takes no memory.
#[derive(Deserialize)]
struct Counted {
    #[serde(default)]
    materials: Vec<IgnoredAny>,
}

/// The structs of the JSON. If they refuse it, properties that the standard leaves open and the crate does not are first brought into its form.
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
    // A name that occurs twice, which refuses the structs, also kept the list from being counted.
    if root.get("materials").and_then(Value::as_array).is_some_and(|list| list.len() > MOST_MATERIALS) {
        return None;
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
        GltfError::new(if at == "." { String::new() } else { at }, wrong(error.into_inner()))
    })?;
    deserializer.end().map_err(wrong)?;
    Ok(root)
}

fn check_version(version: &str) -> Result<()> {
    match version.starts_with("2.") {
        true => Ok(()),
        false => {
            let found = quote(version);
            Err(GltfError::new("asset.version", format!("expected glTF of version 2.0, found {found}")))
        }
    }
}

/// Whether an extension is read, or named with the materials that have it.
fn is_read(extension: &str) -> bool {
    const READ: [&str; 6] = [
        "KHR_lights_punctual",
        "KHR_mesh_quantization",
        "EXT_mesh_gpu_instancing",
        packed::DRACO,
        MESHOPT[0],
        MESHOPT[1],
    ];
    const BY_MATERIAL: [&str; 4] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "GPU_RT_materials_"];
    let is_of_material = BY_MATERIAL.iter().any(|start| extension.starts_with(start));
    READ.contains(&extension) || is_of_material && extension != "KHR_materials_variants"
}

fn check(root: &Root) -> Result<()> {
    /// Extensions that are not read and can be ignored.
    const HARMLESS: [&str; 2] = ["KHR_materials_variants", "KHR_lights_"];
    check_version(&root.asset.version)?;
    let is_harmless = |name: &String| is_read(name) || HARMLESS.iter().any(|start| name.starts_with(start));
    match root.extensions_required.iter().enumerate().find(|(_, name)| !is_harmless(name)) {
        Some((at, name)) => Err(GltfError::new(
            format!("extensionsRequired[{at}]"),
            format!("it requires the extension {}, which is not supported: export it without", quote(name)),
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
        let wrong = |reason: String| GltfError::new(format!("buffers[{index}]"), reason);
        let uri = buffer.uri.as_deref();
        let bytes = match (read.get(&uri), uri) {
            _ if packed::is_fallback(buffer) => {
                all.push(Bytes::default());
                continue;
            }
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
    let file = path.parent().unwrap_or(Path::new("")).join(path_of_uri(uri)?);
    file::read(&file, what, room).map_err(|reason| format!("{}: {reason}", file.display()))
}

/// The path of the file that a uri names, relative to the glTF file.
fn path_of_uri(uri: &str) -> std::result::Result<String, String> {
    match uri.contains(':') {
        true => Err(format!("expected the path of a file, relative to this one, found {}", quote(uri))),
        false => Ok(unescape(uri)),
    }
}

/// The decimal number that an f32 was written as, so that 0.8 stays 0.8 in f64.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_decimals() {
        assert_eq!(decimal(0.8), 0.8);
        assert_eq!(decimal(1e-20), 1e-20);
    }
}
