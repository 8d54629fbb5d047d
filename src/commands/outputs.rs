//! The files that a command is going to write, checked before anything costs time.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::output::format::{Format, format_of};
use crate::output::place::{is_standard, same_file};
use crate::output::writable;

/// An image that is going to be written.
pub struct OutputImage<'a> {
    /// The option that names it.
    pub option: &'static str,
    pub path: &'a Path,
    /// What it may be.
    pub formats: &'static [Format],
}

pub const EXR: &[Format] = &[Format::Exr];
pub const EXR_OR_PNG: &[Format] = &[Format::Exr, Format::Png];
pub const PNG: &[Format] = &[Format::Png];

/// What a command has beside its images.
pub struct Beside<'a> {
    /// The files that it reads, and must not overwrite.
    pub inputs: &'a [PathBuf],
    /// What it prints on standard output, if anything, so that no image can go there: "the report".
    pub stdout: Option<&'static str>,
    /// The work that an error leaves undone: "nothing has been rendered".
    pub undone: &'static str,
}

/// Checks that each of these files can be written, that no two of them are one file, that none is an input, and that their names say formats
/// that they may have.
pub fn check_outputs(images: &[OutputImage<'_>], beside: &Beside<'_>) -> Result<()> {
    let undone = beside.undone;
    let refuse = |path: &Path, reason: String| Err(Error::Usage(format!("{}: {reason}; {undone}", path.display())));
    for (i, &OutputImage { option, path, .. }) in images.iter().enumerate() {
        if let Err(reason) = writable::check(path) {
            return refuse(path, format!("cannot write: {reason}. Give another name with {option}"));
        }
        if let Some(other) = images.iter().take(i).find(|other| same_file(path, other.path)) {
            let reason =
                format!("{option} names the same file as {} {}: give two names", other.option, other.path.display());
            return refuse(path, reason);
        }
        if let Some(input) = beside.inputs.iter().find(|input| same_file(path, input)) {
            let reason = format!("it would overwrite the input {}: give another name with {option}", input.display());
            return refuse(path, reason);
        }
    }
    for &OutputImage { option, path, formats } in images {
        if let Err(reason) = format_of(path, formats) {
            return refuse(path, format!("{reason} with {option}"));
        }
        if let Some(words) = beside.stdout.filter(|_| is_standard(path)) {
            return refuse(path, format!("standard output has {words}: give the name of a file with {option}"));
        }
    }
    Ok(())
}

/// Refuses `-` where it would have to be a file or folder with a name. `what` says what is expected: "a folder".
pub fn check_name(path: &Path, what: &str) -> Result<()> {
    match is_standard(path) {
        true => Err(Error::Usage(format!("-: expected the name of {what}. A file of this name is ./-"))),
        false => Ok(()),
    }
}
