//! Replaces files atomically: a reader finds the old contents or the new ones, never a part.

use std::fs::{self, File, Metadata};
use std::io::{self, Seek, Write};
use std::path::Path;

use super::destination::{Destination, folder_of, is_standard};
use super::stdout;
use super::temporary::Temporary;
use crate::error::{Error, Result};

/// Replaces the file at `path` by what `write` writes to an empty file that can seek.
///
/// The bytes go to a temporary file in the same folder. Once they are on the disk, it replaces the old file. If
/// anything fails, the temporary file is removed and the old file stays. A symbolic link stays, and the file that it
/// points to is replaced. Other kinds of files (/dev/null, a pipe, /dev/stdout) are written to directly, once `write`
/// has succeeded.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    replace_if(path, write, || Ok(()))
}

/// Replaces the file as [`replace`] does, if it `may` be replaced, which is checked last; if not, that is the error. Writers check one after another, so that
/// no other process replaces the old file between the check and the replacement. Other kinds of files are not checked.
pub fn replace_if(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    may: impl FnOnce() -> std::result::Result<(), String>,
) -> Result<()> {
    let replaced = Destination::find(path).and_then(|destination| match destination {
        Destination::Stream => replace_stream(path, write),
        Destination::File(target) => replace_file(&target, write, may),
    });
    replaced.map_err(|error| Error::of_write(path, &error))
}

/// Replaces the file at `path` by these bytes, as [`replace`] does.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |file| file.write_all(bytes))
}

fn replace_file(
    target: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    may: impl FnOnce() -> std::result::Result<(), String>,
) -> io::Result<()> {
    let old = fs::metadata(target).ok();
    // Whoever may not read the old file may not read the new one either, also while it is written.
    let mut temporary =
        Temporary::create(target, old.is_some()).map_err(|error| io::Error::new(error.kind(), no_file(&error)))?;
    // From here on, every return removes the temporary file.
    write(&mut temporary.file)?;
    if let Some(old) = old {
        keep_owner_and_mode(&temporary.file, &old);
    }
    temporary.file.sync_all()?;
    // The folder's lock is held until the end. Where there is none, another writer may come between the check and the replacement.
    let folder = File::open(folder_of(target)).ok();
    let _ = folder.as_ref().map(File::lock);
    may().map_err(io::Error::other)?;
    temporary.persist(target)?;
    // The sync of the folder writes the new name to the disk. Not every system can do that, but the contents are already safe.
    let _ = folder.as_ref().map(File::sync_all);
    Ok(())
}

/// The reason why no file could be made in the folder of the target. It has only the kind of the error, because the full text names the
/// temporary file, which means nothing to the user.
pub(super) fn no_file(error: &io::Error) -> String {
    format!("no file can be made in its folder: {}", error.kind())
}

/// Gives a file the owner, the group and the mode of the old one, as far as the system permits.
#[cfg(unix)]
fn keep_owner_and_mode(file: &File, old: &Metadata) {
    use std::os::unix::fs::{MetadataExt, fchown};
    // Only root may change the owner; a user may choose among the own groups. The mode comes last, because a change of the owner
    // changes it.
    let _ = fchown(file, None, Some(old.gid()));
    let _ = fchown(file, Some(old.uid()), None);
    let _ = file.set_permissions(old.permissions());
}

#[cfg(not(unix))]
fn keep_owner_and_mode(_: &File, _: &Metadata) {}

fn replace_stream(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    // `write` may seek, but a pipe cannot. This temporary file has no name and disappears with its handle.
    let mut file = tempfile::tempfile()?;
    write(&mut file)?;
    file.rewind()?;
    if is_standard(path) {
        stdout::check()?;
        let mut stdout = io::stdout().lock();
        io::copy(&mut file, &mut stdout)?;
        return stdout.flush();
    }
    // Behind what an open file has already, as the shell's >> asks.
    let mut stream = fs::OpenOptions::new().append(true).open(path)?;
    io::copy(&mut file, &mut stream)?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_text(path: &Path, text: &str) -> Result<()> {
        replace(path, |file| file.write_all(text.as_bytes()))
    }

    /// A folder, and the path of a file in it.
    fn folder_and_path() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        (folder, path)
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let (folder, path) = folder_and_path();
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
    fn a_file_that_may_not_be_replaced_stays() {
        let (folder, path) = folder_and_path();
        write_text(&path, "better").unwrap();
        let refused = replace_if(&path, |file| file.write_all(b"new"), || Err("it is better".to_owned()));
        assert_eq!(refused.unwrap_err().to_string(), format!("{}: cannot write: it is better", path.display()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "better");
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    /// Concurrent writers each replace only a smaller number: the largest stays, whoever comes last.
    #[test]
    fn writers_ask_one_after_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("count");
        let there = || fs::read_to_string(&path).ok().and_then(|text| text.parse::<u32>().ok()).unwrap_or(0);
        std::thread::scope(|scope| {
            for writer in 0..8 {
                let (path, there) = (&path, &there);
                scope.spawn(move || {
                    for step in 0..50 {
                        let mine = step * 8 + writer + 1;
                        let may = || if there() < mine { Ok(()) } else { Err(String::new()) };
                        let _ = replace_if(path, |file| file.write_all(mine.to_string().as_bytes()), may);
                        assert!(there() >= mine);
                    }
                });
            }
        });
        assert_eq!(there(), 400);
    }

    #[test]
    fn readers_find_the_old_file_until_the_new_one_is_complete() {
        let (folder, path) = folder_and_path();
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
    fn destinations_that_cannot_be_written_are_named() {
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

    /// The number 12345 is nobody here: only root may give files away, and for others the file stays their own.
    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_mode_and_owner() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
        let (_folder, path) = folder_and_path();
        for mode in [0o640, 0o600, 0o444, 0o666] {
            fs::write(&path, "old").unwrap();
            let _ = chown(&path, Some(12345), Some(12345));
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            let of = |path: &Path| fs::metadata(path).map(|found| (found.uid(), found.gid(), found.mode())).unwrap();
            let old = of(&path);
            replace(&path, |file| {
                // Meanwhile nobody else reads what the old file kept secret.
                assert_eq!(file.metadata()?.mode() & 0o077, 0);
                file.write_all(b"new")
            })
            .unwrap();
            assert_eq!(of(&path), old, "{mode:o}");
            assert_eq!(fs::read_to_string(&path).unwrap(), "new");
            fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn the_longest_names_are_written() {
        let folder = tempfile::tempdir().unwrap();
        for length in [242, 243, 255] {
            let name = "n".repeat(length);
            write_text(&folder.path().join(&name), &name).unwrap();
            assert_eq!(fs::read_to_string(folder.path().join(&name)).unwrap(), name);
        }
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
        // A file that is open, as /dev/stdout is behind the shell's >>, keeps what it has.
        let mut open = tempfile::tempfile().unwrap();
        open.write_all(b"before ").unwrap();
        write_text(Path::new(&format!("/proc/self/fd/{}", open.as_raw_fd())), "behind").unwrap();
        open.rewind().unwrap();
        assert_eq!(io::read_to_string(open).unwrap(), "before behind");
    }
}
