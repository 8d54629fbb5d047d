//! lib/angle: sines, cosines and angles, against f64.

use std::f64::consts::{PI, TAU};

use crate::common::kernel::{Expression, Fault, Kernel};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades};

rows! {
    struct In { turns: f32, angle: f32, point: [f32; 2] }

    struct Out {
        on_circle: [f32; 2], sine_and_rise: [f32; 2],
        angle: f32, padding: f32,
    }
}

const ANGLES: Expression<'_> = [
    "lib/angle",
    "vec4<f32>",
    "array<vec2<f32>, 3>",
    "array(circle_point(given.x), sine_and_rise(given.y), vec2(angle_of(given.w, given.z)))",
];

/// What is left of the turns is exact; times pi/2 it is off by 2 u, the polynomials by 2 u more.
const POINT: f64 = 4.0 * U;
/// Of the angle, in turns: 2 u. Of a sine or a cosine of half of it, 4 u, and of their product and what the angle was off by 1 u and 2 u
/// of pi. 1 - cosine is a square: relative.
const SINE: f64 = (9.0 + 2.0 * PI) * U;
const RISE: f64 = (9.0 + 2.0 * PI) * U;
/// Relative: three halvings, each with a quotient (5 u of the 2.5 ULP that WGSL allows) and a root (half of its 5 u, since it is one of two terms), and 3 u of
/// the series.
const ANGLE: f64 = 28.0 * U;

#[test]
fn angles_sines_and_cosines_are_those_of_f64() {
    let mut random = Random(131);
    let mut rows: Vec<In> = (0..40_000)
        .map(|_| {
            let turns = decades(&mut random, -12.0, 7.0) * (2.0 * random.uniform() - 1.0);
            let angle = decades(&mut random, -12.0, 0.5).min(PI) as f32;
            let seen = decades(&mut random, -12.0, 0.5).min(PI);
            let far = decades(&mut random, -8.0, 8.0);
            In { turns: turns as f32, angle, point: [(far * seen.cos()) as f32, (far * seen.sin()).max(0.0) as f32] }
        })
        .collect();
    // Every sixteenth of a turn and its neighbours: where quarters are taken off, and where the polynomials end.
    for i in -64..=64 {
        let at = i as f32 / 16.0;
        rows.extend([at, at.next_up(), at.next_down()].map(|turns| In { turns, point: [1.0, 0.0], ..In::default() }));
    }
    let worst = |replaced: &[Fault<'_>]| {
        let found = Kernel::of(ANGLES, replaced).run::<_, Out>(&rows);
        rows.iter().zip(found).fold([0.0f64; 4], |worst, (row, out)| {
            let turns = f64::from(row.turns);
            let (sin, cos) = (TAU * (turns - turns.round())).sin_cos();
            let angle = f64::from(row.angle);
            let rise = 2.0 * (0.5 * angle).sin().powi(2);
            let [x, y] = row.point.map(f64::from);
            let seen = y.atan2(x);
            let relative = |found: f32, exact: f64| match exact {
                0.0 => f64::from(found).abs(),
                _ => (f64::from(found) / exact - 1.0).abs(),
            };
            let off = |found: f32, exact: f64| (f64::from(found) - exact).abs();
            let errors = [
                off(out.on_circle[0], cos).max(off(out.on_circle[1], sin)),
                // Of a small angle the sine keeps its digits too.
                off(out.sine_and_rise[0], angle.sin()) / angle.clamp(f64::MIN_POSITIVE, 1.0),
                relative(out.sine_and_rise[1], rise),
                relative(out.angle, seen),
            ];
            std::array::from_fn(|i| if errors[i].is_nan() { f64::MAX } else { worst[i].max(errors[i]) })
        })
    };
    // The driver's functions, of angles of several turns, and differences from 1 and of angles.
    let by_driver = [
        ("select(acute, 3.14159265358979 - acute, x < 0.0)", "acos(x / length(vec2<f32>(x, y)))"),
        (
            "select(within_half, -within_half, (quarter & 2) != 0)",
            "vec2<f32>(cos(6.28318531 * turns), sin(6.28318531 * turns))",
        ),
        ("2.0 * half.y * half", "vec2<f32>(sin(angle), 1.0 - cos(angle))"),
    ];
    let (own, textbook) = (worst(&[]), worst(&by_driver.map(|(part, other)| ("lib/angle", part, other))));
    for (name, i, limit) in [("circle", 0, POINT), ("sine", 1, SINE), ("rise", 2, RISE), ("angle", 3, ANGLE)] {
        assert!(own[i] <= limit, "{name}: {:.2} u of {:.2} u", own[i] / U, limit / U);
    }
    // The textbook's sine is right where the driver's is.
    for (name, i, limit) in [("circle", 0, POINT), ("rise", 2, RISE), ("angle", 3, ANGLE)] {
        assert!(textbook[i] > 10.0 * limit, "{name} by the driver's functions: {:.2} u", textbook[i] / U);
    }
}
