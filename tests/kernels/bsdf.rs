//! Materials of microfacets against their formulas in f64: answers one by one, light and view exchanged, and many directions against their density.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glam::DVec3;

use crate::anisotropy::{ANISOTROPY, FACETS, along, glass_row, metal_row, pbr_row, stretched_rows};
use crate::common::kernel::{Kernel, MODULE, Plant, Setup};
use crate::common::microfacets::{
    ABSORBED, BY_PAPERS, Facets, In, Lobes, NO_LAYER, SCATTERED, SPECULAR, answers, arriving, axes, conductor,
    directional_albedo, frosted, kernel, kernel_with, pane, view_and_normal, within,
};
use crate::common::oracles::{INCIDENT_SCHLICK, fresnel};
use crate::common::stats::{Random, chi_square, sidak};
use crate::common::vectors::{U, exact, rounded};
use crate::pbr::{self, RINGS, SECTORS, cell, formula, hemisphere, share_of_facets};
use crate::pbr_lobes::{self, ALL, filmed, sheened, translucent};
use crate::rough::{self, Space};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;
/// Chi-square of 31 x 17 cells over 2^18 draws finds a density that is off by 3.3 % in the root mean square with a probability of 99.9 %.
pub const DRAWS: usize = 1 << 18;

/// The BSDF times cosine, the density of directions, and how much f32 may be off: of the value and of the weight by channel, and of the density.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bsdf {
    pub value: [f64; 3],
    pub pdf: f64,
    pub off: [f64; 3],
    pub pdf_off: f64,
    /// None where the weight is the quotient of what the kernel says of both.
    pub weight_off: Option<[f64; 3]>,
    /// f32 has no digits here.
    pub is_unknown: bool,
}

/// In the direction of a row's light, or of its answer.
pub type Bsdfs = fn(&In, DVec3) -> Bsdf;
/// So many rows, towards lights or not.
pub type Rows = fn(&mut Random, usize, bool) -> Vec<In>;

/// Rows of which value or density is off: of their own answers, and of those towards lights; own answers whose weight is; and rows compared to 10 %.
fn faults(kernel: &Kernel, rows: &[In], bsdf: Bsdfs) -> [usize; 4] {
    let mut found = [0; 4];
    for (row, out) in rows.iter().zip(answers(kernel, rows, rows.len())) {
        let own = row.light == [0.0; 3];
        if out.non_specular == 0 || own && (out.event == ABSORBED || out.lobe == SPECULAR) {
            continue;
        }
        let expected = bsdf(row, exact(if own { out.direction } else { row.light }).normalize());
        if expected.is_unknown {
            continue;
        }
        let near = |found: f32, expected: f64, off: f64| (f64::from(found) - expected).abs() <= off + 1e-30;
        let is_value = |c: usize| near(out.value[c], expected.value[c], expected.off[c]);
        let is_right = near(out.pdf, expected.pdf, expected.pdf_off) && (0..3).all(is_value);
        found[usize::from(!own)] += usize::from(!is_right);
        let is_weight = |c: usize| match expected.weight_off {
            Some(off) => (f64::from(out.weight[c]) - expected.value[c] / expected.pdf).abs() <= off[c],
            // A quotient of 2.5 ULP, as WGSL allows it, and the roundings of what it is made of.
            None => {
                let ratio = f64::from(out.value[c]) / f64::from(out.pdf);
                (f64::from(out.weight[c]) - ratio).abs() <= 16.0 * U * ratio.max(1.0)
            }
        };
        found[2] += usize::from(own && !(0..3).all(is_weight));
        found[3] += usize::from(expected.pdf_off <= 0.1 * expected.pdf);
    }
    found
}

/// A planted error: another text, an expression, or another formula in f64.
#[derive(Debug)]
pub enum Wrong {
    Text(&'static [Plant]),
    Expression(Plant),
    Formula(Bsdfs),
}
use Wrong::{Expression, Formula, Text};

/// A material, its rows, the formula, and the errors planted. At least so many rows find each: by own answers, by those towards lights, by weights,
/// and more than 100 in all.
pub struct Material {
    pub name: &'static str,
    pub shader: &'static str,
    /// The modules that a scene may choose.
    pub with: &'static [&'static str],
    pub seed: u64,
    pub rows: Rows,
    pub bsdf: Bsdfs,
    /// A module of another option, and what stands in for it.
    pub replaced: &'static [Plant],
    /// How many of 20,000 rows of either kind are compared at least.
    pub compared: usize,
    pub planted: &'static [(Wrong, [usize; 3])],
}

