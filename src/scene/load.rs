//! Reads a scene file: text, then values, then checks, then images and meshes.

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use glam::DVec3;
use ron::extensions::Extensions;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::assets::Assets;
use super::explain::{explain, hash_at_start};
use super::file::Reading;
use super::findings::Findings;
use super::recover::{Parts, recover};
use super::types::*;
use super::{OnProgress, Scene, bitmap, mesh, validate};
use crate::error::{Error, Result};
use crate::source::{MOST_VALUES, Source};

/// The longest scene file, in bytes. A scene of two million spheres is half as long.
const LONGEST_FILE: u64 = 1 << 28;

/// The limit on ron's recursion. An object takes four calls, so that objects can be nested about 60 deep.
/// A stack of 1 MiB is enough for that, even in a build without optimisation.
const RECURSION_LIMIT: usize = 256;

/// The contents of a scene file.
#[derive(Deserialize)]
#[serde(rename = "Scene", deny_unknown_fields)]
struct SceneFile {
    image: ImageSize,
    camera: Camera,
    background: Background,
    #[serde(default, deserialize_with = "in_file_order")]
    materials: Vec<(String, Material)>,
    objects: Vec<Object>,
    #[serde(default)]
    render: RenderDefaults,
}

/// Reads the text of a scene file.
pub fn read(path: &Path) -> Result<String> {
    text_of(File::open(path).map_err(|error| cannot_read(path, &error))?, path)
}

fn cannot_read(path: &Path, error: &io::Error) -> Error {
    Source::new(String::new(), path).error(&[], format!("cannot read the scene file: {error}"))
}

/// The text of a scene file, whose name is `path`.
pub fn text_of(reader: impl Read, path: &Path) -> Result<String> {
    let mut bytes = Vec::new();
    reader.take(LONGEST_FILE + 1).read_to_end(&mut bytes).map_err(|error| cannot_read(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let (good, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let bad = rest.first().copied().unwrap_or_default();
        let good = Source::new(String::from_utf8_lossy(good).into_owned(), path);
        let message = format!("expected UTF-8 text, found the byte 0x{bad:02x}");
        good.error_at(good.text().len(), &[], message)
    })
}

/// Makes the scene that a text describes, and checks it.
/// Images and meshes that `assets` has are not read again.
pub fn parse(mut text: String, path: &Path, progress: &mut OnProgress, assets: &mut Assets) -> Result<Scene> {
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    if text.len() as u64 > LONGEST_FILE {
        let message = format!("the scene file is longer than {LONGEST_FILE} bytes");
        return Err(Source::new(String::new(), path).error(&[], message));
    }
    let source = Source::new(text, path);
    if let Some(at) = source.spans.one_too_many {
        let message = format!("expected at most {MOST_VALUES} values in a scene file: replace objects by meshes");
        return Err(source.error_at(at as usize, &[], message));
    }
    if let Some(error) = hash_at_start(&source) {
        return Err(error);
    }
    if source.spans.root().is_none() && source.spans.unclosed_comment.is_none() {
        let message = "the scene file is empty: expected Scene(image: .., camera: .., ..)";
        return Err(source.error(&[], message));
    }
    let mut findings = Findings::default();
    let file = match options().from_str::<SceneFile>(source.text()) {
        Ok(file) => file,
        Err(error) => {
            let parts = recover(&source, &mut findings);
            if findings.is_empty() {
                return Err(explain(&source, error).error);
            }
            SceneFile::of_parts(parts)
        }
    };
    let mut scene = Scene {
        image: file.image,
        camera: file.camera,
        background: file.background,
        materials: file.materials,
        objects: file.objects,
        render: file.render,
        bitmaps: Bitmaps::new(),
        meshes: BTreeMap::new(),
        source,
    };
    validate::validate(&scene, &mut findings);
    // Large files are not read for a scene that is refused, but all that are missing are named.
    let reading = if findings.is_empty() { Reading::Whole } else { Reading::IfThere };
    scene.bitmaps = bitmap::load_all(&scene, reading, &mut findings, assets);
    scene.meshes = mesh::load_all(&scene, reading, &mut findings, progress, assets);
    if findings.is_empty() && !scene.meshes.is_empty() {
        validate::with_meshes(&scene, &mut findings);
    }
    findings.end()?;
    assets.end();
    Ok(scene)
}

/// How scene files are parsed.
pub fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).with_recursion_limit(RECURSION_LIMIT)
}

impl SceneFile {
    /// What is absent is replaced by something that is valid.
    fn of_parts(parts: Parts) -> SceneFile {
        let camera = || Camera {
            look_from: DVec3::ZERO,
            look_at: DVec3::NEG_Z,
            up: DVec3::Y,
            vertical_fov: 45.0,
            aperture: 0.0,
            focus_distance: None,
        };
        SceneFile {
            image: parts.image.unwrap_or(ImageSize { width: 1, height: 1 }),
            camera: parts.camera.unwrap_or_else(camera),
            background: parts.background.unwrap_or(Background::Solid(Colour::ZERO)),
            materials: parts.materials,
            objects: parts.objects.unwrap_or_default(),
            render: parts.render,
        }
    }
}

/// Reads a map as a list in the file's order. The second occurrence of a name is an error.
pub fn in_file_order<'de, D>(deserializer: D) -> std::result::Result<Vec<(String, Material)>, D::Error>
where
    D: Deserializer<'de>,
{
    struct InFileOrder;

    impl<'de> Visitor<'de> for InFileOrder {
        type Value = Vec<(String, Material)>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map of materials")
        }

        fn visit_map<M>(self, mut map: M) -> std::result::Result<Self::Value, M::Error>
        where
            M: MapAccess<'de>,
        {
            let mut names = HashSet::new();
            let mut materials = Vec::new();
            while let Some(name) = map.next_key::<String>()? {
                if !names.insert(name.clone()) {
                    let message = format!("the material {name:?} is defined twice");
                    return Err(M::Error::custom(message));
                }
                materials.push((name, map.next_value()?));
            }
            Ok(materials)
        }
    }

    deserializer.deserialize_map(InFileOrder)
}
