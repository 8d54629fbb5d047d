//! material/conductor, material/rough_dielectric, material/thin_dielectric: what becomes of a ray, one by one against f64 and many times against the density of
//! visible microfacets.

use std::path::Path;

use glam::DVec3;
use gpu_rt::material::microfacets::directional_albedos;
use gpu_rt::scene::Scene;

use crate::common::kernel::{Kernel, Setup, array};
use crate::common::microfacets::{
    ABSORBED, Facets, In, Out, SCATTERED, arriving, axes, conductor, density, directional_albedo, frosted, kernel,
    kernel_of, masking, metal_reflectance, pane, schlick, shadowing, uniforms, visible, within,
};
use crate::common::oracles::fresnel;
use crate::common::rows::{Answer, SurfaceHit, glass};
use crate::common::stats::{Random, chi_square, sidak};
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;
const DRAWS: usize = 1 << 18;

/// The numbers that a row has after it was rounded.
struct Exact {
    view: DVec3,
    normal: DVec3,
    cos_view: f64,
    alpha: f64,
}

fn exactly(row: &In, roughness: f32) -> Exact {
    let (view, normal) = (-exact(row.incoming).normalize(), exact(row.normal).normalize());
    Exact { view, normal, cos_view: view.dot(normal), alpha: f64::from(roughness).powi(2) }
}

/// Shares of the cells of microfacets that reflect upwards, and last what is lost.
fn reflected_shares(facets: &Facets, alpha: f64, seen: impl Fn(DVec3, f64) -> f64) -> Vec<f64> {
    let mut shares = vec![0.0; Facets::COUNT + 1];
    let view = facets.view();
    facets.integrate(alpha, |cell, facet, share| {
        let up = 2.0 * view.dot(facet) * facet.z - view.z > 0.0;
        shares[if up { cell } else { Facets::COUNT }] += seen(facet, share);
    });
    let sum: f64 = shares.iter().sum();
    shares.iter().map(|share| share / sum).collect()
}

/// Chi-square of 31 x 17 cells over 2^18 draws finds a density that is off by 3.3 % in the root mean square with a probability of
/// 99.9 %.
#[test]
fn conductors_reflect_by_the_visible_microfacets() {
    let mut random = Random(171);
    let roughnesses = [0.04, 0.2, 0.5, 1.0];
    let cosines = [1.0, std::f64::consts::FRAC_1_SQRT_2, 0.1];
    let threshold = sidak(ALPHA, roughnesses.len() * cosines.len());
    let many = kernel("conductor", DRAWS, &[]);
    for roughness in roughnesses {
        for cos in cosines {
            let row = conductor(arriving(&mut random, cos), roughness, None);
            let Exact { view, normal, cos_view, alpha } = exactly(&row, roughness as f32);
            let axes = axes(normal, view);
            let facets = Facets { alpha, cos_view };
            let mut counts = vec![0u64; Facets::COUNT + 1];
            for out in many.run_with::<_, Out>(&[row], DRAWS, &[]) {
                if out.event == ABSORBED {
                    assert_eq!(out.weight, [0.0; 3]);
                    counts[Facets::COUNT] += 1;
                    continue;
                }
                let direction = exact(out.direction);
                assert!(out.event == SCATTERED && (direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
                assert!(out.weight.iter().all(|w| (0.0..=1.0 + 8.0 * U as f32).contains(w)), "{out:?}");
                counts[facets.cell(within(&axes, (direction + view).normalize()))] += 1;
            }
            let p = |shares: Vec<f64>| {
                let expected: Vec<f64> = shares.iter().map(|share| share * DRAWS as f64).collect();
                chi_square(&counts, &expected, 1)
            };
            let right = p(reflected_shares(&facets, alpha, |_, share| share));
            assert!(right > threshold, "roughness {roughness}, cosine {cos}: p = {right:e}");
            // A lobe 3 % wider, and microfacets by their area, hidden or not.
            let wider = p(reflected_shares(&facets, 1.03 * alpha, |_, share| share));
            assert!(wider < threshold, "roughness {roughness}, cosine {cos}, wider: p = {wider:e}");
            let by_area = |facet: DVec3, share: f64| share * facet.z / facet.dot(facets.view()).max(1e-9);
            let area = p(reflected_shares(&facets, alpha, by_area));
            // Where the lobe is narrow and the view steep, all are seen alike.
            let alike = alpha * (1.0 - cos * cos).sqrt() / cos < 0.1;
            assert!(alike || area < threshold, "roughness {roughness}, cosine {cos}, by area: p = {area:e}");
        }
    }
}

/// Rows of random roughness and angle, towards a random light or the answer.
fn rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    (0..count)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -4.0, 0.0) };
            let roughness = [decades(random, -3.0, 0.0), 1.0, 0.1, 0.5][i % 4];
            let k = (i % 3 == 0).then_some([3.9, 2.4, 1e-2]);
            let row = conductor(arriving(random, cos), roughness, k);
            let light = if towards_light { rounded(unit(random)) } else { [0.0; 3] };
            // Of an index its excess over 1.
            let colour = if k.is_some() { [-0.8, -0.1, 0.5] } else { [0.9, 0.5, 0.0] };
            In { u: uniforms(random, i), light, colour, ..row }
        })
        .collect()
}

/// Value per channel, and density, in f64.
fn response(row: &In, direction: DVec3) -> ([f64; 3], f64) {
    let Exact { view, normal, cos_view, alpha } = exactly(row, row.material.numbers[0]);
    let facet = (view + direction).normalize();
    let (cos_light, cos_facet) = (direction.dot(normal), view.dot(facet));
    if cos_light <= 0.0 {
        return ([0.0; 3], 0.0);
    }
    let share = |channel: usize| {
        let colour = f64::from(row.colour[channel]);
        match row.second.numbers[0] != 0.0 {
            true => metal_reflectance(cos_facet, 1.0 + colour, f64::from(row.second.colour[channel])),
            false => schlick(cos_facet, colour),
        }
    };
    let spread = density(facet.cross(normal).length(), facet.dot(normal), alpha) / (4.0 * cos_view);
    let value = [0, 1, 2].map(|channel| share(channel) * spread * shadowing(cos_view, cos_light, alpha));
    (value, visible(facet, view, normal, alpha) / (4.0 * cos_facet))
}

/// The share of the visible microfacets that the light reaches too.
fn shadowed(row: &In, direction: DVec3) -> f64 {
    let Exact { normal, cos_view, alpha, .. } = exactly(row, row.material.numbers[0]);
    shadowing(cos_view, direction.dot(normal).abs().max(1e-12), alpha) / masking(cos_view, alpha)
}

