//! Temporary files, each in the folder of the file that it replaces.
//!
//! Where the system can, such a file has no name until it is complete: if its writer dies before, however it dies, nothing is left. Then it
//! has the name of its target, at once if no file has that name. Elsewhere, as on network file systems, it has a name from the start, and its writer holds a lock on it, which the system gives up when the writer
//! dies. So a temporary file without a lock was left by a dead writer. A process number would not show that, because hosts share folders.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;
use std::time::Duration;

use tempfile::TempPath;

use super::destination::folder_of;

const ENDING: &str = ".part";
/// How all names of temporary files begin.
const BEGINNING: &str = ".gpu-rt-";
/// A temporary file of another target is removed after this time, if no writer holds its lock. Some file systems do not show the locks of other
/// hosts, but no writer takes this long.
const OLD: Duration = Duration::from_secs(3600);

/// A temporary file. Dropping it removes it.
#[derive(Debug)]
pub struct Temporary {
    pub file: File,
    /// `None` if it has no name yet.
    path: Option<TempPath>,
}

impl Temporary {
    /// A temporary file in the folder of `target`. Only its owner can read it if it is `private`; if it is not, it has the permissions
    /// of any new file.
    pub fn create(target: &Path, private: bool) -> io::Result<Temporary> {
        let mut options = OpenOptions::new();
        options.read(true).write(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, if private { 0o600 } else { 0o666 });
        #[cfg(not(unix))]
        let _ = private;
        #[cfg(target_os = "linux")]
        if let Some(file) = nameless::create(folder_of(target), options.clone()) {
            return Ok(Temporary { file, path: None });
        }
        Temporary::named(target, options)
    }

    /// A temporary file that has a name from the start, and a lock.
    fn named(target: &Path, mut options: OpenOptions) -> io::Result<Temporary> {
        options.create_new(true);
        let named = with_name(target, |path| {
            let file = options.open(path)?;
            // Before it is locked, another process may take it for a dead writer's. Then the next name is tried.
            let taken = || io::Error::from(io::ErrorKind::AlreadyExists);
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => Err(taken()),
                Ok(()) if !path.exists() => Err(taken()),
                // Where the file system has no locks, nobody removes what is left.
                Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
            }
        })?;
        let (file, path) = named.into_parts();
        Ok(Temporary { file, path: Some(path) })
    }

    /// Gives it the name of its target, in place of the file that has it.
    pub fn persist(self, target: &Path) -> io::Result<()> {
        let path = match self.path {
            Some(path) => path,
            // A link replaces no file. Where there is none to replace, the file never has a temporary name.
            #[cfg(target_os = "linux")]
            None if nameless::link(&self.file, target).is_ok() => return Ok(()),
            #[cfg(target_os = "linux")]
            None => with_name(target, |path| nameless::link(&self.file, path))?.into_temp_path(),
            #[cfg(not(target_os = "linux"))]
            None => return Err(io::ErrorKind::Unsupported.into()),
        };
        path.persist(target).map_err(|error| error.error)
    }
}

/// Calls `make` with a new name in the folder of `target`, and with another one if that name is taken. Returns what it makes.
fn with_name<T>(target: &Path, make: impl FnMut(&Path) -> io::Result<T>) -> io::Result<tempfile::NamedTempFile<T>> {
    let prefix = format!("{}{}-", beginning(target), std::process::id());
    tempfile::Builder::new().prefix(&prefix).suffix(ENDING).make_in(folder_of(target), make)
}

/// Files without a name.
#[cfg(target_os = "linux")]
mod nameless {
    use std::fs::{File, OpenOptions};
    use std::io;
    use std::os::fd::AsRawFd;
    use std::os::unix::fs::OpenOptionsExt;
    use std::path::{Path, PathBuf};

    use rustix::fs::{AtFlags, CWD, OFlags, linkat};

    /// Creates one in a folder. `None` if the file system has no such files, or if they cannot get a name later.
    pub fn create(folder: &Path, mut options: OpenOptions) -> Option<File> {
        let file = options.custom_flags(OFlags::TMPFILE.bits() as i32).open(folder).ok()?;
        path_of(&file).exists().then_some(file)
    }

