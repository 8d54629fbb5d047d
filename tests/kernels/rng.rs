//! lib/rng and sampler/independent: the hash against an independent one, the unit interval, and the statistics of what comes out.

use crate::common::kernel::Kernel;
use crate::common::oracles::pcg4d;
use crate::common::rows::{WORDS, Words as Out};
use crate::common::stats::{Random, normal_two_sided, sidak, uniform_in_cells};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;

/// A step of a linear congruential generator without the mixing, and all 32 bits rounded to a float.
fn weak() -> Kernel {
    let step = ("lib/rng", "return v;", "return (key + key.yzwx * 3u) * 1664525u + 1013904223u;");
    Kernel::of(WORDS, &[step, ("lib/rng", "(bits >> vec4<u32>(8u)) * 0x1p-24f", "(bits) * 0x1p-32f")])
}

#[test]
fn the_hash_is_pcg4d_and_uniforms_are_its_upper_bits() {
    let mut random = Random(61);
    let mut keys: Vec<[u32; 4]> = (0..10_000).map(|_| [0; 4].map(|_| random.bits() as u32)).collect();
    keys.extend([[0; 4], [u32::MAX; 4], [1, 0, 0, 0], [0, 0, 0, 1]]);
    let wrong = |kernel: &Kernel| {
        let found = kernel.run::<_, Out>(&keys);
        let right = |(key, out): &(&[u32; 4], Out)| {
            let bits = pcg4d(**key);
            out.bits == bits && out.u.map(f64::from) == bits.map(|word| f64::from(word >> 8) / 16_777_216.0)
        };
        keys.iter().zip(found).filter(|pair| !right(pair)).count()
    };
    assert_eq!(wrong(&Kernel::of(WORDS, &[])), 0);
    assert!(wrong(&weak()) > 1000);
}

/// A way in which two samples' numbers are neighbours: the step of pixel, sample, dimension and seed from one to the other.
const NEIGHBOURS: [(&str, [u32; 4]); 7] = [
    ("the pixel to the right", [1, 0, 0, 0]),
    ("the pixel below", [512, 0, 0, 0]),
    ("the next sample", [0, 1, 0, 0]),
    ("the same sample of the next run", [0, 8, 0, 0]),
    ("the next block", [0, 0, 1, 0]),
    ("the next event", [0, 0, 4, 0]),
    ("the next seed", [0, 0, 0, 1]),
];

const PAIRS: usize = 1 << 17;

/// Keys of an image of 512 x 512, one sample each, in even columns; or of one pixel, even samples.
fn keys(by_sample: bool) -> Vec<[u32; 4]> {
    let even = |i: usize| 2 * i as u32;
    match by_sample {
        // The two columns of a pair are this one and the one to its right, so that no number is in two pairs.
        false => (0..PAIRS).map(|i| [even(i), 5, 0, 0]).collect(),
        true => (0..PAIRS).map(|i| [77, even(i), 1, 3]).collect(),
    }
}

fn uniforms(kernel: &Kernel, keys: &[[u32; 4]]) -> Vec<[f32; 4]> {
    kernel.run::<_, Out>(keys).iter().map(|out| out.u).collect()
}

/// Chi-square of one number's histogram.
pub fn histogram(values: impl Iterator<Item = f32>) -> f64 {
    uniform_in_cells((1024, 1), values.map(|u| (f64::from(u), 0.0)))
}

/// P-values of the pairs' joint histogram and of their correlation.
pub fn joint(pairs: impl Iterator<Item = (f32, f32)>) -> [f64; 2] {
    let (mut count, mut sum) = (0.0f64, 0.0);
    let points = pairs.map(|(a, b)| (f64::from(a), f64::from(b))).inspect(|(a, b)| {
        count += 1.0;
        sum += (a - 0.5) * (b - 0.5);
    });
    let p = uniform_in_cells((32, 32), points);
    // The product of two independent uniforms less their means has variance 1/144.
    [p, normal_two_sided(sum / (count / 144.0).sqrt())]
}

/// The least p-value of all tests of numbers, with its name, and how many tests there were: of each number and each two of a key, of keys by their
/// names, and of such pairs of a key's number and one of its neighbour's.
pub fn least(
    uniforms: impl Fn(&[[u32; 4]]) -> Vec<[f32; 4]>,
    bases: &[(String, Vec<[u32; 4]>)],
    neighbours: &[(&str, [u32; 4])],
    pairs: &[(usize, usize)],
) -> (f64, String, usize) {
    let mut found: Vec<(f64, String)> = Vec::new();
    for (of, base) in bases {
        let numbers = uniforms(base);
        for a in 0..4 {
            found.push((histogram(numbers.iter().map(|u| u[a])), format!("{of}: number {a}")));
            for b in 0..a {
                let p = joint(numbers.iter().map(|u| (u[a], u[b])));
                found.extend(p.map(|p| (p, format!("{of}: numbers {a} and {b}"))));
            }
        }
        for (name, step) in neighbours {
            let next: Vec<[u32; 4]> = base.iter().map(|key| [0, 1, 2, 3].map(|i| key[i] + step[i])).collect();
            let next = uniforms(&next);
            for (a, b) in pairs {
                let p = joint(numbers.iter().zip(&next).map(|(u, v)| (u[*a], v[*b])));
                found.extend(p.map(|p| (p, format!("{of}: number {a}, and {b} of {name}"))));
            }
        }
    }
    let tests = found.len();
    let (p, name) = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are tests");
    (p, name, tests)
}

/// Chi-square of 1024 cells over 2^17 numbers finds a density that is off by 5 % in the root mean square, and the
/// correlation one of 0.02, with a probability of 99.9 %.
#[test]
fn uniforms_are_uniform_and_neighbours_independent() {
    let bases = [("pixels".to_string(), keys(false)), ("samples".to_string(), keys(true))];
    let least =
        |kernel: &Kernel| least(|keys| uniforms(kernel, keys), &bases, &NEIGHBOURS, &[(0, 0), (1, 1), (2, 2), (3, 3)]);
    let (p, name, tests) = least(&Kernel::of(WORDS, &[]));
    assert!(p > sidak(ALPHA, tests), "{name}: p = {p:e} in {tests} tests");
    let (p, _, tests) = least(&weak());
    assert!(p < sidak(ALPHA, tests), "p = {p:e}");
}
