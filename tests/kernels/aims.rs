//! light_path/aims, light_path/parallel_aims: the directions of light paths against their densities, from starts on, in and beside the boxes that are aimed at.
//! (What a camera path claims of its density is tests/images/followed_back.rs.)

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use gpu_rt::data::Cuboid;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::RenderOptions;
use gpu_rt::scene::Scene;

use crate::common::kernel::{Kernel, Plant, Setup, array};
use crate::common::rows::rows;
use crate::common::stats::{Random, chi_square, sidak};
use crate::common::vectors::{U, exact, rounded, unit};

const ALPHA: f64 = 1e-6;
const DRAWS: usize = 1 << 15;
/// Cells of equal size of the sphere of directions, or of a square around the boxes' shadow; points within each, at which the density is known.
const CELLS: (usize, usize) = (24, 16);
const POINTS: usize = 12;
const AIMS: usize = 16;

rows! {
    struct In {
        start: [f32; 3], light: u32,
        rounded: [f32; 3], what: u32,
        along: [f32; 3], padding: u32,
    }

    struct Out {
        drawn: [f32; 3], density: f32,
        again: f32, padding: [f32; 3],
    }
}

const BALL: &str = "Sphere(center: (-0.5, 0.5, -2.5), radius: 0.5, material: \"glass\")";
/// The lamp is a mirror too, so that there is a box around it alone.
const QUAD: &str = "Quad(corner: (0.5, 0.5, -3), u: (1, 0, 0), v: (0, 0, 0.5), material: \"lamp\")";
const BOX: &str = "Box(min: (0.5, -0.25, -3), max: (1.25, 0.5, -2.5), material: \"lamp\")";
const ON_QUAD: [[f64; 3]; 3] = [[1.0, 0.5, -2.75], [0.5, 0.5, -2.75], [0.5, 0.5, -3.0]];
const ON_BOX: [[f64; 3]; 3] = [[0.5, 0.125, -2.75], [0.5, 0.5, -2.75], [1.25, 0.5, -2.5]];

/// Objects of which the last is the lamp, and points of it; one is in its middle, one on its edge, one in its corner.
fn scenes() -> Vec<(&'static str, String, Vec<[f64; 3]>)> {
    let turned = |object: &str| format!("Transformed(by: [RotateY(33)], object: {object})");
    let turn = |point: &[f64; 3]| {
        let (sine, cosine) = 33f64.to_radians().sin_cos();
        [cosine * point[0] + sine * point[2], point[1], cosine * point[2] - sine * point[0]]
    };
    let two = "Box(min: (-1, -0.5, -3.5), max: (1, 0.5, -2.5), material: \"glass\"), Box(min: (0, -0.5, -3), max: (1.5, 1, -2), material: \"glass\"),";
    let many: String = (0..24)
        .map(|i| format!("Sphere(center: ({}, {}, -4), radius: 0.45, material: \"glass\"),", i % 6, i / 6 - 2))
        .collect();
    let moving = |object: &str| {
        format!("Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0.25, 0.5, 0))])], object: {object})")
    };
    vec![
        ("a flat lamp", format!("{BALL}, {QUAD}"), ON_QUAD.to_vec()),
        ("a thick lamp", format!("{BALL}, {BOX}"), ON_BOX.to_vec()),
        ("a flat lamp, turned", format!("{BALL}, {}", turned(QUAD)), ON_QUAD.iter().map(turn).collect()),
        ("a thick lamp, turned", format!("{BALL}, {}", turned(BOX)), ON_BOX.iter().map(turn).collect()),
        (
            "a lamp on a block of glass",
            format!("Box(min: (0.25, 0, -3.5), max: (1.75, 0.5, -2), material: \"glass\"), {QUAD}"),
            ON_QUAD.to_vec(),
        ),
        ("a lamp in two blocks and on one", format!("{two} {QUAD}"), ON_QUAD.to_vec()),
        (
            "a lamp in the plane of a disk",
            format!("Disk(center: (0, 0.5, -3), normal: (0, 1, 0), radius: 1.25, material: \"glass\"), {BALL}, {QUAD}"),
            ON_QUAD.to_vec(),
        ),
        ("groups", format!("{many} {QUAD}"), ON_QUAD.iter().copied().chain([[1.0, 0.0, -4.0]]).collect()),
        ("what moves", format!("{}, {}", moving(BALL), moving(BOX)), ON_BOX.to_vec()),
    ]
}