    /// Gives it a name, which no file has. Like a file that is named from the start, it is locked before.
    pub fn link(file: &File, path: &Path) -> io::Result<()> {
        let _ = file.try_lock();
        Ok(linkat(CWD, path_of(file), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
    }

    /// The system's own path of an open file. (A file without a name can only be linked by it, unless by root.)
    fn path_of(file: &File) -> PathBuf {
        format!("/proc/self/fd/{}", file.as_raw_fd()).into()
    }
}

/// Removes the temporary files that dead writers have left, as far as possible: those of `target`, and old ones of others in its folder.
pub fn remove_stale(target: &Path) {
    let beginning = beginning(target);
    let is_temporary = |name: &OsStr, beginning: &str| {
        let name = name.as_encoded_bytes();
        name.starts_with(beginning.as_bytes()) && name.ends_with(ENDING.as_bytes())
    };
    let is_old = |entry: &fs::DirEntry| {
        let age = entry.metadata().and_then(|found| found.modified()).map(|time| time.elapsed().unwrap_or_default());
        age.is_ok_and(|age| age > OLD)
    };
    let is_stale = |entry: &fs::DirEntry| {
        let name = entry.file_name();
        is_temporary(&name, &beginning) || is_temporary(&name, BEGINNING) && is_old(entry)
    };
    let entries = fs::read_dir(folder_of(target)).into_iter().flatten().flatten();
    // Only regular files: to open a link opens another file, and to open a pipe waits.
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()) && is_stale(entry));
    for path in files.map(|entry| entry.path()) {
        // The lock is held until the file is gone: its writer may be about to take it.
        // A network file system locks only files that can be written to.
        if let Ok(file) = OpenOptions::new().read(true).write(true).open(&path)
            && file.try_lock().is_ok()
        {
            // Another process may have removed it too.
            let _ = fs::remove_file(&path);
        }
    }
}

/// How the names of temporary files for `target` begin. A hash stands for its name, which may be as long as names can be.
fn beginning(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().as_encoded_bytes();
    format!("{BEGINNING}{:08x}-", crc32fast::hash(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// One as file systems have it that know no files without a name.
    fn named(target: &Path) -> Temporary {
        Temporary::named(target, OpenOptions::new().read(true).write(true).clone()).unwrap()
    }

    fn path(temporary: &Temporary) -> &Path {
        temporary.path.as_deref().unwrap()
    }

    /// What is left where a process dies: it gives up its lock.
    fn dead(target: &Path) -> std::path::PathBuf {
        named(target).path.unwrap().keep().unwrap()
    }

    #[test]
    fn only_temporary_files_of_dead_writers_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let (target, other) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
        let live = [named(&target), named(&other)];
        let (stale, of_another, old) = (dead(&target), dead(&other), dead(&other));
        let long_ago = std::time::SystemTime::now() - 2 * OLD;
        let age = |path: &Path| File::options().write(true).open(path).and_then(|file| file.set_modified(long_ago));
        age(&old).unwrap();
        age(path(&live[1])).unwrap();
        // Not ours.
        let theirs = [".gpu-rt-notes", "old.part"].map(|name| folder.path().join(name));
        for path in &theirs {
            fs::write(path, "").unwrap();
            age(path).unwrap();
        }
        remove_stale(&target);
        assert!(!stale.exists() && !old.exists());
        assert!(of_another.exists(), "it is of another target, and not old");
        assert!(live.iter().all(|live| path(live).exists()), "their writers live");
        assert!(theirs.iter().all(|path| path.exists()));
        let name = path(&live[0]).file_name().unwrap().to_string_lossy().into_owned();
        assert!(name.starts_with(".gpu-rt-") && name.len() < 64, "{name}");
        drop(live);
        assert_eq!(names(folder.path()).len(), 3);
    }

    /// Both kinds replace the old file, and leave nothing else, also where they are dropped.
    #[test]
    fn a_temporary_file_becomes_its_target() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.exr");
        let nameless = |target: &Path| Temporary::create(target, false).unwrap();
        for create in [nameless, named] {
            fs::write(&target, "old").unwrap();
            let temporary = create(&target);
            let is_named = temporary.path.is_some();
            assert_eq!(names(folder.path()).len(), 1 + usize::from(is_named));
            io::Write::write_all(&mut &temporary.file, b"new").unwrap();
            // Another writer starts before it has its name, and while it has a temporary one.
            remove_stale(&target);
            temporary.persist(&target).unwrap();
            assert_eq!(fs::read_to_string(&target).unwrap(), "new");
            drop(Temporary::create(&target, true).unwrap());
            drop(named(&target));
            assert_eq!(names(folder.path()), ["a.exr"]);
        }
    }

    /// A kill leaves nothing, because there is no name to leave.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_has_no_name_until_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.exr");
        let temporary = Temporary::create(&target, false).unwrap();
        // The system's temporary folder may be on a file system that has no such files.
        let mut options = OpenOptions::new();
        let is_possible = nameless::create(folder.path(), options.read(true).write(true).clone()).is_some();
        assert_eq!(names(folder.path()).is_empty(), is_possible);
        temporary.persist(&target).unwrap();
        assert_eq!(names(folder.path()), ["a.exr"]);
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
                let exists = path(&named(&target)).exists();
                // One that gets its name at the end keeps it until it has that of its target.
                let persisted = Temporary::create(&target, false).and_then(|temporary| temporary.persist(&target));
                if !exists || persisted.is_err() {
                    done.store(true, Ordering::Relaxed);
                }
                assert!(exists && persisted.is_ok(), "{persisted:?}");
            }
            done.store(true, Ordering::Relaxed);
        });
    }
}
