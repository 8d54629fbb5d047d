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
mod projections;
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

/// The rows, and who fills the cells of each. Every row must have the cells that the file declares, or the run fails.
const ROWS: &[(&str, &[Filler])] = &[
    ("scale of the scene", &[positions::powers_of_two, positions::scales, projections::powers_of_two]),
    ("position of the scene", &[positions::positions, projections::positions]),
    ("distance over radius, D/r", &[sphere::distances, sphere::on_the_axis, geometry::distances, views::telescopes]),
    ("radius", &[geometry::radii]),
    (
        "rays that leave a surface",
        &[sphere::leavings, quad::leavings, cuboid::leavings, triangle::leavings, instance::cells],
    ),
    ("gaps between surfaces", &[geometry::gaps, geometry::gaps_by_rays]),
    (
        "grazing hits",
        &[
            sphere::grazing,
            quad::grazed,
            quad::floors_grazed,
            quad::leaving_and_grazing,
            cuboid::grazing,
            triangle::grazing,
            geometry::grazing,
        ],
    ),
    ("index of refraction", &[fresnel::cells]),
    ("fuzz", &[fuzz::cells]),
    ("roughness", &[roughness::cells]),
    ("albedo and depth", &[albedo::cells]),
    (
        "optical depth",
        &[media::depths_of_words, media::shares, media::free_paths, media::black_slabs, media::bright_slabs],
    ),
    ("anisotropy", &[media::cosines, media::directions, media::densities]),
    ("size of a light over its distance, r/D", &[lights::densities, lights::irradiances, lights::floors]),
    ("radiance", &[lights::radiances, lights::rooms]),
    ("vertical_fov", &[views::fields_of_view, projections::fisheyes]),
    ("aperture", &[views::apertures]),
    ("focus_distance", &[views::focuses]),
    ("bases around a normal", &[basis::cells]),
    ("random numbers at their ends", &[uniforms::cells]),
    ("Perlin noise far out", &[noise::values, noise::seams, noise::far_objects]),
    ("number of objects", &[crowds::cells]),
    ("cameras on surfaces and in objects", &[geometry::on_surfaces, geometry::inside_glass, geometry::inside_media]),
    ("size of the image", &[views::sizes]),
    ("number of samples", &[film::means, film::constants, film::variances]),
    ("samples that are not finite", &[rejection::cells]),
    ("degenerate scenes", &[degenerate::cells]),
];

#[test]
fn every_cell_is_within_its_limit() {
    let cells = run();
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
fn run() -> Vec<Cell> {
    let fillers: Vec<_> = ROWS.iter().flat_map(|(row, fillers)| fillers.iter().map(move |fill| (row, fill))).collect();
    let next = AtomicUsize::new(0);
    let found: Vec<Mutex<Vec<Cell>>> = fillers.iter().map(|_| Mutex::default()).collect();
    let fill_all = || {
        while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|index| *index < fillers.len()) {
            let (row, fill) = fillers[index];
            let cells = fill().into_iter().map(|cell| Cell { row, ..cell });
            *found[index].lock().expect("nobody panics with it") = cells.collect();
        }
    };
    std::thread::scope(|scope| (0..2).for_each(|_| _ = scope.spawn(fill_all)));
    found.into_iter().flat_map(|cells| cells.into_inner().expect("every thread has ended well")).collect()
}
