//! The scene as a whole, scaled and moved.

use crate::everything::{Everything, World, same};
use crate::render::{Ask, Shot, render, worst_difference};
use crate::stats::normal_two_sided;
use crate::table::{Cell, Row};

/// The table's cells of scales and places.
pub fn cells() -> Vec<Cell> {
    let mut all = powers_of_two();
    all.extend(scales_and_places());
    all
}

fn powers_of_two() -> Vec<Cell> {
    let files = Everything::new();
    let shot = |world: World| render(&files.scene(world), &Ask::spp(16));
    let usual = shot(World::default());
    let differs = |other: &Shot| f64::from(u8::from(!same(&usual, other)));
    [-40, -13, 13, 40]
        .map(|exponent| {
            let world = World { scale: 2f64.powi(exponent), ..World::default() };
            let moved = World { camera_shift: 1e-6, ..world };
            Cell::new(
                Row::Scale,
                format!("2^{exponent}"),
                "Whether any bit of the image of a scene with everything in it differs",
                0.0,
                "The host scales to an extent of 1 by a power of two, in f64: every number that kernels see is the same.",
            )
            .achieved(differs(&shot(world)))
            .planted("camera moved by a millionth", differs(&shot(moved)))
        })
        .into()
}

/// Other scales and places round the scene's numbers otherwise, so that some paths differ: other seeds and a statistical test tell
/// whether the image does. At 1e8 the scene is stored to 1.5e-8 of its unit.
///
/// The lamp is dim here, for little noise. The difference of two tiles of 8 x 8 pixels has a standard error of 0.7 % of them, up to 1.8 %
/// where the lamp is near (measured), so that 4 to 10 % of any tile are found, and 1.5 % of the whole. A camera moved by 0.1, a
/// fiftieth of its distance, changes the tiles with edges by more, and so does a lamp that is brighter by a half.
fn scales_and_places() -> Vec<Cell> {
    const FIGURE: &str = "Largest difference from the scene at scale 1 and the origin, over tiles and the whole image, in standard errors";
    const BECAUSE: &str = "A normal variate of 39 is above it once in 1e6 (Šidák): differences by noise alone.";
    let files = Everything::new();
    let usual_world = World { lamp: 0.1, ..World::default() };
    let shot = |world: World, seed| render(&files.scene(world), &Ask::spp(256).size(32, 24).seed(seed));
    let usual = shot(usual_world, 10);
    let off = |world: World, seed| worst_difference(&usual, &shot(world, seed), 1e-5).z;
    let limit = chance_limit(39);
    let scaled =
        [1e-6, 1e-7 / 3.0, 1e3, 1e6].map(|scale| (Row::Scale, format!("{scale:.1e}"), World { scale, ..usual_world }));
    let moved = [1e3, 1e6, 1e8].map(|far| {
        let shift = [-far / 3.0, far, -0.7 * far];
        (Row::Offset, format!("({:.1e}, {:.1e}, {:.1e})", shift[0], shift[1], shift[2]), World { shift, ..usual_world })
    });
    let mut all = Vec::new();
    for (seed, (row, range, world)) in (11..).zip(scaled.into_iter().chain(moved)) {
        let mut cell = Cell::new(row, range, FIGURE, limit, BECAUSE).achieved(off(world, seed));
        if world.shift[1] == 1e8 || world.scale == 1e6 {
            cell = cell
                .planted("camera moved by a fiftieth of its distance", off(World { camera_shift: 0.1, ..world }, 13))
                .planted("lamp brighter by a half", off(World { lamp: 0.15, ..world }, 13));
        }
        all.push(cell);
    }
    all
}

/// The number of standard errors that the largest of so many normal variates exceeds once in a million.
pub fn chance_limit(compared: usize) -> f64 {
    let threshold = crate::stats::sidak(1e-6, compared);
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if normal_two_sided(middle) > threshold { low = middle } else { high = middle }
    }
    high
}
