//! lib/thin_film: the reflectance of a thin film, against its formula in f64 and against waves that are summed over the spectrum.

use std::f64::consts::{PI, TAU};

use crate::common::kernel::{Expression, Kernel, Plant, Setup, values_of};
use crate::common::microfacets::schlick;
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades};

rows! {
    struct In {
        f0: [f32; 3], cosine: f32,
        ior: f32, thickness: f32, padding: [f32; 2],
    }
}

const FILM: Expression<'_> = [
    "lib/thin_film",
    "array<vec4<f32>, 2>",
    "vec4<f32>",
    "vec4(thin_film(given[0].w, given[1].x, given[1].y, given[0].xyz), 0.0)",
];

/// Gaussians of the frequency in 1/m, with the middle, the variance of the phase, and the height: x is the sum of two (Belcour and Barla 2017,
/// supplemental code).
const SENSITIVITIES: [[[f64; 3]; 2]; 3] = [
    [[1.6810e6, 4.3278e9, 5.4856e-13], [2.2399e6, 4.5282e9, 9.7470e-14]],
    [[1.7953e6, 9.3046e9, 4.4201e-13], [0.0; 3]],
    [[2.2084e6, 6.6121e9, 5.2481e-13], [0.0; 3]],
];
const TO_RGB: [[f64; 3]; 3] =
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]];

fn rgb(xyz: [f64; 3]) -> [f64; 3] {
    TO_RGB.map(|row| row.iter().zip(xyz).map(|(a, b)| a * b).sum())
}

/// A film and what lies below: the reflectances of both boundaries by Schlick's approximation, the difference of the ways in nm, and the
/// shifts of the phase at the lower boundary.
struct Film {
    top: f64,
    bottom: [f64; 3],
    difference: f64,
    shifts: [f64; 3],
}

impl Film {
    fn new(cosine: f64, film_ior: f64, thickness: f64, f0: [f64; 3]) -> Film {
        let x = (thickness / 0.03).clamp(0.0, 1.0);
        let ior = 1.0 + (film_ior - 1.0) * x * x * (3.0 - 2.0 * x);
        let inside = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).max(0.0).sqrt();
        let base_ior = f0.map(|f0| {
            let root = f0.clamp(0.0, 0.9999).sqrt();
            (1.0 + root) / (1.0 - root)
        });
        Film {
            top: schlick(cosine, ((ior - 1.0) / (ior + 1.0)).powi(2)),
            bottom: base_ior.map(|base| schlick(inside, ((base - ior) / (base + ior)).powi(2))),
            difference: 2.0 * ior * thickness * inside,
            shifts: base_ior.map(|base| if base < ior { TAU } else { PI }),
        }
    }

    /// The sum of so many terms. Each is the colour of waves whose ways differ by so many passages of the film.
    fn reflectance(&self, terms: usize) -> [f64; 3] {
        // The two boundaries by channel, though the phases are by x, y and z: as the paper's code has it.
        let colours = (1..=terms).map(|m| {
            let phase = TAU * self.difference * 1e-9 * m as f64;
            let xyz = [0, 1, 2].map(|i| {
                let waves = SENSITIVITIES[i].iter().map(|[at, variance, height]| {
                    let size = height * (TAU * variance).sqrt() * (-variance * phase * phase).exp() / 1.0685e-7;
                    size * (at * phase + m as f64 * self.shifts[i]).cos()
                });
                waves.sum()
            });
            rgb(xyz)
        });
        let colours: Vec<[f64; 3]> = colours.collect();
        [0, 1, 2].map(|c| {
            let passed = 1.0 - self.top;
            let both = (self.top * self.bottom[c]).min(0.9999);
            let series = passed * passed * self.bottom[c] / (1.0 - both);
            let waves = colours.iter().zip(1..).map(|(colour, m)| both.sqrt().powi(m) * 2.0 * colour[c]);
            (self.top + series + (series - passed) * waves.sum::<f64>()).clamp(0.0, 1.0)
        })
    }

    /// The same of waves that are summed at each frequency, with all their reflections: of the first channel, where all are alike. Their mean over
    /// all phases is grey, as in the paper's code.
    fn by_waves(&self) -> [f64; 3] {
        let bottom = self.bottom[0];
        let (top, below) = (self.top.sqrt(), bottom.sqrt());
        let airy = |frequency: f64| {
            // r = r1 + t1 t2 r2 e^(i phase) / (1 - r1' r2 e^(i phase)), with r1' = -r1: a shift of half a turn.
            let phase = TAU * self.difference * 1e-9 * frequency + self.shifts[0];
            let both = top * below;
            let through = (1.0 - self.top) * below;
            let (sine, cosine) = phase.sin_cos();
            let (re, im) = (1.0 - both * cosine, -both * sine);
            let size = re * re + im * im;
            // Both terms start with the phase of the lower way, seen from the upper one.
            let (a, b) = (through * cosine, through * sine);
            let (x, y) = ((a * re + b * im) / size, (b * re - a * im) / size);
            (x - top).powi(2) + y * y
        };
        let mean = self.top + (1.0 - self.top).powi(2) * bottom / (1.0 - self.top * bottom);
        let xyz = SENSITIVITIES.map(|all| {
            let parts = all.iter().filter(|[_, _, height]| *height > 0.0).map(|[at, variance, height]| {
                // exp(-variance phase^2) is the transform of a Gaussian of twice this variance.
                let sigma = (2.0 * variance).sqrt();
                let steps = 4000;
                let (mut sum, mut weight) = (0.0, 0.0);
                for step in 0..steps {
                    let x = 12.0 * ((step as f64 + 0.5) / steps as f64 - 0.5);
                    let share = (-0.5 * x * x).exp();
                    sum += share * (airy(at + sigma * x) - mean);
                    weight += share;
                }
                height * (TAU * variance).sqrt() / 1.0685e-7 * sum / weight
            });
            parts.sum()
        });
        rgb(xyz).map(|c| mean + c)
    }
}