/// All planted expressions of a shader are in one kernel.
pub fn respond_by_their_formulas(materials: &[Material]) {
    let mut plants: BTreeMap<_, Vec<Plant>> = BTreeMap::new();
    for material in materials {
        let expression = |(wrong, _): &(Wrong, _)| if let Expression(plant) = wrong { Some(*plant) } else { None };
        let own = material.planted.iter().filter_map(expression);
        plants.entry((material.shader, material.with)).or_default().extend(own);
    }
    for material in materials {
        let Material { name, shader, with, seed, rows, bsdf, replaced, compared: least, planted } = material;
        let plants = &plants[&(*shader, *with)];
        let with_plants = kernel_with(shader, with, &Setup { plants, ..Setup::default() });
        let own = kernel_with(shader, with, &Setup { replaced, ..Setup::default() });
        let mut random = Random(*seed);
        let mut all = Vec::new();
        for towards_light in [false, true] {
            let rows = rows(&mut random, 20_000, towards_light);
            let [off, off_of_lights, unweighted, compared] = faults(&own, &rows, *bsdf);
            let found = [off + off_of_lights, unweighted];
            assert_eq!(found, [0, 0], "{name}: rows that are off, of {compared}, towards lights: {towards_light}");
            assert!(compared > *least, "{name}: {compared} rows are compared, towards lights: {towards_light}");
            all.extend(rows);
        }
        for (wrong, least) in *planted {
            let kernel_of = |setup: &Setup<'_>| kernel_with(shader, with, setup);
            let found = match *wrong {
                Text(replaced) => faults(&kernel_of(&Setup { replaced, ..Setup::default() }), &all, *bsdf),
                Expression(plant) => {
                    let number = plants.iter().position(|known| *known == plant).expect("it is in the kernel");
                    faults(&with_plants.planted(number), &all, *bsdf)
                }
                Formula(other) => faults(&own, &all, other),
            };
            let found = &found[..3];
            let enough = found.iter().zip(least).all(|(found, least)| found >= least);
            assert!(enough && found.iter().sum::<usize>() > 100, "{name}: {wrong:?} is found in {found:?} rows");
        }
    }
}

const TEXTBOOK: Wrong = Text(&BY_PAPERS);
/// By 1 %.
const BRIGHTER: Wrong = Text(&[
    ("lib/fresnel_conductor", "schlick_up_to(cosine, albedo, 1.0)", "1.01 * schlick_up_to(cosine, albedo, 1.0)"),
    ("lib/fresnel_conductor", "return share * fresnel_of_index(", "return 1.01 * share * fresnel_of_index("),
]);
const SCHLICK: Plant = ("lib/fresnel", MODULE, "lib/fresnel_schlick");
const STRETCHED: &[(Wrong, [usize; 3])] = &[
    (
        Expression((
            FACETS,
            "vec2<f32>(mix(alpha, 1.0, hit.lobes.anisotropy), alpha)",
            "vec2<f32>(alpha, mix(alpha, 1.0, hit.lobes.anisotropy))",
        )),
        [0; 3],
    ),
    (
        Expression((
            FACETS,
            "{{mix(alpha, 1.0, hit.lobes.anisotropy)}}, alpha)",
            "mix(alpha, 1.02, hit.lobes.anisotropy)",
        )),
        [0; 3],
    ),
    (Expression(("lib/anisotropic_microfacet", "alphas * direction.xy", "alphas.yx * direction.xy")), [0; 3]),
];

/// A half too wide, and visible by the other tail of the slopes.
const BECKMANN: &[(Wrong, [usize; 3])] = &[
    (Expression(("lib/beckmann", "{{exp(-slope2)}} / (PI", "exp(-1.01 * slope2)")), [0; 3]),
    (Expression(("lib/beckmann", "{{1.0 - erfc(steepness)}}) + spread", "1.0 - 1.01 * erfc(steepness)")), [0; 3]),
];

fn with_beckmann(rows: Vec<In>) -> Vec<In> {
    rows.into_iter().map(|row| In { beckmann: 1.0, ..row }).collect()
}

pub const fn material(name: &'static str, shader: &'static str, rows: Rows, bsdf: Bsdfs) -> Material {
    Material { name, shader, with: &[], seed: 173, rows, bsdf, replaced: &[], compared: 8000, planted: &[] }
}

