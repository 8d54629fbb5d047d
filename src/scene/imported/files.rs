//! The files of a scene, which may include each other.

use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;

use super::Place;
use crate::error::{Error, Result, require};
use crate::scene::assets::Assets;
use crate::scene::file::{self, LONGEST_SCENE};

/// The most files that are open at a time, and that a scene includes.
const DEEPEST: usize = 100;
const MOST_FILES: usize = 1000;

/// The files that are open, each included by the one before.
pub struct Includes {
    open: Vec<PathBuf>,
    /// How many files were included.
    count: usize,
}

impl Includes {
    pub fn new(first: &Path) -> Includes {
        Includes { open: vec![real(first)], count: 0 }
    }

    /// Opens a file that the last one includes.
    pub fn open(&mut self, path: &Path) -> std::result::Result<(), String> {
        let circle = || format!("{} includes itself: expected no circle", path.display());
        require(!self.open.contains(&real(path)), circle)?;
        if self.open.len() > DEEPEST || self.count >= MOST_FILES {
            return Err(format!("expected at most {MOST_FILES} included files, {DEEPEST} in each other"));
        }
        self.open.push(real(path));
        self.count += 1;
        Ok(())
    }

    pub fn close(&mut self) {
        self.open.pop();
    }
}

fn real(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or(path.to_owned())
}

/// The text of a file, which may be packed by gzip.
pub fn text(path: &Path, assets: &mut Assets) -> Result<String> {
    let at = |line: usize, message: String| {
        Place { file: path.into(), line: line as u32, column: line.min(1) as u32 }.error("scene", message)
    };
    assets.stamp_files(path);
    let mut bytes = file::read(path, "scene file", LONGEST_SCENE).map_err(|reason| at(0, reason))?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        let done = GzDecoder::new(&bytes[..]).take(LONGEST_SCENE + 1).read_to_end(&mut unpacked);
        if done.is_err() || unpacked.len() as u64 > LONGEST_SCENE {
            return Err(at(0, format!("expected a gzip file of at most {LONGEST_SCENE} bytes")));
        }
        bytes = unpacked;
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = error.as_bytes().get(..error.utf8_error().valid_up_to()).unwrap_or_default();
        let lines = before.iter().filter(|byte| **byte == b'\n').count();
        at(lines + 1, "expected UTF-8 text in this line".to_owned())
    })
}

/// An error about an included file as a whole stands where the file is included. Others keep their place.
pub fn where_included(error: Error, at: impl FnOnce(String) -> Error) -> Error {
    match error {
        Error::Scene { location, message, .. } if location.line == 0 => at(message),
        other => other,
    }
}
