//! material/conductor, material/rough_dielectric, material/thin_dielectric: their formulas in f64 (bsdf.rs compares them), and what becomes of a ray where
//! they are smooth.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use gpu_rt::material::microfacets::directional_albedos;
use gpu_rt::scene::Scene;

use crate::bsdf::Bsdf;
use crate::common::kernel::{Kernel, Setup, array};
use crate::common::microfacets::{
    ABSORBED, Facets, In, OnePlastic, Out, SCATTERED, arriving, conductor, directional_albedo, frosted, kernel,
    metal_reflectance, pane, plastic, plastics, schlick, uniforms, view_and_normal, within,
};
use crate::common::oracles::fresnel;
use crate::common::rows::{Answer, SurfaceHit, glass};
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// Microfacets in a space whose z is the normal and whose x is the tangent: the view, and the alphas along x and y.
pub struct Space {
    axes: [DVec3; 3],
    view: DVec3,
    pub alphas: [f64; 2],
    is_isotropic: bool,
    pub is_beckmann: bool,
}

impl Space {
    pub fn of(row: &In) -> Space {
        let (view, normal) = view_and_normal(row);
        let tangent = exact(row.tangent);
        let tangent =
            (tangent - tangent.dot(normal) * normal).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        let axes = [tangent, normal.cross(tangent), normal];
        let alpha = f64::from(row.material.numbers[0]).powi(2);
        let anisotropy = f64::from(row.lobes.anisotropy);
        let alphas = [alpha + anisotropy * (1.0 - alpha), alpha];
        Space {
            axes,
            view: within(&axes, view),
            alphas,
            is_isotropic: anisotropy == 0.0,
            is_beckmann: row.beckmann != 0.0,
        }
    }

    /// Heitz, JCGT 3(2), 2014, equations 80, 85 and 86.
    fn density(&self, facet: DVec3) -> f64 {
        let [a, b] = self.alphas;
        if facet.z <= 0.0 {
            return 0.0;
        }
        if self.is_beckmann {
            return (-self.slope2(facet)).exp() / (PI * a * b * facet.z.powi(4));
        }
        let spread = (facet.x / a).powi(2) + (facet.y / b).powi(2) + facet.z * facet.z;
        1.0 / (PI * a * b * spread * spread)
    }

    /// The square of a normal's slope in alphas.
    fn slope2(&self, facet: DVec3) -> f64 {
        let [a, b] = self.alphas;
        ((facet.x / a).powi(2) + (facet.y / b).powi(2)) / (facet.z * facet.z)
    }

    fn lambda(&self, v: DVec3) -> f64 {
        let [a, b] = self.alphas;
        let across = ((a * v.x).powi(2) + (b * v.y).powi(2)) / (v.z * v.z);
        if self.is_beckmann {
            // Equation 78.
            let steepness = across.sqrt().recip();
            return 0.5 * ((-steepness * steepness).exp() / (steepness * PI.sqrt()) - erfc(steepness));
        }
        0.5 * ((1.0 + across).sqrt() - 1.0)
    }

    /// The density of the microfacet normals that the view sees.
    fn visible(&self, facet: DVec3) -> f64 {
        self.density(facet) * self.view.dot(facet).max(0.0) / ((1.0 + self.lambda(self.view)) * self.view.z)
    }

    /// The density of directions, in the space of the row, to which these are mirrors.
    pub fn density_of_reflection(&self, direction: DVec3) -> f64 {
        let light = within(&self.axes, direction);
        let facet = (self.view + light).normalize();
        if light.z > 0.0 { self.visible(facet) / (4.0 * self.view.dot(facet)) } else { 0.0 }
    }

    /// G2 / G1.
    fn shadowed(&self, light: DVec3) -> f64 {
        let view = self.lambda(self.view);
        (1.0 + view) / (1.0 + view + self.lambda(light))
    }

    /// By how much f32 turns a sum of two directions of this length, each of so many u: anisotropic ones are turned into the axes besides.
    fn turned(&self, roundings: f64, length: f64) -> f64 {
        roundings * if self.is_isotropic { U } else { 2.0 * U } / length
    }