#[test]
fn materials_respond_by_their_formulas() {
    let stretched = |name, shader, rows, bsdf| Material {
        with: ANISOTROPY,
        seed: 701,
        compared: 3000,
        planted: STRETCHED,
        ..material(name, shader, rows, bsdf)
    };
    let beckmann = |name, shader, with, rows, bsdf| Material {
        with,
        seed: 709,
        compared: 3000,
        planted: BECKMANN,
        ..material(name, shader, rows, bsdf)
    };
    let brushed: &[&str] = &["lobe/beckmann", FACETS];
    respond_by_their_formulas(&[
        Material {
            planted: &[(TEXTBOOK, [100, 0, 1]), (BRIGHTER, [4000; 3])],
            ..material("conductors", "conductor", rough::metal_rows, rough::metal)
        },
        Material {
            seed: 183,
            planted: &[(TEXTBOOK, [100; 3]), (Text(&INCIDENT_SCHLICK), [1000, 1000, 0])],
            ..material("rough glass", "rough_dielectric", rough::glass_rows, rough::boundary)
        },
        Material {
            seed: 203,
            compared: 12_000,
            planted: &[(TEXTBOOK, [100; 3])],
            ..material("panes", "thin_dielectric", rough::pane_rows, rough::exact_pane)
        },
        Material {
            seed: 203,
            compared: 12_000,
            replaced: &[SCHLICK],
            planted: &[(Formula(rough::exact_pane), [1000, 1000, 0])],
            ..material("panes by Schlick", "thin_dielectric", rough::pane_rows, rough::schlick_pane)
        },
        Material {
            seed: 203,
            planted: &[(BRIGHTER, [3000, 3000, 0])],
            ..material("glTF", "pbr", pbr::rows, pbr_lobes::bsdf)
        },
        Material {
            with: &["lobe/specular"],
            seed: 207,
            planted: &[
                (Formula(|row, d| pbr_lobes::bsdf(&In { f90: NO_LAYER, ..*row }, d)), [0, 3000, 0]),
                // 1 % brighter at grazing angles.
                (Formula(|row, d| pbr_lobes::bsdf(&In { f90: 1.01 * row.f90, ..*row }, d)), [0, 300, 0]),
            ],
            ..material("glTF with a layer of its own", "pbr", pbr::layered_rows, pbr_lobes::bsdf)
        },
        stretched("brushed conductors", "conductor", |r, n, l| stretched_rows(r, n, l, metal_row), rough::metal),
        stretched("brushed glTF", "pbr", |r, n, l| stretched_rows(r, n, l, pbr_row), rough::metal),
        stretched("brushed glass", "rough_dielectric", |r, n, l| stretched_rows(r, n, l, glass_row), rough::boundary),
        Material {
            with: &["lobe/beckmann", "lobe/rough_layer"],
            seed: 711,
            planted: &[
                (
                    Expression((
                        "material/plastic_eval",
                        "{{hit.second.${plastic.nonlinear} > 0.0}}",
                        "hit.second.${plastic.nonlinear} < 0.0",
                    )),
                    [0; 3],
                ),
                (Expression(("lobe/rough_layer", "{{sqrt(cosine)}} * f32", "1.01 * sqrt(cosine)")), [0; 3]),
            ],
            ..material("plastics", "plastic", rough::plastic_rows, rough::plastic_bsdf)
        },
        beckmann(
            "Beckmann's conductors",
            "conductor",
            &["lobe/beckmann"],
            |r, n, l| with_beckmann(rough::metal_rows(r, n, l)),
            rough::metal,
        ),
        beckmann(
            "Beckmann's glass",
            "rough_dielectric",
            &["lobe/beckmann"],
            |r, n, l| with_beckmann(rough::glass_rows(r, n, l)),
            rough::boundary,
        ),
        beckmann(
            "brushed conductors of Beckmann",
            "conductor",
            brushed,
            |r, n, l| with_beckmann(stretched_rows(r, n, l, metal_row)),
            rough::metal,
        ),
    ]);
}

/// A row with light and view exchanged.
fn exchanged(row: &In) -> In {
    let through = exact(row.light).dot(exact(row.normal)) < 0.0;
    let normal = if through { row.normal.map(|c| -c) } else { row.normal };
    let front = if through { 1 - row.front } else { row.front };
    In { incoming: row.light.map(|c| -c), light: row.incoming.map(|c| -c), normal, front, ..*row }
}

/// How much values may differ, relatively and besides; infinitely where f32 has no digits.
type Limit<'a> = &'a dyn Fn(&In, &In) -> (f64, f64);