/// The relative error that f32 explains: the sum of two directions is off by 4 u, which turns the half vector by that over its
/// length, and moves the density by at most 2 of it per alpha. A cosine is off by 4 u, which counts where the light grazes.
fn explained(row: &In, direction: DVec3) -> f64 {
    let Exact { view, normal, alpha, cos_view } = exactly(row, row.material.numbers[0]);
    let turned = 4.0 * U / (view + direction).length();
    let light = direction.dot(normal).abs().max(1e-9);
    64.0 * U + 4.0 * turned / alpha + 4.0 * U / light + 4.0 * U / (cos_view + alpha) + 16.0 * turned
}

/// The rows whose value or density is off by more, and those whose weight is not their ratio.
fn faults(kernel: &Kernel, rows: &[In]) -> (usize, usize) {
    let (mut off, mut unweighted) = (0, 0);
    for (row, out) in rows.iter().zip(kernel.run::<_, Out>(rows)) {
        let own = row.light == [0.0; 3];
        let direction = exact(if own { out.direction } else { row.light }).normalize();
        if own && out.event == ABSORBED {
            continue;
        }
        let (value, pdf) = response(row, direction);
        let limit = explained(row, direction);
        // A reflectance is off by 5 times the cosine's rounding.
        let cosine = 20.0 * U / (direction - exact(row.incoming)).length().min(1.0);
        let white = pdf * shadowed(row, direction);
        let near = |found: f32, expected: f64| {
            (f64::from(found) - expected).abs() <= limit * expected + cosine * white + 1e-30
        };
        // A light within the rounding of the horizon may lie on either side of it.
        let on_edge = direction.dot(exact(row.normal)).abs() < 4.0 * U;
        off += usize::from(!(on_edge || near(out.pdf, pdf) && (0..3).all(|c| near(out.value[c], value[c]))));
        if own {
            let is_ratio = |c: usize| {
                let ratio = value[c] / pdf;
                (f64::from(out.weight[c]) - ratio).abs() <= limit * ratio + cosine
            };
            unweighted += usize::from(!(0..3).all(is_ratio));
        }
    }
    (off, unweighted)
}

#[test]
fn conductors_respond_by_the_microfacet_formula() {
    let mut random = Random(173);
    let own = kernel("conductor", 1, &[]);
    let textbook = kernel("conductor", 1, &[("lib/microfacet", "test/control/microfacet_textbook")]);
    for towards_light in [false, true] {
        let rows = rows(&mut random, 20_000, towards_light);
        assert_eq!(faults(&own, &rows), (0, 0), "towards lights: {towards_light}");
        let (off, unweighted) = faults(&textbook, &rows);
        assert!(off > 100 || towards_light, "1 - cos²: {off}");
        let brighter = kernel("conductor", 1, &[("lib/fresnel_conductor", "test/control/fresnel_conductor_brighter")]);
        let (off, unweighted_brighter) = faults(&brighter, &rows);
        assert!(
            off > 4000 && (towards_light || unweighted_brighter > 4000),
            "1 % brighter: {off}, {unweighted_brighter}"
        );
        assert!(towards_light || unweighted > 0, "{unweighted}");
    }
}

/// The BRDF for light and view exchanged, over its value: off by the roundings of either.
#[test]
fn conductors_reflect_the_same_both_ways() {
    let mut random = Random(175);
    let rows: Vec<In> = rows(&mut random, 20_000, true)
        .into_iter()
        .filter(|row| {
            exact(row.light).dot(exact(row.normal)) > 1e-3 && -exact(row.incoming).dot(exact(row.normal)) > 1e-3
        })
        .collect();
    assert!(rows.len() > 4000);
    let back: Vec<In> = rows
        .iter()
        .map(|row| In { incoming: row.light.map(|c| -c), light: row.incoming.map(|c| -c), ..*row })
        .collect();
    let kernel = kernel("conductor", 1, &[]);
    let (there, back) = (kernel.run::<_, Out>(&rows), kernel.run::<_, Out>(&back));
    // `power` is 1 for the BRDF, and 0 for the values with their cosines, which are not the same both ways.
    let wrong = |power: i32| {
        let pairs = rows.iter().zip(there.iter().zip(&back));
        let off = pairs.filter(|(row, (there, back))| {
            let normal = exact(row.normal);
            let (cos_there, cos_back) = (exact(row.light).dot(normal), -exact(row.incoming).dot(normal));
            let (a, b) =
                (f64::from(there.value[1]) / cos_there.powi(power), f64::from(back.value[1]) / cos_back.powi(power));
            (a - b).abs() > 2.0 * (explained(row, exact(row.light)) + 8.0 * U / cos_back) * a
        });
        off.count()
    };
    assert_eq!(wrong(1), 0);
    assert!(wrong(0) > 4000);
}

#[test]
fn white_conductors_keep_what_single_scattering_keeps() {
    let mut random = Random(177);
    let many = kernel("conductor", DRAWS, &[]);
    for (roughness, cos) in [(0.1, 0.9), (0.5, 1.0), (0.5, 0.2), (1.0, 1.0), (1.0, 0.5), (1.0, 0.05)] {
        let row = conductor(arriving(&mut random, cos), roughness, None);
        let Exact { cos_view, alpha, .. } = exactly(&row, roughness as f32);
        let found = many.run_with::<_, Out>(&[row], DRAWS, &[]);
        let mean = found.iter().map(|out| f64::from(out.weight[0])).sum::<f64>() / DRAWS as f64;
        let expected = directional_albedo(&Facets { alpha, cos_view });
        println!("roughness {roughness}, cosine {cos}: {mean:.4} of {expected:.4}");
        // Weights are from 0 to 1: 4.9 standard errors, and 2e-4 of the integral. It would find 0.5 % of the light.
        let limit = 4.9 * 0.5 * (4.0 * expected * (1.0 - expected)).sqrt() / (DRAWS as f64).sqrt() + 2e-4;
        assert!(
            (mean - expected).abs() < limit && limit < 0.0051,
            "roughness {roughness}, cosine {cos}: {mean} of {expected}"
        );
    }
}