    /// The relative error that f32 explains, for a half vector that is turned by so much: it moves the density by at most 2 of that per alpha.
    /// A cosine is off by 4 u, which counts where the light grazes.
    /// That of Beckmann falls by the square of the slope: by as much more.
    fn limit(&self, roundings: f64, turned: f64, cos_light: f64, facet: DVec3) -> f64 {
        let [_, alpha] = self.alphas;
        let slope2 = if self.is_beckmann { self.slope2(facet) } else { 0.0 };
        let (roundings, turned) = (roundings + 8.0 * slope2, turned * (1.0 + slope2.sqrt()));
        roundings * U + 4.0 * turned / alpha + 4.0 * U / cos_light + 4.0 * U / (self.view.z + alpha) + 16.0 * turned
    }
}

/// 1 - erf(x) of an x that is not negative, by Simpson's rule.
fn erfc(x: f64) -> f64 {
    let at = |i: i32| (-(x + f64::from(i) / 64.0).powi(2)).exp();
    2.0 / PI.sqrt() / 192.0 * (0..320).map(|i| at(2 * i) + 4.0 * at(2 * i + 1) + at(2 * i + 2)).sum::<f64>()
}

/// Rows at all angles, of roughnesses from this power of ten on, towards a random light or the answer.
pub fn rows_from(
    (random, count, towards_light): (&mut Random, usize, bool),
    least: f64,
    make: impl Fn(usize, In, f64) -> In,
) -> Vec<In> {
    let mut row = |i: usize| {
        let cos = if i.is_multiple_of(2) { random.uniform() } else { decades(random, -4.0, 0.0) };
        let roughness = [decades(random, least, 0.0), 1.0, 0.1, 0.5][i % 4];
        let row = make(i, arriving(random, cos), roughness);
        let light = if towards_light { rounded(unit(random)) } else { [0.0; 3] };
        In { u: uniforms(random, i), light, ..row }
    };
    (0..count).map(&mut row).collect()
}

/// Metals of an albedo and of an index.
pub fn metal_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    rows_from((random, count, towards_light), -3.0, |i, row, roughness| {
        let k = i.is_multiple_of(3).then_some([3.9, 2.4, 1e-2]);
        // Of an index its excess over 1.
        let colour = if k.is_some() { [-0.8, -0.1, 0.5] } else { [0.9, 0.5, 0.0] };
        In { colour, ..conductor(row, roughness, k) }
    })
}

/// A metal's BSDF.
pub fn metal(row: &In, direction: DVec3) -> Bsdf {
    let space = Space::of(row);
    let light = within(&space.axes, direction);
    let weight_off = Some([0.0; 3]);
    if light.z < 4.0 * U {
        // A light within the rounding of the horizon may lie on either side of it.
        return Bsdf { is_unknown: light.z > -4.0 * U, weight_off, ..Bsdf::default() };
    }
    let (length, cos_facet) = ((space.view + light).length(), space.view.dot((space.view + light).normalize()));
    let share = |c: usize| match row.second.numbers[0] != 0.0 {
        true => metal_reflectance(cos_facet, 1.0 + f64::from(row.colour[c]), f64::from(row.second.colour[c])),
        false => schlick(cos_facet, f64::from(row.colour[c])),
    };
    let pdf = space.density_of_reflection(direction);
    let white = pdf * space.shadowed(light);
    let value = [0, 1, 2].map(|c| share(c) * white);
    let limit = space.limit(
        if space.is_isotropic { 64.0 } else { 96.0 },
        space.turned(4.0, length),
        light.z,
        space.view + light,
    );
    // A reflectance is off by 5 times the cosine's rounding.
    let cosine = 20.0 * U / length.min(1.0);
    Bsdf {
        value,
        pdf,
        off: value.map(|value| limit * value + cosine * white),
        pdf_off: limit * pdf,
        weight_off: Some(value.map(|value| limit * value / pdf + cosine)),
        is_unknown: (!space.is_isotropic || space.is_beckmann) && limit > 0.1,
    }
}

/// Plastics of all their numbers.
pub fn plastic_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    rows_from((random, count, towards_light), -1.0, |i, row, _| {
        plastic(In { colour: [0.9, 0.5, 0.0], ..row }, i / 4 % plastics().len(), i.is_multiple_of(3))
    })
}

