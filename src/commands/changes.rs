//! The files of a scene that change under `--watch`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};

use crate::commands::signals::WAIT;
use crate::error::{Error, Result};
use crate::output::destination::{folder_of, is_standard};
use crate::scene::{Stamp, stamp};

/// A save is over when the files have not changed for this long.
const CALM: Duration = Duration::from_millis(20);
/// A file counts as removed when it has been missing for this long.
const MISSING: Duration = Duration::from_secs(1);
/// The files are checked this often even if no change is reported: shared folders report none.
const PAUSE: Duration = Duration::from_secs(1);

/// Refuses to watch a scene that cannot change.
///
/// # Errors
/// `Error::Usage` for standard input.
pub fn check_watched(scene: &Path) -> Result<()> {
    let refused = "--watch: standard input does not change: give the name of a scene file";
    if is_standard(scene) { Err(Error::Usage(refused.to_owned())) } else { Ok(()) }
}

/// Detects changes of files by their stamps. Reports of the system only say when to check them: they do not show what a save is, because
/// editors save in many ways, and some replace the old file by a new one.
pub struct Changes {
    files: BTreeMap<PathBuf, Stamp>,
    /// `None` if the system does not report changes.
    system: Option<RecommendedWatcher>,
    /// The folders that the system watches.
    folders: BTreeSet<PathBuf>,
    /// Whether the system has reported a change since the files were last checked.
    stirred: Arc<AtomicBool>,
    checked: Mutex<Instant>,
    /// Whether a file has changed.
    has_changed: AtomicBool,
}

impl Changes {
    /// Wakes this thread when files change.
    pub fn new() -> Changes {
        let stirred = Arc::new(AtomicBool::new(false));
        let (noted, waiting) = (Arc::clone(&stirred), thread::current());
        let system = notify::recommended_watcher(move |_| {
            noted.store(true, Ordering::Relaxed);
            waiting.unpark();
        });
        Changes {
            files: BTreeMap::new(),
            system: system.ok(),
            folders: BTreeSet::new(),
            stirred,
            checked: Mutex::new(Instant::now()),
            has_changed: AtomicBool::new(false),
        }
    }

    /// Begins anew with these files, as they were when they were read.
    pub fn follow(&mut self, files: &BTreeMap<PathBuf, Stamp>) {
        self.files.clone_from(files);
        self.has_changed = AtomicBool::new(false);
        // A file behind a link changes in another folder.
        let real = files.keys().filter_map(|path| path.canonicalize().ok());
        let folders: BTreeSet<PathBuf> =
            files.keys().cloned().chain(real).map(|path| folder_of(&path).to_owned()).collect();
        if let Some(system) = &mut self.system {
            for folder in folders.difference(&self.folders) {
                // Where that fails, the files are looked at all the same, if less often.
                let _ = system.watch(folder, RecursiveMode::NonRecursive);
            }
            for folder in self.folders.difference(&folders) {
                let _ = system.unwatch(folder);
            }
        }
        self.folders = folders;
        // Changes since the files were read have not been reported.
        self.stirred.store(true, Ordering::Relaxed);
    }

    /// Whether a file has changed. Any thread may call it at any time.
    pub fn have_changed(&self) -> bool {
        if self.has_changed.load(Ordering::Relaxed) {
            return true;
        }
        let mut checked = self.checked.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.stirred.swap(false, Ordering::Relaxed) && checked.elapsed() < PAUSE {
            return false;
        }
        *checked = Instant::now();
        let changed = self.files.iter().any(|(path, before)| stamp(path) != *before);
        self.has_changed.fetch_or(changed, Ordering::Relaxed);
        changed
    }

    /// Waits until a file has changed and the save is over, or until `ends`. The result is the files that have changed, and when that was noted.
    pub fn wait(&self, ends: impl Fn() -> bool) -> Option<(Vec<&Path>, Instant)> {
        while !self.have_changed() {
            if ends() {
                return None;
            }
            thread::park_timeout(WAIT);
        }
        let noted = Instant::now();
        let mut before = self.stamps();
        loop {
            if ends() {
                return None;
            }
            thread::sleep(CALM);
            let now = self.stamps();
            let is_missing = self.files.values().zip(&now).any(|(known, now)| known.is_some() && now.is_none());
            if now == before && (!is_missing || noted.elapsed() > MISSING) {
                let changed = self.files.iter().zip(&now).filter(|((_, known), now)| *known != *now);
                return Some((changed.map(|((path, _), _)| path.as_path()).collect(), noted));
            }
            before = now;
        }
    }

    fn stamps(&self) -> Vec<Stamp> {
        self.files.keys().map(|path| stamp(path)).collect()
    }
}