/// Compares the BSDF for light and view exchanged, over the index squared where light enters a solid. Values with their cosines are planted, and an
/// index squared that counts where it must not, or does not where it must. At least so many rows reflect and pass light, and find either.
fn compare_both_ways(
    name: &str,
    kernel: &Kernel,
    rows: Vec<In>,
    index2: (f64, fn(&In) -> f64),
    limit: Limit<'_>,
    least: [usize; 4],
) {
    let turned: Vec<In> = rows.iter().map(exchanged).collect();
    let [there, back] = [&rows, &turned].map(|rows| answers(kernel, rows, rows.len()));
    let (mut wrong, mut found) = (0, [0; 4]);
    for ((row, turned), (there, back)) in rows.iter().zip(&turned).zip(there.iter().zip(&back)) {
        let normal = exact(row.normal);
        let (cos_there, cos_back) = (exact(row.light).dot(normal), -exact(row.incoming).dot(normal));
        let (a, b) = (f64::from(there.value[0]) / cos_there.abs(), f64::from(back.value[0]) / cos_back.abs());
        let passes = cos_there < 0.0;
        let scale = |power: f64| if passes { (index2.1)(row).powf(power) } else { 1.0 };
        let (relative, absolute) = limit(row, turned);
        let off = |a: f64, b: f64| usize::from((a - b).abs() > relative * a + absolute);
        wrong += off(a, b * scale(index2.0));
        found[usize::from(passes)] += usize::from(a > 0.0);
        found[2] += off(a * cos_there.abs(), b * scale(index2.0) * cos_back.abs());
        found[3] += off(a, b * scale(1.0 - index2.0));
    }
    assert_eq!(wrong, 0, "{name}: of {found:?} rows");
    assert!(found.iter().zip(least).all(|(found, least)| *found >= least), "{name}: {found:?} rows");
}

#[test]
fn materials_scatter_the_same_both_ways() {
    let steep = |rows: Vec<In>, least: f64, passes: bool| -> Vec<In> {
        let cosine = |row: &In, v: [f32; 3]| exact(v).dot(exact(row.normal));
        let is_steep = |row: &In| {
            let light = cosine(row, row.light);
            (light > least || passes && light < -least) && -cosine(row, row.incoming) > least
        };
        rows.into_iter().filter(is_steep).collect()
    };
    let by_alpha = |absolute: f64, roundings: f64| {
        move |row: &In, _: &In| (absolute + roundings * U / f64::from(row.material.numbers[0]).powi(2), 1e-9)
    };
    let none: (f64, fn(&In) -> f64) = (0.0, |_| 1.0);
    compare_both_ways(
        "conductors",
        &kernel("conductor", &[]),
        steep(rough::metal_rows(&mut Random(175), 20_000, true), 1e-3, false),
        none,
        &|row, turned| {
            let cos_back = exact(turned.light).dot(exact(row.normal));
            (2.0 * (rough::explained(row, exact(row.light)) + 8.0 * U / cos_back), 0.0)
        },
        [4000, 0, 4000, 0],
    );
    let limit_of = |bsdf: Bsdfs, row: &In| {
        let found = bsdf(row, exact(row.light).normalize());
        match found.pdf == 0.0 {
            true => 0.0,
            false if found.is_unknown => f64::INFINITY,
            false => found.pdf_off / found.pdf,
        }
    };
    let resolved = |limit: f64| if limit < 0.05 { limit } else { f64::INFINITY };
    let glass = steep(rough::glass_rows(&mut Random(185), 40_000, true), 1e-2, true);
    compare_both_ways(
        "rough glass",
        &kernel("rough_dielectric", &[]),
        glass.into_iter().filter(|row| limit_of(rough::boundary, row) < 0.01).collect(),
        (1.0, |row| rough::eta_of(row).powi(2)),
        &|row, turned| {
            let both = limit_of(rough::boundary, row) + limit_of(rough::boundary, turned);
            (resolved(2.0 * both + 1e-5), 0.0)
        },
        [4000, 2000, 0, 1000],
    );
    // What passes a thin pane ends in the solid in which it began.
    compare_both_ways(
        "panes",
        &kernel("thin_dielectric", &[]),
        steep(rough::pane_rows(&mut Random(205), 40_000, true), 1e-2, true),
        (0.0, |row| rough::index_of(row).powi(2)),
        &|row, turned| (resolved(limit_of(rough::exact_pane, row) + limit_of(rough::exact_pane, turned)), 0.0),
        [4000, 4000, 0, 1000],
    );
    let pbr_rows = steep(pbr::rows(&mut Random(205), 20_000, true), 0.01, false);
    assert!(pbr_rows.len() > 4000);
    compare_both_ways("glTF", &kernel("pbr", &[]), pbr_rows, none, &by_alpha(2e-5, 32.0), [0, 0, 2000, 0]);
    let layered = pbr_lobes::glassy_rows(&mut Random(603), 40_000, true).into_iter().enumerate();
    let layered = layered.map(|(i, row)| translucent(i / 13, filmed(i / 11, sheened(i / 7, row))));
    let of_panes = steep(layered.filter(|row| row.lobes.ior == 0.0).collect(), 0.01, true);
    assert!(of_panes.len() > 8000);
    let name = "a base with panes, sheen, film and translucence";
    compare_both_ways(name, &kernel("pbr", &ALL), of_panes, none, &by_alpha(1e-3, 64.0), [0, 0, 2000, 0]);
    let brushed = steep(stretched_rows(&mut Random(705), 20_000, true, metal_row), 0.01, false);
    let brushed_kernel = kernel("conductor", ANISOTROPY);
    compare_both_ways("brushed conductors", &brushed_kernel, brushed, none, &by_alpha(1e-4, 64.0), [4000, 0, 2000, 0]);
}

