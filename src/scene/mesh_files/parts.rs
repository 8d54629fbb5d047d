//! The OBJ files that are open while a scene is read, so that each is read once, however many materials it has.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::input::Input;
use super::obj;
use crate::scene::draft::MOST_BYTES;
use crate::scene::file::{self, OnProgress};
use crate::shape::mesh::Mesh;

#[derive(Default)]
pub struct ObjFiles(HashMap<PathBuf, Arc<Parts>>);

/// The parts of a file by their materials.
pub struct Parts {
    /// Each with the bytes that reading it took. None of a part without area.
    pub meshes: Vec<(Option<Arc<Mesh>>, usize)>,
    pub materials: Vec<Option<obj::Named>>,
    pub libraries: Vec<obj::Named>,
}

impl ObjFiles {
    pub fn open(&mut self, path: &Path, progress: &mut OnProgress) -> Result<Arc<Parts>, String> {
        if let Some(open) = self.0.get(path) {
            return Ok(Arc::clone(open));
        }
        let bytes = file::read(path, "mesh", file::LONGEST)?;
        let total = bytes.len() as u64;
        let mut tell = |done: usize| progress(path, done as u64, total);
        let obj::Contents { parts, libraries } = obj::read(&mut Input::new(&bytes, &mut tell), MOST_BYTES, true)?;
        let (mut meshes, mut materials) = (Vec::new(), Vec::new());
        let mut reason = "it has no faces: expected at least one of three corners or more".to_owned();
        for obj::Part { material, draft, .. } in parts {
            let taken = draft.taken();
            meshes.push((draft.finish().map_err(|wrong| reason = wrong).ok().map(Arc::new), taken));
            materials.push(material);
        }
        if meshes.iter().all(|(mesh, _)| mesh.is_none()) {
            return Err(reason);
        }
        let open = Arc::new(Parts { meshes, materials, libraries });
        self.0.insert(path.to_owned(), Arc::clone(&open));
        Ok(open)
    }
}
