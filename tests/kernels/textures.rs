//! texture/*, lib/bilinear and lib/sphere_map: colours at points, against f64.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use gpu_rt::bitmap::{Bitmap, FORMATS, Format, SRGB};
use gpu_rt::data::{Settings, Texture};
use gpu_rt::gpu::link::{Choices, Entry, Reason};

use crate::common::kernel::{Expression, Fault, Kernel, Setup, array, values_of};
use crate::common::oracles::{NOISE_ERROR, perlin, turbulence};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};

rows! {
    struct In {
        texture: Texture,
        point: [f32; 3], along_z: f32,
        uv: [f32; 2], phase: f32, wraps: u32,
    }
}

type Colour = [f32; 4];

fn kernel(texture: &str, replaced: &[Fault<'_>]) -> Kernel {
    Kernel::with("test/texture", &Setup { replaced, values: &[("texture", texture)], ..Setup::default() })
}

fn colour(out: &Colour) -> [f32; 3] {
    [out[0], out[1], out[2]]
}

#[test]
fn checker_cells_alternate_on_both_sides_of_zero() {
    let mut random = Random(91);
    let texture = Texture { first: [1.0, 0.5, 0.25], second: [0.0, 2.0, 8.0], ..Texture::default() };
    let mut points: Vec<[f32; 3]> =
        (0..20_000).map(|_| rounded(decades(&mut random, -2.0, 4.0) * unit(&mut random))).collect();
    points.extend((0..5000).map(|_| rounded((20.0 * unit(&mut random)).round())));
    points.extend([[0.0; 3], [-0.0; 3], [-1e-30, 0.5, 0.5], [-1e-40, 0.5, 0.5], [1e-30, -1e-30, 0.5]]);
    let rows: Vec<In> = points.iter().map(|&point| In { texture, point, ..In::default() }).collect();
    let wrong = |kernel: &Kernel| {
        let found = kernel.run::<_, Colour>(&rows);
        let even = |p: &[f32; 3]| exact(*p).floor().to_array().iter().map(|c| *c as i64).sum::<i64>() % 2 == 0;
        // WGSL may take a subnormal for zero.
        let tiny = |p: &[f32; 3]| p.iter().any(|c| c.is_subnormal());
        let expected = |p: &[f32; 3]| if even(p) { texture.first } else { texture.second };
        points.iter().zip(&found).filter(|(p, out)| !tiny(p) && colour(out) != expected(p)).count()
    };
    assert_eq!(wrong(&kernel("checker", &[])), 0);
    // By truncation the two cells around zero are one.
    assert!(wrong(&kernel("checker", &[("texture/checker", "floor(at.point)", "at.point")])) > 1000);
}

/// Squares in texture coordinates take turns along both axes; all points are inside of squares by more than rounding.
#[test]
fn squares_alternate_along_both_axes() {
    let mut random = Random(97);
    let (first, second) = ([1.0, 0.5, 0.25], [0.0, 2.0, 8.0]);
    let mut rows = Vec::new();
    for _ in 0..5000 {
        let parameter = (2.0f64.powf(6.0 * random.uniform())) as f32;
        let cell = [0; 2].map(|_| (random.uniform() * f64::from(parameter)).floor());
        let uv = cell.map(|cell| ((cell + 0.01 + 0.98 * random.uniform()) / f64::from(parameter)) as f32);
        let is_even = (cell[0] + cell[1]) as i64 % 2 == 0;
        rows.push((
            In { texture: Texture { first, second, parameter, ..Texture::default() }, uv, ..In::default() },
            is_even,
        ));
    }
    let inputs: Vec<In> = rows.iter().map(|(row, _)| *row).collect();
    let wrong = |kernel: &Kernel| {
        let found = kernel.run::<_, Colour>(&inputs);
        rows.iter()
            .zip(&found)
            .filter(|((_, is_even), out)| colour(out) != if *is_even { first } else { second })
            .count()
    };
    assert_eq!(wrong(&kernel("uv_checker", &[])), 0);
    assert!(wrong(&kernel("uv_checker", &[("texture/uv_checker", "cell.x + cell.y", "cell.x")])) > 1000);
}

/// An angle minus a multiple of 2 pi, and its sine.
const TURN: Expression<'_> = [
    "texture/marble",
    "f32",
    "vec2<f32>",
    "vec2<f32>(within_one_turn(given), circle_point(within_one_turn(given) * 0.15915494).y)",
];