/// A plastic's BSDF: its layer, and what enters it, is scattered by the body and leaves it.
pub fn plastic_bsdf(row: &In, direction: DVec3) -> Bsdf {
    let space = Space::of(row);
    let light = within(&space.axes, direction);
    let [roughness, contrast, leaving] = row.material.numbers.map(f64::from);
    let is_own = |one: &&OnePlastic| {
        one.own.roughness as f32 == row.material.numbers[0] && one.leaving as f32 == row.material.numbers[2]
    };
    let OnePlastic { table, .. } = plastics().iter().find(is_own).expect("it is one of them");
    let eta = (1.0 + contrast).sqrt();
    let passed = |cosine: f64| match roughness < 1.0 / 1024.0 {
        true => 1.0 - fresnel(cosine, eta).0,
        false => {
            let x = cosine.sqrt() * 63.0;
            let left = (x as usize).min(62);
            table[left] + (x - left as f64) * (table[left + 1] - table[left])
        }
    };
    let nonlinear = row.second.numbers[0] != 0.0;
    let body = row.colour.map(|colour| {
        let colour = f64::from(colour);
        let again = if nonlinear { colour } else { 1.0 };
        colour / (eta * eta * (1.0 - again) + leaving * again)
    });
    let of_layer = 1.0 - passed(space.view.z);
    let of_body = passed(space.view.z) * leaving * body.iter().sum::<f64>() / 3.0;
    let share = (of_layer / (of_layer + of_body)).clamp(0.1, 0.9);
    if light.z < 4.0 * U {
        return Bsdf { is_unknown: light.z > -4.0 * U, ..Bsdf::default() };
    }
    let matt = passed(space.view.z) * passed(light.z) * light.z / PI;
    // f32 rounds 1 - F and the steps between the columns of the table, which are less than 8 times the cosine's rounding over its root.
    let cosine = |cosine: f64| 16.0 * U * (1.0 + 8.0 / cosine.sqrt()) / passed(cosine).max(U);
    let blurred = 64.0 * U + cosine(space.view.z) + cosine(light.z);
    let matt_pdf = (1.0 - share) * light.z / PI;
    let smooth = Bsdf {
        value: body.map(|body| body * matt),
        pdf: matt_pdf,
        off: body.map(|body| blurred * body * matt),
        pdf_off: (blurred + 16.0 * U / light.z) * matt_pdf,
        weight_off: None,
        is_unknown: false,
    };
    if roughness < 1.0 / 1024.0 {
        return smooth;
    }
    let (length, facet) = ((space.view + light).length(), (space.view + light).normalize());
    let facets = space.density_of_reflection(direction);
    let glossy = fresnel(space.view.dot(facet).min(1.0), eta).0 * facets * space.shadowed(light);
    let limit = space.limit(64.0, space.turned(4.0, length), light.z, facet) + 64.0 * U / space.view.dot(facet);
    // A reflectance at a low index is the square of a small number.
    let of_reflectance = 64.0 * U / (1.0 - space.view.dot(facet).min(1.0 - U)).sqrt().max(1e-3);
    Bsdf {
        value: smooth.value.map(|matt| matt + glossy),
        pdf: matt_pdf + share * facets,
        off: smooth.off.map(|off| off + (limit + of_reflectance) * glossy),
        pdf_off: smooth.pdf_off + (limit + blurred) * share * facets,
        is_unknown: limit > 0.1,
        ..smooth
    }
}

/// The relative error of an isotropic metal's value that f32 explains.
pub fn explained(row: &In, direction: DVec3) -> f64 {
    let space = Space::of(row);
    let light = within(&space.axes, direction);
    space.limit(64.0, space.turned(4.0, (space.view + light).length()), light.z.abs().max(1e-9), space.view + light)
}

/// The index of the far side relative to the near one.
pub fn eta_of(row: &In) -> f64 {
    let ior = f64::from(row.second.numbers[0]);
    if row.front == 1 { ior } else { 1.0 / ior }
}

/// The ray that a microfacet refracts, if it does.
pub fn refracted(view: DVec3, facet: DVec3, eta: f64) -> Option<DVec3> {
    let cos = view.dot(facet);
    let transmitted = fresnel(cos, eta).1;
    (transmitted > 0.0).then(|| -view / eta + (cos / eta - transmitted) * facet)
}

/// The microfacet normal between the view and a direction on the far side: Walter et al., equation 16.
pub fn facet_between(view: DVec3, direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let facet = (view + eta * direction).normalize();
    if facet.dot(normal) < 0.0 { -facet } else { facet }
}