/// Many answers to a row: counts in cells, of which the last is for what is absorbed, and the mean weight with its variance.
struct Drawn {
    counts: Vec<u64>,
    mean: f64,
    variance: f64,
}

impl Drawn {
    fn new(kernel: &Kernel, row: &In, cells: usize, most: f32, cell: impl Fn(DVec3) -> usize) -> Drawn {
        let mut counts = vec![0; cells + 1];
        let (mut sum, mut squares) = (0.0, 0.0);
        for out in answers(kernel, &[*row], DRAWS) {
            let weight = f64::from(out.weight[0]);
            (sum, squares) = (sum + weight, squares + weight * weight);
            if out.event == ABSORBED {
                assert_eq!(out.weight, [0.0; 3]);
                counts[cells] += 1;
                continue;
            }
            let direction = exact(out.direction);
            assert!(out.event == SCATTERED && (direction.length() - 1.0).abs() < 4.0 * U, "{out:?}");
            assert!(out.weight.iter().all(|weight| (0.0..=most).contains(weight)), "{out:?}");
            counts[cell(direction)] += 1;
        }
        let mean = sum / DRAWS as f64;
        Drawn { counts, mean, variance: squares / DRAWS as f64 - mean * mean }
    }

    /// The p-value of shares of the cells. A cell that no midpoint is in may have a corner that is.
    fn p(&self, shares: &[f64]) -> f64 {
        let expected: Vec<f64> = shares.iter().map(|share| (share * DRAWS as f64).max(1e-9)).collect();
        chi_square(&self.counts, &expected, 1)
    }
}

/// Shares of the cells of microfacets that reflect upwards, of those that let light pass, and last what is lost: by the reflectance at a cosine, and
/// by the microfacets that light may pass to the far side.
fn facet_shares(
    facets: &Facets,
    alpha: f64,
    reflectance: impl Fn(f64) -> f64,
    passes: impl Fn(DVec3) -> bool,
    seen: impl Fn(DVec3) -> f64,
) -> Vec<f64> {
    let mut shares = vec![0.0; 2 * Facets::COUNT + 1];
    let view = facets.view();
    facets.integrate(alpha, |cell, facet, share| {
        let (cos, share) = (view.dot(facet), share * seen(facet));
        if cos <= 0.0 {
            return;
        }
        let reflected = reflectance(cos.min(1.0));
        let up = 2.0 * cos * facet.z - view.z > 0.0;
        shares[if up { cell } else { 2 * Facets::COUNT }] += share * reflected;
        shares[if passes(facet) { Facets::COUNT + cell } else { 2 * Facets::COUNT }] += share * (1.0 - reflected);
    });
    let sum: f64 = shares.iter().sum();
    shares.iter().map(|share| share / sum).collect()
}

