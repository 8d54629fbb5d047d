//! geometry/cuboid: rays that leave boxes, at all angles.

use crate::common::cuboids::{Exact, assorted, error_of, rays_at};
use crate::common::kernel::Kernel;
use crate::common::stats::Random;
use crate::common::trace::{NO_HIT, WITHOUT_OFFSET, leaving, trace, tracer};
use crate::common::vectors::{U, decades, exact};
use crate::table::{BY_BITS, Cell, NO_OFFSET, OFFSET_BY_BITS, decade};

/// Rays that met a box and leave it, out and in, at cosines with the face's normal within these decades: those that left to the
/// wrong side, those of the rays outwards that met it again, and of those inwards whose chord was lost or off by 10 %.
fn leave(kernel: &Kernel, aspect: f64, distance: (f64, f64), cosines: (f64, f64)) -> f64 {
    let mut random = Random(23);
    let cuboids = assorted(&mut random, 3000, aspect, distance);
    let mut rays = rays_at(&mut random, &cuboids, 10_000);
    for ray in &mut rays {
        let cosine = decades(&mut random, cosines.0, cosines.1);
        let outwards = random.below(2) == 0;
        ray.leaving = leaving(&mut random, cosine, outwards);
    }
    let (mut hits, mut wrong_side, mut again, mut chords) = (0, 0, 0, 0);
    for (ray, out) in rays.iter().zip(&trace(kernel, &cuboids, &rays)) {
        let cuboid = &cuboids[ray.primitive as usize];
        if out.t == NO_HIT {
            continue;
        }
        hits += 1;
        // The side that it left to. Along the face, to within the rounding of the direction and of its product with the
        // normal, either will do.
        let outwards = (exact(out.start) - exact(out.point)).dot(exact(out.normal)) >= 0.0;
        let cosine = exact(out.leaving).dot(exact(out.normal));
        wrong_side += usize::from(cosine.abs() > 8.0 * U && outwards != (cosine > 0.0));
        if outwards {
            again += usize::from(out.again != NO_HIT);
        } else {
            let (at, error) = (Exact::new(cuboid), error_of(cuboid));
            let chord = at.span(exact(out.point), exact(out.leaving), error).map_or(0.0, |span| span.1);
            // Shorter chords, at the edges, are within the errors of their ends.
            if chord > 2000.0 * error {
                chords += usize::from(out.again == NO_HIT || (f64::from(out.again) / chord - 1.0).abs() > 0.1);
            }
        }
    }
    assert!(hits > 6000, "{hits} hits");
    (wrong_side + again + chords) as f64
}

const BECAUSE: &str =
    "none, because the offset exceeds the bound of the point's error, and is below a tenth of the tested chords.";

/// The kernel, and one without the offset.
fn tracers() -> [Kernel; 2] {
    [&[][..], &[WITHOUT_OFFSET]].map(|replaced| tracer("cuboid", replaced))
}

pub fn leavings() -> Vec<Cell> {
    let [own, without] = tracers();
    let by_bits = tracer("cuboid", &[BY_BITS]);
    let mut all = Vec::new();
    for aspect in [0, 3, 6] {
        for (name, distance) in [("up to 1", (-2.0, 0.0)), ("1e2", (1.9, 2.1)), ("1e4", (3.9, 4.1))] {
            let range = format!("edges down to 1e-{aspect} of the longest, {name} edges from the origin");
            let figure = "Boxes: of 10 000 rays, those that hit their own box again or had a wrong chord inside, with cosines from \
                          0.05 to 1";
            let (aspect, cosines) = (f64::from(aspect), (-1.3, 0.0));
            let mut cell = Cell::new(range, figure, 0.0, BECAUSE)
                .achieved(leave(&own, aspect, distance, cosines))
                .planted(NO_OFFSET, leave(&without, aspect, distance, cosines));
            if distance.0 < 3.0 {
                cell = cell.planted(OFFSET_BY_BITS, leave(&by_bits, aspect, distance, cosines));
            }
            all.push(cell);
        }
    }
    all
}

pub fn grazing() -> Vec<Cell> {
    let [own, without] = tracers();
    let cell = |exponent| {
        let (range, cosines) = decade(exponent);
        let figure = "Boxes by the cosine of the leaving ray: of 10 000 rays, those that hit their own box again or had a wrong \
                      chord inside";
        Cell::new(range, figure, 0.0, BECAUSE)
            .achieved(leave(&own, 1.0, (-2.0, 1.0), cosines))
            .planted(NO_OFFSET, leave(&without, 1.0, (-2.0, 1.0), cosines))
    };
    (1..7).map(cell).collect()
}