/// The table of it, whose error is that of interpolation.
#[test]
fn the_table_of_what_single_scattering_keeps_is_right() {
    let mut random = Random(179);
    let rows: Vec<[f32; 2]> = (0..96)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(&mut random, -3.0, 0.0) };
            let roughness = [random.uniform(), decades(&mut random, -3.0, 0.0), 1.0][i % 3];
            [cos as f32, roughness as f32]
        })
        .collect();
    let own = Kernel::new("test/directional_albedo");
    let expected = |[cos, roughness]: [f32; 2]| {
        directional_albedo(&Facets { alpha: f64::from(roughness.max(1.0 / 1024.0)).powi(2), cos_view: f64::from(cos) })
    };
    let expected: Vec<f64> = rows.iter().map(|row| expected(*row)).collect();
    let worst = |shares: &[[f32; 4]]| {
        let found = own.run_with::<_, f32>(&rows, rows.len(), &[array("directional_albedos", shares)]);
        let off = found.iter().zip(&expected).map(|(found, expected)| (f64::from(*found) / expected - 1.0).abs());
        off.fold(0.0, f64::max)
    };
    let mut shares = directional_albedos();
    println!("off by {:.4} at most", worst(&shares));
    assert!(worst(&shares) < 0.008);
    shares.rotate_left(8);
    assert!(worst(&shares) > 0.01, "a row of the table too few is not found");
}

/// The response with 1 + F0 (1 - E) / E, for an albedo and for an index, and of each lobe of glTF's material.
#[test]
fn multiple_scattering_is_a_factor() {
    let mut random = Random(181);
    let colour = [0.9f32, 0.5, 0.1];
    let compensation = 0.75f32;
    let mut rows = |of_material: &dyn Fn(In) -> In| -> Vec<In> {
        let arriving = (0..600).map(|i| {
            let row = arriving(&mut Random(i), 0.05 + 0.0015 * i as f64);
            of_material(In { colour, compensation, u: uniforms(&mut random, i as usize), ..row })
        });
        arriving.collect()
    };
    let pbr = |metallic: f32| {
        move |row: In| {
            let material = gpu_rt::data::Material { numbers: [0.5, 0.3, metallic], ..Default::default() };
            let colour = if metallic == 1.0 { row.colour } else { [0.0; 3] };
            In { material, colour, ..row }
        }
    };
    let f0 = |c: usize| metal_reflectance(1.0, 1.0 + f64::from(colour[c]), 2.0);
    let albedo = |c: usize| f64::from(colour[c]);
    type Case<'a> = (&'a str, Vec<In>, Box<dyn Fn(usize) -> f64 + 'a>);
    let cases: [Case; 4] = [
        ("conductor", rows(&|row| conductor(row, 0.5, None)), Box::new(albedo)),
        ("conductor", rows(&|row| conductor(row, 0.5, Some([2.0; 3]))), Box::new(f0)),
        ("pbr", rows(&pbr(1.0)), Box::new(albedo)),
        ("pbr", rows(&pbr(0.0)), Box::new(|_| 0.3)),
    ];
    for (material, rows, f0) in cases {
        let (single, full) = (kernel(material, 1, &[]), kernel_of(material, 1, &[], &["scene/multiscatter"]));
        let pairs = single.run::<_, Out>(&rows).into_iter().zip(full.run::<_, Out>(&rows));
        let mut compared = 0;
        for (single, full) in pairs {
            assert!(single.event == full.event && single.direction == full.direction && single.pdf == full.pdf);
            for c in 0..3 {
                let factor = 1.0 + f0(c) * f64::from(compensation);
                for (one, other) in [(single.value[c], full.value[c]), (single.weight[c], full.weight[c])] {
                    let (one, other) = (f64::from(one), f64::from(other));
                    assert!((one * factor - other).abs() <= 16.0 * U * other, "{material}: {one}, {other}, {factor}");
                    compared += usize::from(other > 0.0);
                }
            }
        }
        assert!(compared > 2000, "{material}: {compared}");
    }
}

/// The reflectance of gold, silver and an index like glass, over all angles, by a mirror.
#[test]
fn smooth_conductors_are_mirrors_with_the_reflectance_of_the_metal() {
    let mut random = Random(179);
    let excess = [-0.857, 0.65, -0.999];
    let k = [3.98, 0.0, 1e3];
    let rows: Vec<In> = (0..20_000)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(&mut random, -6.0, 0.0) };
            let roughness = [0.0, 0.0009][i % 2];
            In { colour: excess, ..conductor(arriving(&mut random, cos), roughness, Some(k)) }
        })
        .collect();
    let found = kernel("conductor", 1, &[]).run::<_, Out>(&rows);
    let mirror: Vec<SurfaceHit> = rows
        .iter()
        .map(|row| SurfaceHit {
            incoming: row.incoming,
            normal: row.normal,
            front: 1,
            colour: [1.0; 3],
            ..SurfaceHit::default()
        })
        .collect();
    let values = [("material", "metal"), ("times", "1"), ("keyed", "false")];
    let mirror = Kernel::with("test/scatter", &Setup { values: &values, ..Setup::default() }).run::<_, Answer>(&mirror);
    let (mut schlick_is_off, mut absorbed) = (0, 0);
    for ((row, out), mirrored) in rows.iter().zip(&found).zip(&mirror) {
        // The bytes of a metal without fuzz.
        assert_eq!((out.event, out.direction, out.non_specular), (mirrored.event, mirrored.direction, 0));
        absorbed += usize::from(out.event == ABSORBED);
        let cos = -exact(row.incoming).dot(exact(row.normal));
        for channel in 0..3 {
            let eta = 1.0 + f64::from(excess[channel]);
            let reflectance = |cos: f64| metal_reflectance(cos, eta, f64::from(k[channel]));
            let expected = reflectance(cos);
            let blur = (reflectance((cos + 4.0 * U).min(1.0)) - reflectance((cos - 4.0 * U).max(0.0))).abs() + 64.0 * U;
            let off = |share: f64| out.event == SCATTERED && (f64::from(out.weight[channel]) - share).abs() > blur;
            assert!(!off(expected), "{row:?}: {} of {expected}", out.weight[channel]);
            schlick_is_off += usize::from(off(schlick(cos, reflectance(1.0))));
        }
    }
    assert!(schlick_is_off > 10_000 && absorbed < 100, "{schlick_is_off}, {absorbed}");
    // From the limit on it is rough.
    let at = |roughness: f64| conductor(arriving(&mut Random(1), 0.5), roughness, None);
    let found = kernel("conductor", 1, &[]).run::<_, Out>(&[at(1.0 / 1024.0), at(1.0 / 1024.1)]);
    assert_eq!([found[0].non_specular, found[1].non_specular], [1, 0]);
}