/// Of 2 x 31 x 17 cells. White conductors and panes keep what single scattering keeps, whatever the index: 4.9 standard errors of it, of weights
/// from 0 to 1, are at most 0.5 % of the light.
#[test]
fn materials_scatter_by_the_visible_microfacets() {
    let mut random = Random(171);
    let cross = |lobes: &[(f64, f64)], cosines: &[f64]| -> Vec<(f64, f64, f64)> {
        lobes.iter().flat_map(|(roughness, ior)| cosines.iter().map(move |cos| (*roughness, *ior, *cos))).collect()
    };
    let mut metals = cross(&[(0.04, 1.0), (0.2, 1.0), (0.5, 1.0), (1.0, 1.0)], &[1.0, FRAC_1_SQRT_2, 0.1]);
    metals.extend([(0.1, 1.0, 0.9), (0.5, 1.0, 0.2), (1.0, 1.0, 0.5), (1.0, 1.0, 0.05)]);
    let glass = [(0.2, 1.5), (0.5, 1.5), (1.0, 1.5), (0.4, 1.1), (0.6, 2.4), (0.3, 0.6)];
    let panes = [(0.2, 1.5), (0.5, 1.5), (1.0, 1.3), (0.6, 2.4)];
    for (shader, cases) in [
        ("conductor", metals),
        ("rough_dielectric", cross(&glass, &[1.0, 0.6, 0.15])),
        ("thin_dielectric", cross(&panes, &[1.0, 0.4, 0.1])),
    ] {
        let many = kernel(shader, &[]);
        let threshold = sidak(ALPHA, cases.len());
        for (roughness, ior, cos) in cases {
            let what = format!("{shader}, roughness {roughness}, ior {ior}, cosine {cos}");
            let arriving = arriving(&mut random, cos);
            let (is_metal, is_solid) = (shader == "conductor", shader == "rough_dielectric");
            let row = match shader {
                "conductor" => conductor(arriving, roughness, None),
                "thin_dielectric" => pane(arriving, ior, roughness),
                _ => In { front: u32::from(cos != 0.6), ..frosted(arriving, ior, roughness) },
            };
            let (view, normal) = view_and_normal(&row);
            let (axes, alpha) = (axes(normal, view), f64::from(roughness as f32).powi(2));
            let eta = if is_solid { rough::eta_of(&row) } else { rough::index_of(&row) };
            let facets = Facets { alpha, cos_view: view.dot(normal) };
            let drawn = Drawn::new(&many, &row, 2 * Facets::COUNT, 1.0 + 8.0 * U as f32, |direction| {
                let (first, facet) = match direction.dot(normal) > 0.0 {
                    true => (0, (direction + view).normalize()),
                    false if is_solid => (Facets::COUNT, rough::facet_between(view, direction, normal, eta)),
                    false => (Facets::COUNT, (rough::before_the_pane(direction, normal) + view).normalize()),
                };
                first + facets.cell(within(&axes, facet))
            });
            let reflectance = |cos: f64| if is_metal { 1.0 } else { fresnel(cos, eta).0 };
            let passes = |facet: DVec3| match is_solid {
                true => rough::refracted(facets.view(), facet, eta).is_some_and(|direction| direction.z < 0.0),
                false => 2.0 * facets.view().dot(facet) * facet.z - facets.cos_view > 0.0,
            };
            let p = |alpha: f64| drawn.p(&facet_shares(&facets, alpha, reflectance, passes, |_| 1.0));
            assert!(p(alpha) > threshold, "{what}: p = {:e}", p(alpha));
            let wider = if is_metal { 1.03 } else { 1.04 };
            assert!(p(wider * alpha) < threshold, "{what}, wider: p = {:e}", p(wider * alpha));
            if is_metal {
                // Microfacets by their area, hidden or not. Where the lobe is narrow and the view steep, all are seen alike.
                let area = |facet: DVec3| facet.z / facet.dot(facets.view()).max(1e-9);
                let p = drawn.p(&facet_shares(&facets, alpha, reflectance, passes, area));
                let alike = alpha * (1.0 - cos * cos).sqrt() / cos < 0.1;
                assert!(alike || p < threshold, "{what}, by area: p = {p:e}");
            } else {
                // Reflection by the surface's normal instead of the microfacet's. Within the narrow lobe of a pane it hardly changes.
                let flat = reflectance(facets.cos_view);
                let p = drawn.p(&facet_shares(&facets, alpha, |_| flat, passes, |_| 1.0));
                let alike = cos == 1.0 || !is_solid && roughness < 0.5;
                assert!(alike || p < threshold, "{what}, by the surface: p = {p:e}");
            }
            let expected = directional_albedo(&facets);
            let limit = 4.9 * (expected * (1.0 - expected)).sqrt() / (DRAWS as f64).sqrt() + 2e-4;
            let is_kept = (drawn.mean - expected).abs() < limit && limit < 0.0051;
            assert!(is_solid || is_kept, "{what}: {} of {expected}", drawn.mean);
        }
    }
}