/// The formula.
pub fn thin_film(cosine: f64, ior: f64, thickness: f64, f0: [f64; 3]) -> [f64; 3] {
    Film::new(cosine, ior, thickness, f0).reflectance(2)
}

/// How much f32 may be off: a wave counts fewer than a thousandth of the way in nm, each with its roundings, and turns by 2 pi each; a colour is
/// at most 5.3 times x, y or z, and both terms together have at most 4 times that. The rest are roundings, of numbers that
/// a base which reflects nearly all divides by 1 - its root.
pub fn off(ior: f64, thickness: f64) -> f64 {
    let waves = 2.0 * 0.0022399 * 2.0 * ior * thickness;
    4.0 * 5.3 * U * (32.0 + 4.0 * TAU * waves.min(400.0)) + 256.0 * U
}

fn rows(random: &mut Random) -> Vec<In> {
    let row = |i: usize| In {
        f0: [[0.04; 3], [0.9, 0.6, 0.3], [1e-5; 3], [1.0, 0.5, 0.01], [0.2; 3]][i % 5],
        cosine: [random.uniform() as f32, decades(random, -6.0, 0.0) as f32, 0.0, 1.0][i / 2 % 4],
        // None is that of what lies below, where the phase turns.
        ior: [1.3, 1.0, 2.0, 1.45, 1000.0][i / 3 % 5],
        thickness: [400.0, decades(random, -3.0, 6.0) as f32, 0.0, 100.0 + 900.0 * random.uniform() as f32][i % 4],
        padding: [0.0; 2],
    };
    (0..20_000).map(row).collect()
}

/// Rows that are off by more than f32 explains.
fn faults(rows: &[In], kernel: &Kernel) -> usize {
    let pairs = rows.iter().zip(kernel.run::<_, [f32; 4]>(rows));
    let wrong = |(row, found): &(&In, [f32; 4])| {
        let (ior, thickness) = (f64::from(row.ior), f64::from(row.thickness));
        let expected = thin_film(f64::from(row.cosine), ior, thickness, row.f0.map(f64::from));
        let limit = off(ior, thickness);
        (0..3).any(|c| {
            let is_there = (0.0..=1.0).contains(&found[c]);
            !is_there || (f64::from(found[c]) - expected[c]).abs() > limit
        })
    };
    pairs.filter(wrong).count()
}

const PLANTED: [Plant; 4] = [
    ("lib/thin_film", "base_ior < vec3<f32>(ior)", "base_ior > vec3<f32>(ior)"),
    ("lib/thin_film", "0.0016810", "0.0016840"),
    ("lib/thin_film", "(first + second)", "first"),
    ("lib/thin_film", "schlick({{min(inside, 1.0)}},", "cosine"),
];

#[test]
fn films_reflect_by_their_formula() {
    let rows = rows(&mut Random(701));
    assert_eq!(faults(&rows, &Kernel::of(FILM, &[])), 0);
    let setup = Setup { plants: &PLANTED, values: &values_of(FILM), ..Setup::default() };
    let kernel = Kernel::with("test/expression", &setup);
    for (number, planted) in PLANTED.iter().enumerate() {
        let found = faults(&rows, &kernel.planted(number));
        assert!(found > 1000, "{planted:?} is found in {found} rows");
    }
}

/// All waves of the film, at each frequency, against the first two terms. What the others have is at most the rest of a geometric series.
#[test]
fn films_reflect_as_waves_do() {
    let mut random = Random(703);
    let (mut worst, mut other) = (0.0f64, 0.0f64);
    for _ in 0..300 {
        let (cosine, ior) = (0.05 + 0.95 * random.uniform(), 1.05 + random.uniform());
        let thickness = 1000.0 * random.uniform();
        let film = Film::new(cosine, ior, thickness, [random.uniform() * 0.9; 3]);
        let (waves, terms, all) = (film.by_waves(), film.reflectance(2), film.reflectance(60));
        let root = (film.top * film.bottom[0]).sqrt();
        let rest = 5.3 * 2.0 * (1.0 - film.top) * root.powi(3) / (1.0 - root);
        let shifted = Film { shifts: film.shifts.map(|shift| shift + 0.3), ..film }.reflectance(60);
        for c in 0..3 {
            // The sum over the spectrum may leave 0..1, since the colours of pure waves do.
            let inside = waves[c].clamp(0.0, 1.0);
            worst = worst.max((all[c] - inside).abs());
            other = other.max((shifted[c] - inside).abs());
            assert!((terms[c] - inside).abs() < rest + 1e-3, "{terms:?} of {waves:?}");
        }
    }
    println!("all terms are off by {worst:.4}, a shift of 0.3 by {other:.4}");
    assert!(worst < 1e-3 && other > 0.05, "{worst}, {other}");
}
