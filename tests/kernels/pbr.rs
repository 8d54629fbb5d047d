//! material/pbr: the formula of glTF's material in f64 (bsdf.rs compares it), and what it is where its layer is smooth.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gpu_rt::data;

use crate::common::microfacets::{
    ABSORBED, In, NO_LAYER, Out, SPECULAR, conductor, density, kernel, schlick, shadowing, view_and_normal, visible,
};
use crate::common::stats::Random;
use crate::common::vectors::{U, exact};
use crate::rough::rows_from;
use crate::thin_film::thin_film;

/// Cells of directions, all of the same solid angle.
pub const RINGS: usize = 23;
pub const SECTORS: usize = 17;

pub fn pbr(row: In, base: [f32; 3], metallic: f64, roughness: f64, ior: f64) -> In {
    let material = data::Material {
        numbers: [roughness as f32, ((ior - 1.0) / (ior + 1.0)).powi(2) as f32, metallic as f32],
        ..data::Material::default()
    };
    In { colour: base, material, f90: NO_LAYER, ..row }
}

/// The reflectances of the layer at normal and at grazing incidence.
pub fn ends_of_layer(row: &In) -> ([f64; 3], f64) {
    match row.f90 == NO_LAYER {
        true => ([f64::from(row.material.numbers[1]); 3], 1.0),
        false => (row.f0.map(f64::from), f64::from(row.f90)),
    }
}

/// What the layer reflects without a film: by KHR_materials_specular if the row has a layer of its own, else by appendix B.
pub fn layer(row: &In, cosine: f64) -> [f64; 3] {
    let (f0, f90) = ends_of_layer(row);
    f0.map(|f0| f0 + (f90 - f0) * (1.0 - cosine).powi(5))
}

/// The film's share of the surface: none where it has no thickness.
pub fn film_share(row: &In) -> f64 {
    let x = (f64::from(row.lobes.film_thickness) / 0.03).clamp(0.0, 1.0);
    f64::from(row.lobes.film) * x * x * (3.0 - 2.0 * x)
}

/// A reflectance with the film's share of the surface.
pub fn with_film(row: &In, reflectance: [f64; 3], (f0, f90): ([f64; 3], f64), cosine: f64) -> [f64; 3] {
    let share = film_share(row);
    if share == 0.0 || f90 == 0.0 {
        return reflectance;
    }
    let [ior, thickness] = [row.lobes.film_ior, row.lobes.film_thickness].map(f64::from);
    let film = thin_film(cosine, ior, thickness, f0.map(|f0| f0 / f90));
    [0, 1, 2].map(|c| (1.0 - share) * reflectance[c] + share * f90 * film[c])
}

/// What the layer and the metal reflect with their film.
pub fn layer_with_film(row: &In, cosine: f64) -> [f64; 3] {
    with_film(row, layer(row, cosine), ends_of_layer(row), cosine)
}

pub fn metal_with_film(row: &In, cosine: f64) -> [f64; 3] {
    let base = row.colour.map(f64::from);
    with_film(row, base.map(|base| schlick(cosine, base)), (base, 1.0), cosine)
}

/// What the matt body scatters to the near side and to the far one.
pub fn body(row: &In) -> [[f64; 3]; 2] {
    let through = f64::from(row.lobes.through);
    [row.colour.map(|c| (1.0 - through) * f64::from(c)), row.lobes.colour_through.map(|c| through * f64::from(c))]
}

/// The probability of the far side.
pub fn share_of_far_side(row: &In) -> f64 {
    let [near, far] = body(row).map(|colour| colour.iter().sum::<f64>());
    if near + far > 0.0 { far / (near + far) } else { f64::from(row.lobes.through) }
}

/// The formula of appendix B: value per channel with the cosine, and the densities of microfacets and of the body.
pub struct Formula {
    pub value: [f64; 3],
    pub facets: f64,
    pub cosine: f64,
}