fn flattened(objects: &str) -> DeviceScene {
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40, shutter: (0, 1)), background: Solid((0, 0, 0)),
         materials: {{\"glass\": Dielectric(ior: 1.5), \"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"lamp\": Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 1, roughness: 0, emission: Rgb(1, 1, 1))}},
         objects: [Quad(corner: (-4, -1, 0), u: (8, 0, 0), v: (0, 0, -8), material: \"floor\"), {objects}])"
    );
    let scene = Scene::parse(&text, Path::new("test.ron")).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let flat = flatten(&scene, (16, 16), &RenderOptions::default()).expect("it flattens");
    assert!(!flat.aims.is_empty(), "{objects}");
    flat
}

const PLANTED: [Plant; 5] = [
    // The box of the lamp forgotten where a box is chosen, or where its weight is summed up.
    ("light_path/aims", "if {{is_aimed_at(i, light)}}", "true"),
    ("light_path/aims", "&& {{is_aimed_at(i, light)}}", "true"),
    // A start in a box.
    ("light/cuboid", "{{4.0 * PI}}, is_in_cuboid", "3.96 * PI"),
    // 1 % of a density.
    ("light_path/aims", "DirectionSample(direction, {{weight / choice.sum}})", "1.01 * weight / choice.sum"),
    ("light_path/aims", "{{weight_on_ray(ray, light, 0.0)}} / sum", "1.01 * weight_on_ray(ray, light, 0.0)"),
];

fn kernel(plants: &[Plant]) -> Kernel {
    Kernel::with("test/aims", &Setup { values: &[("aims", &AIMS.to_string())], plants, ..Setup::default() })
}

/// A start, or a direction of a directional light, and the boxes.
struct Case {
    row: In,
    aims: Vec<Cuboid>,
}

fn cases() -> Vec<(String, Case)> {
    let mut random = Random(67);
    let mut cases = Vec::new();
    for (name, objects, points) in scenes() {
        let flat = flattened(&objects);
        // Boxes of weight 0 are never aimed at.
        let mut aims = flat.aims.clone();
        assert!(aims.len() <= AIMS, "{name}");
        aims.resize(AIMS, Cuboid { light: u32::MAX, ..Cuboid::default() });
        let scale = 2f64.powi(-flat.space.exponent);
        let light = flat.lights[0].code;
        for (i, point) in points.iter().enumerate() {
            let start = rounded(scale * DVec3::from_array(*point));
            // A hit rounds each coordinate by some units.
            let moved = exact(start) + 4.0 * U * exact(start).length() * unit(&mut random);
            let row = In { start, light, rounded: rounded(moved), ..In::default() };
            cases.push((format!("{name}, start {i}"), Case { row, aims: aims.clone() }));
        }
        for along in [DVec3::NEG_Y, unit(&mut random)] {
            let row = In { along: rounded(along), what: 1, ..In::default() };
            cases.push((format!("{name}, parallel rays along {along}"), Case { row, aims: aims.clone() }));
        }
    }
    cases
}

/// Two axes across a direction, which are not those of a box.
fn across(direction: DVec3) -> (DVec3, DVec3) {
    let (x, y) = direction.any_orthonormal_pair();
    let (sine, cosine) = 0.4f64.sin_cos();
    (cosine * x + sine * y, cosine * y - sine * x)
}

impl Case {
    /// Half the side of a square that holds the boxes' shadow, around the shadow of the first one.
    fn half_side(&self) -> f64 {
        let middle = exact(self.aims[0].center);
        let of = |aim: &Cuboid| (exact(aim.center) - middle).length() + exact(aim.half_extent).length();
        self.aims.iter().filter(|aim| aim.light != u32::MAX || aim.material != 0).map(of).fold(0.0, f64::max)
    }

    fn is_parallel(&self) -> bool {
        self.row.what == 1
    }

    /// The directions or parallel rays of the middle points of all cells, and how much of the sphere or plane each stands for.
    fn grid(&self) -> (Vec<In>, f64) {
        let (columns, rows) = (CELLS.0 * POINTS, CELLS.1 * POINTS);
        let share = 1.0 / (columns * rows) as f64;
        let points = (0..columns)
            .flat_map(|i| (0..rows).map(move |j| ((i as f64 + 0.5) / columns as f64, (j as f64 + 0.5) / rows as f64)));
        if !self.is_parallel() {
            let at = |(x, y): (f64, f64)| {
                let (z, angle) = (2.0 * y - 1.0, 2.0 * PI * x - PI);
                let across = (1.0 - z * z).sqrt();
                In { what: 2, along: rounded(DVec3::new(across * angle.cos(), across * angle.sin(), z)), ..self.row }
            };
            return (points.map(at).collect(), 4.0 * PI * share);
        }
        let (x_axis, y_axis) = across(exact(self.row.along));
        let half = self.half_side();
        let at = |(x, y): (f64, f64)| {
            let point = exact(self.aims[0].center) + half * ((2.0 * x - 1.0) * x_axis + (2.0 * y - 1.0) * y_axis);
            In { what: 3, start: rounded(point), ..self.row }
        };
        (points.map(at).collect(), 4.0 * half * half * share)
    }

    /// The cell of what was drawn.
    fn cell(&self, out: &Out) -> usize {
        let (x, y) = match self.is_parallel() {
            false => {
                let direction = exact(out.drawn);
                (direction.y.atan2(direction.x) / (2.0 * PI) + 0.5, 0.5 * (direction.z + 1.0))
            }
            true => {
                let (x_axis, y_axis) = across(exact(self.row.along));
                let point = exact(out.drawn) - exact(self.aims[0].center);
                (0.5 + 0.5 * point.dot(x_axis) / self.half_side(), 0.5 + 0.5 * point.dot(y_axis) / self.half_side())
            }
        };
        let bin = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
        bin(x, CELLS.0) * CELLS.1 + bin(y, CELLS.1)
    }
}

/// The findings of a case; nothing if it has no direction.
fn judge(case: &Case, kernel: &Kernel) -> Option<Judged> {
    let more = [array("aims", &case.aims)];
    let (grid, share) = case.grid();
    let known: Vec<Out> = kernel.run_with(&grid, grid.len(), &more);
    let drawn: Vec<Out> = kernel.run_with(std::slice::from_ref(&case.row), DRAWS, &more);
    if drawn.iter().all(|out| out.density == 0.0) {
        return None;
    }
    let integral: f64 = known.iter().map(|out| share * f64::from(out.density)).sum();
    let wrong = drawn.iter().filter(|out| ((out.density / out.again - 1.0).abs() >= 1e-3) || out.again == 0.0).count();
    let mut cells = vec![0u64; CELLS.0 * CELLS.1];
    drawn.iter().for_each(|out| cells[case.cell(out)] += 1);
    // The cells in which no density changes are known exactly. All others, and those that nothing is expected in, count as one.
    let (mut observed, mut expected) = (vec![drawn.len() as u64], vec![drawn.len() as f64]);
    // Where an edge crosses a cell, at most half a row of its points are on the wrong side.
    let mut unknown = 1e-4;
    for (cell, seen) in cells.iter().enumerate() {
        let (column, row) = (cell / CELLS.1, cell % CELLS.1);
        let at = |i: usize| (column * POINTS + i / POINTS) * CELLS.1 * POINTS + row * POINTS + i % POINTS;
        let within = || (0..POINTS * POINTS).map(|i| f64::from(known[at(i)].density));
        let (least, most) = (within().fold(f64::MAX, f64::min), within().fold(0.0, f64::max));
        unknown += share * 0.5 * POINTS as f64 * (most - least);
        if least > 0.0 && least == most {
            let want = share * (POINTS * POINTS * drawn.len()) as f64 * most;
            (observed[0], expected[0]) = (observed[0] - seen, expected[0] - want);
            observed.push(*seen);
            expected.push(want);
        }
    }
    expected[0] = expected[0].max(0.0);
    let p = chi_square(&observed, &expected, 1);
    Some(Judged { integral, unknown, wrong: wrong as f64 / DRAWS as f64, p })
}

/// The integral of the density, and what it may be off by; the share of draws whose density is another one where it is asked for; the p-value of
/// chi-square.
#[derive(Debug)]
struct Judged {
    integral: f64,
    unknown: f64,
    wrong: f64,
    p: f64,
}

/// The share of directions that rounding takes over an edge: 1.5e-5 measured.
const ROUNDED: f64 = 1e-3;

impl Judged {
    fn is_right(&self, threshold: f64) -> bool {
        (self.integral - 1.0).abs() < self.unknown && self.wrong < ROUNDED && self.p > threshold
    }
}

/// The densities of what is drawn are those that are claimed, from wherever a hit is rounded to; they integrate to 1; and directions are as frequent
/// as they say.
#[test]
fn light_paths_go_where_their_density_says() {
    let own = kernel(&[]);
    let cases = cases();
    let threshold = sidak(ALPHA, cases.len());
    for (name, case) in &cases {
        let judged = judge(case, &own).unwrap_or_else(|| panic!("{name}: no direction"));
        assert!(judged.is_right(threshold), "{name}: {judged:?}");
    }
    // Each planted error, with the number of cases that find it.
    let mut found = Vec::new();
    let with_plants = kernel(&PLANTED);
    for (number, plant) in PLANTED.iter().enumerate() {
        let kernel = with_plants.planted(number);
        let is_found =
            |(_, case): &&(String, Case)| !judge(case, &kernel).is_some_and(|judged| judged.is_right(threshold));
        found.push((plant, cases.iter().step_by(5).filter(is_found).count()));
    }
    assert!(found.iter().all(|(_, cases)| *cases > 0), "{found:?}");
}
