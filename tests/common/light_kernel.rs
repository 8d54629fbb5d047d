//! Directions towards lights on the device, by the kernel tests/shaders/light.wgsl; and spheres as lights in f64.

use bytemuck::Pod;
use glam::DVec3;
use gpu_rt::data::Sphere;

use super::kernel::{Fault, Kernel, Setup, array};
use super::rows::rows;
use super::stats::Random;
use super::vectors::{U, decades, exact, rounded, unit};

/// Draws for each configuration. Chi-square of 31 x 17 cells over 2^16 of them finds a density that is off by 6.6 % in the
/// root mean square with a probability of 99.9 %.
pub const DRAWS: usize = 1 << 16;

/// A cell of the square of a shape's coordinates, as light/parts has it.
#[derive(Clone, Copy, Debug)]
pub struct PartCell {
    pub exponents: [u32; 2],
    pub cell: [u32; 2],
    /// Of a triangle: the half above the diagonal.
    pub is_above: bool,
}

impl PartCell {
    pub fn code(&self) -> u32 {
        let [[i, j], [x, y]] = [self.cell, self.exponents];
        i | j << 11 | x << 22 | y << 26 | u32::from(self.is_above) << 30
    }

    pub fn size(&self) -> [f64; 2] {
        self.exponents.map(|exponent| 0.5f64.powi(exponent as i32))
    }

    pub fn low(&self) -> [f64; 2] {
        let size = self.size();
        [0, 1].map(|axis| f64::from(self.cell[axis]) * size[axis])
    }
}

/// Cells of several sizes: all of the shape, and parts of it.
pub const CELLS: [PartCell; 4] = [
    PartCell { exponents: [0, 0], cell: [0, 0], is_above: false },
    PartCell { exponents: [1, 1], cell: [0, 1], is_above: false },
    PartCell { exponents: [2, 2], cell: [1, 1], is_above: true },
    PartCell { exponents: [2, 2], cell: [2, 0], is_above: false },
];

rows! {
    pub struct In {
        from: [f32; 3], shape: u32,
        u: [f32; 2], padding: [f32; 2],
    }

    pub struct Out {
        direction: [f32; 3], pdf: f32,
        again: f32, distance: f32, padding: [f32; 2],
    }
}

/// A kind of light: its module in geometry, its type in WGSL, and whether it is a part of the shape.
pub type Kind = (&'static str, &'static str, bool);

pub const SPHERE: Kind = ("sphere", "Sphere", false);
pub const LARGE_SPHERE: Kind = ("large_sphere", "LargeSphere", false);
/// Corners; the code of the part is beside the first.
pub const TRIANGLE: Kind = ("triangle", "array<vec4<f32>, 3>", false);
pub const TRIANGLE_PART: Kind = ("triangle", "array<vec4<f32>, 3>", true);
pub const QUAD: Kind = ("quad", "Quad", false);
/// The light's number is the code of the part.
pub const QUAD_PART: Kind = ("quad", "Quad", true);
pub const DISK: Kind = ("disk", "Quad", false);
pub const DISK_PART: Kind = ("disk", "Quad", true);
pub const CUBOID: Kind = ("cuboid", "Cuboid", false);

pub fn kernel((shape, kind, is_part): Kind, replaced: &[Fault<'_>]) -> Kernel {
    let light = format!("{shape}{}", if is_part { "_parts" } else { "" });
    let calls = if shape == "triangle" {
        let corners = "Corners(shape[0].xyz, shape[1].xyz, shape[2].xyz)";
        let part = format!("part_of_triangle({corners}, bitcast<u32>(shape[0].w))");
        let own = if is_part { &*part } else { corners };
        [
            format!("corners_sample(from_point, {own}, u)"),
            format!("corners_pdf(from_point, {own})"),
            format!("face_hit(ray, {corners}).t"),
        ]
    } else {
        let (name, of) = if is_part { ("part", "shape, shape.light") } else { ("light", "shape") };
        [
            format!("{shape}_{name}_sample(from_point, {of}, u)"),
            format!("{shape}_{name}_pdf(from_point, sampled.direction, {of})"),
            format!("{shape}_distance(ray, shape)"),
        ]
    };
    let [sample, pdf, distance] = calls.each_ref().map(String::as_str);
    let values = [
        ("light", &*light),
        ("shape", shape),
        ("type", kind),
        ("sample", sample),
        ("pdf", pdf),
        ("distance", distance),
    ];
    Kernel::with("test/light", &Setup { replaced, values: &values, ..Setup::default() })
}

/// Many draws for each row; a few rows at a time, for a buffer's sake.
pub fn draws<S: Pod>(kind: Kind, rows: &[In], shapes: &[S], replaced: &[Fault<'_>]) -> Vec<Out> {
    let kernel = kernel(kind, replaced);
    let shapes = array("shapes", shapes);
    rows.chunks(32).flat_map(|rows| kernel.run_with(rows, rows.len() * DRAWS, std::slice::from_ref(&shapes))).collect()
}

/// The uniforms' ends in each dimension, and some between.
pub fn ends() -> Vec<[f32; 2]> {
    let all = [0.0, U as f32, 2f32.powi(-12), 0.3, 0.5, 1.0 - 2f32.powi(-12), 1.0 - U as f32];
    all.into_iter().flat_map(|x| all.map(|y| [x, y])).collect()
}

/// Answers every row for all of [`ends`].
pub fn at_ends<S: Pod>(kind: Kind, rows: &[In], shapes: &[S]) -> Vec<(In, Out)> {
    let rows: Vec<In> = rows.iter().flat_map(|row| ends().into_iter().map(|u| In { u, ..*row })).collect();
    let found = kernel(kind, &[]).run_with::<_, Out>(&rows, rows.len(), &[array("shapes", shapes)]);
    rows.into_iter().zip(found).collect()
}

/// Spheres of all sizes with points at r/D of each of these.
pub fn spheres(shares: &[f64], seed: u64) -> (Vec<In>, Vec<Sphere>) {
    let mut random = Random(seed);
    let (mut rows, mut shapes) = (Vec::new(), Vec::new());
    for &share in shares {
        let radius = decades(&mut random, -3.0, 1.0) as f32;
        // The point near the origin, so that it has its digits where it is close to the sphere's surface.
        let from = rounded(1e-3 * f64::from(radius) * unit(&mut random));
        let center = rounded(exact(from) + f64::from(radius) / share * unit(&mut random));
        rows.push(In { from, shape: shapes.len() as u32, ..In::default() });
        shapes.push(Sphere { center, radius, ..Sphere::default() });
    }
    (rows, shapes)
}

/// Half angle of the cone: sine and 1 - cosine, of the numbers that the device has.
pub fn cone(row: &In, sphere: &Sphere) -> (DVec3, f64, f64) {
    let to_center = exact(sphere.center) - exact(row.from);
    let sine = f64::from(sphere.radius) / to_center.length();
    (to_center.normalize(), sine, if sine >= 1.0 { 2.0 } else { sine * sine / (1.0 + (1.0 - sine * sine).sqrt()) })
}

pub const SHARES: [f64; 20] = [
    1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 2e-4, 1e-3, 1e-2, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999999,
    0.9999995, 0.9999999,
];

rows! {
    pub struct Triangle {
        a: [f32; 3], padding0: f32,
        b: [f32; 3], padding1: f32,
        c: [f32; 3], padding2: f32,
    }
}
