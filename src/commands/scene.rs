//! The scene that a command names: a file, or `-` for standard input.

use std::ffi::OsStr;
use std::path::Path;

use crate::error::Result;
use crate::output::place::is_standard;
use crate::scene::{OnProgress, Scene};

/// Reads the scene. Of one on standard input, paths are relative to the current folder, and errors name `<stdin>`.
pub fn load_scene(path: &Path, progress: &mut OnProgress) -> Result<Scene> {
    match is_standard(path) {
        true => Scene::read(std::io::stdin().lock(), Path::new("<stdin>"), progress),
        false => Scene::load_with(path, progress),
    }
}

/// The scene's name, which names of outputs begin with: that of its file without the ending, or `stdin`.
pub fn stem_of(path: &Path) -> &OsStr {
    match is_standard(path) {
        true => OsStr::new("stdin"),
        false => path.file_stem().unwrap_or_default(),
    }
}

/// The name that reports give the scene: that of its file, or `stdin`.
pub fn name_of(path: &Path) -> String {
    match is_standard(path) {
        true => "stdin".to_string(),
        false => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}
