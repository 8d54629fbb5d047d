//! The grids of a scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::assets::Assets;
use super::file::{self, Reading};
use super::findings::Findings;
use super::grid_files;
use super::model::Scene;
use super::types::Object;
use crate::source::ValuePath;
use crate::volume::grid::Grid;

/// The most bytes that the grids of a scene may take.
const MOST_BYTES: usize = 4 << 30;

/// The grids of a scene, by paths and names.
pub type Grids = BTreeMap<(String, String), Arc<Grid>>;

/// Reads every grid of the scene once. Errors point at the `path` field.
pub fn load_all(scene: &Scene, reading: Reading, findings: &mut Findings, assets: &mut Assets) -> Grids {
    let mut grids = Grids::new();
    let mut room = MOST_BYTES;
    let mut load = |at: &ValuePath, path: &str, name: &str| {
        let key = (path.to_owned(), name.to_owned());
        if findings.is_full() || grids.contains_key(&key) {
            return;
        }
        let file = scene.source.resolve(path);
        let files = assets.stamp_files(&file);
        let loaded = match (reading, assets.grid(&file, name, &files)) {
            (Reading::IfThere, _) => file::find(&file, "grid", file::LONGEST).map(|_| None),
            (Reading::Complete, Some(grid)) => Ok(Some(grid)),
            (Reading::Complete, None) => {
                let read =
                    file::read(&file, "grid", file::LONGEST).and_then(|bytes| grid_files::read(&bytes, name, room));
                read.map(|grid| Some(Arc::new(grid)))
            }
        };
        let loaded = loaded.map_err(|reason| at.field("path").error(format!("{}: {reason}", file.display())));
        if let Some(grid) = findings.record(loaded).flatten() {
            room = room.saturating_sub(grid.bytes());
            assets.keep_grid(&file, name, files, Arc::clone(&grid));
            grids.insert(key, grid);
        }
    };
    scene.visit_objects(&mut |at, object| {
        let Object::Medium { density, emission, .. } = object else { return };
        if let Some((path, name)) = density.grid() {
            load(&at.field("density").variant("Grid"), path, name);
        }
        if let Some((path, name)) = emission.as_ref().and_then(|emission| emission.grid()) {
            load(&at.field("emission").variant("Blackbody"), path, name);
        }
    });
    grids
}