/// The largest error of a metal's reflectance, over its bound, for indices of this distance from 1 or larger ones. The bound is what a change of
/// the cosine, of eta - 1 and of k by 4 u makes, and 32 roundings: the formula has some twenty, of which the squared ones count twice.
fn worst_reflectance(shader: &Kernel, random: &mut Random, excesses: &[f64]) -> f64 {
    let mut rows = Vec::new();
    for &excess in excesses {
        for k in [0.0, 1e-10, 1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0] {
            let text = format!(
                "(image: (width: 1, height: 1), camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vertical_fov: 40), background: Solid((0, 0, 0)),
                  materials: {{ \"metal\": Conductor(eta: ({0:?}, {0:?}, {0:?}), k: ({k:?}, {k:?}, {k:?})) }}, objects: [])",
                1.0 + excess
            );
            let scene = Scene::parse(&text, Path::new("metal.ron")).unwrap_or_else(|error| panic!("{error}"));
            let model = scene.materials[0].1.model();
            let (material, second) = (model.on_device, model.second_part.expect("it has k"));
            for i in 0..100 {
                let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -4.0, 0.0) };
                // Along an axis, so that the kernel has this cosine without rounding.
                let incoming = rounded(DVec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos));
                let at = In { incoming, normal: [0.0, 0.0, 1.0], front: 1, ..In::default() };
                let row = In { material, second, colour: material.colour, ..at };
                // As the scene file has it, in f64.
                rows.push((row, (1.0 + excess) - 1.0, k));
            }
        }
    }
    let given: Vec<In> = rows.iter().map(|(row, ..)| *row).collect();
    let mut worst = 0.0f64;
    for ((row, excess, k), out) in
        rows.iter().zip(shader.run::<_, Out>(&given)).filter(|(_, out)| out.event == SCATTERED)
    {
        let cos = -f64::from(row.incoming[2]);
        let reflectance = |cos: f64, excess: f64, k: f64| reflectance_by_excess(cos.min(1.0), excess, k);
        let expected = reflectance(cos, *excess, *k);
        let by = |change: f64| {
            let changed = [
                reflectance(cos + change * cos.max(U), *excess, *k),
                reflectance(cos, excess + change * excess.abs(), *k),
                reflectance(cos, *excess, k + change * k),
            ];
            changed.iter().map(|changed| (changed - expected).abs()).sum::<f64>()
        };
        let bound = by(4.0 * U).max(by(-4.0 * U)) + 32.0 * U * expected;
        let error = (f64::from(out.weight[0]) - expected).abs();
        worst = worst.max(if error == 0.0 { 0.0 } else { error / bound });
    }
    worst
}

/// Fresnel's equations with eta - 1, in f64: a - c is (b² + m) / (a + c), with m = eta² - k² - 1.
fn reflectance_by_excess(cos: f64, excess: f64, k: f64) -> f64 {
    let m = excess * (2.0 + excess) - k * k;
    let (real, imaginary) = (m + cos * cos, 2.0 * (1.0 + excess) * k);
    let larger = 0.5 * (real.hypot(imaginary) + real.abs());
    let smaller = if larger > 0.0 { 0.25 * imaginary * imaginary / larger } else { 0.0 };
    let (a2, b2) = if real > 0.0 { (larger, smaller) } else { (smaller, larger) };
    let (a, s2) = (a2.sqrt(), (1.0 - cos) * (1.0 + cos));
    let less = if m.abs() + b2 < (a + cos).powi(2) { (b2 + m) / (a + cos) } else { a - cos };
    let perpendicular = (less * less + b2) / ((a + cos).powi(2) + b2);
    let across = b2 * cos * cos;
    0.5 * perpendicular * (1.0 + ((a * cos - s2).powi(2) + across) / ((a * cos + s2).powi(2) + across))
}

/// Indices near 1 on both sides, and ordinary ones, with all of k: the relative error is that of some roundings. The control rounds the
/// index to f32, as a material file would.
#[test]
fn metals_reflect_by_their_index_however_near_to_1() {
    // Both forms of Fresnel's equations agree where neither cancels.
    for (cos, eta, k) in [(0.3, 0.143, 3.98), (0.9, 1.65, 1e-3), (0.01, 0.9, 0.5), (1.0, 2.0, 0.0)] {
        let (own, book) = (reflectance_by_excess(cos, eta - 1.0, k), metal_reflectance(cos, eta, k));
        assert!((own - book).abs() < 1e-9 * book, "{own}, {book}");
    }
    let shader = kernel("conductor", 1, &[]);
    let mut random = Random(199);
    for power in -7..=2 {
        let of_power = |sign: f64| [1.0, 2.0, 5.0, 9.0].map(|digit| sign * digit * 10f64.powi(power));
        let excesses: Vec<f64> =
            of_power(1.0).into_iter().chain(of_power(-1.0).into_iter().filter(|e| *e > -1.0)).collect();
        let worst = worst_reflectance(&shader, &mut random, &excesses);
        println!("eta = 1 ± 1e{power}..9e{power}: {worst:.2}");
        assert!(worst <= 1.0, "eta = 1 ± 1e{power}: {worst}");
    }
    assert!(worst_reflectance(&shader, &mut random, &[0.0]) <= 1.0, "eta = 1");
    let row =
        |colour: f32| In { colour: [colour; 3], ..conductor(arriving(&mut Random(4), 0.7), 0.0, Some([1e-6; 3])) };
    let excess = 1e-4;
    let found = shader.run::<_, Out>(&[row(excess as f32), row((1.0 + excess) as f32 - 1.0)]);
    let cos = -exact(row(0.0).incoming).dot(exact(row(0.0).normal));
    let off = found.iter().map(|out| f64::from(out.weight[0]) / reflectance_by_excess(cos, excess, 1e-6) - 1.0);
    let off: Vec<f64> = off.map(f64::abs).collect();
    assert!(off[0] < 1e-5 && off[1] > 1e-4, "{off:?}");
}

/// The index of the far side relative to the near one.
fn eta_of(row: &In) -> f64 {
    let ior = f64::from(row.second.numbers[0]);
    if row.front == 1 { ior } else { 1.0 / ior }
}

/// The ray that a microfacet refracts, if it does.
fn refracted(view: DVec3, facet: DVec3, eta: f64) -> Option<DVec3> {
    let cos = view.dot(facet);
    let transmitted = fresnel(cos, eta).1;
    (transmitted > 0.0).then(|| -view / eta + (cos / eta - transmitted) * facet)
}

