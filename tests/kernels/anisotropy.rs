//! lobe/anisotropy: microfacets that are rougher along a direction, against their formulas in f64, for each material that has them.

use std::f64::consts::PI;

use glam::DVec3;

use crate::common::kernel::Kernel;
use crate::common::microfacets::{
    ABSORBED, In, Lobes, Out, SCATTERED, arriving, axes, conductor, frosted, kernel, kernel_of, planted_kernel,
    schlick, uniforms, within,
};
use crate::common::oracles::fresnel;
use crate::common::stats::{Random, chi_square, sidak};
use crate::common::vectors::{U, decades, exact, rounded, unit};
use crate::pbr::{NO_LAYER, RINGS, SECTORS, cell, hemisphere, pbr};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;
const DRAWS: usize = 1 << 18;
const FACETS: &str = "lobe/anisotropy";

/// The row with this strength along a random direction.
fn along(random: &mut Random, row: In, strength: f64) -> In {
    let normal = exact(row.normal);
    let tangent = normal.cross(unit(random)).normalize();
    let lobes = Lobes { anisotropy: (strength * strength) as f32, ..row.lobes };
    In { tangent: rounded(tangent), lobes, ..row }
}

/// The space of a row: its axes, its view there, and its two alphas.
struct Space {
    axes: [DVec3; 3],
    view: DVec3,
    alphas: [f64; 2],
}

impl Space {
    fn of(row: &In) -> Space {
        let (normal, tangent) = (exact(row.normal).normalize(), exact(row.tangent));
        let tangent = (tangent - tangent.dot(normal) * normal).normalize();
        let axes = [tangent, normal.cross(tangent), normal];
        let alpha = f64::from(row.material.numbers[0]).powi(2);
        let alphas = [alpha + f64::from(row.lobes.anisotropy) * (1.0 - alpha), alpha];
        Space { axes, view: within(&axes, -exact(row.incoming).normalize()), alphas }
    }

    /// Heitz, JCGT 3(2), 2014, equations 85 and 86.
    fn density(&self, facet: DVec3) -> f64 {
        let [a, b] = self.alphas;
        if facet.z <= 0.0 {
            return 0.0;
        }
        let spread = (facet.x / a).powi(2) + (facet.y / b).powi(2) + facet.z * facet.z;
        1.0 / (PI * a * b * spread * spread)
    }

    fn lambda(&self, v: DVec3) -> f64 {
        let [a, b] = self.alphas;
        let across = ((a * v.x).powi(2) + (b * v.y).powi(2)) / (v.z * v.z);
        0.5 * ((1.0 + across).sqrt() - 1.0)
    }

    /// The density of the microfacet normals that the view sees.
    fn visible(&self, facet: DVec3) -> f64 {
        self.density(facet) * self.view.dot(facet).max(0.0) / ((1.0 + self.lambda(self.view)) * self.view.z)
    }

    /// G2 / G1.
    fn shadowed(&self, direction: DVec3) -> f64 {
        let view = self.lambda(self.view);
        (1.0 + view) / (1.0 + view + self.lambda(direction))
    }
}

/// The value by channel and the density of a metal, and the relative error that f32 explains: as for conductors, with the smaller alpha.
fn metal(row: &In, direction: DVec3) -> ([f64; 3], f64, f64) {
    let space = Space::of(row);
    let light = within(&space.axes, direction);
    if light.z <= 0.0 {
        return ([0.0; 3], 0.0, 0.0);
    }
    let facet = (space.view + light).normalize();
    let pdf = space.visible(facet) / (4.0 * space.view.dot(facet));
    let value =
        row.colour.map(|albedo| schlick(space.view.dot(facet), f64::from(albedo)) * pdf * space.shadowed(light));
    let turned = 8.0 * U / (space.view + light).length();
    let [_, alpha] = space.alphas;
    let limit = 96.0 * U + 4.0 * turned / alpha + 4.0 * U / light.z + 4.0 * U / (space.view.z + alpha) + 16.0 * turned;
    (value, pdf, limit)
}

