//! The images and meshes that a scene was read with. If it is read again, those whose files have not changed are taken from here.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use super::gltf;
use super::gltf_path::split;
use super::inputs::{Input, buffers};
use super::mesh_files::ObjFiles;
use crate::bitmap::{Bitmap, Decoding};
use crate::shape::mesh::Mesh;
use crate::volume::grid::Grid;

/// The stamp of a file, which shows that it has changed: the time of its last write, its length, and its inode, which another file of its name would not
/// have. `None` if there is no file.
pub type Stamp = Option<(SystemTime, u64, u64)>;

/// The stamp of a file as it is now.
pub fn stamp(path: &Path) -> Stamp {
    let found = std::fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len(), number(&found)))
}

#[cfg(unix)]
fn number(found: &std::fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(found)
}

#[cfg(not(unix))]
fn number(_: &std::fs::Metadata) -> u64 {
    0
}

/// Decoded images of one file.
pub type Decoded = Vec<(Decoding, Bitmap)>;

/// The images and meshes of a scene, by their paths: of files, or of parts of glTF files.
#[derive(Default)]
pub struct Assets {
    bitmaps: HashMap<PathBuf, Kept<Decoded>>,
    /// With the bytes of memory that reading each took of the room that there was.
    meshes: HashMap<PathBuf, Kept<(Arc<Mesh>, usize)>>,
    /// By their names in the files, too.
    grids: HashMap<(PathBuf, String), Kept<Arc<Grid>>>,
    /// The files that the scene was read from, also those that are missing, as they were before they were read.
    pub files: BTreeMap<PathBuf, Stamp>,
    /// How many images and meshes have been read since the start.
    pub read: usize,
    /// The images and meshes that the scene names.
    named: HashSet<PathBuf>,
    /// What the files are, as they were noted: each names those that are read with it.
    noted: HashMap<PathBuf, Vec<(PathBuf, Stamp)>>,
    /// The glTF files that parts are read from.
    pub(super) gltf: gltf::Files,
    /// The OBJ files that parts are read from.
    pub(super) obj: ObjFiles,
    /// Whether these stay open from one scene to the next.
    keeps_open: bool,
}

struct Kept<T> {
    what: T,
    /// Its files, as they were before it was read.
    files: Vec<(PathBuf, Stamp)>,
}

impl Assets {
    /// For the frames of one glTF file, which is read once: the scene has the file as it was at the first frame.
    pub fn of_frames() -> Assets {
        Assets { keeps_open: true, ..Assets::default() }
    }

    /// Begins to read a scene.
    pub(super) fn begin(&mut self, scene: &Path) {
        self.files = BTreeMap::from([(scene.to_owned(), stamp(scene))]);
        self.named.clear();
        self.noted.clear();
        self.close();
    }

    /// Closes the files that are read from no more.
    pub(super) fn close(&mut self) {
        if !self.keeps_open {
            self.gltf = gltf::Files::default();
            self.obj = ObjFiles::default();
        }
    }

    /// Ends it: what the scene does not name is dropped.
    pub(super) fn end(&mut self) {
        let Assets { bitmaps, meshes, grids, named, .. } = self;
        bitmaps.retain(|path, _| named.contains(path));
        meshes.retain(|path, _| named.contains(path));
        grids.retain(|(path, _), _| named.contains(path));
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.bitmaps.len() + self.meshes.len() + self.grids.len()
    }

    /// Records that the scene names a file, or a part of one. The result is the file and those that it names, as they are.
    pub(super) fn stamp_files(&mut self, path: &Path) -> Vec<(PathBuf, Stamp)> {
        self.named.insert(path.to_owned());
        let path = split(path).0.into_owned();
        if let Some(files) = self.noted.get(&path) {
            return files.clone();
        }
        let file = Input { path: path.clone(), fixed: false };
        let others = buffers(&file).into_iter().map(|buffer| buffer.path);
        let files: Vec<_> = others.chain([file.path]).map(|path| (stamp(&path), path)).map(|(s, p)| (p, s)).collect();
        self.files.extend(files.iter().cloned());
        self.noted.insert(path, files.clone());
        files
    }

    /// An image, if its file is as it was, and was decoded in all ways that are wanted.
    pub(super) fn bitmaps(
        &self,
        path: &Path,
        files: &[(PathBuf, Stamp)],
        wanted: &BTreeSet<Decoding>,
    ) -> Option<Decoded> {
        let kept = kept(&self.bitmaps, path, files)?;
        let found: Decoded = kept.iter().filter(|(decoding, _)| wanted.contains(decoding)).cloned().collect();
        (found.len() == wanted.len()).then_some(found)
    }

    /// A mesh, if its files are as they were, and the bytes that reading it took.
    pub(super) fn mesh(&self, path: &Path, files: &[(PathBuf, Stamp)]) -> Option<(Arc<Mesh>, usize)> {
        kept(&self.meshes, path, files).cloned()
    }

    /// A grid, if its file is as it was.
    pub(super) fn grid(&self, path: &Path, name: &str, files: &[(PathBuf, Stamp)]) -> Option<Arc<Grid>> {
        kept(&self.grids, &(path.to_owned(), name.to_owned()), files).cloned()
    }

    pub(super) fn keep_grid(&mut self, path: &Path, name: &str, files: Vec<(PathBuf, Stamp)>, what: Arc<Grid>) {
        self.read += 1;
        self.grids.insert((path.to_owned(), name.to_owned()), Kept { what, files });
    }

    pub(super) fn keep_bitmaps(&mut self, path: &Path, files: Vec<(PathBuf, Stamp)>, what: Decoded) {
        self.read += 1;
        self.bitmaps.insert(path.to_owned(), Kept { what, files });
    }

    pub(super) fn keep_mesh(&mut self, path: &Path, files: Vec<(PathBuf, Stamp)>, what: (Arc<Mesh>, usize)) {
        self.read += 1;
        self.meshes.insert(path.to_owned(), Kept { what, files });
    }
}

/// What is kept of a file, if its files are as they were.
fn kept<'a, K: Eq + Hash + Borrow<Q>, Q: Eq + Hash + ?Sized, T>(
    all: &'a HashMap<K, Kept<T>>,
    key: &Q,
    files: &[(PathBuf, Stamp)],
) -> Option<&'a T> {
    all.get(key).filter(|kept| kept.files == files).map(|kept| &kept.what)
}