/// The widest angle: stripes of a scale of 100 along 100 units, and turbulence.
const WIDEST: f64 = 1e4;

#[test]
fn angles_come_down_to_one_turn() {
    let mut random = Random(92);
    let mut angles: Vec<f32> = (0..30_000).map(|_| (WIDEST * (2.0 * random.uniform() - 1.0)) as f32).collect();
    angles.extend((0..10_000).map(|_| (decades(&mut random, -6.0, 4.0) * (2.0 * random.uniform() - 1.0)) as f32));
    // Next to the odd multiples of pi, where the rounding of the turns decides.
    angles.extend((-1500..1500).map(|i| ((2.0 * f64::from(i) + 1.0) * PI) as f32));
    let worst = |kernel: &Kernel| {
        let found = kernel.run::<_, [f32; 2]>(&angles);
        angles.iter().zip(found).fold([0.0f64; 3], |worst, (&angle, [reduced, sine])| {
            let (angle, reduced) = (f64::from(angle), f64::from(reduced));
            let turns = (angle - reduced) / TAU;
            let off = ((turns - turns.round()) * TAU).abs();
            [worst[0].max(off), worst[1].max(reduced.abs() - PI), worst[2].max((f64::from(sine) - angle.sin()).abs())]
        })
    };
    let own = worst(&Kernel::of(TURN, &[]));
    // 1592 turns at most: the second part of the turn and its product are off by 3 u of itself, 1592 x 0.0019 = 3; the
    // last difference rounds by 4 u. Measured 3 u.
    assert!(own[0] <= 8.0 * U, "{:e}", own[0]);
    // It goes beyond pi by the rounding of angle / 2 pi alone: 2 x 1592 u of a turn.
    assert!(own[1] <= 2.0 * 1592.0 * U * TAU, "{:e}", own[1]);
    // And its sine: 4 u beside, and 2 u of pi by the way in turns.
    assert!(own[2] <= (8.0 + 4.0 + 2.0 * PI) * U, "{:e}", own[2]);
    // In one part, whose multiples round.
    let replaced =
        [("texture/marble", "(angle - turns * 6.28125) - turns * 0.0019353072", "angle - turns * 6.2831855")];
    let wrong = worst(&Kernel::of(TURN, &replaced));
    assert!(wrong[0] > 100.0 * U, "{:e}", wrong[0]);
}