/// The microfacet normal between the view and a direction on the far side: Walter et al., equation 16.
fn facet_between(view: DVec3, direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let facet = (view + eta * direction).normalize();
    if facet.dot(normal) < 0.0 { -facet } else { facet }
}

/// Shares of the cells of microfacets that reflect upwards, of those that refract downwards, and last what is lost.
fn boundary_shares(facets: &Facets, eta: f64, alpha: f64, reflectance: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut shares = vec![0.0; 2 * Facets::COUNT + 1];
    let view = facets.view();
    facets.integrate(alpha, |cell, facet, share| {
        let cos = view.dot(facet);
        if cos <= 0.0 {
            return;
        }
        let reflected = reflectance(cos);
        let up = 2.0 * cos * facet.z - view.z > 0.0;
        shares[if up { cell } else { 2 * Facets::COUNT }] += share * reflected;
        let down = refracted(view, facet, eta).is_some_and(|direction| direction.z < 0.0);
        shares[if down { Facets::COUNT + cell } else { 2 * Facets::COUNT }] += share * (1.0 - reflected);
    });
    let sum: f64 = shares.iter().sum();
    // A cell that no midpoint is in may have a corner that is.
    shares.iter().map(|share| (share / sum).max(1e-9)).collect()
}

/// Of 2 x 31 x 17 cells; see above.
#[test]
fn rough_dielectrics_reflect_and_refract_by_the_visible_microfacets() {
    let mut random = Random(181);
    let many = kernel("rough_dielectric", DRAWS, &[]);
    let cases: Vec<(f64, f64, f64, u32)> = [(0.2, 1.5), (0.5, 1.5), (1.0, 1.5), (0.4, 1.1), (0.6, 2.4), (0.3, 0.6)]
        .into_iter()
        .flat_map(|(roughness, ior)| [1.0, 0.6, 0.15].map(|cos| (roughness, ior, cos, u32::from(cos != 0.6))))
        .collect();
    let threshold = sidak(ALPHA, cases.len());
    for (roughness, ior, cos, front) in cases {
        let what = format!("roughness {roughness}, ior {ior}, cosine {cos}, front {front}");
        let row = In { front, ..frosted(arriving(&mut random, cos), ior, roughness) };
        let Exact { view, normal, cos_view, alpha } = exactly(&row, roughness as f32);
        let (axes, eta) = (axes(normal, view), eta_of(&row));
        let facets = Facets { alpha, cos_view };
        let mut counts = vec![0u64; 2 * Facets::COUNT + 1];
        for out in many.run_with::<_, Out>(&[row], DRAWS, &[]) {
            if out.event == ABSORBED {
                counts[2 * Facets::COUNT] += 1;
                continue;
            }
            let direction = exact(out.direction);
            assert!(out.event == SCATTERED && (direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
            assert!((0.0..=1.0 + 8.0 * U as f32).contains(&out.weight[0]), "{out:?}");
            let (first, facet) = match direction.dot(normal) > 0.0 {
                true => (0, (direction + view).normalize()),
                false => (Facets::COUNT, facet_between(view, direction, normal, eta)),
            };
            counts[first + facets.cell(within(&axes, facet))] += 1;
        }
        let p = |shares: Vec<f64>| {
            let expected: Vec<f64> = shares.iter().map(|share| share * DRAWS as f64).collect();
            chi_square(&counts, &expected, 1)
        };
        let exactly = |cos: f64| fresnel(cos, eta).0;
        let right = p(boundary_shares(&facets, eta, alpha, exactly));
        assert!(right > threshold, "{what}: p = {right:e}");
        let wider = p(boundary_shares(&facets, eta, 1.04 * alpha, exactly));
        assert!(wider < threshold, "{what}, wider: p = {wider:e}");
        // Reflection by the surface's normal instead of the microfacet's.
        let flat = p(boundary_shares(&facets, eta, alpha, |_| fresnel(cos_view, eta).0));
        assert!(cos == 1.0 || flat < threshold, "{what}, by the surface: p = {flat:e}");
    }
}

/// Rows of random index, roughness, side and angle, towards a random light or the answer.
fn boundary_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    (0..count)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -4.0, 0.0) };
            let roughness = [decades(random, -2.0, 0.0), 1.0, 0.1, 0.5][i % 4];
            let ior = [1.5, 1.01, 2.4, 0.6, 1.33][i % 5];
            let row = frosted(arriving(random, cos), ior, roughness);
            let light = if towards_light { rounded(unit(random)) } else { [0.0; 3] };
            In { u: uniforms(random, i), light, front: i as u32 / 7 % 2, ..row }
        })
        .collect()
}

/// The value and the density in f64, how much of either f32 may be off, and the share that the light reaches too.
pub fn boundary_response(row: &In, direction: DVec3) -> (f64, f64, f64, f64) {
    let Exact { view, normal, cos_view, alpha } = exactly(row, row.material.numbers[0]);
    let eta = eta_of(row);
    let cos_light = direction.dot(normal);
    let reflects = cos_light > 0.0;
    let sum = if reflects { view + direction } else { view + eta * direction };
    let facet = if reflects { sum.normalize() } else { facet_between(view, direction, normal, eta) };
    let (cos_facet, cos_out) = (view.dot(facet), direction.dot(facet));
    if cos_facet <= 0.0 || (cos_out > 0.0) != reflects {
        return (0.0, 0.0, 0.0, 0.0);
    }
    let reflectance = fresnel(cos_facet, eta).0;
    let seen = visible(facet, view, normal, alpha);
    let pdf = match reflects {
        true => reflectance * seen / (4.0 * cos_facet),
        false => (1.0 - reflectance) * seen * eta * eta * cos_out.abs() / (cos_facet + eta * cos_out).powi(2),
    };
    let share = shadowing(cos_view, cos_light.abs(), alpha) / masking(cos_view, alpha);
    // As for conductors; and Fresnel's reflectance by the cosine's rounding, most of all next to total reflection.
    let turned = 4.0 * (1.0 + eta) * U / sum.length();
    let near = [-2.0, 2.0].map(|by| fresnel((cos_facet + by * turned).clamp(0.0, 1.0), eta).0);
    let blur = (near[0] - near[1]).abs() + 64.0 * U * reflectance;
    let of_share = if reflects { blur / reflectance } else { blur / (1.0 - reflectance) };
    let grazing = 4.0 * U / cos_light.abs()
        + 4.0 * U / (cos_view + alpha)
        + 4.0 * turned / cos_facet
        + 4.0 * turned / cos_out.abs();
    // Microfacets that stand upright are seen or not by their last digits.
    let upright = if facet.dot(normal).abs() < 16.0 * U / sum.length() { f64::NAN } else { 0.0 };
    let limit = upright + 96.0 * U + 4.0 * turned / alpha + grazing + 16.0 * turned + of_share;
    (pdf * share, pdf, limit, share)
}

