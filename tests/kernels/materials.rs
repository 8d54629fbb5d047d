//! material/*: what becomes of a ray, one by one against f64 and many times against the density.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gpu_rt::data::{ABSORBED, EMITTED, Material, SCATTERED};

use crate::common::kernel::{Fault, Kernel, Setup};
use crate::common::oracles::{INCIDENT_SCHLICK, fresnel, metal_density};
use crate::common::rows::{Answer as Out, SurfaceHit as In, glass};
use crate::common::stats::{Random, bin, chi_square, sidak, uniform_in_cells};
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;

/// Answers each row for its own uniforms, or many times for independent ones.
fn kernel(material: &str, replaced: &[Fault<'_>]) -> Kernel {
    Kernel::with("test/scatter", &Setup { replaced, values: &[("material", material)], ..Setup::default() })
}

/// Draws for each row of input.
const DRAWS: usize = 1 << 18;

fn draws(material: &str, row: &In) -> Vec<Out> {
    kernel(material, &[]).run_with(&[*row], DRAWS, &[])
}

/// A normal, and a direction that comes in at an angle with it.
fn arriving(random: &mut Random, cos: f64) -> (DVec3, DVec3) {
    let normal = unit(random);
    let across = normal.cross(unit(random)).normalize();
    (normal, ((1.0 - cos * cos).sqrt() * across - cos * normal).normalize())
}

/// Counts by the height and azimuth around an axis, the height in cells of a share in 0..1.
struct Cells {
    axis: DVec3,
    across: DVec3,
    other: DVec3,
}

impl Cells {
    const RINGS: usize = 31;
    const SECTORS: usize = 17;
    const COUNT: usize = Cells::RINGS * Cells::SECTORS;

    fn around(axis: DVec3, towards: DVec3) -> Cells {
        let across =
            (towards - towards.dot(axis) * axis).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
        Cells { axis, across, other: axis.cross(across) }
    }

    /// Angles from the axis, and around it from `across` on, in -pi..pi.
    fn angles(&self, direction: DVec3) -> (f64, f64) {
        let (x, y, z) = (direction.dot(self.across), direction.dot(self.other), direction.dot(self.axis));
        (x.hypot(y).atan2(z), y.atan2(x))
    }

    fn cell(ring: f64, azimuth: f64) -> usize {
        bin(ring, Cells::RINGS) * Cells::SECTORS + bin((azimuth + PI) / TAU, Cells::SECTORS)
    }
}

/// Chi-square of 31 x 17 cells over 2^18 draws finds a density that is off by 3.3 % in the root mean square with a
/// probability of 99.9 %.
#[test]
fn lambertian_scatters_by_the_cosine_and_weighs_by_the_albedo() {
    let mut random = Random(71);
    let colour = [0.2, 0.5, 0.9];
    let normals = [DVec3::Z, DVec3::NEG_Z, DVec3::new(1e-4, 0.0, -1.0), DVec3::X, unit(&mut random)];
    let mut wrong_density = Vec::new();
    for normal in normals {
        let normal = rounded(normal.normalize());
        let row = In { incoming: [0.0, 0.0, -1.0], front: 1, normal, colour, ..In::default() };
        let cells = Cells::around(exact(normal), DVec3::new(0.3, 0.5, 0.8));
        let mut angles = Vec::new();
        for out in draws("lambertian", &row) {
            assert_eq!((out.event, out.weight), (SCATTERED, colour));
            let direction = exact(out.direction);
            assert!((direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
            // z is 2^-12 at least before it is turned, by a basis that is off by 3 u.
            assert!(direction.dot(exact(normal)) > 2e-4, "{out:?}");
            angles.push(cells.angles(direction));
        }
        // The share of directions nearer to the horizon is cos^2; were they uniform, it would be the cosine.
        let p_by = |share: fn(f64) -> f64| {
            let points = angles.iter().map(|(theta, azimuth)| (share(theta.cos()), (azimuth + PI) / TAU));
            uniform_in_cells((Cells::RINGS, Cells::SECTORS), points)
        };
        let p = p_by(|cos| cos * cos);
        assert!(p > sidak(ALPHA, normals.len()), "around {normal:?}: p = {p:e}");
        wrong_density.push(p_by(|cos| cos));
    }
    assert!(wrong_density.iter().all(|p| *p < ALPHA), "{wrong_density:?}");
}

/// Shares of the cells around the mirror direction, of what lies above the surface, and last what is absorbed. The
/// direction at `theta` and azimuth phi, counted from the normal's side, is above the surface where
/// cos theta cos i + sin theta sin i cos phi > 0.
fn metal_shares(fuzz: f64, cos_incident: f64, density: impl Fn(f64) -> f64) -> Vec<f64> {
    // Midpoints of the rings' angles; the azimuths are integrated exactly.
    const STEPS: usize = 2000;
    let reach = fuzz.min(1.0).asin();
    let sin_incident = (1.0 - cos_incident * cos_incident).sqrt();
    let mut shares = vec![0.0; Cells::COUNT + 1];
    for step in 0..Cells::RINGS * STEPS {
        let share = (step as f64 + 0.5) / (Cells::RINGS * STEPS) as f64;
        let theta = share * reach;
        let ring = density(theta) * theta.sin() * reach / (Cells::RINGS * STEPS) as f64;
        let up = (-theta.cos() * cos_incident / (theta.sin() * sin_incident)).clamp(-1.0, 1.0).acos();
        for sector in 0..Cells::SECTORS {
            let edge = |i: usize| TAU * i as f64 / Cells::SECTORS as f64 - PI;
            let within = edge(sector + 1).min(up) - edge(sector).max(-up);
            shares[step / STEPS * Cells::SECTORS + sector] += ring * within.max(0.0);
        }
    }
    shares[Cells::COUNT] = 1.0 - shares.iter().sum::<f64>();
    shares
}

/// Counts of a metal's answers by those cells, and the shares expected.
fn metal_counts(random: &mut Random, fuzz: f64, cos_incident: f64) -> Vec<u64> {
    let (normal, incoming) = arriving(random, cos_incident);
    let material = Material { numbers: [fuzz as f32, 0.0, 0.0], ..Material::default() };
    let colour = [0.3, 0.6, 0.8];
    let row = In { incoming: rounded(incoming), front: 1, normal: rounded(normal), colour, material, ..In::default() };
    let mirrored = incoming - 2.0 * incoming.dot(normal) * normal;
    let cells = Cells::around(mirrored, normal);
    let reach = fuzz.min(1.0).asin();
    let mut counts = vec![0u64; Cells::COUNT + 1];
    for out in draws("metal", &row) {
        if out.event == ABSORBED {
            assert_eq!(out.weight, [0.0; 3]);
            counts[Cells::COUNT] += 1;
            continue;
        }
        assert_eq!((out.event, out.weight), (SCATTERED, colour));
        let direction = exact(out.direction);
        assert!((direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
        assert!(direction.dot(exact(row.normal)) > -2.0 * U, "{out:?}");
        let (theta, azimuth) = cells.angles(direction);
        // The lobe's edge, a hair beyond for the roundings of the ball's points.
        assert!(theta <= reach + 2e-3, "{theta} of {reach}");
        counts[Cells::cell(theta / reach, azimuth)] += 1;
    }
    counts
}

#[test]
fn metal_scatters_by_the_density_of_its_lobe() {
    let mut random = Random(73);
    let fuzzes = [0.1, 0.5, 1.0];
    let cosines = [1.0, std::f64::consts::FRAC_1_SQRT_2, 0.05];
    let threshold = sidak(ALPHA, fuzzes.len() * cosines.len());
    for fuzz in fuzzes {
        // The material holds it as f32.
        let fuzz = f64::from(fuzz as f32);
        for cos in cosines {
            let counts = metal_counts(&mut random, fuzz, cos);
            let p = |shares: Vec<f64>| {
                let expected: Vec<f64> = shares.iter().map(|share| share.max(0.0) * DRAWS as f64).collect();
                chi_square(&counts, &expected, 1)
            };
            let right = p(metal_shares(fuzz, cos, |theta| metal_density(theta, fuzz)));
            assert!(right > threshold, "fuzz {fuzz}, cosine {cos}: p = {right:e}");
            // A lobe 3 % wider, and the full cone instead of the ball's segment of it.
            let wider = p(metal_shares(fuzz, cos, |theta| metal_density(theta * 0.97, fuzz)));
            assert!(wider < threshold, "fuzz {fuzz}, cosine {cos}, wider: p = {wider:e}");
            let cone = |theta: f64| {
                let reach = theta.cos() + (fuzz * fuzz - theta.sin().powi(2)).max(0.0).sqrt();
                reach.powi(3) / (4.0 * PI * fuzz.powi(3))
            };
            assert!(fuzz == 1.0 || p(metal_shares(fuzz, cos, cone)) < threshold, "fuzz {fuzz}, cosine {cos}");
        }
    }
}

/// Dielectric rows at cosines from 1e-3 to 1, from both sides, with the relative index of each. Uniforms reach `last`.
fn dielectric_rows(random: &mut Random, ior: f64, count: usize, last: f32) -> Vec<(f64, In)> {
    (0..count)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -3.0, 0.0) };
            let (normal, incoming) = arriving(random, cos);
            let front = i % 4 < 2;
            let mut u = [0; 4].map(|_| (random.bits() >> 40) as f32 * U as f32);
            // Every fourth time at an end of its range.
            if i % 16 < 4 {
                u[0] = [0.0, last][i / 16 % 2];
            }
            let (incoming, normal) = (rounded(incoming), rounded(normal));
            let row = In { incoming, normal, front: u32::from(front), u, material: glass(ior), ..In::default() };
            (if front { ior } else { 1.0 / ior }, row)
        })
        .collect()
}

/// Answers that go the wrong way, and directions that are off by more than f32 explains.
fn dielectric_faults(kernel: &Kernel, rows: &[(f64, In)]) -> (usize, usize) {
    let given: Vec<In> = rows.iter().map(|(_, row)| *row).collect();
    let (mut wrong_way, mut off) = (0, 0);
    for ((eta, row), out) in rows.iter().zip(kernel.run::<_, Out>(&given)) {
        assert_eq!((out.event, out.weight), (SCATTERED, [1.0; 3]));
        let (incoming, normal, direction) = (exact(row.incoming), exact(row.normal), exact(out.direction));
        // The vectors are unit to a rounding only, and the shader's cosine is their product.
        let c = -incoming.dot(normal);
        let (share, transmitted) = fresnel(c, *eta);
        let reflected = direction.dot(normal) > 0.0;
        // The reflectance is off by what the cosine's 3 u do to it: next to total reflection by their root. Beyond that, all is reflected.
        let near = [c - 4.0 * U, c + 4.0 * U].map(|c| fresnel(c, *eta).0);
        let u = f64::from(row.u[0]);
        wrong_way += usize::from(match near {
            [1.0, 1.0] => !reflected,
            [low, high] => reflected != (u < share) && (u - share).abs() > (high - low).abs() + 64.0 * U,
        });
        let expected = match reflected {
            true => incoming + 2.0 * c * normal,
            false => incoming / *eta + (c / eta - transmitted) * normal,
        };
        let blur = (fresnel(c + 4.0 * U, *eta).1 - fresnel(c - 4.0 * U, *eta).1).abs() + 32.0 * U * (1.0 + 1.0 / eta);
        off += usize::from((direction - expected.normalize()).length() > blur);
    }
    (wrong_way, off)
}

#[test]
fn dielectric_reflects_by_fresnel_and_refracts_by_snell() {
    let mut random = Random(75);
    let own = kernel("dielectric", &[]);
    let schlick = kernel("dielectric", &INCIDENT_SCHLICK);
    for ior in [1.5, 1.0 / 1.5, 2.4, 1.1, 1.000_001] {
        let rows = dielectric_rows(&mut random, ior, 20_000, 1.0 - U as f32);
        assert_eq!(dielectric_faults(&own, &rows), (0, 0), "ior {ior}");
        let (wrong_way, _) = dielectric_faults(&schlick, &rows);
        assert!(wrong_way > 100, "ior {ior}: {wrong_way}");
    }
    // Under total reflection a uniform of 1 would pass.
    let rows = dielectric_rows(&mut random, 1.5, 20_000, 1.0);
    assert!(dielectric_faults(&own, &rows).0 > 100);
}

#[test]
fn a_dielectric_of_index_one_changes_nothing() {
    let mut random = Random(77);
    let rows: Vec<In> = dielectric_rows(&mut random, 1.0, 10_000, 1.0)
        .into_iter()
        // The least uniform reflects wherever the reflectance is not 0.
        .map(|(_, row)| In { u: [0.0; 4], ..row })
        .collect();
    let changed = |kernel: &Kernel| {
        let found = kernel.run::<_, Out>(&rows);
        rows.iter().zip(found).filter(|(row, out)| row.incoming != out.direction || out.weight != [1.0; 3]).count()
    };
    assert_eq!(changed(&kernel("dielectric", &[])), 0);
    assert!(changed(&kernel("dielectric", &INCIDENT_SCHLICK)) > 9000);
}

#[test]
fn lights_emit_on_the_sides_they_have() {
    let colour = [3.0, 0.0, 1e20];
    let mut rows = Vec::new();
    let mut expected = Vec::new();
    for (two_sided, front, emits) in [(1.0, 1, true), (1.0, 0, true), (0.0, 1, true), (0.0, 0, false)] {
        let material = Material { numbers: [two_sided, 0.0, 0.0], ..Material::default() };
        rows.push(In { incoming: [0.0, 0.0, -1.0], normal: [0.0, 0.0, 1.0], front, colour, material, ..In::default() });
        expected.push(if emits { (EMITTED, colour) } else { (ABSORBED, [0.0; 3]) });
    }
    let found = kernel("diffuse_light", &[]).run::<_, Out>(&rows);
    assert_eq!(found.iter().map(|out| (out.event, out.weight)).collect::<Vec<_>>(), expected);
}