/// Rough glass in the same way, where a microfacet sees both directions.
fn boundary(row: &In, direction: DVec3) -> ([f64; 3], f64, f64) {
    let space = Space::of(row);
    let light = within(&space.axes, direction);
    let ior = f64::from(row.second.numbers[0]);
    let eta = if row.front == 1 { ior } else { 1.0 / ior };
    let reflects = light.z > 0.0;
    let sum = space.view + if reflects { 1.0 } else { eta } * light;
    let facet = sum.normalize() * if sum.z < 0.0 { -1.0 } else { 1.0 };
    let (cos_facet, cos_out) = (space.view.dot(facet), light.dot(facet));
    if cos_facet <= 0.0 || (cos_out > 0.0) != reflects {
        return ([0.0; 3], 0.0, f64::NAN);
    }
    let reflectance = fresnel(cos_facet, eta).0;
    let seen = space.visible(facet);
    let pdf = match reflects {
        true => reflectance * seen / (4.0 * cos_facet),
        false => (1.0 - reflectance) * seen * eta * eta * cos_out.abs() / (cos_facet + eta * cos_out).powi(2),
    };
    let turned = 8.0 * (1.0 + eta) * U / sum.length();
    let near = [-2.0, 2.0].map(|by| fresnel((cos_facet + by * turned).clamp(0.0, 1.0), eta).0);
    let blur = (near[0] - near[1]).abs() + 64.0 * U * reflectance;
    let of_share = if reflects { blur / reflectance } else { blur / (1.0 - reflectance) };
    let [_, alpha] = space.alphas;
    let grazing = 4.0 * U / light.z.abs()
        + 4.0 * U / (space.view.z + alpha)
        + 4.0 * turned / cos_facet
        + 4.0 * turned / cos_out.abs();
    // Microfacets that stand upright are seen or not by their last digits.
    let upright = if facet.z.abs() < 16.0 * U / sum.length() { f64::NAN } else { 0.0 };
    let limit = upright + 96.0 * U + 4.0 * turned / alpha + grazing + 16.0 * turned + of_share;
    ([pdf * space.shadowed(light); 3], pdf, limit)
}

/// Makes a row of a material with this roughness, by its number.
type Make = fn(In, f64, usize) -> In;
type Formula = fn(&In, DVec3) -> ([f64; 3], f64, f64);

fn rows(random: &mut Random, count: usize, towards_light: bool, make: Make) -> Vec<In> {
    (0..count)
        .map(|i| {
            let cos = if i % 2 == 0 { random.uniform() } else { decades(random, -3.0, 0.0) };
            // From the smallest that microfacets have on.
            let roughness = [decades(random, -2.0, 0.0), 1.0, 0.1, 1.0 / 1024.0][i % 4];
            let row = make(arriving(random, cos), roughness, i);
            let strength = [1.0, 0.3, 0.8, 0.01][i / 4 % 4];
            let light = if towards_light { rounded(unit(random)) } else { [0.0; 3] };
            In { u: uniforms(random, i), light, ..along(random, row, strength) }
        })
        .collect()
}

fn metal_row(row: In, roughness: f64, _: usize) -> In {
    In { colour: [0.9, 0.5, 0.0], ..conductor(row, roughness, None) }
}

fn pbr_row(row: In, roughness: f64, _: usize) -> In {
    In { f90: NO_LAYER, ..pbr(row, [0.9, 0.5, 0.0], 1.0, roughness, 1.5) }
}

fn glass_row(row: In, roughness: f64, i: usize) -> In {
    In { front: i as u32 / 3 % 2, ..frosted(row, [1.5, 1.33, 2.4][i % 3], roughness) }
}