fn boundary_faults(kernel: &Kernel, rows: &[In]) -> (usize, usize, usize) {
    let (mut off, mut unweighted, mut compared) = (0, 0, 0);
    for (row, out) in rows.iter().zip(kernel.run::<_, Out>(rows)) {
        let own = row.light == [0.0; 3];
        if own && out.event == ABSORBED || out.non_specular == 0 {
            continue;
        }
        let direction = exact(if own { out.direction } else { row.light }).normalize();
        let (value, pdf, limit, share) = boundary_response(row, direction);
        // Where f32 has no digit left, at the ends of the sides of microfacets, there is nothing to compare.
        if limit.is_nan() || limit > 0.1 || direction.dot(exact(row.normal)).abs() < 4.0 * U {
            continue;
        }
        compared += 1;
        let near = |found: f32, expected: f64| (f64::from(found) - expected).abs() <= limit * expected + 1e-30;
        // A response that is 0 here may be one on the edge of what microfacets see there.
        off += usize::from(pdf > 0.0 && !(near(out.pdf, pdf) && near(out.value[0], value)));
        unweighted += usize::from(own && pdf > 0.0 && (f64::from(out.weight[0]) - share).abs() > limit * share);
    }
    (off, unweighted, compared)
}

#[test]
fn rough_dielectrics_respond_by_the_microfacet_formula() {
    let mut random = Random(183);
    let own = kernel("rough_dielectric", 1, &[]);
    let textbook = kernel("rough_dielectric", 1, &[("lib/microfacet", "test/control/microfacet_textbook")]);
    let schlick = kernel("rough_dielectric", 1, &[("lib/fresnel", "test/control/fresnel_schlick")]);
    for towards_light in [false, true] {
        let rows = boundary_rows(&mut random, 20_000, towards_light);
        let (off, unweighted, compared) = boundary_faults(&own, &rows);
        assert_eq!((off, unweighted), (0, 0), "of {compared}, towards lights: {towards_light}");
        assert!(compared > 8000, "{compared}");
        let (off, unweighted, _) = boundary_faults(&textbook, &rows);
        assert!(off > 100 && (towards_light || unweighted > 100), "textbook: {off}, {unweighted}");
        let (off, ..) = boundary_faults(&schlick, &rows);
        assert!(off > 1000, "Schlick: {off}");
    }
}

/// The BSDF for light and view exchanged: over the index squared of the side of the light it is the same. The value is the BSDF
/// times the cosine of the light.
#[test]
fn rough_dielectrics_scatter_the_same_both_ways_but_for_the_index_squared() {
    let mut random = Random(185);
    let rows: Vec<In> = boundary_rows(&mut random, 40_000, true)
        .into_iter()
        .filter(|row| [row.light, row.incoming].iter().all(|v| exact(*v).dot(exact(row.normal)).abs() > 1e-2))
        .filter(|row| boundary_response(row, exact(row.light).normalize()).2 < 0.01)
        .collect();
    let turned: Vec<In> = rows
        .iter()
        .map(|row| {
            let through = exact(row.light).dot(exact(row.normal)) < 0.0;
            let normal = if through { row.normal.map(|c| -c) } else { row.normal };
            let front = if through { 1 - row.front } else { row.front };
            In { incoming: row.light.map(|c| -c), light: row.incoming.map(|c| -c), normal, front, ..*row }
        })
        .collect();
    let kernel = kernel("rough_dielectric", 1, &[]);
    let (there, back) = (kernel.run::<_, Out>(&rows), kernel.run::<_, Out>(&turned));
    let limit = |row: &In| boundary_response(row, exact(row.light).normalize()).2;
    let (mut wrong, mut unscaled, mut refracted, mut reflected) = (0, 0, 0, 0);
    for ((row, turned), (there, back)) in rows.iter().zip(&turned).zip(there.iter().zip(&back)) {
        let normal = exact(row.normal);
        let (cos_there, cos_back) = (exact(row.light).dot(normal), -exact(row.incoming).dot(normal));
        let (a, b) = (f64::from(there.value[0]) / cos_there.abs(), f64::from(back.value[0]) / cos_back);
        let scale = if cos_there < 0.0 { eta_of(row).powi(2) } else { 1.0 };
        let off = |scale: f64| {
            let limit = 2.0 * (limit(row) + limit(turned)) + 1e-5;
            usize::from(limit < 0.05 && (a - b * scale).abs() > limit * a)
        };
        wrong += off(scale);
        unscaled += off(1.0);
        *(if cos_there < 0.0 { &mut refracted } else { &mut reflected }) += usize::from(a > 0.0);
    }
    assert_eq!(wrong, 0);
    assert!(unscaled > 1000 && refracted > 2000 && reflected > 4000, "{unscaled}, {refracted}, {reflected}");
}

/// A roughness of 0 makes the glass, bit by bit; and so does a roughness that f32 directions cannot distinguish from it.
#[test]
fn smooth_rough_dielectrics_are_glass() {
    let mut random = Random(187);
    for (ior, roughness) in [(1.5, 0.0), (0.7, 0.0009), (1.0, 0.5), (1.000_000_1, 1.0), (2.4, 0.0)] {
        let rows: Vec<In> = (0..10_000)
            .map(|i| {
                let cos = if i % 2 == 0 { random.uniform() } else { decades(&mut random, -3.0, 0.0) };
                let row = frosted(arriving(&mut random, cos), ior, roughness);
                In { u: uniforms(&mut random, i), front: i as u32 / 3 % 2, ..row }
            })
            .collect();
        let smooth: Vec<SurfaceHit> = rows
            .iter()
            .map(|row| SurfaceHit {
                incoming: row.incoming,
                normal: row.normal,
                front: row.front,
                u: row.u,
                material: glass(ior),
                ..SurfaceHit::default()
            })
            .collect();
        let values = [("material", "dielectric"), ("times", "1"), ("keyed", "false")];
        let smooth =
            Kernel::with("test/scatter", &Setup { values: &values, ..Setup::default() }).run::<_, Answer>(&smooth);
        for (out, smooth) in kernel("rough_dielectric", 1, &[]).run::<_, Out>(&rows).iter().zip(&smooth) {
            assert_eq!(
                (out.event, out.direction, out.weight, out.non_specular),
                (smooth.event, smooth.direction, smooth.weight, 0)
            );
        }
    }
    let rough = frosted(arriving(&mut random, 0.5), 1.5, 1.0 / 1023.0);
    assert_eq!(kernel("rough_dielectric", 1, &[]).run::<_, Out>(&[rough])[0].non_specular, 1);
}