#[test]
fn noise_and_marble_are_what_their_formulas_say() {
    let mut random = Random(93);
    let first = [1.0, 0.5, 0.25];
    let rows: Vec<In> = (0..5000)
        .map(|_| {
            let texture = Texture { first, parameter: decades(&mut random, -1.0, 2.0) as f32, ..Texture::default() };
            let point = rounded(50.0 * random.uniform() * unit(&mut random));
            // The stripes' angle comes in two parts: along z from the frame's origin, and the phase there.
            let along_z = (20.0 * random.uniform() - 10.0) as f32;
            let phase = (TAU * (random.uniform() - 0.5)) as f32;
            In { texture, point, along_z, phase, ..In::default() }
        })
        .collect();
    let marble = |row: &In| {
        let angle = f64::from(row.texture.parameter) * f64::from(row.along_z) + f64::from(row.phase);
        0.5 * (1.0 + (angle + 10.0 * turbulence(exact(row.point))).sin())
    };
    let noise = |row: &In| 0.5 * (1.0 + perlin(exact(row.point)));
    // The angle, up to 1000, is rounded twice; the sine is good to 4 u.
    for (name, formula, allowed) in [
        ("noise", &noise as &dyn Fn(&In) -> f64, NOISE_ERROR),
        ("marble", &marble, 4.0 * U + 0.5 * (2.0 * 1000.0 * U + 10.0 * 2.0 * NOISE_ERROR)),
    ] {
        let off = |formula: &dyn Fn(&In) -> f64| {
            let found = kernel(name, &[]).run::<_, Colour>(&rows);
            rows.iter().zip(found).fold(0.0f64, |worst, (row, out)| {
                let off = (0..3).map(|i| (f64::from(out[i]) - f64::from(first[i]) * formula(row)).abs());
                off.fold(worst, f64::max)
            })
        };
        let own = off(formula);
        assert!(own <= allowed, "{name}: {own:e}");
        // Without the octaves, and with the other sign.
        let wrong = match name {
            "noise" => off(&|row| 0.5 * (1.0 - perlin(exact(row.point)))),
            _ => off(&|row| 0.5 * (1.0 + (f64::from(row.texture.parameter) * f64::from(row.along_z)).sin())),
        };
        assert!(wrong > 100.0 * allowed, "{name}: {wrong:e}");
    }
}

/// An image of random texels, linear between their centres, held or wrapped at its edges.
pub struct Image {
    pub first: u32,
    pub width: u32,
    pub height: u32,
}

impl Image {
    /// In f64, at u to the right and v up. `wraps`: to the right and downwards.
    pub fn at(&self, texels: &[[f32; 3]], u: f64, v: f64, wraps: [bool; 2]) -> DVec3 {
        let (w, h) = (i64::from(self.width), i64::from(self.height));
        let (x, y) = (u * w as f64 - 0.5, (1.0 - v) * h as f64 - 0.5);
        let texel = |column: i64, row: i64| {
            let column = if wraps[0] { column.rem_euclid(w) } else { column.clamp(0, w - 1) };
            let row = if wraps[1] { row.rem_euclid(h) } else { row.clamp(0, h - 1) };
            exact(texels[self.first as usize + (row * w + column) as usize])
        };
        let (left, top) = (x.floor(), y.floor());
        let (column, row) = (left as i64, top as i64);
        let above = texel(column, row).lerp(texel(column + 1, row), x - left);
        let below = texel(column, row + 1).lerp(texel(column + 1, row + 1), x - left);
        above.lerp(below, y - top)
    }
}

