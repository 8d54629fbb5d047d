//! Temporary files, each in the folder of the file that it replaces.
//!
//! A writer holds a lock on its temporary file. The system gives up the lock when the writer dies, however it dies. So a temporary
//! file without a lock was left by a dead writer. A process number would not show that, because hosts share folders.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;

use tempfile::NamedTempFile;

use super::destination::folder_of;

const ENDING: &str = ".part";

/// A locked temporary file in the folder of `target`. Dropping it removes it. Only its owner can read it if it is `private`; if it
/// is not, it has the permissions of any new file.
pub fn create(target: &Path, private: bool) -> io::Result<NamedTempFile> {
    let prefix = format!("{}{}-", beginning(target), std::process::id());
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, if private { 0o600 } else { 0o666 });
    #[cfg(not(unix))]
    let _ = private;
    tempfile::Builder::new().prefix(&prefix).suffix(ENDING).make_in(folder_of(target), |path| {
        let file = options.open(path)?;
        // Before it is locked, another process may take it for a dead writer's. Then the next name is tried.
        let taken = || io::Error::from(io::ErrorKind::AlreadyExists);
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(taken()),
            Ok(()) if !path.exists() => Err(taken()),
            // Where the file system has no locks, nobody removes what is left.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
        }
    })
}

/// Removes the temporary files that dead writers of `target` have left, as far as possible.
pub fn remove_stale(target: &Path) {
    let beginning = beginning(target);
    let is_ours = |name: &OsStr| {
        let name = name.as_encoded_bytes();
        name.starts_with(beginning.as_bytes()) && name.ends_with(ENDING.as_bytes())
    };
    let entries = fs::read_dir(folder_of(target)).into_iter().flatten().flatten();
    // Only regular files: to open a link opens another file, and to open a pipe waits.
    let files =
        entries.filter(|entry| is_ours(&entry.file_name()) && entry.file_type().is_ok_and(|kind| kind.is_file()));
    for path in files.map(|entry| entry.path()) {
        // The lock is held until the file is gone: its writer may be about to take it.
        if let Ok(file) = open(&path)
            && file.try_lock().is_ok()
        {
            // Another process may have removed it too.
            let _ = fs::remove_file(&path);
        }
    }
}

/// A network file system locks only files that can be written to.
fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).open(path)
}

/// How the names of temporary files for `target` begin. A hash stands for its name, which may be as long as names can be.
fn beginning(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().as_encoded_bytes();
    format!(".gpu-rt-{:08x}-", crc32fast::hash(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn only_temporary_files_of_dead_writers_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.exr");
        let name = |file: &NamedTempFile| file.path().file_name().unwrap().to_string_lossy().into_owned();
        let live = create(&target, false).unwrap();
        // A process that ends gives up its lock, and leaves the file.
        let dead = |target: &Path| create(target, false).unwrap().into_temp_path().keep().unwrap();
        let (stale, of_another) = (dead(&target), dead(&folder.path().join("b.exr")));
        remove_stale(&target);
        assert!(!stale.exists());
        assert!(of_another.exists(), "it is of another target");
        assert!(live.path().exists(), "its writer lives");
        assert!(name(&live).starts_with(".gpu-rt-") && name(&live).len() < 64, "{}", name(&live));
        drop(live);
        assert_eq!(names(folder.path()).len(), 1);
    }

    /// Without the second look behind the lock, a file is removed between its creation and its lock, and its writer does not know.
    #[test]
    fn a_writer_keeps_its_file_while_others_start() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.exr");
        let done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    remove_stale(&target);
                }
            });
            for _ in 0..2000 {
                let file = create(&target, false).unwrap();
                let exists = file.path().exists();
                if !exists {
                    done.store(true, Ordering::Relaxed);
                }
                assert!(exists);
            }
            done.store(true, Ordering::Relaxed);
        });
    }
}
