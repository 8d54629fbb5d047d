//! Writes a scene as the text of a scene file.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use ron::ser::PrettyConfig;
use serde::Serialize;

use super::animation_frame::FPS;
use super::model::Scene;
use super::syntax::options;
use super::types::{Camera, Object, Thin};

impl Scene {
    /// The text of a scene file of this scene.
    pub fn text(&self) -> String {
        self::text(self).unwrap_or_default()
    }
}

impl Camera {
    /// The camera in the notation of scene files, on one line.
    pub fn text(&self) -> String {
        value(self).unwrap_or_default()
    }
}

/// The text of a scene file. Nothing can fail but what serialises nothing.
fn text(scene: &Scene) -> Result<String, ron::Error> {
    let Scene { image, camera, background, materials, objects, render, .. } = scene;
    let mut out = "Scene(\n".to_owned();
    // Writing to a string never fails.
    let mut line = |text: String| _ = writeln!(out, "    {text}");
    line(format!("image: (width: {}, height: {}),", image.width, image.height));
    line(format!("camera: {},", value(camera)?));
    line(format!("background: {},", value(background)?));
    line("materials: {".to_owned());
    for (name, material) in materials {
        line(format!("    {}: {},", value(name)?, value(material)?));
    }
    line("},".to_owned());
    line("objects: [".to_owned());
    for object in objects {
        line(format!("    {},", self::object(object)?));
    }
    line("],".to_owned());
    line(format!("render: (samples: {}, max_depth: {}),", render.samples, render.max_depth));
    out += ")\n";
    Ok(out)
}

/// An object. Its path is no part of what serde writes, because it is no part of what a scene says.
fn object(object: &Object) -> Result<String, ron::Error> {
    Ok(match object {
        Object::Mesh { path, material } => {
            let material = match material {
                Some(name) => format!(", material: {}", value(name)?),
                None => String::new(),
            };
            format!("Mesh(path: {}{material})", value(path)?)
        }
        Object::Transformed { by, object } => {
            format!("Transformed(by: {}, object: {})", value(by)?, self::object(object)?)
        }
        Object::Moving { keys, object } => {
            format!("Moving(keys: {}, object: {})", value(keys)?, self::object(object)?)
        }
        Object::Named { name, object } => format!("Named(name: {}, object: {})", value(name)?, self::object(object)?),
        Object::Group(objects) => {
            let objects: Result<Vec<_>, _> = objects.iter().map(self::object).collect();
            format!("Group([{}])", objects?.join(", "))
        }
        Object::Gltf { path, watts, thin, frame, fps, .. } => {
            let watts = watts.map_or(String::new(), |watts| format!(", watts: {watts}"));
            let thin = if *thin == Thin::Pane { ", thin: Pane" } else { "" };
            let frame = frame.map_or(String::new(), |frame| format!(", frame: {frame:?}"));
            let fps = if *fps == FPS { String::new() } else { format!(", fps: {fps:?}") };
            format!("Gltf(path: {}{watts}{thin}{frame}{fps})", value(path)?)
        }
        Object::Medium { boundary, density, albedo, anisotropy, emission } => {
            let boundary = match boundary {
                Some(boundary) => format!("boundary: {}, ", self::object(boundary)?),
                None => String::new(),
            };
            let emission = match emission {
                Some(emission) => format!(", emission: {}", value(emission)?),
                None => String::new(),
            };
            let [density, albedo, anisotropy] = [value(density)?, value(albedo)?, value(anisotropy)?];
            format!("Medium({boundary}density: {density}, albedo: {albedo}, anisotropy: {anisotropy}{emission})")
        }
        // What contains neither objects nor the path of a file is written as it is read.
        _ => value(object)?,
    })
}

/// A value on one line.
pub(super) fn value(value: &(impl Serialize + ?Sized)) -> Result<String, ron::Error> {
    let config = PrettyConfig::new().depth_limit(0).extensions(ron::extensions::Extensions::IMPLICIT_SOME);
    options().to_string_pretty(value, config)
}

/// The path of a file in the scene file `to`: as it is if the scene stays where it is and the file lies in its folder, else relative to that.
pub fn named(file: &Path, to: &Path, is_in_place: bool) -> String {
    let folder = to.parent().unwrap_or(Path::new(""));
    let beside = file.strip_prefix(folder).ok().filter(|_| is_in_place);
    beside.map_or_else(|| relative(folder, file), Path::to_owned).to_string_lossy().into_owned()
}

/// The path of a file as a scene in a folder names it.
pub fn relative(folder: &Path, file: &Path) -> PathBuf {
    let absolute = |path: &Path| std::fs::canonicalize(path).or_else(|_| std::path::absolute(path));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(folder), Ok(file)) = (absolute(folder), absolute(file)) else { return file.to_owned() };
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        // Another drive.
        return file;
    }
    let up = folder.components().skip(shared).map(|_| Path::new("..").as_os_str());
    up.chain(file.components().skip(shared).map(|part| part.as_os_str())).collect()
}