#[test]
fn images_are_linear_between_texels_and_meet_at_their_edges() {
    let mut random = Random(94);
    let mut images = Vec::new();
    let mut texels: Vec<[f32; 3]> = Vec::new();
    for (width, height) in [(1, 1), (1, 5), (5, 1), (2, 2), (7, 5), (31, 17), (4096, 2)] {
        images.push(Image { first: texels.len() as u32, width, height });
        texels.extend((0..width * height).map(|_| [0; 3].map(|_| random.uniform() as f32)));
    }
    let mut rows = Vec::new();
    let mut of = Vec::new();
    for (i, image) in images.iter().enumerate() {
        let texture = Texture {
            first: [1.0; 3],
            texel: 3 * image.first,
            width: image.width,
            height: image.height,
            ..Texture::default()
        };
        for wraps in 0..4 {
            let mut points: Vec<[f32; 2]> =
                (0..1000).map(|_| [random.uniform() as f32, random.uniform() as f32]).collect();
            // Edges, texel centres and the lines between texels.
            let along = |n: u32| (0..=2 * n.min(20)).map(move |k| k as f32 / (2 * n) as f32).chain([1.0]);
            points.extend(along(image.width).flat_map(|u| along(image.height).map(move |v| [u, v])));
            rows.extend(points.iter().map(|&uv| In { texture, uv, wraps, ..In::default() }));
            of.extend(points.iter().map(|_| i));
        }
    }
    let worst = |kernel: &Kernel| {
        let found = kernel.run_with::<_, Colour>(&rows, rows.len(), &[array("texels", &texels)]);
        rows.iter().zip(&of).zip(&found).fold(0.0f64, |worst, ((row, &i), out)| {
            let image = &images[i];
            let expected =
                image.at(&texels, f64::from(row.uv[0]), f64::from(row.uv[1]), [1, 2].map(|bit| row.wraps & bit != 0));
            // The position in texels is off by two roundings of itself, and the texels differ by 1 at most; 1 - v rounds at
            // most as much again. Three blends of four roundings.
            let rounding = 3.0 * U * f64::from(image.width + image.height);
            worst.max((exact(colour(out)) - expected).abs().max_element() / (rounding + 12.0 * U))
        })
    };
    let own = worst(&kernel("image", &[]));
    assert!(own <= 1.0, "{own}");
    // Texel centres at integers; and no wrapping along either axis.
    let plants = [
        ("lib/bilinear", "u * f32(width) - 0.5", "u * f32(width - 1u)"),
        ("lib/bilinear", "i32(width), {{wraps.x}}", "false"),
        ("lib/bilinear", "i32(height), {{wraps.y}}", "false"),
    ];
    let planted =
        Kernel::with("test/texture", &Setup { plants: &plants, values: &[("texture", "image")], ..Setup::default() });
    assert!([0, 1, 2].iter().all(|number| worst(&planted.planted(*number)) > 1000.0));
}

/// On the device, the texels of each format are the host's to the bit.
#[test]
fn texels_of_every_format_are_those_of_the_host() {
    let mut random = Random(96);
    let (width, height) = (16, 16);
    let mut code = |index: usize| if index < 256 { index as u8 } else { random.bits() as u8 };
    let codes: Vec<[u8; 3]> = (0..256).map(|i| [code(i), code(256), code(256)]).collect();
    let images = [
        Bitmap::of_floats(width, height, codes.iter().map(|texel| texel.map(|c| f32::from(c) * 0.3))),
        Bitmap::of_codes(width, height, Format::Srgb, codes.iter().copied()),
        Bitmap::of_codes(width, height, Format::Linear, codes.iter().copied()),
        Bitmap::of_numbers(width, height, codes.iter().map(|[r, ..]| *r)),
    ];
    let (mut words, mut rows, mut expected) = (SRGB.map(f32::to_bits).to_vec(), Vec::new(), Vec::new());
    for image in &images {
        let texture = Texture {
            first: [1.0; 3],
            texel: words.len() as u32,
            width,
            height,
            format: image.format.number() as u32,
            ..Texture::default()
        };
        words.extend(image.words.iter());
        // At the centres of texels.
        let uv_of = |i: usize| [(i % 16) as f32 + 0.5, 15.5 - (i / 16) as f32].map(|x| x / 16.0);
        rows.extend((0..image.len()).map(|i| In { texture, uv: uv_of(i), ..In::default() }));
        expected.extend(image.texels());
    }
    let entry = |(number, name): (usize, &&str)| Entry {
        name: name.to_string(),
        number: number as u32,
        closes: number + 1 == FORMATS.len(),
        why: Reason::EveryRender,
    };
    let mut plan = Choices::default();
    plan.lists.insert("texel_format", FORMATS.iter().enumerate().map(entry).collect());
    let setup = Setup { values: &[("texture", "image")], plan, ..Setup::default() };
    let kernel = Kernel::with("test/texture", &setup);
    let wrong = |words: &[u32]| {
        let found = kernel.run_with::<_, Colour>(&rows, rows.len(), &[array("texels", words)]);
        let bits = |texel: [f32; 3]| texel.map(f32::to_bits);
        found.iter().zip(&expected).filter(|(out, expected)| bits(colour(out)) != bits(**expected)).count()
    };
    assert_eq!(wrong(&words), 0);
    // One value of the table that is the next to it, and one channel of a texel.
    words[77] += 1;
    words[256 + 3 * 9] += 1;
    assert!(wrong(&words) >= 2);
}