pub fn formula(row: &In, view: DVec3, normal: DVec3, direction: DVec3) -> Formula {
    let alpha = f64::from(row.material.numbers[0].max(1.0 / 1024.0)).powi(2);
    let metallic = f64::from(row.material.numbers[2]);
    let (cos_view, cos_light) = (view.dot(normal), direction.dot(normal));
    if cos_light < 0.0 && row.lobes.through > 0.0 {
        // The layer lets as much in as for the mirror image of the direction.
        let mirrored = direction - 2.0 * cos_light * normal;
        let layer = layer_with_film(row, view.dot((view + mirrored).normalize()));
        let passed = (1.0 - metallic) * (1.0 - layer.into_iter().fold(0.0, f64::max)) * -cos_light / PI;
        let cosine = share_of_far_side(row) * -cos_light / PI;
        return Formula { value: body(row)[1].map(|colour| passed * colour), facets: 0.0, cosine };
    }
    if cos_light <= 0.0 {
        return Formula { value: [0.0; 3], facets: 0.0, cosine: 0.0 };
    }
    let facet = (view + direction).normalize();
    let cos_facet = view.dot(facet);
    let specular = density(facet.cross(normal).length(), facet.dot(normal), alpha)
        * shadowing(cos_view, cos_light, alpha)
        / (4.0 * cos_view);
    let (layer, metal) = (layer_with_film(row, cos_facet), metal_with_film(row, cos_facet));
    let passed = 1.0 - layer.into_iter().fold(0.0, f64::max);
    let [near, _] = body(row);
    let value = [0, 1, 2].map(|c| {
        let dielectric = passed * near[c] * cos_light / PI + layer[c] * specular;
        (1.0 - metallic) * dielectric + metallic * metal[c] * specular
    });
    let cosine = (1.0 - share_of_far_side(row)) * cos_light / PI;
    Formula { value, facets: visible(facet, view, normal, alpha) / (4.0 * cos_facet), cosine }
}

/// About what comes back by microfacets and by the matt body, the sum of the channels.
pub fn brightness(row: &In, cos_view: f64) -> (f64, f64) {
    let metallic = f64::from(row.material.numbers[2]);
    let layer = layer(row, cos_view);
    let [near, far] = body(row);
    let (mut facets, mut matt) = (0.0, 0.0);
    for c in 0..3 {
        facets += (1.0 - metallic) * layer[c] + metallic * schlick(cos_view, f64::from(row.colour[c]));
        matt += (1.0 - metallic) * (1.0 - layer[c]) * (near[c] + far[c]);
    }
    (facets, matt)
}

/// The probability of a microfacet, as the shader has it.
pub fn share_of_facets(row: &In, cos_view: f64) -> f64 {
    let metallic = f64::from(row.material.numbers[2]);
    let (facets, matt) = brightness(row, cos_view);
    if metallic == 1.0 || body(row) == [[0.0; 3]; 2] { 1.0 } else { (facets / (facets + matt)).clamp(0.1, 0.9) }
}

/// Calls with the cell, the direction and the solid angle of many directions over the hemisphere around z.
pub fn hemisphere(mut add: impl FnMut(usize, DVec3, f64)) {
    const STEPS: usize = 24;
    let (rings, sectors) = (RINGS * STEPS, SECTORS * STEPS);
    for ring in 0..rings {
        let cos = (ring as f64 + 0.5) / rings as f64;
        let sin = (1.0 - cos * cos).sqrt();
        for sector in 0..sectors {
            let azimuth = TAU * (sector as f64 + 0.5) / sectors as f64 - PI;
            let direction = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
            let cell = ring / STEPS * SECTORS + sector / STEPS;
            add(cell, direction, TAU / (rings * sectors) as f64);
        }
    }
}

pub fn cell(direction: DVec3) -> usize {
    let bin = |x: f64, bins: usize| ((x * bins as f64) as usize).min(bins - 1);
    bin(direction.z, RINGS) * SECTORS + bin((direction.y.atan2(direction.x) + PI) / TAU, SECTORS)
}

/// Rows of random base and angle.
pub fn rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    rows_from((random, count, towards_light), -2.0, |i, row, roughness| {
        let base = [[0.8, 0.5, 0.2], [1.0, 0.0, 0.5], [0.0; 3]][i / 2 % 3];
        pbr(row, base, [0.0, 1.0, 0.3][i % 3], roughness, [1.5, 1.0, 2.4][i / 3 % 3])
    })
}