/// Compares directions and the mean weight with the integral of the density and of the value, in cells over the sphere. The planted error is another
/// density: of the row in a space with this normal, the direction there, and the right density; and whether as much is to be lost by it.
fn scatters_by_its_density(
    what: &str,
    (kernel, row): (&Kernel, &In),
    threshold: f64,
    bsdf: Bsdfs,
    (wrong, loses_as_much): (impl Fn(&In, DVec3, f64) -> f64, bool),
) {
    let cells = RINGS * SECTORS;
    let (view, normal) = view_and_normal(row);
    let axes = axes(normal, view);
    let side = |z: f64| if z < 0.0 { cells } else { 0 };
    let drawn = Drawn::new(kernel, row, 2 * cells, f32::MAX, |direction| {
        let own = within(&axes, direction);
        side(own.z) + cell(DVec3::new(own.x, own.y, own.z.abs()))
    });
    let turned = |v: [f32; 3]| rounded(within(&axes, exact(v)));
    let [incoming, coat_normal, tangent] = [row.incoming, row.coat_normal, row.tangent].map(turned);
    let own = In { incoming, normal: [0.0, 0.0, 1.0], coat_normal, tangent, ..*row };
    let (mut shares, mut planted, mut kept) = (vec![0.0; 2 * cells + 1], vec![0.0; 2 * cells + 1], 0.0);
    for sign in [1.0, -1.0] {
        hemisphere(|cell, direction, solid_angle| {
            let direction = DVec3::new(direction.x, direction.y, sign * direction.z);
            let found = bsdf(&own, direction);
            let at = side(direction.z) + cell;
            shares[at] += solid_angle * found.pdf;
            planted[at] += solid_angle * wrong(&own, direction, found.pdf);
            kept += solid_angle * found.value[0];
        });
    }
    let all: f64 = shares.iter().sum();
    assert!(all < 1.001, "{what}: the density's integral is {all}");
    let planted_all: f64 = planted.iter().sum();
    let (scale, lost) = if loses_as_much { (all / planted_all, 1.0 - all) } else { (1.0, 1.0 - planted_all) };
    planted.iter_mut().for_each(|share| *share *= scale);
    (shares[2 * cells], planted[2 * cells]) = (1.0 - all, lost);
    let (right, other) = (drawn.p(&shares), drawn.p(&planted));
    assert!(right > threshold, "{what}: p = {right:e}");
    assert!(other < threshold, "{what}, another density: p = {other:e}");
    let error = 4.9 * (drawn.variance / DRAWS as f64).sqrt() + 1e-3 * kept;
    assert!((drawn.mean - kept).abs() < error, "{what}: {} of {kept}, known to {error}", drawn.mean);
    assert!(error < 0.01 * kept, "{what}: {kept} is known to {error}");
}

const COSINES: [f64; 3] = [1.0, 0.6, 0.2];

/// Materials whose lobes are wide enough for cells of directions.
#[test]
fn gltfs_material_scatters_by_its_density_and_keeps_the_light_of_its_formula() {
    let mut random = Random(201);
    let plain = kernel("pbr", &[]);
    let cases = [([0.8, 0.5, 0.2], 0.0, 0.5), ([0.9, 0.6, 0.3], 1.0, 0.7), ([0.5; 3], 0.5, 1.0), ([0.0; 3], 0.0, 0.6)];
    let threshold = sidak(ALPHA, cases.len() * COSINES.len());
    for (base, metallic, roughness) in cases {
        for cos in COSINES {
            let what = format!("{base:?}, metallic {metallic}, roughness {roughness}, cosine {cos}");
            let row = pbr::pbr(arriving(&mut random, cos), base, metallic, roughness, 1.5);
            // Another share of microfacets.
            let wrong = |row: &In, direction: DVec3, _| {
                let (view, normal) = view_and_normal(row);
                let pbr::Formula { facets, cosine, .. } = formula(row, view, normal, direction);
                let share = share_of_facets(row, view.dot(normal)) - 0.05;
                share * facets + (1.0 - share) * cosine
            };
            scatters_by_its_density(&what, (&plain, &row), threshold, pbr_lobes::bsdf, (wrong, false));
        }
    }
}

/// 8 % more on one side of a plane, and less on the other.
fn leaning(_: &In, direction: DVec3, pdf: f64) -> f64 {
    pdf * if direction.y > 0.0 { 1.08 } else { 0.92 }
}

