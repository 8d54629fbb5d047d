//! Reads a file that the scene names.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The longest image or mesh file, in bytes. A file is in memory while it is read, and this is what loading may take beyond what
/// fits a device. A mesh of 50 million triangles needs no more as a binary PLY. Sparse files can claim any length.
pub const LONGEST: u64 = 1 << 30;

/// The bytes of a file of at most `most` bytes. `what` names it in errors: "image".
pub fn read(path: &Path, what: &str, most: u64) -> Result<Vec<u8>, String> {
    let cannot = |reason: String| format!("cannot read the {what}: {reason}");
    let failed = |error: std::io::Error| cannot(error.to_string());
    let meta = std::fs::metadata(path).map_err(failed)?;
    if !meta.is_file() {
        return Err(cannot("it is not a file".to_owned()));
    }
    let too_long = |length: u64| Err(cannot(format!("expected a file of at most {most} bytes, found {length}")));
    if meta.len() > most {
        return too_long(meta.len());
    }
    let mut bytes = Vec::new();
    let size = meta.len() as usize;
    bytes.try_reserve_exact(size).map_err(|_| format!("there is no memory for its {size} bytes"))?;
    // The file may grow while it is read.
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > most {
        return too_long(bytes.len() as u64);
    }
    Ok(bytes)
}