/// The index of a pane as the device has it.
fn index_of(row: &In) -> f64 {
    (1.0 + f64::from(row.material.numbers[1])).sqrt()
}

/// What a pane passes counts by its mirror image, on the side of the view.
fn before_the_pane(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal).min(0.0) * normal
}

/// Shares of the cells of microfacets that reflect, of those that pass light, and last what is lost.
fn pane_shares(facets: &Facets, alpha: f64, reflectance: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut shares = vec![0.0; 2 * Facets::COUNT + 1];
    let view = facets.view();
    facets.integrate(alpha, |cell, facet, share| {
        let cos = view.dot(facet);
        let up = 2.0 * cos * facet.z - view.z > 0.0;
        let reflected = reflectance(cos.clamp(0.0, 1.0));
        shares[if up { cell } else { 2 * Facets::COUNT }] += share * reflected;
        shares[if up { Facets::COUNT + cell } else { 2 * Facets::COUNT }] += share * (1.0 - reflected);
    });
    let sum: f64 = shares.iter().sum();
    shares.iter().map(|share| (share / sum).max(1e-9)).collect()
}

/// Of 2 x 31 x 17 cells; see above. The mean weight is what single scattering keeps, whatever the index: 4.9 standard errors of it are
/// at most 0.5 % of the light.
#[test]
fn panes_reflect_and_pass_by_the_visible_microfacets() {
    let mut random = Random(201);
    let many = kernel("thin_dielectric", DRAWS, &[]);
    let cases: Vec<(f64, f64, f64)> = [(0.2, 1.5), (0.5, 1.5), (1.0, 1.3), (0.6, 2.4)]
        .into_iter()
        .flat_map(|(roughness, ior)| [1.0, 0.4, 0.1].map(|cos| (roughness, ior, cos)))
        .collect();
    let threshold = sidak(ALPHA, cases.len());
    for (roughness, ior, cos) in cases {
        let what = format!("roughness {roughness}, ior {ior}, cosine {cos}");
        let row = pane(arriving(&mut random, cos), ior, roughness);
        let Exact { view, normal, cos_view, alpha } = exactly(&row, roughness as f32);
        let (axes, eta) = (axes(normal, view), index_of(&row));
        let facets = Facets { alpha, cos_view };
        let mut counts = vec![0u64; 2 * Facets::COUNT + 1];
        let mut sum = 0.0;
        for out in many.run_with::<_, Out>(&[row], DRAWS, &[]) {
            sum += f64::from(out.weight[0]);
            if out.event == ABSORBED {
                counts[2 * Facets::COUNT] += 1;
                continue;
            }
            let direction = exact(out.direction);
            assert!(out.event == SCATTERED && (direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
            assert!((0.0..=1.0 + 8.0 * U as f32).contains(&out.weight[0]), "{out:?}");
            let first = if direction.dot(normal) > 0.0 { 0 } else { Facets::COUNT };
            let facet = (before_the_pane(direction, normal) + view).normalize();
            counts[first + facets.cell(within(&axes, facet))] += 1;
        }
        let p = |shares: Vec<f64>| {
            let expected: Vec<f64> = shares.iter().map(|share| share * DRAWS as f64).collect();
            chi_square(&counts, &expected, 1)
        };
        let exactly = |cos: f64| fresnel(cos, eta).0;
        let right = p(pane_shares(&facets, alpha, exactly));
        assert!(right > threshold, "{what}: p = {right:e}");
        let wider = p(pane_shares(&facets, 1.04 * alpha, exactly));
        assert!(wider < threshold, "{what}, wider: p = {wider:e}");
        // Reflection by the surface's normal instead of the microfacet's. Within a narrow lobe it hardly changes.
        let flat = p(pane_shares(&facets, alpha, |_| exactly(cos_view)));
        assert!(cos == 1.0 || roughness < 0.5 || flat < threshold, "{what}, by the surface: p = {flat:e}");
        let (mean, expected) = (sum / DRAWS as f64, directional_albedo(&facets));
        let limit = 4.9 * (expected * (1.0 - expected)).sqrt() / (DRAWS as f64).sqrt() + 2e-4;
        assert!((mean - expected).abs() < limit && limit < 0.0051, "{what}: {mean} of {expected}");
    }
}

/// Rows of random index, roughness and angle, towards a random light or the answer.
fn pane_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    (0..count)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -4.0, 0.0) };
            let roughness = [decades(random, -2.0, 0.0), 1.0, 0.1, 0.5][i % 4];
            let ior = [1.5, 1.0001, 2.4, 1e3, 1.0][i % 5];
            let light = if towards_light { rounded(unit(random)) } else { [0.0; 3] };
            In { u: uniforms(random, i), light, ..pane(arriving(random, cos), ior, roughness) }
        })
        .collect()
}

/// The share that a smooth boundary reflects at a cosine, for an index.
pub type Reflectance = fn(f64, f64) -> f64;

pub fn fresnel_of_a_pane(cos: f64, eta: f64) -> f64 {
    if eta == 1.0 { 0.0 } else { fresnel(cos, eta).0 }
}

fn schlick_of_a_pane(cos: f64, eta: f64) -> f64 {
    schlick(cos, ((eta - 1.0) / (eta + 1.0)).powi(2))
}

/// As of a rough boundary.
pub fn pane_response(row: &In, direction: DVec3, reflectance: Reflectance) -> (f64, f64, f64, f64) {
    let Exact { view, normal, cos_view, alpha } = exactly(row, row.material.numbers[0]);
    let eta = index_of(row);
    let (height, mirrored) = (direction.dot(normal), before_the_pane(direction, normal));
    let facet = (view + mirrored).normalize();
    let cos_facet = view.dot(facet);
    let reflected = reflectance(cos_facet.min(1.0), eta);
    let part = if height > 0.0 { reflected } else { 1.0 - reflected };
    let pdf = part * visible(facet, view, normal, alpha) / (4.0 * cos_facet);
    let share = shadowing(cos_view, height.abs(), alpha) / masking(cos_view, alpha);
    // As for conductors, with a direction that is rounded once more; and the reflectance by the cosine's rounding.
    let turned = 8.0 * U / (view + mirrored).length();
    let near = [-2.0, 2.0].map(|by| reflectance((cos_facet + by * turned).clamp(0.0, 1.0), eta));
    let blur = (near[0] - near[1]).abs() + 64.0 * U * reflected;
    let limit = 2.0 * explained(row, mirrored) + if part > 0.0 { blur / part } else { 0.0 };
    (pdf * share, pdf, limit, share)
}

