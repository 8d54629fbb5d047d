//! lib/basis: orthonormal around every unit vector, also near the poles.

use glam::DVec3;

use crate::common::kernel::{Expression, Kernel};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, exact, rounded, unit};
use crate::table::{Cell, FRISVAD};

rows! {
    struct Out {
        tangent: [f32; 3], padding0: u32,
        bitangent: [f32; 3], padding1: u32,
        point: [f32; 3], padding2: u32,
    }
}

/// The axes of a basis, and the point (1, 2, 3) in it.
const BASIS: Expression<'_> = [
    "lib/basis",
    "vec4<f32>",
    "array<vec4<f32>, 3>",
    "array(vec4(basis_around(given.xyz).tangent, 0.0), vec4(basis_around(given.xyz).bitangent, 0.0),
        vec4(from_basis(basis_around(given.xyz), vec3<f32>(1.0, 2.0, 3.0)), 0.0))",
];

/// The largest of the deviations from unit length and from right angles, without bound where the basis is left-handed;
/// and the largest error of a point in the basis.
fn worst(kernel: &Kernel, normals: &[DVec3]) -> (f64, f64) {
    let rows: Vec<[f32; 4]> = normals.iter().map(|n| rounded(*n)).map(|[x, y, z]| [x, y, z, 0.0]).collect();
    let (mut angle, mut point) = (0.0f64, 0.0f64);
    for ([x, y, z, _], out) in rows.iter().zip(kernel.run::<_, Out>(&rows)) {
        let (n, t, b) = (exact([*x, *y, *z]), exact(out.tangent), exact(out.bitangent));
        let off = [t.length() - 1.0, b.length() - 1.0, t.dot(b), t.dot(n), b.dot(n)];
        angle = off.iter().fold(angle, |worst, off| worst.max(off.abs()));
        if t.cross(b).dot(n) <= 0.0 {
            angle = f64::INFINITY;
        }
        point = point.max((exact(out.point) - (t + 2.0 * b + 3.0 * n)).length());
    }
    (angle, point)
}

/// Unit vectors `across` from the pole at z.
fn near_pole(random: &mut Random, z: f64, across: f64) -> Vec<DVec3> {
    let at_height = |at: DVec3| DVec3::new(at.x, at.y, z * (1.0 - at.x * at.x - at.y * at.y).sqrt());
    (0..200).map(|_| at_height(across * unit(random))).collect()
}

/// The table's cells of bases.
pub fn cells() -> Vec<Cell> {
    const FIGURE: &str = "Largest deviation from unit lengths, right angles and a right-handed basis";
    const BECAUSE: &str = "8 u: the vector's own length is off by 1.5 u, which counts twice, and there are some roundings of \
                           numbers below 1.";
    let mut random = Random(52);
    let own = Kernel::of(BASIS, &[]);
    // Frisvad, "Building an Orthonormal Basis from a 3D Unit Vector Without Normalization", JGT 16(3), 2012, which cancels near z = -1.
    let at_pole = "let s = 1.0;
    if n.z < -0.9999999 {
        return Basis(vec3<f32>(0.0, -1.0, 0.0), vec3<f32>(-1.0, 0.0, 0.0), n);
    }";
    let by_side = "let s = select(-1.0, 1.0, n.z >= 0.0);";
    let frisvad = Kernel::of(BASIS, &[("lib/basis", by_side, at_pole)]);
    let cell =
        |range: String, normals: &[DVec3]| Cell::new(range, FIGURE, 8.0 * U, BECAUSE).achieved(worst(&own, normals).0);
    let everywhere: Vec<DVec3> = (0..5000).map(|_| unit(&mut random)).collect();
    let mut all = vec![
        cell("everywhere".to_string(), &everywhere),
        Cell::new(
            "everywhere",
            "Largest error of the vector (1, 2, 3) in a basis",
            16.0 * U,
            "16 u: three products of up to 3, and their sums.",
        )
        .achieved(worst(&own, &everywhere).1),
    ];
    for z in [1.0, -1.0] {
        for exponent in [1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20] {
            let normals = near_pole(&mut random, z, 10f64.powi(-exponent));
            let found = cell(format!("z near {z}, xy = 1e-{exponent}"), &normals);
            // 1 + z cancels; and where z counts as -1, the basis is that of the pole itself.
            all.push(match z < 0.0 && exponent <= 6 {
                true => found.planted(FRISVAD, worst(&frisvad, &normals).0),
                false => found,
            });
        }
        let zeros = [(0.0, 0.0), (-0.0, 0.0), (0.0, -0.0), (-0.0, -0.0), (1e-40, 0.0), (0.0, -1e-40)];
        let zeros = zeros.map(|(x, y)| DVec3::new(x, y, z));
        all.push(cell(format!("z = {z}, xy = 0, -0 and 1e-40"), &zeros));
        // On the equator, where the sign of z decides.
        let equator = [DVec3::new(0.6, 0.8, 1e-30 * z), DVec3::new(-0.8, 0.6, 0.0 * z), DVec3::new(0.0, 1.0, 0.0 * z)];
        all.push(cell(
            format!("z = {}0 and {}1e-30", ["", "-"][usize::from(z < 0.0)], ["", "-"][usize::from(z < 0.0)]),
            &equator,
        ));
    }
    all
}