/// Layers of any share and colour, as KHR_materials_specular has them.
pub fn layered_rows(random: &mut Random, count: usize, towards_light: bool) -> Vec<In> {
    let layered = |(i, row): (usize, In)| {
        let f90 = [0.0, 0.5, 1.0, 0.01][i % 4];
        let color = [[1.0; 3], [0.9, 0.3, 0.0], [0.0; 3]][i / 4 % 3];
        In { f0: color.map(|c: f32| c * f90 * row.material.numbers[1]), f90, ..row }
    };
    rows(random, count, towards_light).into_iter().enumerate().map(layered).collect()
}

/// A roughness below the limit makes a mirror over the matt body: the bytes of a smooth conductor where nothing else reflects, and else a lobe
/// of one direction, drawn as often as its share, that is no part of the response.
#[test]
fn a_smooth_pbr_is_a_mirror_over_its_matt_body() {
    let mut random = Random(209);
    let smooth = |(i, row): (usize, In)| In {
        material: data::Material {
            numbers: [[0.0, 0.0009][i % 2], row.material.numbers[1], row.material.numbers[2]],
            ..row.material
        },
        ..row
    };
    let rows: Vec<In> = rows(&mut random, 20_000, false).into_iter().enumerate().map(smooth).collect();
    let found = kernel("pbr", &[]).run::<_, Out>(&rows);
    let as_conductors: Vec<In> = rows.iter().map(|row| conductor(*row, 0.0, None)).collect();
    let mirrors = kernel("conductor", &[]).run::<_, Out>(&as_conductors);
    let (mut metals, mut layers, mut matt, mut planted) = (0, 0, 0, 0);
    for ((row, out), mirror) in rows.iter().zip(&found).zip(&mirrors) {
        if row.material.numbers[2] == 1.0 {
            let bytes = |out: &Out| (out.event, out.direction, out.non_specular, out.lobe);
            assert_eq!(bytes(out), bytes(mirror), "{row:?}");
            // The weight is divided by a share of 1, which WGSL lets change it by 2.5 ULP.
            let same = |c: usize| (out.weight[c] - mirror.weight[c]).abs() <= 5.0 * U as f32 * mirror.weight[c];
            assert!((0..3).all(same), "{row:?} {out:?} {mirror:?}");
            metals += 1;
            continue;
        }
        let (view, normal) = view_and_normal(row);
        let cos_view = view.dot(normal);
        let share = share_of_facets(row, cos_view);
        let metallic = f64::from(row.material.numbers[2]);
        let near = |found: f32, expected: f64| (f64::from(found) - expected).abs() <= 1e-5 * expected.max(0.1);
        let u = f64::from(row.u[0]);
        if out.event == ABSORBED || (u - share).abs() < 1e-5 {
            continue;
        }
        assert_eq!((out.lobe == SPECULAR, out.non_specular), (u < share, 1), "{row:?} {out:?}");
        if u < share {
            let reflected = |c: usize| {
                let base = f64::from(row.colour[c]);
                (1.0 - metallic) * layer(row, cos_view)[c] + metallic * schlick(cos_view, base)
            };
            assert_eq!(out.direction, mirror.direction);
            assert!((0..3).all(|c| near(out.weight[c], reflected(c) / share)), "{row:?} {out:?}");
            planted += usize::from((0..3).any(|c| !near(out.weight[c], 1.01 * reflected(c) / share)));
            layers += 1;
        } else {
            // The formula without its microfacets.
            let direction = exact(out.direction).normalize();
            let cos_facet = view.dot((view + direction).normalize());
            let passed = 1.0 - layer(row, cos_facet).into_iter().fold(0.0, f64::max);
            let cosine = direction.dot(normal).max(0.0) / PI;
            let value = |c: usize| (1.0 - metallic) * passed * f64::from(row.colour[c]) * cosine;
            assert!(near(out.pdf, (1.0 - share) * cosine), "{row:?} {out:?}");
            assert!((0..3).all(|c| near(out.value[c], value(c))), "{row:?} {out:?}");
            matt += 1;
        }
    }
    assert!(metals > 5000 && layers > 2000 && matt > 2000 && planted > 2000, "{metals} {layers} {matt} {planted}");
}
