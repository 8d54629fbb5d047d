//! Whether a file can be written to a path, found out before the work whose result it is to hold.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use super::atomic::no_file;
use super::destination::{Destination, folder_of};
use super::temporary::{Temporary, remove_stale};
use crate::error::{Error, Result};

/// The destination of the path, if [`atomic::replace`](super::atomic::replace) can write there as far as can be known. The error is the
/// reason why it cannot.
///
/// A stream is not opened. Temporary files that dead writers of the file have left are removed.
pub fn check(path: &Path) -> std::result::Result<Destination, String> {
    let destination = Destination::find(path).map_err(|error| error.to_string())?;
    if let Destination::File(target) = &destination {
        // Even where files can be made in the folder, this one may not be replaceable.
        if let Some(obstacle) = by_attributes(target) {
            return Err(obstacle);
        }
        let ours = Temporary::create(target, true).map_err(|error| no_file(&error))?;
        if is_anothers(target, &ours.file) {
            return Err(
                "it belongs to another user, and its folder is sticky: only its owner may replace it".to_owned()
            );
        }
        remove_stale(target);
    }
    Ok(destination)
}

/// Whether the disk of a file has room for anything. The error is that of writing the file.
pub fn has_room(path: &Path) -> Result<()> {
    let Ok(Destination::File(target)) = Destination::find(path) else { return Ok(()) };
    let written = Temporary::create(&target, true).and_then(|mut temporary| temporary.file.write_all(&[1; 4096]));
    written.map_err(|error| Error::of_write(path, &error))
}

/// The attribute that keeps a file from being replaced, if the file system has one.
#[cfg(target_os = "linux")]
fn by_attributes(target: &Path) -> Option<String> {
    use rustix::fs::{AtFlags, CWD, StatxAttributes, StatxFlags, statx};
    let attributes = |path: &Path| {
        let found = statx(CWD, path, AtFlags::empty(), StatxFlags::empty());
        found.map_or(StatxAttributes::empty(), |found| found.stx_attributes)
    };
    let folder = folder_of(target);
    let of_file = obstacle(attributes(target)).map(|obstacle| format!("it {obstacle}"));
    // A folder that is mounted is as good as any.
    let of_folder = || obstacle(attributes(folder) - StatxAttributes::MOUNT_ROOT);
    of_file.or_else(|| of_folder().map(|obstacle| format!("its folder {} {obstacle}", folder.display())))
}

#[cfg(not(target_os = "linux"))]
fn by_attributes(_: &Path) -> Option<String> {
    None
}

#[cfg(target_os = "linux")]
fn obstacle(attributes: rustix::fs::StatxAttributes) -> Option<&'static str> {
    use rustix::fs::StatxAttributes;
    let obstacles = [
        (StatxAttributes::IMMUTABLE, "is immutable (`chattr -i` allows changes)"),
        (StatxAttributes::APPEND, "may only be appended to (`chattr -a` allows changes)"),
        (StatxAttributes::MOUNT_ROOT, "is a mount point, which cannot be replaced: mount its folder instead"),
    ];
    obstacles.into_iter().find(|(attribute, _)| attributes.contains(*attribute)).map(|(_, words)| words)
}

/// Whether the file belongs to somebody else than `ours`, in a folder such as /tmp that keeps everyone's files from all others.
#[cfg(unix)]
fn is_anothers(target: &Path, ours: &File) -> bool {
    use std::fs;
    use std::os::unix::fs::MetadataExt;
    let found = (fs::metadata(folder_of(target)), fs::metadata(target), ours.metadata());
    let (Ok(folder), Ok(old), Ok(ours)) = found else { return false };
    is_forbidden(folder.mode(), [folder.uid(), old.uid()], ours.uid())
}

#[cfg(not(unix))]
fn is_anothers(_: &Path, _: &File) -> bool {
    false
}

/// Whether a user may not replace a file: in a folder with the sticky bit, only root and the owners of the file and of the folder may.
#[cfg(unix)]
fn is_forbidden(mode_of_folder: u32, owners: [u32; 2], user: u32) -> bool {
    const STICKY: u32 = 0o1000;
    const ROOT: u32 = 0;
    mode_of_folder & STICKY != 0 && user != ROOT && !owners.contains(&user)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;
    use std::process::Command;

    #[test]
    fn a_writable_path_passes_and_stays_empty() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("old"), "old").unwrap();
        symlink("old", at("link")).unwrap();
        let longest = "n".repeat(255);
        for (name, target) in [("new", "new"), ("old", "old"), ("link", "old"), (&longest, &longest)] {
            assert_eq!(check(&at(name)), Ok(Destination::File(at(target))), "{name}");
        }
        assert_eq!(fs::read_to_string(at("old")).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        // A pipe that nobody reads is not opened: that would wait.
        rustix::fs::mkfifoat(rustix::fs::CWD, at("pipe"), rustix::fs::Mode::RWXU).unwrap();
        assert_eq!(check(&at("pipe")), Ok(Destination::Stream));
        assert_eq!(check(Path::new("/dev/null")), Ok(Destination::Stream));
    }

    #[test]
    fn folders_where_no_file_can_be_made_are_found() {
        let reason = check(Path::new("/proc/sys/a.exr")).unwrap_err();
        assert!(reason.starts_with("no file can be made in its folder: "), "{reason}");
    }

    #[test]
    fn obstacles_are_named() {
        use rustix::fs::StatxAttributes as Is;
        for (attributes, words) in [
            (Is::IMMUTABLE | Is::COMPRESSED, "is immutable"),
            (Is::APPEND, "may only be appended to"),
            (Is::MOUNT_ROOT, "is a mount point"),
        ] {
            assert!(obstacle(attributes).is_some_and(|found| found.starts_with(words)), "{words}");
        }
        assert_eq!(obstacle(Is::NODUMP | Is::COMPRESSED), None);
    }

    /// Only a privileged user may set attributes, and not in every file system. Where they can be set, they are found.
    #[test]
    fn attributes_of_files_and_folders_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let (file, inner) = (folder.path().join("file"), folder.path().join("inner"));
        fs::write(&file, "").unwrap();
        fs::create_dir(&inner).unwrap();
        let set = |change: &str, path: &Path| {
            let ran = Command::new("chattr").arg(change).arg(path).output();
            ran.is_ok_and(|ran| ran.status.success())
        };
        for (letter, words) in [("i", "immutable"), ("a", "appended")] {
            for (changed, path) in [(&file, &file), (&inner, &inner.join("new"))] {
                let found = set(&format!("+{letter}"), changed).then(|| check(path));
                set(&format!("-{letter}"), changed);
                assert!(
                    found.is_none_or(|found| found.is_err_and(|reason| reason.contains(words))),
                    "{path:?} {letter}"
                );
                assert_eq!(check(path), Ok(Destination::File(path.clone())));
            }
        }
    }

    #[test]
    fn a_sticky_folder_keeps_the_files_of_others() {
        let (folder, file, other) = (7, 8, 9);
        for (mode, user, is_kept) in [
            (0o1777, other, true),
            (0o1777, file, false),
            (0o1777, folder, false),
            (0o1777, 0, false),
            (0o0777, other, false),
        ] {
            assert_eq!(is_forbidden(mode, [folder, file], user), is_kept, "{mode:o} {user}");
        }
    }
}
