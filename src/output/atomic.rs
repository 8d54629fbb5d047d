//! Replaces files atomically: a reader finds the old contents or the new ones, never a part.

use std::fs::{self, File};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The number of links after which Linux reports a loop.
const MAX_LINKS: usize = 40;

/// Replaces the file at `path` by what `write` writes to an empty file that can seek.
///
/// The bytes go to a temporary file in the same folder. Once they are on the disk, it replaces the old file. If
/// anything fails, the temporary file is removed and the old file stays. A symbolic link stays, and the file that it
/// points to is replaced. Other kinds of files (/dev/null, a pipe, /dev/stdout) are written to directly, once `write`
/// has succeeded.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    let failed = |reason: String| Error::File { path: path.to_owned(), action: "write", reason };
    match destination(path).map_err(|error| failed(error.to_string()))? {
        Destination::Stream => replace_stream(path, write).map_err(|error| failed(error.to_string())),
        Destination::Regular(target) => replace_regular(&target, write).map_err(failed),
    }
}

/// Replaces the file at `path` by these bytes, as [`replace`] does.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |file| file.write_all(bytes))
}

enum Destination {
    /// The path of a regular file, or of a file that does not exist yet. The path is not a link.
    Regular(PathBuf),
    /// Something that can be written to but not replaced.
    Stream,
}

/// Follows links one by one, because the last one may point to a file that does not exist yet.
fn destination(path: &Path) -> io::Result<Destination> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(io::Error::other("it is a folder")),
        Ok(metadata) if !metadata.is_file() => return Ok(Destination::Stream),
        // A missing file will be created. Other errors are a loop of links, a folder that may not be entered, …
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        // An open file, such as /dev/stdout redirected to a file: if the file were replaced, other writers of the open
        // file would write to the old one.
        if target.starts_with("/proc") || target.starts_with("/dev/fd") {
            return Ok(Destination::Stream);
        }
        match fs::read_link(&target) {
            // `join` returns an absolute link unchanged.
            Ok(link) => target = folder_of(&target).join(link),
            Err(_) => return Ok(Destination::Regular(target)),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn replace_regular(target: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> std::result::Result<(), String> {
    let name = target.file_name().ok_or("it names no file")?;
    let folder = folder_of(target);
    if !folder.is_dir() {
        return Err(format!("the folder {} does not exist", folder.display()));
    }
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    #[cfg(unix)]
    {
        // Temporary files are private by default. This one becomes the user's file, so that the umask decides its permissions.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // Only the kind of the error: the full text names the temporary file, which means nothing to the user.
    let mut file =
        builder.tempfile_in(folder).map_err(|error| format!("no file can be made in its folder: {}", error.kind()))?;
    // From here on, every return removes the temporary file.
    write(file.as_file_mut()).map_err(|error| error.to_string())?;
    file.as_file().sync_all().map_err(|error| error.to_string())?;
    file.persist(target).map_err(|error| error.error.to_string())?;
    // The sync of the folder writes the new name to the disk. Not every system can do that, but the contents are already safe.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn replace_stream(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    // `write` may seek, but a pipe cannot. This temporary file has no name and disappears with its handle.
    let mut file = tempfile::tempfile()?;
    write(&mut file)?;
    file.rewind()?;
    let mut stream = fs::OpenOptions::new().write(true).open(path)?;
    io::copy(&mut file, &mut stream)?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_text(path: &Path, text: &str) -> Result<()> {
        replace(path, |file| file.write_all(text.as_bytes()))
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_text(&path, "old").unwrap();
        let error = replace(&path, |file| {
            file.write_all(b"half of the ne")?;
            Err(io::Error::other("the encoder failed"))
        });
        let message = error.unwrap_err().to_string();
        assert_eq!(message, format!("{}: cannot write: the encoder failed", path.display()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    #[test]
    fn readers_find_the_old_file_until_the_new_one_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_text(&path, "old, and longer").unwrap();
        replace(&path, |file| {
            file.write_all(b"new")?;
            file.flush()?;
            assert_eq!(fs::read_to_string(&path)?, "old, and longer");
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    #[test]
    fn places_that_cannot_be_written_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing").join("a.exr");
        let message = write_text(&missing, "").unwrap_err().to_string();
        assert!(message.contains("missing/a.exr") && message.contains("does not exist"), "{message}");
        let message = write_text(folder.path(), "").unwrap_err().to_string();
        assert!(message.contains("it is a folder"), "{message}");
        for nothing in ["", "/", ".."] {
            assert!(write_text(Path::new(nothing), "").is_err(), "{nothing}");
        }
        let file_as_folder = folder.path().join("file");
        write_text(&file_as_folder, "").unwrap();
        assert!(write_text(&file_as_folder.join("a.exr"), "").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn the_mode_is_that_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_text(&ours, "").unwrap();
        fs::write(&plain, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_what_they_point_to_is_replaced() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        write_text(&at("sub/real"), "old").unwrap();
        symlink("sub/real", at("link")).unwrap();
        symlink("link", at("link_to_link")).unwrap();
        symlink("sub/not_yet", at("dangling")).unwrap();
        symlink("loop", at("loop")).unwrap();
        write_text(&at("link_to_link"), "new").unwrap();
        write_text(&at("dangling"), "made").unwrap();
        assert_eq!(fs::read_to_string(at("sub/real")).unwrap(), "new");
        assert_eq!(fs::read_to_string(at("sub/not_yet")).unwrap(), "made");
        assert!(at("link").is_symlink() && at("dangling").is_symlink() && at("link_to_link").is_symlink());
        assert!(write_text(&at("loop"), "").is_err());
        assert_eq!(names(&at("sub")), ["not_yet", "real"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_and_pipes_are_written_to() {
        use std::os::unix::fs::FileTypeExt;
        write_text(Path::new("/dev/null"), "text").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let message = write_text(Path::new("/dev/full"), "text").unwrap_err().to_string();
        assert!(message.starts_with("/dev/full: cannot write: ") && message.contains("space"), "{message}");
        let (mut reader, writer) = io::pipe().unwrap();
        use std::os::fd::AsRawFd;
        write_text(Path::new(&format!("/proc/self/fd/{}", writer.as_raw_fd())), "through a pipe").unwrap();
        drop(writer);
        assert_eq!(io::read_to_string(&mut reader).unwrap(), "through a pipe");
    }
}