/// Rough boundaries of all indices, seen from both sides.
pub fn glass_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    rows_from((random, count, towards_light), -2.0, |i, row, roughness| In {
        front: i as u32 / 7 % 2,
        ..frosted(row, [1.5, 1.01, 2.4, 0.6, 1.33][i % 5], roughness)
    })
}

/// What an oracle says of a white boundary: the density, the share of it that the light reaches too, and the relative error that f32 explains.
fn white(pdf: f64, share: f64, limit: f64, is_unknown: bool) -> Bsdf {
    let value = [pdf * share; 3];
    let is_unknown = is_unknown || pdf == 0.0 || limit.is_nan() || limit > 0.1;
    let (off, weight_off) = (value.map(|value| limit * value), Some([limit * share; 3]));
    Bsdf { value, pdf, off, pdf_off: limit * pdf, weight_off, is_unknown }
}

/// A rough boundary's BSDF.
pub fn boundary(row: &In, direction: DVec3) -> Bsdf {
    let (space, eta) = (Space::of(row), eta_of(row));
    let light = within(&space.axes, direction);
    let reflects = light.z > 0.0;
    let sum = space.view + if reflects { 1.0 } else { eta } * light;
    let facet = sum.normalize() * if sum.z < 0.0 { -1.0 } else { 1.0 };
    let (cos_facet, cos_out) = (space.view.dot(facet), light.dot(facet));
    if cos_facet <= 0.0 || (cos_out > 0.0) != reflects {
        // This may be on the edge of what microfacets see there.
        return Bsdf { is_unknown: true, ..Bsdf::default() };
    }
    let reflectance = fresnel(cos_facet, eta).0;
    let seen = space.visible(facet);
    let pdf = match reflects {
        true => reflectance * seen / (4.0 * cos_facet),
        false => (1.0 - reflectance) * seen * eta * eta * cos_out.abs() / (cos_facet + eta * cos_out).powi(2),
    };
    // Fresnel's reflectance is off by the cosine's rounding, most of all next to total reflection.
    let turned = space.turned(4.0 * (1.0 + eta), sum.length());
    let near = [-2.0, 2.0].map(|by| fresnel((cos_facet + by * turned).clamp(0.0, 1.0), eta).0);
    let blur = (near[0] - near[1]).abs() + 64.0 * U * reflectance;
    let of_share = if reflects { blur / reflectance } else { blur / (1.0 - reflectance) };
    // Microfacets that stand upright are seen or not by their last digits.
    let upright = facet.z.abs() < 16.0 * U / sum.length();
    let limit = space.limit(96.0, turned, light.z.abs(), facet)
        + 4.0 * turned / cos_facet
        + 4.0 * turned / cos_out.abs()
        + of_share;
    white(pdf, space.shadowed(light), limit, upright || light.z.abs() < 4.0 * U)
}

/// The index of a pane as the device has it.
pub fn index_of(row: &In) -> f64 {
    (1.0 + f64::from(row.material.numbers[1])).sqrt()
}

/// What a pane passes counts by its mirror image, on the side of the view.
pub fn before_the_pane(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal).min(0.0) * normal
}

/// Panes of all indices.
pub fn pane_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    rows_from((random, count, towards_light), -2.0, |i, row, roughness| {
        pane(row, [1.5, 1.0001, 2.4, 1e3, 1.0][i % 5], roughness)
    })
}

pub fn fresnel_of_a_pane(cos: f64, eta: f64) -> f64 {
    if eta == 1.0 { 0.0 } else { fresnel(cos, eta).0 }
}

pub fn exact_pane(row: &In, direction: DVec3) -> Bsdf {
    pane_bsdf(row, direction, fresnel_of_a_pane)
}

pub fn schlick_pane(row: &In, direction: DVec3) -> Bsdf {
    pane_bsdf(row, direction, |cos, eta| schlick(cos, ((eta - 1.0) / (eta + 1.0)).powi(2)))
}

