//! The files that a command is going to write, checked before anything costs time.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::output::destination::{is_standard, same_file};
use crate::output::format::{Format, format_of};
use crate::output::writable;

/// An image that is going to be written, unless it has no path: the option that names it, its path, and the formats that it may have.
pub type Image<'a> = (&'static str, Option<&'a Path>, &'static [Format]);

pub const EXR: &[Format] = &[Format::Exr];
pub const EXR_OR_PNG: &[Format] = &[Format::Exr, Format::Png];
pub const PNG: &[Format] = &[Format::Png];

/// Checks that each of these images can be written, that no two of them are one file, that none is an input, and that their names say formats
/// that they may have. `stdout` is printed on standard output, if anything, so that no image can go there: "the report". `undone` is the
/// work that an error leaves undone: "nothing has been rendered".
pub fn check_outputs(
    images: &[Image<'_>],
    inputs: &[PathBuf],
    stdout: Option<&'static str>,
    undone: &'static str,
) -> Result<()> {
    let images: Vec<_> =
        images.iter().filter_map(|(option, path, formats)| Some((option, (*path)?, *formats))).collect();
    let refuse = |path: &Path, reason: String| Err(Error::Usage(format!("{}: {reason}; {undone}", path.display())));
    for (i, &(option, path, _)) in images.iter().enumerate() {
        if let Err(reason) = writable::check(path) {
            return refuse(path, format!("cannot write: {reason}. Give another name with {option}"));
        }
        if let Some((other, its, _)) = images.iter().take(i).find(|(_, other, _)| same_file(path, other)) {
            let reason = format!("{option} names the same file as {other} {}: give two names", its.display());
            return refuse(path, reason);
        }
        if let Some(input) = inputs.iter().find(|input| same_file(path, input)) {
            let reason = format!("it would overwrite the input {}: give another name with {option}", input.display());
            return refuse(path, reason);
        }
    }
    if stdout.is_some() || images.iter().any(|(_, path, _)| is_standard(path)) {
        let closed = |reason| Error::file("stdout", "write")(format!("{reason}; {undone}"));
        crate::output::stdout::check().map_err(closed)?;
    }
    for (option, path, formats) in images {
        if let Err(reason) = format_of(path, formats) {
            return refuse(path, format!("{reason} with {option}"));
        }
        if let Some(words) = stdout.filter(|_| is_standard(path)) {
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

/// Creates a folder unless it exists. If that fails, the error includes `undone`: the work that has not been done.
pub fn make_folder(folder: &Path, undone: &str) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|error| Error::file(folder, "write")(format!("{error}; {undone}")))
}