#[test]
fn layers_scatter_by_their_densities() {
    let mut random = Random(605);
    let many = kernel("pbr", &ALL);
    let glass = [
        ([0.8, 0.5, 0.2], 0.0, 0.5, 0.3, 1.5, false, 1),
        // Lobes of refraction are narrower.
        ([0.8, 0.5, 0.2], 0.0, 0.9, 0.7, 1.5, true, 1),
        ([0.9, 0.6, 0.3], 0.3, 0.9, 0.5, 1.33, true, 0),
        ([0.3; 3], 0.0, 0.9, 1.0, 1.5, true, 1),
    ];
    let coat = |roughness: f32| Lobes { coat: 1.0, coat_roughness: roughness, coat_f0: 0.2, ..Lobes::default() };
    let sheen = |roughness: f32| Lobes { sheen: [0.9, 0.5, 0.2], sheen_roughness: roughness, ..Lobes::default() };
    let through = Lobes { through: 0.6, colour_through: [0.3, 0.9, 0.2], ..Lobes::default() };
    let film = Lobes { film: 1.0, film_ior: 1.8, film_thickness: 300.0, ..Lobes::default() };
    let all = Lobes { sheen: [0.5, 0.8, 0.1], sheen_roughness: 0.4, dispersion: 0.05, ..coat(0.5) };
    let all = Lobes { film: 0.5, film_ior: 1.4, film_thickness: 450.0, ..all };
    // With the tilt of the coat's normal.
    let layers = [
        (coat(0.5), 0.0, 0.3),
        (coat(0.7), 0.0, 0.0),
        (sheen(0.3), 0.0, 0.0),
        (sheen(1.0), 1.0, 0.0),
        (through, 0.0, 0.0),
        (film, 1.0, 0.0),
        (all, 0.3, 0.2),
    ];
    let threshold = sidak(ALPHA, (glass.len() + layers.len()) * COSINES.len());
    for cos in COSINES {
        for (base, metallic, roughness, share, ior, is_solid, front) in glass {
            let what = format!("{base:?}, metallic {metallic}, roughness {roughness}, {share} of glass, cosine {cos}");
            let row = pbr::pbr(arriving(&mut random, cos), base, metallic, roughness, ior);
            let row = In { front, ..pbr_lobes::glassy(row, share, ior, is_solid) };
            scatters_by_its_density(&what, (&many, &row), threshold, pbr_lobes::bsdf, (leaning, true));
        }
        for (lobes, metallic, tilt) in layers {
            let what = format!("{lobes:?}, metallic {metallic}, cosine {cos}");
            let roughness = if metallic == 0.3 { 0.9 } else { 0.6 };
            let row = pbr::pbr(arriving(&mut random, cos), [0.8, 0.5, 0.2], metallic, roughness, 1.5);
            let normal = exact(row.normal).normalize();
            let own = (normal + tilt * normal.any_orthonormal_vector()).normalize();
            let row = In { lobes, coat_normal: rounded(own), ..row };
            let row = if metallic == 0.3 { pbr_lobes::glassy(row, 0.4, 1.5, true) } else { row };
            scatters_by_its_density(&what, (&many, &row), threshold, pbr_lobes::bsdf, (leaning, true));
        }
    }
}

#[test]
fn brushed_conductors_and_those_of_beckmann_scatter_by_their_density() {
    let mut random = Random(707);
    let many = kernel("conductor", &["lobe/beckmann", FACETS]);
    let cases = [(0.5, 0.7, 0.0), (0.4, 1.0, 0.0), (0.8, 0.4, 0.0), (0.5, 0.0, 1.0), (0.9, 0.0, 1.0), (0.4, 0.6, 1.0)];
    let threshold = sidak(ALPHA, cases.len() * COSINES.len());
    for (roughness, strength, beckmann) in cases {
        for cos in COSINES {
            let what = format!("roughness {roughness}, strength {strength}, Beckmann {beckmann}, cosine {cos}");
            let row = metal_row(arriving(&mut random, cos), roughness, 0);
            let row = In { beckmann, ..along(&mut random, row, strength) };
            let rougher = |row: &In, direction: DVec3, _| {
                let mut space = Space::of(row);
                space.alphas[0] *= 1.05;
                space.density_of_reflection(direction)
            };
            scatters_by_its_density(&what, (&many, &row), threshold, rough::metal, (rougher, false));
        }
    }
}

/// Directions over a sphere stand for all of its solid angle.
#[test]
fn cells_cover_the_hemisphere() {
    let mut sum = 0.0;
    hemisphere(|_, _, solid_angle| sum += solid_angle);
    assert!((sum - TAU).abs() < 1e-9);
}
