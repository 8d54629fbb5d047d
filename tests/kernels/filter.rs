//! filter/*: the points and weights of samples against each filter's distribution function, in f64.

use std::f64::consts::TAU;

use crate::common::kernel::Kernel;
use crate::common::rows::FilterPoint as Out;

const FILTERS: [&str; 4] = ["box", "tent", "gauss", "mitchell"];

/// Numbers along an axis: the middles of cells, so that sums over them are integrals, and the ends of the interval.
const CELLS: usize = 256;

fn numbers() -> Vec<f32> {
    let middles = (0..CELLS).map(|cell| (cell as f32 + 0.5) / CELLS as f32);
    let least = 2f32.powi(-24);
    middles.chain([0.0, least, 0.5, 1.0 - least]).collect()
}

fn points(filter: &'static str) -> Vec<([f32; 2], Out)> {
    let weight = if filter == "mitchell" { "filter_weight(given)" } else { "1.0" };
    let point = format!("vec4(filter_point(given), {weight}, 0.0)");
    let kernel = Kernel::of([&format!("filter/{filter}"), "vec2<f32>", "vec4<f32>", &point], &[]);
    let numbers = numbers();
    let rows: Vec<[f32; 2]> = numbers.iter().flat_map(|y| numbers.iter().map(move |x| [*x, *y])).collect();
    let found = kernel.run::<_, Out>(&rows);
    rows.into_iter().zip(found).collect()
}

/// The integral of |f| of Mitchell and Netravali's filter from its middle to `x`, by Simpson's rule on each piece of f: exact for cubics.
fn mitchell_area(x: f64) -> f64 {
    let f = |x: f64| match x {
        ..=1.0 => (7.0 * x.powi(3) - 12.0 * x.powi(2) + 16.0 / 3.0) / 6.0,
        _ => ((-7.0 / 3.0 * x.powi(3) + 12.0 * x.powi(2) - 20.0 * x + 32.0 / 3.0) / 6.0).abs(),
    };
    let simpson = |from: f64, to: f64| (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to));
    let pieces: [f64; 4] = [0.0, 1.0, 8.0 / 7.0, 2.0];
    pieces.windows(2).map(|piece| simpson(piece[0].min(x), piece[1].min(x))).sum()
}

/// The random numbers that lead to a point: the share of the filter on the near side of it.
fn shares(filter: &str, [x, y]: [f64; 2]) -> [f64; 2] {
    let along = |share: fn(f64) -> f64| [share(x), share(y)];
    match filter {
        "box" => along(|x| x + 0.5),
        "tent" => along(|x| if x < 0.0 { 0.5 * (1.0 + x).powi(2) } else { 1.0 - 0.5 * (1.0 - x).powi(2) }),
        "gauss" => {
            let within = |square: f64| 1.0 - (-2.0 * square).exp();
            [within(x * x + y * y) / within(1.5 * 1.5), (0.5 + y.atan2(x) / TAU).rem_euclid(1.0)]
        }
        _ => along(|x| 0.5 + 0.5 * (mitchell_area(x.abs()) / mitchell_area(2.0)).copysign(x)),
    }
}

/// The largest difference between random numbers and the shares of their points. Angles are compared around the circle, and not at all in
/// the middle, where no point has one.
fn worst(filter: &str, found: &[([f32; 2], Out)]) -> f64 {
    let mut worst: f64 = 0.0;
    for (u, out) in found {
        let offset = out.point.map(|x| f64::from(x) - 0.5);
        let shares = shares(filter, offset);
        for axis in 0..2 {
            let difference = (shares[axis] - f64::from(u[axis])).abs();
            let middle = filter == "gauss" && axis == 1 && offset[0].hypot(offset[1]) < 1e-3;
            worst = worst.max(if middle { 0.0 } else { difference.min((1.0 - difference).abs()) });
        }
    }
    worst
}

/// The limit is of shares: the densities are at most 1.3, so that points are right to about as many pixels. The tent's takes a root of a
/// number with an error of 2^-24, and adds two roundings. The Gaussian's logarithm is promised to 2^-21 near 1, of a share that is twice its
/// half. Mitchell's area is a straight line within 2^-11 pixels: with f' up to 1.3 it is off by 1.3 · 2^-22 / 8, beside a few roundings.
#[test]
fn points_have_the_filters_density() {
    for filter in FILTERS {
        let found = points(filter);
        let limit = match filter {
            "box" => 0.0,
            "tent" => 4.0 * 2f64.powi(-24),
            _ => 2f64.powi(-20),
        };
        let off = worst(filter, &found);
        println!("{filter}: shares are off by {off:.2e}");
        assert!(off <= limit, "{filter}: {off:e}");
        // Another filter's points are found.
        for other in FILTERS.iter().filter(|other| **other != filter) {
            assert!(worst(other, &found) > 0.01, "{filter} passes as {other}");
        }
    }
}

/// The mean of the weights is 1: constant radiance stays what it is. They are negative where one axis is in a negative lobe.
#[test]
fn weights_are_those_of_negative_lobes() {
    let found = points("mitchell");
    let middles = |u: &[f32; 2]| u.iter().all(|u| (f64::from(*u) * CELLS as f64).fract() == 0.5);
    let sum: f64 = found.iter().filter(|(u, _)| middles(u)).map(|(_, out)| f64::from(out.weight)).sum();
    // The sign changes within a cell of each axis: of 2 · 256 · 2 cells, each of which may have the wrong one, at weights of 1.145.
    let limit = 1.145 * 2.0 * 4.0 / CELLS as f64;
    let mean = sum / (CELLS * CELLS) as f64;
    assert!((mean - 1.0).abs() < limit, "{mean}");
    let absolute = mitchell_area(2.0) / 0.5;
    for (_, out) in &found {
        let negative = |x: f32| (f64::from(x) - 0.5).abs() > 8.0 / 7.0;
        let sign = if negative(out.point[0]) == negative(out.point[1]) { 1.0 } else { -1.0 };
        // At the zero itself rounding decides.
        let at_zero = out.point.iter().any(|x| ((f64::from(*x) - 0.5).abs() - 8.0 / 7.0).abs() < 1e-6);
        let off = (f64::from(out.weight) - sign * absolute * absolute).abs();
        assert!(at_zero || off < 4.0 * 2f64.powi(-24), "{out:?}");
    }
}
