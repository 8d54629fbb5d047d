//! The files that a command is going to write, checked before anything costs time.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::output::place::same_file;
use crate::output::writable;

/// Checks that each of these files can be written, that no two of them are one file, and that none is an input. The strings are the
/// options that name them. An error includes `undone`: the work that has not been done.
pub fn check_outputs(outputs: &[(&str, &Path)], inputs: &[PathBuf], undone: &str) -> Result<()> {
    let refuse = |path: &Path, reason: String| Err(Error::Usage(format!("{}: {reason}; {undone}", path.display())));
    for (i, &(option, path)) in outputs.iter().enumerate() {
        if let Err(reason) = writable::check(path) {
            return refuse(path, format!("cannot write: {reason}. Give another name with {option}"));
        }
        if let Some((other, same)) = outputs.iter().take(i).find(|(_, other)| same_file(path, other)) {
            let reason = format!("{option} names the same file as {other} {}: give two names", same.display());
            return refuse(path, reason);
        }
        if let Some(input) = inputs.iter().find(|input| same_file(path, input)) {
            let reason = format!("it would overwrite the input {}: give another name with {option}", input.display());
            return refuse(path, reason);
        }
    }
    Ok(())
}
