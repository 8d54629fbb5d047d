//! The scene, scaled and moved.

use crate::common::everything::{Everything, World, same};
use crate::common::render::{Request, Shot, render, worst_difference};
use crate::common::stats::{normal_two_sided, one_sample_t, student_two_sided};
use crate::table::Cell;

pub fn powers_of_two() -> Vec<Cell> {
    let files = Everything::new();
    let shot = |world: World| render(&files.scene(world), &Request::spp(16));
    let usual = shot(World::default());
    let differs = |other: &Shot| f64::from(u8::from(!same(&usual, other)));
    [-40, -13, 13, 40]
        .map(|exponent| {
            let world = World { scale: 2f64.powi(exponent), ..World::default() };
            let moved = World { camera_shift: 1e-6, ..world };
            Cell::new(
                format!("2^{exponent}"),
                "Whether any bit of the image differs, for a scene with every feature",
                0.0,
                "none, because the host scales the scene to an extent of 1 by a power of two, in f64: kernels read the same numbers.",
            )
            .achieved(differs(&shot(world)))
            .planted("camera moved by a millionth", differs(&shot(moved)))
        })
        .into()
}

/// The scene that the others are compared with.
fn usual() -> World {
    World { lamp: 0.1, ..World::default() }
}

/// Other scales and positions round the scene's numbers otherwise, so that some paths differ. At 1e8 the scene is stored
/// to 1.5e-8 of its unit.
///
/// The seed is that of the usual scene, so that what both have alike cancels: of their pixels' differences, over tiles
/// of 8 x 8 pixels and the full image, Student's test says whether their mean is none, but for 1e-5 of the value. The
/// lamp is dim here, and makes about a tenth of the light: a lamp that is brighter by a twentieth is half a percent of
/// it. A camera that is moved by a fiftieth of its distance moves light from pixel to pixel: the images as if of two
/// seeds tell that, of whose tiles the means' difference has a standard error of 0.7 % up to 1.8 %. (What both have
/// alike makes that test the safer.)
fn differences(worlds: impl Iterator<Item = (String, World)>) -> Vec<Cell> {
    const FIGURE: &str = "Largest difference from the scene at scale 1 and the origin, with the same seed, over tiles and the whole \
                          image, in standard deviations";
    const BECAUSE: &str = "noise alone: the largest of 78 normal variates exceeds the limit once in 1e6 (Šidák).";
    let files = Everything::new();
    let shot = |world: World| render(&files.scene(world), &Request::spp(256).size(32, 24).seed(10));
    let usual = shot(self::usual());
    let off = |world: World| {
        let other = shot(world);
        worst_paired(&usual, &other).max(worst_difference(&usual, &other, 1e-5).z)
    };
    let limit = chance_limit(78);
    let mut all = Vec::new();
    for (range, world) in worlds {
        let mut cell = Cell::new(range, FIGURE, limit, BECAUSE).achieved(off(world));
        if world.shift[1] == 1e8 || world.scale == 1e6 {
            cell = cell
                .planted("camera moved by a fiftieth of its distance", off(World { camera_shift: 0.1, ..world }))
                .planted("lamp brighter by a twentieth", off(World { lamp: 0.105, ..world }));
        }
        all.push(cell);
    }
    all
}

/// Of the means of the pixels' differences the one that is least likely to be by chance, as a deviation of a normal variate.
fn worst_paired(usual: &Shot, other: &Shot) -> f64 {
    const ROUNDING: f64 = 1e-5;
    let (width, height) = (usual.picture.width, usual.picture.height);
    let tiles = (0..height / 8).flat_map(|y| (0..width / 8).map(move |x| (8 * x, 8 * y, 8, 8)));
    let areas = std::iter::once((0, 0, width, height)).chain(tiles);
    let worst =
        areas.flat_map(|area| (0..3).map(move |channel| (area, channel))).map(|((left, top, w, h), channel)| {
            let pixels = (top..top + h).flat_map(|y| (left..left + w).map(move |x| (y * width + x) as usize));
            let value = |shot: &Shot, pixel: usize| f64::from(shot.picture.rgb[pixel][channel]);
            let values: Vec<[f64; 2]> = pixels.map(|pixel| [value(usual, pixel), value(other, pixel)]).collect();
            let differences: Vec<f64> = values.iter().map(|[a, b]| b - a).collect();
            let sum: f64 = values.iter().map(|[a, _]| a).sum();
            let found = one_sample_t(&differences, 0.0);
            let excess = (found.difference.abs() - ROUNDING * sum / values.len() as f64).max(0.0);
            if excess == 0.0 { 1.0 } else { student_two_sided(found.t * excess / found.difference, found.degrees) }
        });
    deviation(worst.fold(1.0, f64::min))
}

/// The deviation that a normal variate exceeds, either way, with such a probability.
fn deviation(p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if normal_two_sided(middle) > p { low = middle } else { high = middle }
    }
    high
}

/// The number of standard errors that the largest of so many normal variates exceeds once in a million.
pub fn chance_limit(compared: usize) -> f64 {
    deviation(crate::common::stats::sidak(1e-6, compared))
}

pub fn scales() -> Vec<Cell> {
    let scaled = |scale| (format!("{scale:.1e}"), World { scale, ..usual() });
    differences([1e-6, 1e-7 / 3.0, 1e3, 1e6].into_iter().map(scaled))
}

pub fn positions() -> Vec<Cell> {
    let moved = |far: f64| {
        let shift = [-far / 3.0, far, -0.7 * far];
        (format!("({:.1e}, {:.1e}, {:.1e})", shift[0], shift[1], shift[2]), World { shift, ..usual() })
    };
    differences([1e3, 1e6, 1e8].into_iter().map(moved))
}
