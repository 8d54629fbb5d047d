//! geometry/sheared_triangle: rays that leave triangles, at all angles.

use crate::common::kernel::Kernel;
use crate::common::stats::Random;
use crate::common::trace::{NO_HIT, WITHOUT_OFFSET};
use crate::common::triangles::{Corners, In, stout, trace, tracer};
use crate::common::vectors::{decades, rounded, unit};
use crate::table::{Cell, NO_OFFSET, decade};

/// Rays that meet triangles of all sizes, every second a needle down to 1e-5 of its length, up to `far` sizes from the
/// origin, and leave them at cosines within these decades: how many met the triangle again.
fn leave(kernel: &Kernel, far: f64, cosines: (f64, f64)) -> f64 {
    const RAYS: usize = 20_000;
    let mut random = Random(73);
    let (mut triangles, mut rays) = (Vec::new(), Vec::new());
    for i in 0..RAYS {
        let size = decades(&mut random, -6.0, 6.0);
        let mut corners = stout(&mut random, size);
        if i % 2 == 0 {
            // One vertex to within a share of another.
            let (one, other) = (i / 2 % 3, (i / 2 + 1) % 3);
            corners[one] = corners[other] + decades(&mut random, -5.0, 0.0) * (corners[one] - corners[other]);
        }
        let translation = far * size * decades(&mut random, -3.0, 0.0) * unit(&mut random);
        let corners = Corners::new(corners.map(|p| p + translation));
        let [a, b, c] = corners.exact();
        let normal = (b - a).cross(c - a).normalize_or(unit(&mut random));
        let (v, w) = (random.uniform(), random.uniform());
        let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
        let target = a + v * (b - a) + w * (c - a);
        let origin = rounded(target + size * decades(&mut random, -2.0, 1.0) * unit(&mut random));
        let cos = decades(&mut random, cosines.0, cosines.1) * if i % 4 < 2 { 1.0 } else { -1.0 };
        // Along the plane, half of them along the longest way.
        let along = if i % 8 < 4 { (b - a) - (c - b) } else { unit(&mut random) };
        let along = (along - along.dot(normal) * normal).normalize_or(unit(&mut random));
        let leaving = rounded(cos * normal + (1.0 - cos * cos).sqrt() * along);
        triangles.push(corners);
        let direction = rounded((target - crate::common::vectors::exact(origin)).normalize());
        rays.push(In { origin, direction, first: i as u32, count: 1, leaving, ..In::default() });
    }
    let found = trace(kernel, &triangles, &rays);
    let hits = found.iter().filter(|out| out.t != NO_HIT);
    let count = hits.clone().count();
    assert!(count > RAYS / 4, "{count} hits");
    hits.filter(|out| out.again != NO_HIT).count() as f64
}

/// The table's cells of triangles.
fn cells(figure: &'static str, ranges: impl Iterator<Item = (String, f64, (f64, f64))>) -> Vec<Cell> {
    const BECAUSE: &str = "none, because the offset exceeds the bound of the errors of the point and of the next distance \
                           (geometry/sheared_triangle).";
    let own = tracer(&[]);
    let without = tracer(&[WITHOUT_OFFSET]);
    let cell = |(range, far, cosines)| {
        Cell::new(range, figure, 0.0, BECAUSE)
            .achieved(leave(&own, far, cosines))
            .planted(NO_OFFSET, leave(&without, far, cosines))
    };
    ranges.map(cell).collect()
}

pub fn leavings() -> Vec<Cell> {
    let figure = "Triangles, including needles: of 20 000 rays, those that hit their own triangle again, with cosines from 0.01 to 1";
    let range = |far| (format!("up to {far} sizes from the origin"), far, (-2.0, 0.0));
    cells(figure, [1.0, 1e1, 1e2, 1e3].into_iter().map(range))
}

pub fn grazing() -> Vec<Cell> {
    let figure = "Triangles by the cosine of the leaving ray: of 20 000 rays, those that hit their own triangle again";
    let range = |exponent| {
        let (range, cosines) = decade(exponent);
        (range, 1.0, cosines)
    };
    cells(figure, (1..7).map(range))
}