/// Directions everywhere, and ever closer to the poles and to the seam.
fn directions() -> Vec<[f32; 4]> {
    let mut random = Random(95);
    let mut all: Vec<DVec3> = (0..20_000).map(|_| unit(&mut random)).collect();
    for exponent in 1..=10 {
        for _ in 0..50 {
            let near = 10f64.powi(-exponent) * unit(&mut random);
            all.extend(DVec3::AXES.iter().flat_map(|axis| [axis + near, near - axis]));
        }
    }
    let seam = [DVec3::new(-0.6, 0.8, -0.0), DVec3::new(-0.0, 0.8, 0.6)];
    all.extend([DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].into_iter().chain(seam));
    all.into_iter().map(|d| rounded(d.normalize())).map(|[x, y, z]| [x, y, z, 0.0]).collect()
}

/// Clarberg's map from the square to the sphere, the inverse of the kernels' one.
fn of_square(p: [f64; 2]) -> DVec3 {
    let [x, y] = p.map(|x| 2.0 * x - 1.0);
    let signed = 1.0 - x.abs() - y.abs();
    let r = 1.0 - signed.abs();
    let angle = if r == 0.0 { 0.0 } else { ((y.abs() - x.abs()) / r + 1.0) * PI / 4.0 };
    let long = r * (2.0 - r * r).sqrt();
    DVec3::new((angle.cos() * long).copysign(x), (angle.sin() * long).copysign(y), (1.0 - r * r).copysign(signed))
}

/// The share of the angle is off by 10 u, r by 4 and what is added by 2; the way back doubles this twice at most.
const SQUARE: f64 = 4.0 * 16.0 * U;

#[test]
fn directions_map_to_the_square_of_an_octahedral_sky() {
    let rows = directions();
    let kernel =
        Kernel::of(["lib/square_map", "vec4<f32>", "vec4<f32>", "vec4<f32>(square_map(given.xyz), 0.0, 0.0)"], &[]);
    let found = kernel.run::<_, [f32; 4]>(&rows);
    let (mut worst, mut wrong) = (0.0f64, 0.0f64);
    for ([x, y, z, _], [u, v, ..]) in rows.iter().zip(&found) {
        assert!([u, v].iter().all(|value| (0.0..=1.0).contains(*value)), "{x} {y} {z}: {u} {v}");
        let n = exact([*x, *y, *z]).normalize();
        worst = worst.max((of_square([f64::from(*u), f64::from(*v)]) - n).length());
        wrong = wrong.max((of_square([f64::from(*v), f64::from(*u)]) - n).length());
    }
    assert!(worst <= SQUARE, "{worst:e} {SQUARE:e}");
    assert!(wrong > 1.0);
}

/// An angle of pi by 8 u, and its way into turns and back by 2 u of pi.
const ANGLE: f64 = 10.0 * PI * U;

