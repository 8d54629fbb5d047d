//! Where a file goes: what a path leads to, and which paths name one file.
//!
//! No function here opens a file, because opening a pipe waits for its other end.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// The number of links after which Linux reports a loop.
const MAX_LINKS: usize = 40;

/// Whether a path is `-`: standard input or standard output. A file of this name is `./-`.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The kind of file that a path leads to.
#[derive(Debug, PartialEq, Eq)]
pub enum Destination {
    /// A regular file, or a file that does not exist yet in a folder that does. The path is not a link.
    File(PathBuf),
    /// Something that can be written to but not replaced: standard output, a pipe, a device, or an open file such as /dev/stdout.
    Stream,
}

impl Destination {
    /// Follows links one by one, because the last one may point to a file that does not exist yet.
    pub fn find(path: &Path) -> io::Result<Destination> {
        if is_standard(path) {
            return Ok(Destination::Stream);
        }
        let exists = match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => return Err(io::Error::other("it is a folder")),
            Ok(metadata) if !metadata.is_file() => return Ok(Destination::Stream),
            Ok(_) => true,
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            // A loop of links, a name that is too long, …
            Err(error) => return Err(error),
        };
        let mut target = path.to_owned();
        for _ in 0..MAX_LINKS {
            // An open file, such as /dev/stdout redirected to a file: if the file were replaced, other writers of the open
            // file would write to the old one.
            if exists && (target.starts_with("/proc") || target.starts_with("/dev/fd")) {
                return Ok(Destination::Stream);
            }
            match fs::read_link(&target) {
                // `join` returns an absolute link unchanged.
                Ok(link) => target = target.parent().unwrap_or(Path::new("")).join(link),
                Err(_) => return Destination::of_file(target),
            }
        }
        Err(io::Error::other("too many symbolic links"))
    }

    fn of_file(target: PathBuf) -> io::Result<Destination> {
        // `Path` hides a separator at the end. To the system it means a folder, as "." and ".." do.
        let text = target.to_string_lossy();
        if matches!(text.rsplit(std::path::is_separator).next(), None | Some("" | "." | "..")) {
            return Err(io::Error::other("it names no file"));
        }
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(io::Error::other(format!("the folder {} does not exist", folder.display())));
        }
        Ok(Destination::File(target))
    }
}

/// Whether a later file can replace what is there. A pipe gets one file, at the end.
pub fn can_be_replaced(path: &Path) -> bool {
    !matches!(Destination::find(path), Ok(Destination::Stream))
}

/// Whether a folder of PATH has a file of this name.
pub fn is_on_path(file: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(file).is_file())
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Whether two paths name one file, in any spelling and through any link, also where the file does not exist yet.
///
/// A device such as /dev/null is not the same as itself: what one writes does not change what another finds.
pub fn same_file(a: &Path, b: &Path) -> bool {
    if is_standard(a) || is_standard(b) {
        return is_standard(a) && is_standard(b);
    }
    identity(a).is_some_and(|a| identity(b) == Some(a))
}

#[derive(PartialEq, Eq)]
enum Identity {
    #[cfg(unix)]
    Inode(u64, u64),
    Path(PathBuf),
}

fn identity(path: &Path) -> Option<Identity> {
    match fs::metadata(path) {
        Ok(metadata) => identity_of_existing(path, &metadata),
        Err(_) => match Destination::find(path) {
            Ok(Destination::File(target)) => {
                let folder = folder_of(&target).canonicalize().ok()?;
                Some(Identity::Path(folder.join(target.file_name()?)))
            }
            _ => None,
        },
    }
}

#[cfg(unix)]
fn identity_of_existing(_: &Path, metadata: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let is_device = metadata.file_type().is_char_device();
    (!is_device).then(|| Identity::Inode(metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity_of_existing(path: &Path, _: &Metadata) -> Option<Identity> {
    path.canonicalize().ok().map(Identity::Path)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn one_file_is_recognised_in_every_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("a"), "").unwrap();
        fs::write(at("b"), "").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        symlink("a", at("link")).unwrap();
        symlink("sub", at("door")).unwrap();
        symlink("sub/new", at("dangling")).unwrap();
        for (one, other) in [
            ("a", "a"),
            ("a", "./a"),
            ("a", "sub/../a"),
            ("a", "hard"),
            ("hard", "link"),
            // Missing files.
            ("new", "sub/../new"),
            ("sub/new", "door/new"),
            ("sub/new", "dangling"),
            ("dangling", "door/../sub/new"),
        ] {
            assert!(same_file(&at(one), &at(other)) && same_file(&at(other), &at(one)), "{one} {other}");
        }
        for (one, other) in [("a", "b"), ("a", "new"), ("new", "newer"), ("new", "sub/new"), ("missing/a", "missing/a")]
        {
            assert!(!same_file(&at(one), &at(other)), "{one} {other}");
        }
        let null = Path::new("/dev/null");
        assert!(!same_file(null, null));
    }

    #[test]
    fn a_path_that_names_no_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        symlink("missing/", at("to_folder")).unwrap();
        symlink("missing/a", at("to_missing")).unwrap();
        symlink("loop", at("loop")).unwrap();
        for (name, words) in [
            ("", "it is a folder"),
            ("new/", "it names no file"),
            ("new/.", "it names no file"),
            ("to_folder", "it names no file"),
            ("file/", "directory"),
            ("to_missing", "missing does not exist"),
            ("missing/a", "missing does not exist"),
            ("loop", "links"),
            (&"n".repeat(256), "long"),
        ] {
            let error = Destination::find(&at(name)).map_err(|error| error.to_string().to_lowercase());
            assert!(error.as_ref().is_err_and(|error| error.contains(words)), "{name}: {error:?}");
        }
        let longest = at(&"n".repeat(255));
        assert_eq!(Destination::find(&longest).unwrap(), Destination::File(longest));
    }
}
