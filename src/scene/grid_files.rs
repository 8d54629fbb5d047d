//! Grids of numbers from files.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::assets::Assets;
use super::file::{self, Reading};
use super::findings::Findings;
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
                let read = file::read(&file, "grid", file::LONGEST).and_then(|bytes| read(&bytes, name, room));
                read.map(|grid| Some(Arc::new(grid)))
            }
        };
        let loaded = loaded.map_err(|reason| at.field("path").error(&format!("{}: {reason}", file.display())));
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

fn read(bytes: &[u8], _name: &str, _most_bytes: usize) -> Result<Grid, String> {
    use crate::volume::grid::Leaf;
    use glam::*;
    let text = String::from_utf8_lossy(bytes);
    let n: Vec<f64> = text.split_whitespace().map(|x| x.parse().unwrap()).collect();
    let (dx, dy, dz) = (n[0] as i32, n[1] as i32, n[2] as i32);
    let o = IVec3::new(n[3] as i32, n[4] as i32, n[5] as i32);
    let mut grid =
        Grid { background: n[7] as f32, to_own: DAffine3::from_scale(DVec3::splat(n[6])), ..Default::default() };
    grid.active = Some((o, o + IVec3::new(dx, dy, dz) - 1));
    let mut leaves: std::collections::BTreeMap<[i32; 3], Box<[f32; 512]>> = Default::default();
    for x in 0..dx {
        for y in 0..dy {
            for z in 0..dz {
                let v = n[8 + ((x * dy + y) * dz + z) as usize] as f32;
                let p = o + IVec3::new(x, y, z);
                let l = p.map(|c| c.div_euclid(8) * 8);
                let w = p - l;
                leaves.entry(l.to_array()).or_insert_with(|| Box::new([n[7] as f32; 512]))
                    [(w.x * 64 + w.y * 8 + w.z) as usize] = v;
            }
        }
    }
    grid.leaves = leaves.into_iter().map(|(lower, values)| Leaf { lower: lower.into(), values }).collect();
    Ok(grid)
}