#[test]
fn directions_map_to_their_texture_coordinates_on_sphere_and_sky() {
    let rows = directions();
    let both = "vec4<f32>(sphere_uv_at(given.xyz), sky_uv(given.xyz))";
    let kernel = Kernel::of(["lib/sphere_map", "vec4<f32>", "vec4<f32>", both], &[]);
    let found = kernel.run::<_, [f32; 4]>(&rows);
    let mut worst = [0.0f64; 4];
    let mut wrong = 0.0f64;
    for ([x, y, z, _], out) in rows.iter().zip(&found) {
        assert!(out.iter().all(|value| (0.0..=1.0).contains(value)), "{x} {y} {z}: {out:?}");
        let n = exact([*x, *y, *z]);
        let n = n.normalize();
        // u = (atan2(-z, x) + pi) / 2 pi and v = acos(-y) / pi of a sphere; of the sky -z in the middle, +x on the right.
        let [u, v, right, down] = out.map(f64::from);
        let around = |a: f64, b: f64| ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs() * TAU;
        worst[0] = worst[0].max(around(u, ((-n.z).atan2(n.x) + PI) / TAU));
        worst[1] = worst[1].max((v - (-n.y).acos() / PI).abs() * PI);
        worst[2] = worst[2].max(around(right, 0.5 + n.x.atan2(-n.z) / TAU));
        worst[3] = worst[3].max((down - n.y.acos() / PI).abs() * PI);
        wrong = wrong.max(around(u, (n.z.atan2(n.x) + PI) / TAU));
    }
    assert!(worst.iter().all(|off| *off <= ANGLE), "{worst:?}");
    // With z's sign turned.
    assert!(wrong > 1.0);
    // The axes themselves, said in words: a sphere's u is a quarter at +z, half at +x; v is 1 at the top. The sky's middle
    // is -z, its right half +x, its top row +y.
    let axes = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, -1.0, 0.0f32]];
    let found = kernel.run::<_, [f32; 4]>(&axes);
    for (uv, expected) in found.iter().zip([[0.5, 0.5, 0.75, 0.5], [0.25, 0.5, 1.0, 0.5], [0.75, 0.5, 0.5, 0.5f32]]) {
        let off = uv.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(f64::from(off) < ANGLE, "{uv:?} is not {expected:?}");
    }
}

fn background(kind: &'static str, settings: &Settings, texels: &[[f32; 3]], rows: &[[f32; 4]]) -> Vec<Colour> {
    let radiance = format!("vec4<f32>({kind}_background(given.xyz), 0.0)");
    let module = format!("background/{kind}");
    let values = values_of([&module, "vec4<f32>", "vec4<f32>", &radiance]);
    let setup = Setup { values: &values, facts: &[("camera_axes", false)], ..Setup::default() };
    let kernel = Kernel::with("test/expression", &setup);
    kernel.run_with(rows, rows.len(), &[kernel.settings(settings), array("texels", texels)])
}

#[test]
fn backgrounds_shine_as_their_formulas_say() {
    let rows = directions();
    let settings =
        Settings { background_bottom: [1.0, 0.25, 0.5], background_top: [0.5, 0.75, 1e3], ..Settings::default() };
    for out in background("solid", &settings, &[], &rows) {
        assert_eq!(colour(&out), settings.background_bottom);
    }
    let (bottom, top) = (exact(settings.background_bottom), exact(settings.background_top));
    for (row, out) in rows.iter().zip(background("gradient", &settings, &[], &rows)) {
        let expected = bottom.lerp(top, 0.5 * (f64::from(row[1]) + 1.0));
        let off = (exact(colour(&out)) - expected).abs() / bottom.max(top);
        assert!(off.max_element() <= 4.0 * U, "{row:?}: {out:?}");
    }
    // A sky of 4 x 2 texels: by octants, away from the lines between them.
    let texels: Vec<[f32; 3]> = (0..8).map(|i| [i as f32, 1.0, 0.0]).collect();
    let sky = Settings { background_width: 4, background_height: 2, ..settings };
    let centres: Vec<[f32; 4]> = (0..8)
        .map(|i| {
            let uv = DVec2::new((f64::from(i % 4) + 0.5) / 4.0, (f64::from(i / 4) + 0.5) / 2.0);
            let (azimuth, polar) = (TAU * (uv.x - 0.5), PI * uv.y);
            let [x, y, z] = rounded(DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos()));
            [x, y, z, 0.0]
        })
        .collect();
    for (i, out) in background("image", &sky, &texels, &centres).iter().enumerate() {
        // Off by the error of atan2 in texels, times the texels' differences.
        let off = (exact(colour(out)) - bottom * DVec3::new(i as f64, 1.0, 0.0)).abs().max_element();
        assert!(off < 4.0 * ANGLE * 4.0, "{i}: {out:?}");
    }
}