/// A rough pane's BSDF, by the share that a smooth boundary reflects at a cosine, for an index.
fn pane_bsdf(row: &In, direction: DVec3, reflectance: fn(f64, f64) -> f64) -> Bsdf {
    let (space, eta) = (Space::of(row), index_of(row));
    let light = within(&space.axes, direction);
    let mirrored = before_the_pane(light, DVec3::Z);
    let sum = space.view + mirrored;
    let facet = sum.normalize();
    let cos_facet = space.view.dot(facet);
    let reflected = reflectance(cos_facet.min(1.0), eta);
    let part = if light.z > 0.0 { reflected } else { 1.0 - reflected };
    let pdf = part * space.visible(facet) / (4.0 * cos_facet);
    // A direction is rounded once more than a conductor's; and the reflectance by the cosine's rounding.
    let turned = space.turned(8.0, sum.length());
    let near = [-2.0, 2.0].map(|by| reflectance((cos_facet + by * turned).clamp(0.0, 1.0), eta));
    let blur = (near[0] - near[1]).abs() + 64.0 * U * reflected;
    let explained = space.limit(64.0, space.turned(4.0, sum.length()), mirrored.z.abs().max(1e-9), facet);
    let limit = 2.0 * explained + if part > 0.0 { blur / part } else { 0.0 };
    let found = white(pdf, space.shadowed(mirrored), limit, false);
    // At an index of 1 nothing is reflected.
    Bsdf { is_unknown: limit > 0.1 || light.z.abs() < 4.0 * U, ..found }
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
    let albedo = "directional_albedo(given.x, given.y)";
    let own = Kernel::of(["scene/directional_albedo", "vec2<f32>", "f32", albedo], &[]);
    let expected = |[cos, roughness]: [f32; 2]| {
        directional_albedo(&Facets { alpha: f64::from(roughness.max(1.0 / 1024.0)).powi(2), cos_view: f64::from(cos) })
    };
    let expected: Vec<f64> = rows.iter().map(|row| expected(*row)).collect();
    let worst = |shares: &[[f32; 4]]| {
        let found = own.run_with::<_, f32>(&rows, rows.len(), &[array("directional_albedos", shares)]);
        let off = found.iter().zip(&expected).map(|(found, expected)| (f64::from(*found) / expected - 1.0).abs());
        off.fold(0.0, f64::max)
    };
    let mut shares = directional_albedos().to_vec();
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
        let (single, full) = (kernel(material, &[]), kernel(material, &["scene/multiscatter"]));
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

/// The answers of a material without microfacets to the same rays.
fn smooth_answers(material: &str, rows: &[In], hit: impl Fn(&In) -> SurfaceHit) -> Vec<Answer> {
    let with_ray = |row: &In| SurfaceHit { incoming: row.incoming, normal: row.normal, front: row.front, ..hit(row) };
    let rows: Vec<SurfaceHit> = rows.iter().map(with_ray).collect();
    Kernel::with("test/scatter", &Setup { values: &[("material", material)], ..Setup::default() }).run(&rows)
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
    let found = kernel("conductor", &[]).run::<_, Out>(&rows);
    let mirror = smooth_answers("metal", &rows, |_| SurfaceHit { colour: [1.0; 3], ..SurfaceHit::default() });
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
    let found = kernel("conductor", &[]).run::<_, Out>(&[at(1.0 / 1024.0), at(1.0 / 1024.1)]);
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
    let shader = kernel("conductor", &[]);
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
        let of_glass = |row: &In| SurfaceHit { u: row.u, material: glass(ior), ..SurfaceHit::default() };
        let smooth = smooth_answers("dielectric", &rows, of_glass);
        for (out, smooth) in kernel("rough_dielectric", &[]).run::<_, Out>(&rows).iter().zip(&smooth) {
            assert_eq!(
                (out.event, out.direction, out.weight, out.non_specular),
                (smooth.event, smooth.direction, smooth.weight, 0)
            );
        }
    }
    let rough = frosted(arriving(&mut random, 0.5), 1.5, 1.0 / 1023.0);
    assert_eq!(kernel("rough_dielectric", &[]).run::<_, Out>(&[rough])[0].non_specular, 1);
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
    for (row, out) in rows.iter().zip(kernel("thin_dielectric", &[]).run::<_, Out>(&rows)) {
        assert_eq!((out.event, out.weight, out.non_specular), (SCATTERED, [1.0; 3], 0), "{row:?}");
        let (view, normal) = (-exact(row.incoming).normalize(), exact(row.normal).normalize());
        let off = (exact(out.direction) - (2.0 * view.dot(normal) * normal - view)).length();
        assert!(off < 8.0 * U, "{row:?}: {out:?}");
    }
    let rough = pane(arriving(&mut random, 0.5), 1.5, 1.0 / 1024.0);
    assert_eq!(kernel("thin_dielectric", &[]).run::<_, Out>(&[rough])[0].non_specular, 1);
}
