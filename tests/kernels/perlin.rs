//! lib/perlin: what noise must be whatever its gradients. Its values against f64: tests/extremes/noise.rs.

use glam::DVec3;

use crate::common::kernel::Kernel;
use crate::common::oracles::{LINEAR_NOISE, NOISE, NOISE_ERROR};
use crate::common::stats::{Random, one_sample_t};
use crate::common::vectors::rounded;

fn evaluate(kernel: &Kernel, points: &[DVec3]) -> Vec<[f32; 2]> {
    let rows: Vec<[f32; 4]> = points.iter().map(|p| rounded(*p)).map(|[x, y, z]| [x, y, z, 0.0]).collect();
    kernel.run(&rows)
}

fn noise(kernel: &Kernel, points: &[DVec3]) -> Vec<f64> {
    evaluate(kernel, points).iter().map(|out| f64::from(out[0])).collect()
}

/// Points that f32 holds exactly, multiples of 2^-10 within so many units: so that their sums with whole numbers are exact.
fn exact_points(random: &mut Random, count: usize, reach: f64) -> Vec<DVec3> {
    let mut coordinate = || ((2.0 * random.uniform() - 1.0) * reach * 1024.0).round() / 1024.0;
    (0..count).map(|_| DVec3::new(coordinate(), coordinate(), coordinate())).collect()
}

#[test]
fn noise_is_zero_on_the_lattice_bounded_and_of_mean_zero() {
    let kernel = Kernel::of(NOISE, &[]);
    let mut random = Random(82);
    let lattice: Vec<DVec3> = exact_points(&mut random, 5000, 1000.0).iter().map(|p| p.round()).collect();
    assert!(noise(&kernel, &lattice).iter().all(|value| *value == 0.0));
    // 2^16 points of 2^24 cells, so that few share one: the noise's deviation is 0.18, the mean's 0.0007. A mean of 0.01
    // is found.
    let values = noise(&kernel, &exact_points(&mut random, 1 << 16, 128.0));
    assert!(values.iter().all(|value| value.abs() < 1.0));
    let found = one_sample_t(&values, 0.0);
    assert!(found.p > 1e-6, "{found:?}");
    assert!(one_sample_t(&values, 0.01).p < 1e-6);
    // It spreads, for the test of the mean would accept a constant 0: the mean square of eight independent gradients'
    // products, 8 x 19/630 x (13/35)^2 = 0.0333, known here to 1 %.
    let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
    assert!((variance / 0.0333 - 1.0).abs() < 0.05, "{variance}");
}

/// The value and the slope on both sides of the planes between cells, across zero and elsewhere.
#[test]
fn noise_and_its_slope_are_continuous_across_cells() {
    const STEP: f64 = 1.0 / 1024.0;
    let mut random = Random(84);
    let mut points = Vec::new();
    for (i, p) in exact_points(&mut random, 3000, 100.0).into_iter().enumerate() {
        let axis = i % 3;
        let mut on_plane = p;
        on_plane[axis] = if i % 2 == 0 { 0.0 } else { p[axis].round() };
        for steps in [-2.0, -1.0, 1.0, 2.0] {
            let mut at = on_plane;
            at[axis] += steps * STEP;
            points.push(at);
        }
    }
    let worst = |kernel: &Kernel| {
        let values = noise(kernel, &points);
        values.chunks_exact(4).fold([0.0f64; 2], |worst, v| {
            let jump = (v[2] - v[1]).abs();
            let kink = ((v[3] - v[2]) - (v[1] - v[0])).abs() / STEP;
            [worst[0].max(jump), worst[1].max(kink)]
        })
    };
    let [jump, kink] = worst(&Kernel::of(NOISE, &[]));
    // Slopes are below 10: the gradients' own mean, and 1.5 along each axis times the difference of two mean products. Two
    // steps from plane to plane.
    assert!(jump <= 2.0 * STEP * 10.0, "{jump}");
    // Second derivatives are below 60 (6 from the fade's, times the same), over the three steps between the slopes'
    // middles; and four errors of the noise over a step.
    assert!(kink <= 3.0 * STEP * 60.0 + 4.0 * NOISE_ERROR / STEP, "{kink}");
    let [jump, kink] = worst(&Kernel::of(NOISE, &LINEAR_NOISE));
    assert!(jump > 0.1 && kink > 1.0, "{jump} {kink}");
}