/// The rows whose value or density is off, those whose weight is not their ratio, and those compared.
fn faults(kernel: &Kernel, rows: &[In], formula: Formula) -> (usize, usize, usize) {
    let (mut off, mut unweighted, mut compared) = (0, 0, 0);
    for (row, out) in rows.iter().zip(kernel.run::<_, Out>(rows)) {
        let own = row.light == [0.0; 3];
        if own && out.event == ABSORBED {
            continue;
        }
        let direction = exact(if own { out.direction } else { row.light }).normalize();
        let (value, pdf, limit) = formula(row, direction);
        // Where f32 has no digits, there is nothing to compare.
        if limit.is_nan() || limit > 0.1 || direction.dot(exact(row.normal)).abs() < 4.0 * U {
            continue;
        }
        compared += 1;
        let cosine = 20.0 * U / (direction - exact(row.incoming)).length().min(1.0);
        let near = |found: f32, expected: f64, all: f64| {
            (f64::from(found) - expected).abs() <= limit * expected + cosine * all + 1e-30
        };
        let is_off = !(near(out.pdf, pdf, 0.0) && (0..3).all(|c| near(out.value[c], value[c], pdf)));
        off += usize::from(is_off);
        let is_ratio = |c: usize| {
            let ratio = value[c] / pdf;
            (f64::from(out.weight[c]) - ratio).abs() <= limit * ratio + cosine
        };
        unweighted += usize::from(own && pdf > 0.0 && !(0..3).all(is_ratio));
    }
    (off, unweighted, compared)
}

#[test]
fn materials_respond_by_the_anisotropic_formula() {
    let mut random = Random(701);
    let kinds: [(&str, Make, Formula); 3] =
        [("conductor", metal_row, metal), ("pbr", pbr_row, metal), ("rough_dielectric", glass_row, boundary)];
    for (material, make, formula) in kinds {
        let own = kernel_of(material, 1, &[], &[FACETS]);
        let mut all = Vec::new();
        for towards_light in [false, true] {
            let rows = rows(&mut random, 20_000, towards_light, make);
            let (off, unweighted, compared) = faults(&own, &rows, formula);
            assert_eq!((off, unweighted), (0, 0), "{material}, of {compared}, towards lights: {towards_light}");
            assert!(compared > 3000, "{material}: {compared}");
            all.extend(rows);
        }
        for planted in [
            (
                FACETS,
                "vec2<f32>(mix(alpha, 1.0, hit.lobes.anisotropy), alpha)",
                "vec2<f32>(alpha, mix(alpha, 1.0, hit.lobes.anisotropy))",
            ),
            (FACETS, "mix(alpha, 1.0, hit.lobes.anisotropy), alpha)", "mix(alpha, 1.02, hit.lobes.anisotropy), alpha)"),
            (
                "lib/anisotropic_microfacet",
                "let across = alphas * direction.xy;",
                "let across = alphas.yx * direction.xy;",
            ),
        ] {
            let (off, ..) = faults(&planted_kernel(material, 1, &[FACETS], planted), &all, formula);
            assert!(off > 100, "{material}: {planted:?} is found in {off} rows");
        }
    }
}

/// A material without anisotropy has the bytes of isotropic microfacets.
#[test]
fn without_a_strength_microfacets_are_isotropic() {
    let mut random = Random(703);
    for (material, make) in [("conductor", metal_row as Make), ("pbr", pbr_row), ("rough_dielectric", glass_row)] {
        for towards_light in [false, true] {
            let rows: Vec<In> = rows(&mut random, 10_000, towards_light, make)
                .into_iter()
                .map(|row| In { lobes: Lobes::default(), ..row })
                .collect();
            let bytes = |kernel: &Kernel| bytemuck::cast_slice::<Out, u32>(&kernel.run::<_, Out>(&rows)).to_vec();
            assert!(bytes(&kernel(material, 1, &[])) == bytes(&kernel_of(material, 1, &[], &[FACETS])), "{material}");
        }
    }
}

