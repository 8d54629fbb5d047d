//! lib/sampling: chi-square of every map against its density, and the ends of the unit interval.

use std::f64::consts::{PI, TAU};

use crate::common::kernel::Kernel;
use crate::common::rows::Maps as Out;
use crate::common::stats::{Random, bin, chi_square, sidak};
use crate::common::vectors::{U, exact};

/// Cells, odd in number so that no symmetry of the map hides in their edges.
const RINGS: usize = 31;
const SECTORS: usize = 17;
const SHELLS: usize = 5;

/// Draws of each map. Chi-square of 31 x 17 cells over 2^19 draws finds a density that is off by 2.3 % in the root mean
/// square with a probability of 99.9 %.
const DRAWS: usize = 1 << 19;

/// Counts of draws by a share in 0..1 and an angle, and by a second share if `shells` is not 1; all cells are as likely.
fn uniform_cells(draws: impl Iterator<Item = (f64, f64, f64)>, shells: usize) -> f64 {
    let mut cells = vec![0u64; RINGS * SECTORS * shells];
    for (share, angle, shell) in draws {
        let at = bin(share, RINGS) * SECTORS + bin((angle + PI) / TAU, SECTORS);
        cells[at * shells + bin(shell, shells)] += 1;
    }
    let expected = vec![DRAWS as f64 / cells.len() as f64; cells.len()];
    chi_square(&cells, &expected, 1)
}

fn length2(v: &[f32]) -> f64 {
    v.iter().map(|&x| f64::from(x) * f64::from(x)).sum()
}

fn azimuth(v: &[f32]) -> f64 {
    f64::from(v[1]).atan2(f64::from(v[0]))
}

#[test]
fn every_map_has_its_density() {
    let draws = Kernel::new("test/sampling").run_with::<[f32; 4], Out>(&[[0.0; 4]], DRAWS, &[]);
    let draws = draws.iter();
    // Distribution functions: of the disk's radius r^2, of the hemisphere's height cos^2, of the sphere's (1 + z)/2, of the
    // ball's radius r^3.
    let disk = |by: fn(f64) -> f64| {
        uniform_cells(draws.clone().map(|out| (by(length2(&out.disk)), azimuth(&out.disk), 0.0)), 1)
    };
    let hemisphere = |by: fn(f64) -> f64| {
        uniform_cells(draws.clone().map(|out| (by(f64::from(out.hemisphere[2])), azimuth(&out.hemisphere), 0.0)), 1)
    };
    let height = |z: f32| 0.5 * (1.0 + f64::from(z));
    let sphere = |by: fn(f64) -> f64| {
        uniform_cells(draws.clone().map(|out| (by(height(out.sphere[2])), azimuth(&out.sphere), 0.0)), 1)
    };
    let ball = |by: fn(f64) -> f64| {
        let cell = |out: &Out| {
            let r2 = length2(&out.ball);
            let share = 0.5 * (1.0 + f64::from(out.ball[2]) / r2.sqrt().max(1e-300));
            (share, azimuth(&out.ball), by(r2))
        };
        uniform_cells(draws.clone().map(cell), SHELLS)
    };
    let threshold = sidak(1e-6, 4);
    for (name, p) in [
        ("disk", disk(|r2| r2)),
        ("hemisphere", hemisphere(|z| z * z)),
        ("sphere", sphere(|share| share)),
        ("ball", ball(|r2| r2.powf(1.5))),
    ] {
        assert!(p > threshold, "{name}: p = {p:e}");
    }
    // Densities a little off, and quite other ones.
    for (name, p) in [
        ("disk, by r^1.94", disk(|r2| r2.powf(0.97))),
        ("disk, by r", disk(f64::sqrt)),
        ("hemisphere, by cos^1.94", hemisphere(|z| z.powf(1.94))),
        ("uniform hemisphere", hemisphere(|z| z)),
        ("sphere, a little upwards", sphere(|share| share.powf(0.97))),
        ("ball, by r^2.82", ball(|r2| r2.powf(1.41))),
    ] {
        assert!(p < threshold, "{name}: p = {p:e}");
    }
}

#[test]
fn the_ends_of_the_unit_interval_give_what_is_promised() {
    let last = 1.0 - U as f32;
    let ends = [0.0, U as f32, 0.25, 0.5, 0.75, last];
    let mut rows: Vec<[f32; 4]> = Vec::new();
    for x in ends {
        for y in ends {
            rows.extend(ends.map(|z| [x, y, z, 0.5]));
        }
    }
    let mut random = Random(62);
    rows.extend((0..10_000).map(|_| [0; 4].map(|_| (random.bits() >> 40) as f32 * U as f32)));
    // A root, a point on the circle (4 u) and a product, squared.
    let near = 16.0 * U;
    for (u, out) in rows.iter().zip(Kernel::new("test/sampling").run::<_, Out>(&rows)) {
        let all = [&out.disk[..], &out.circle, &out.hemisphere, &out.sphere, &out.ball, &[out.root]].concat();
        assert!(all.iter().all(|x| x.is_finite()), "{u:?}: {out:?}");
        assert!((length2(&out.circle) - 1.0).abs() < near, "{u:?}: {out:?}");
        assert!((length2(&out.disk) - f64::from(u[0])).abs() < near, "{u:?}: {out:?}");
        assert!((length2(&out.hemisphere) - 1.0).abs() < near, "{u:?}: {out:?}");
        assert!((length2(&out.sphere) - 1.0).abs() < near, "{u:?}: {out:?}");
        // The light that a surface is lit by comes from above it. A root is off by 9 u where it is 1 / inverseSqrt(x), as WGSL allows.
        let above = 2f64.powi(-12) * (1.0 - 9.0 * U);
        assert!(f64::from(out.hemisphere[2]) >= above, "{u:?}: {out:?}");
        // exp2(log2(x)/3) is good to about 3e-6 over 24 binary orders.
        assert!((f64::from(out.root) - f64::from(u[0]).cbrt()).abs() < 4e-6, "{u:?}: {out:?}");
        assert!((exact(out.ball).length() - f64::from(u[2]).cbrt()).abs() < 4e-6, "{u:?}: {out:?}");
        assert!(exact(out.ball).length() <= 1.0 + near, "{u:?}: {out:?}");
    }
    // Uniforms that reach 1 would lay it in the surface.
    let flat = Kernel::new("test/sampling").run::<_, Out>(&[[1.0f32; 4]])[0].hemisphere[2];
    assert!(flat < 2f32.powi(-13), "{flat:e}");
}
