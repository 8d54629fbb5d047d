//! lib/float: what the bits of a float say.

use crate::common::kernel::{Expression, Kernel};
use crate::common::stats::Random;

/// What the bits of a float say, and its neighbour towards another one.
const FACTS: Expression<'_> = [
    "lib/float",
    "vec2<u32>",
    "vec4<u32>",
    "vec4<u32>(u32(is_nan(bitcast<f32>(given.x))), u32(is_infinite(bitcast<f32>(given.x))),
        bitcast<u32>(next_float(bitcast<f32>(given.x), bitcast<f32>(given.y))), 0u)",
];

fn inputs() -> Vec<[u32; 2]> {
    let special = [
        0, 1, 0x007fffff, 0x00800000, 0x00800001, 0x3f7fffff, 0x3f800000, 0x3fffffff, 0x7f7ffffe, 0x7f7fffff,
        0x7f800000, 0x7f800001, 0x7fbfffff, 0x7fc00000, 0x7fffffff,
    ];
    let toward = [0.0f32, -0.0, 1.0, -1.0, 1e-30, -1e30].map(f32::to_bits);
    let mut random = Random(51);
    let mut all: Vec<[u32; 2]> = Vec::new();
    for bits in special {
        all.extend(toward.iter().flat_map(|&t| [[bits, t], [bits | 1 << 31, t]]));
    }
    all.extend((0..20_000).map(|_| [random.bits() as u32, toward[random.below(toward.len())]]));
    all
}

/// Answers that differ from the standard library's.
fn wrong(kernel: &Kernel) -> [usize; 3] {
    let rows = inputs();
    let mut wrong = [0; 3];
    for ([x, toward], [nan, infinite, next, _]) in rows.iter().zip(kernel.run::<_, [u32; 4]>(&rows)) {
        let (value, toward) = (f32::from_bits(*x), f32::from_bits(*toward));
        wrong[0] += usize::from((nan != 0) != value.is_nan());
        wrong[1] += usize::from((infinite != 0) != value.is_infinite());
        if value.is_finite() {
            let expected = match (value.is_normal(), toward) {
                // Zero and subnormals stay, for their neighbours may be flushed to zero.
                (false, _) | (_, 0.0) => *x,
                (true, toward) if toward > 0.0 => value.next_up().to_bits(),
                (true, _) => value.next_down().to_bits(),
            };
            wrong[2] += usize::from(next != expected);
        }
    }
    wrong
}

#[test]
fn floats_are_distinguished_and_stepped_by_their_bits() {
    assert_eq!(wrong(&Kernel::of(FACTS, &[])), [0; 3]);
    // A guard that takes infinities for NaN, and a neighbour by a relative step, which zero and rounding lead astray.
    let replaced = [
        ("(bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u", "(bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u"),
        ("(bitcast<u32>(x) & 0x7fffffffu) == 0x7f800000u", "abs(x) > VERY_FAR"),
        ("bitcast<f32>(select(moved, bits, steady))", "x + sign(toward) * abs(x) * 0x1p-23f"),
    ];
    let found = wrong(&Kernel::of(FACTS, &replaced.map(|(part, other)| ("lib/float", part, other))));
    assert!(found.iter().all(|&n| n > 0), "{found:?}");
}
