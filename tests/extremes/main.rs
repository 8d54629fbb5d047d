//! What happens to the numbers at the extremes: a table of cells, each with a range of inputs, an oracle, a limit and the figure that
//! was achieved. docs/dev/extremes.tsv is what a run wrote, and declares the cells: one that is missing, or that is not there, fails the run.
//! Figures are not compared, since they depend on the driver. `GPU_RT_RENEW=1` writes it anew.
//!
//! Cells of functions run kernels that import the shader files that render, and compare with f64; cells of scenes compare renders with
//! closed forms or with each other.

#[path = "../common/mod.rs"]
mod common;

mod albedo;
mod basis;
mod crowds;
mod cuboid;
mod degenerate;
mod film;
mod fresnel;
mod fuzz;
mod geometry;
mod instance;
mod lights;
mod media;
mod noise;
mod positions;
mod quad;
mod rejection;
mod roughness;
mod sphere;
mod table;
mod triangle;
mod uniforms;
mod views;

use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::device;
use table::{COMPARED_NAN, Cell, FILE, FORMS, PAGE, faults, file, page};

type Filler = fn() -> Vec<Cell>;

/// Who fills cells.
const CELLS: &[Filler] = &[
    sphere::distances,
    sphere::on_the_axis,
    sphere::leavings,
    sphere::grazing,
    quad::cells,
    cuboid::cells,
    triangle::cells,
    instance::cells,
    basis::cells,
    geometry::gaps,
    geometry::gaps_by_rays,
    geometry::distances,
    geometry::radii,
    geometry::grazing,
    geometry::on_surfaces,
    geometry::inside_glass,
    geometry::inside_media,
    crowds::cells,
    positions::powers_of_two,
    positions::scales_and_positions,
    views::fields_of_view,
    views::telescopes,
    views::lenses,
    views::sizes,
    film::means,
    film::constants,
    film::variances,
    rejection::cells,
    fresnel::cells,
    fuzz::cells,
    roughness::cells,
    albedo::cells,
    media::depths_of_words,
    media::shares,
    media::free_paths,
    media::black_slabs,
    media::bright_slabs,
    media::cosines,
    media::directions,
    media::densities,
    lights::densities,
    lights::irradiances,
    lights::floors,
    lights::radiances,
    lights::rooms,
    uniforms::cells,
    noise::values,
    noise::seams,
    noise::far_objects,
    degenerate::cells,
];

#[test]
fn every_cell_is_within_its_limit() {
    let cells = run(CELLS);
    let text = file(&cells);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if common::renew() {
        fs::write(root.join(FILE), &text).expect("the file can be written");
        fs::write(root.join(PAGE), page(&cells, &device::software().name.driver)).expect("the page can be written");
    }
    let wanted = fs::read_to_string(root.join(FILE)).expect("the file can be read");
    // A driver without the flaw that makes a form wrong shows nothing of it.
    let shown = |form: &&&str| **form != COMPARED_NAN || rejection::folds();
    let forms: Vec<&str> = FORMS.iter().filter(shown).copied().collect();
    let faults = faults(&cells, &text, &wanted, &forms);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// All cells, in the order of the list, on two threads: the host's part of one goes on while the device has the other's.
fn run(fillers: &[Filler]) -> Vec<Cell> {
    let next = AtomicUsize::new(0);
    let found: Vec<Mutex<Vec<Cell>>> = fillers.iter().map(|_| Mutex::default()).collect();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((fill, cell)) = take(fillers, &found, next.fetch_add(1, Ordering::Relaxed)) {
                    *cell.lock().expect("nobody panics with it") = fill();
                }
            });
        }
    });
    found.into_iter().flat_map(|cells| cells.into_inner().expect("every thread has ended well")).collect()
}

fn take<'a>(
    fillers: &'a [Filler],
    found: &'a [Mutex<Vec<Cell>>],
    index: usize,
) -> Option<(&'a Filler, &'a Mutex<Vec<Cell>>)> {
    Some((fillers.get(index)?, found.get(index)?))
}
