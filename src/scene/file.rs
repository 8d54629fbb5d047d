//! Reads a file that the scene names.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A callback for the progress of reading a file, with its path, the bytes read so far, and all its bytes.
pub type OnProgress<'a> = dyn FnMut(&Path, u64, u64) + 'a;

/// The longest image or mesh file, in bytes. A file is in memory while it is read, and this is what loading may take beyond what
/// fits a device. A mesh of 50 million triangles needs no more as a binary PLY. Sparse files can claim any length.
pub const LONGEST: u64 = 1 << 30;

/// The longest scene file, in bytes. A scene of two million spheres is half as long.
pub const LONGEST_SCENE: u64 = 1 << 28;

/// What is read of the files that a scene names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    Complete,
    /// Nothing: whether they are there is all that counts.
    IfThere,
}

/// Checks that a file is there and is at most so long; the result is its length. `what` names it in errors: "image".
pub fn find(path: &Path, what: &str, most: u64) -> Result<u64, String> {
    let cannot = |reason: String| format!("cannot read the {what}: {reason}");
    let meta = std::fs::metadata(path).map_err(|error| cannot(error.to_string()))?;
    if !meta.is_file() {
        return Err(cannot("it is not a file".to_owned()));
    }
    if meta.len() > most {
        return Err(cannot(too_long(most, meta.len())));
    }
    Ok(meta.len())
}

fn too_long(most: u64, length: u64) -> String {
    format!("expected a file of at most {most} bytes, found {length}")
}

/// The bytes of a file of at most `most` bytes.
pub fn read(path: &Path, what: &str, most: u64) -> Result<Vec<u8>, String> {
    let cannot = |reason: String| format!("cannot read the {what}: {reason}");
    let mut bytes = Vec::new();
    let size = find(path, what, most)? as usize;
    bytes.try_reserve_exact(size).map_err(|_| format!("there is no memory for its {size} bytes"))?;
    // The file may grow while it is read.
    File::open(path)
        .and_then(|file| file.take(most + 1).read_to_end(&mut bytes))
        .map_err(|error| cannot(error.to_string()))?;
    if bytes.len() as u64 > most {
        return Err(cannot(too_long(most, bytes.len() as u64)));
    }
    Ok(bytes)
}
