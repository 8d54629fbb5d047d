//! The error type of the program: what went wrong, where, and what to do about it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::printable::one_line;

/// A position in a text file. Lines and columns count from 1; columns count characters. In a binary file, both are 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    pub file: PathBuf,
    pub line: usize,
    pub column: usize,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = path_on_one_line(&self.file);
        match self.line {
            0 => f.write_str(&file),
            line => write!(f, "{file}:{line}:{}", self.column),
        }
    }
}

/// A path as messages show it. A newline in a name must not look like the start of another message.
fn path_on_one_line(path: &Path) -> String {
    one_line(&path.to_string_lossy()).into_owned()
}

fn lines(errors: &[Error], more: usize) -> Vec<String> {
    let rest = (more > 0).then(|| format!("{more} more errors, which are not listed"));
    errors.iter().map(Error::to_string).chain(rest).collect()
}

/// All errors of gpu-rt. The text names the location or the limit, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene file, or a file that it names, has an error.
    #[error("{location}: {}: {}", one_line(field), one_line(message))]
    Scene {
        location: Location,
        /// The path of the wrong field from the top: `objects[3].Sphere.radius`.
        field: String,
        message: String,
    },
    /// Errors of a scene file, in its order. `more` is the number of those that are not listed.
    #[error("{}", lines(errors, *more).join("\n"))]
    Several { errors: Vec<Error>, more: usize },
    /// The command line requests something impossible.
    #[error("{0}")]
    Usage(String),
    /// A file could not be read or written.
    #[error("{}: cannot {action}: {}", path_on_one_line(path), one_line(reason))]
    File { path: PathBuf, action: &'static str, reason: String },
    /// A file could not be written because its disk is full. That may change.
    #[error("{}: cannot write: {}", path_on_one_line(path), one_line(reason))]
    NoRoom { path: PathBuf, reason: String },
    /// No device is suitable, the device refused, or it was lost.
    #[error("{0}")]
    Device(String),
    /// The library that denoises is missing, is another one, or has failed.
    #[error("{}", one_line(.0))]
    Denoiser(String),
    /// A shader did not link or validate. This is a defect of gpu-rt, never of the scene.
    #[error("{0}")]
    Shader(String),
    /// All samples were rejected, or some with `--strict`.
    #[error("{0}")]
    Strict(String),
    /// `--fail-above` was given and a metric is above its limit.
    #[error("{0}")]
    Limit(String),
    /// The render was given up, because its scene has changed. It is not reported.
    #[error("the scene has changed")]
    Dropped,
    /// A signal ended the work. Finished parts are kept.
    #[error("{message}")]
    Interrupted { signal: i32, message: String },
}

pub type Result<T> = std::result::Result<T, Error>;

/// Returns the error unless the condition holds.
pub(crate) fn require<E>(holds: bool, error: impl FnOnce() -> E) -> std::result::Result<(), E> {
    match holds {
        true => Ok(()),
        false => Err(error()),
    }
}

/// The first of several errors, if there is one.
pub(crate) fn first(errors: Vec<Error>) -> Result<()> {
    errors.into_iter().next().map_or(Ok(()), Err)
}

impl Error {
    /// The error of a file that could not be read or written, for its reason.
    pub fn file<R: ToString>(path: &(impl AsRef<Path> + ?Sized), action: &'static str) -> impl Fn(R) -> Error {
        let path = path.as_ref().to_owned();
        move |reason| Error::File { path: path.clone(), action, reason: reason.to_string() }
    }

    /// The error of a file that could not be written.
    pub fn of_write(path: &Path, error: &io::Error) -> Error {
        let (path, reason) = (path.to_owned(), error.to_string());
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Error::NoRoom { path, reason },
            _ => Error::File { path, action: "write", reason },
        }
    }

    /// Appends to the message what is kept and what to do. Errors of the scene and of arguments do not change.
    pub fn and(self, words: &str) -> Error {
        let more = |text: String| format!("{text}; {words}");
        match self {
            Error::File { path, action, reason } => Error::File { path, action, reason: more(reason) },
            Error::NoRoom { path, reason } => Error::NoRoom { path, reason: more(reason) },
            Error::Device(text) => Error::Device(more(text)),
            Error::Denoiser(text) => Error::Denoiser(more(text)),
            other => other,
        }
    }

    /// The errors one by one.
    pub fn each(&self) -> &[Error] {
        match self {
            Error::Several { errors, .. } => errors,
            one => std::slice::from_ref(one),
        }
    }

    /// The messages one by one.
    pub fn messages(&self) -> Vec<String> {
        match self {
            Error::Several { errors, more } => lines(errors, *more),
            one => vec![one.to_string()],
        }
    }

    /// The exit status of the process: 2 for bad input or arguments, 1 if the work itself failed, and after a signal 128 plus its
    /// number, as shells report it.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Scene { .. } | Error::Several { .. } | Error::Usage(_) => 2,
            Error::File { action, .. } if *action == "read" => 2,
            Error::Interrupted { signal, .. } => u8::try_from(128 + signal).unwrap_or(1),
            _ => 1,
        }
    }
}
