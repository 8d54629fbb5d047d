//! Rays that leave an instance of a mesh, whatever transform placed it.

use crate::common::instances::{In, NOTHING, ball_file, flat_around, kernel, run};
use crate::common::kernel::Fault;
use crate::common::scenes::triple;
use crate::common::stats::Random;
use crate::common::trace::WITHOUT_OFFSET;
use crate::common::vectors::{exact, rounded, unit};
use crate::table::{Cell, NO_OFFSET};
use glam::DVec3;

/// Rays at a ball of so many units, placed by a transform so far from the eye: how many of those that leave it again
/// met the face that they left, met the ball though they left it outwards, or lost the inside though they went in.
fn leave(size: f64, distance: f64, replaced: &[Fault<'_>]) -> f64 {
    let random = &mut Random(62);
    const RAYS: usize = 10_000;
    let mesh = ball_file(3, DVec3::ONE);
    let center = distance * unit(random);
    let object = format!(
        "Transformed(by: [Rotate(axis: {}, degrees: 77), Scale({size:?}), Translate({})], object: Mesh(path: \"ball.obj\", \
         material: \"m\"))",
        triple(unit(random)),
        triple(center)
    );
    let flat = flat_around(DVec3::ZERO, &mesh, &[object]);
    let instance = flat.shapes.instances[0];
    let (at, radius) = (exact(instance.translation), f64::from(instance.scale));
    let rays: Vec<In> = (0..RAYS)
        .map(|i| {
            let target = at + 0.9 * radius * random.uniform() * unit(random);
            let origin = target + 3.0 * radius * unit(random);
            let direction = rounded((target - origin).normalize());
            let leaving = rounded(unit(random));
            let origin = if i % 2 == 0 { rounded(origin) } else { rounded(at + 0.5 * radius * unit(random)) };
            In { origin, direction, root: flat.settings.root, leaving, ..In::default() }
        })
        .collect();
    let found = run(&kernel(&flat, 8 * 64, replaced), &flat, &rays);
    let (mut hits, mut wrong) = (0, 0);
    for (out, ray) in found.iter().zip(&rays) {
        if out.walked[0] == NOTHING {
            continue;
        }
        let cosine = exact(ray.leaving).dot(exact(out.normal));
        hits += 1;
        let same = out.again >= 0.0 && out.again_code == out.walked[0];
        let outwards = cosine > 0.0 && out.again >= 0.0;
        // At less than a tenth to the surface, a facet's chord is as short as what rounding moves a point by.
        let lost = cosine < -0.1 && out.again < 0.0;
        wrong += usize::from(same || outwards || lost);
    }
    assert!(hits > RAYS / 2, "{hits} rays met the ball");
    wrong as f64
}

/// The table's cells of instances.
pub fn cells() -> Vec<Cell> {
    // Beyond a ratio of 1e4 the inside of the ball is some thousand floats wide, and facets' chords near its edge are lost.
    let sizes = [1.0, 1e-4, 1e4, 1.0, 1e4, 1e-4, 1.0, 1e-4, 1e4];
    let distances = [0.0, 0.0, 0.0, 1.0, 3e3, 1e-2, 1e3, 1.0, 1e8];
    let mut all = Vec::new();
    for (size, distance) in sizes.into_iter().zip(distances) {
        let cell = Cell::new(
            format!("scaled by {size:e}, {distance:e} from the eye"),
            "Instances: of 10 000 rays, those that hit the face or the ball that they left, or missed its far side",
            0.0,
            "none, because the offset exceeds the error within the mesh, plus 16 u of the position in it for the transforms \
             (geometry/instance).",
        )
        .achieved(leave(size, distance, &[]));
        all.push(match distance > 0.0 {
            true => cell.planted(NO_OFFSET, leave(size, distance, &[WITHOUT_OFFSET])),
            false => cell,
        });
    }
    all
}