/// The BRDF of metals for light and view exchanged.
#[test]
fn anisotropic_metals_reflect_the_same_both_ways() {
    let mut random = Random(705);
    let upright = |v: [f32; 3], row: &In| exact(v).dot(exact(row.normal)).abs();
    let rows: Vec<In> = rows(&mut random, 20_000, true, metal_row)
        .into_iter()
        .filter(|row| exact(row.light).dot(exact(row.normal)) > 0.01 && upright(row.incoming, row) > 0.01)
        .collect();
    let turned: Vec<In> = rows
        .iter()
        .map(|row| In { incoming: row.light.map(|c| -c), light: row.incoming.map(|c| -c), ..*row })
        .collect();
    let kernel = kernel_of("conductor", 1, &[], &[FACETS]);
    let (there, back) = (kernel.run::<_, Out>(&rows), kernel.run::<_, Out>(&turned));
    let wrong = |power: i32| {
        let off = rows.iter().zip(there.iter().zip(&back)).filter(|(row, (there, back))| {
            let (light, view) = (upright(row.light, row).powi(power), upright(row.incoming, row).powi(power));
            let (a, b) = (f64::from(there.value[0]) / light, f64::from(back.value[0]) / view);
            let alpha = f64::from(row.material.numbers[0]).powi(2);
            (a - b).abs() > (1e-4 + 64.0 * U / alpha) * a + 1e-9
        });
        off.count()
    };
    assert!(rows.len() > 4000, "{}", rows.len());
    assert_eq!(wrong(1), 0);
    assert!(wrong(0) > 2000);
}

/// Directions in cells of the hemisphere, whose azimuth counts from the tangent.
#[test]
fn anisotropic_metals_scatter_by_their_density() {
    let mut random = Random(707);
    let many = kernel_of("conductor", DRAWS, &[], &[FACETS]);
    let cases = [(0.5, 0.7), (0.4, 1.0), (0.8, 0.4)];
    let cosines = [1.0, 0.6, 0.2];
    let threshold = sidak(ALPHA, cases.len() * cosines.len());
    let cells = RINGS * SECTORS;
    for (roughness, strength) in cases {
        for cos in cosines {
            let what = format!("roughness {roughness}, strength {strength}, cosine {cos}");
            let row = metal_row(arriving(&mut random, cos), roughness, 0);
            let row = along(&mut random, row, strength);
            let space = Space::of(&row);
            let mut counts = vec![0u64; cells + 1];
            for out in many.run_with::<_, Out>(&[row], DRAWS, &[]) {
                if out.event == ABSORBED {
                    counts[cells] += 1;
                    continue;
                }
                assert!(out.event == SCATTERED && out.weight[0] <= 1.0 + 8.0 * U as f32, "{out:?}");
                counts[cell(within(&space.axes, exact(out.direction)))] += 1;
            }
            let p = |space: &Space| {
                let mut shares = vec![0.0; cells + 1];
                hemisphere(|cell, direction, solid_angle| {
                    let facet = (space.view + direction).normalize();
                    shares[cell] += solid_angle * space.visible(facet) / (4.0 * space.view.dot(facet)) * DRAWS as f64;
                });
                shares.iter_mut().for_each(|share| *share = share.max(1e-9));
                shares[cells] = (DRAWS as f64 - shares.iter().sum::<f64>()).max(1e-9);
                chi_square(&counts, &shares, 1)
            };
            let right = p(&space);
            assert!(right > threshold, "{what}: p = {right:e}");
            let [a, b] = space.alphas;
            let other = p(&Space { alphas: [1.05 * a, b], ..space });
            assert!(other < threshold, "{what}, another alpha: p = {other:e}");
        }
    }
    // The axes of other tests, whose view has no y.
    let row = arriving(&mut random, 0.5);
    let own = axes(exact(row.normal), -exact(row.incoming));
    assert!(within(&own, exact(row.incoming)).y.abs() < 1e-6);
}