fn pane_faults(kernel: &Kernel, rows: &[In], reflectance: Reflectance) -> (usize, usize, usize) {
    let (mut off, mut unweighted, mut compared) = (0, 0, 0);
    for (row, out) in rows.iter().zip(kernel.run::<_, Out>(rows)) {
        let own = row.light == [0.0; 3];
        if own && out.event == ABSORBED {
            continue;
        }
        let direction = exact(if own { out.direction } else { row.light }).normalize();
        let (value, pdf, limit, share) = pane_response(row, direction, reflectance);
        if limit > 0.1 || direction.dot(exact(row.normal)).abs() < 4.0 * U {
            continue;
        }
        compared += 1;
        let near = |found: f32, expected: f64| (f64::from(found) - expected).abs() <= limit * expected + 1e-30;
        off += usize::from(!(near(out.pdf, pdf) && out.value.iter().all(|found| near(*found, value))));
        unweighted += usize::from(own && (f64::from(out.weight[0]) - share).abs() > limit * share);
    }
    (off, unweighted, compared)
}

#[test]
fn panes_respond_by_the_microfacet_formula() {
    let mut random = Random(203);
    let own = kernel("thin_dielectric", 1, &[]);
    let textbook = kernel("thin_dielectric", 1, &[("lib/microfacet", "test/control/microfacet_textbook")]);
    let approximate = kernel("thin_dielectric", 1, &[("lib/fresnel", "lib/fresnel_schlick")]);
    for towards_light in [false, true] {
        let rows = pane_rows(&mut random, 20_000, towards_light);
        let (off, unweighted, compared) = pane_faults(&own, &rows, fresnel_of_a_pane);
        assert_eq!((off, unweighted), (0, 0), "of {compared}, towards lights: {towards_light}");
        assert!(compared > 12_000, "{compared}");
        let (off, unweighted, _) = pane_faults(&textbook, &rows, fresnel_of_a_pane);
        assert!(off > 100 && (towards_light || unweighted > 100), "textbook: {off}, {unweighted}");
        // Each reflectance, where the other is expected, and where it is.
        let (off, ..) = pane_faults(&approximate, &rows, fresnel_of_a_pane);
        assert!(off > 1000, "Schlick: {off}");
        let (off, unweighted, _) = pane_faults(&approximate, &rows, schlick_of_a_pane);
        assert_eq!((off, unweighted), (0, 0), "Schlick, towards lights: {towards_light}");
    }
}

/// The BSDF for light and view exchanged, on either side: what passes a thin pane ends in the solid in which it began. Planted is the
/// index squared.
#[test]
fn panes_scatter_the_same_both_ways() {
    let mut random = Random(205);
    let rows: Vec<In> = pane_rows(&mut random, 40_000, true)
        .into_iter()
        .filter(|row| [row.light, row.incoming].iter().all(|v| exact(*v).dot(exact(row.normal)).abs() > 1e-2))
        .collect();
    let turned: Vec<In> = rows
        .iter()
        .map(|row| {
            let through = exact(row.light).dot(exact(row.normal)) < 0.0;
            let normal = if through { row.normal.map(|c| -c) } else { row.normal };
            let front = u32::from(!through);
            In { incoming: row.light.map(|c| -c), light: row.incoming.map(|c| -c), normal, front, ..*row }
        })
        .collect();
    let kernel = kernel("thin_dielectric", 1, &[]);
    let (there, back) = (kernel.run::<_, Out>(&rows), kernel.run::<_, Out>(&turned));
    let limit = |row: &In| pane_response(row, exact(row.light).normalize(), fresnel_of_a_pane).2;
    let (mut wrong, mut scaled, mut passed, mut reflected) = (0, 0, 0, 0);
    for ((row, turned), (there, back)) in rows.iter().zip(&turned).zip(there.iter().zip(&back)) {
        let normal = exact(row.normal);
        let (cos_there, cos_back) = (exact(row.light).dot(normal), -exact(row.incoming).dot(normal));
        let (a, b) = (f64::from(there.value[0]) / cos_there.abs(), f64::from(back.value[0]) / cos_back);
        let off = |scale: f64| {
            let limit = limit(row) + limit(turned);
            usize::from(limit < 0.05 && (a - b * scale).abs() > limit * a)
        };
        wrong += off(1.0);
        scaled += if cos_there < 0.0 { off(index_of(row).powi(2)) } else { 0 };
        *(if cos_there < 0.0 { &mut passed } else { &mut reflected }) += usize::from(a > 0.0);
    }
    assert_eq!(wrong, 0);
    assert!(scaled > 1000 && passed > 4000 && reflected > 4000, "{scaled}, {passed}, {reflected}");
}

/// A smooth pane scatters only what it reflects, as a mirror does: rays pass it before (tests/images/panes.rs).
#[test]
fn smooth_panes_scatter_as_mirrors() {
    let mut random = Random(207);
    let rows: Vec<In> = (0..20_000)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(&mut random, -6.0, 0.0) };
            let (ior, roughness) = ([1.5, 1.0, 1.0001, 1e3, 2.4][i % 5], [0.0, 1.0 / 1024.1][i / 5 % 2]);
            In { u: uniforms(&mut random, i), ..pane(arriving(&mut random, cos), ior, roughness) }
        })
        .collect();
    for (row, out) in rows.iter().zip(kernel("thin_dielectric", 1, &[]).run::<_, Out>(&rows)) {
        assert_eq!((out.event, out.weight, out.non_specular), (SCATTERED, [1.0; 3], 0), "{row:?}");
        let (view, normal) = (-exact(row.incoming).normalize(), exact(row.normal).normalize());
        let off = (exact(out.direction) - (2.0 * view.dot(normal) * normal - view)).length();
        assert!(off < 8.0 * U, "{row:?}: {out:?}");
    }
    let rough = pane(arriving(&mut random, 0.5), 1.5, 1.0 / 1024.0);
    assert_eq!(kernel("thin_dielectric", 1, &[]).run::<_, Out>(&[rough])[0].non_specular, 1);
}
