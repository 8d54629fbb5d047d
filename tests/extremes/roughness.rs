//! material/conductor, material/rough_dielectric, material/thin_dielectric, material/pbr, lib/microfacet: lobes as narrow as f32 directions can represent, and as wide as there are; grazing views.

use glam::DVec3;
use gpu_rt::data;

use crate::common::kernel::{Fault, Overlay, Setup};
use crate::common::microfacets::{
    ABSORBED, BY_PAPERS, Facets, In, Out, SCATTERED, arriving, conductor, directional_albedo, frosted, kernel,
    kernel_with, pane, uniforms, visible,
};
use crate::common::render::{Request, render, render_planted, scene};
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact};
use crate::table::Cell;

const COSINE: &str = "density by 1 - cos²";
/// The ends of the range of indices of panes, and between.
const INDICES: [f64; 4] = [1.0, 1.0001, 1.5, 1e3];
const UNCORRELATED: &str = "shadowing without the view's";

fn rows(roughness: f64) -> Vec<In> {
    let mut random = Random(191);
    (0..5000)
        .map(|i| {
            let cos = decades(&mut random, -4.0, 0.0);
            let row = conductor(arriving(&mut random, cos), roughness, None);
            In { u: uniforms(&mut random, i), ..row }
        })
        .collect()
}

/// The largest relative error of the density of an answer, of those whose half vector is longer than 0.1.
fn density_error(roughness: f64, replaced: &[Fault<'_>]) -> f64 {
    let rows = rows(roughness);
    let alpha = f64::from(roughness as f32).powi(2);
    rows.iter().zip(kernel_with("conductor", &[], &Setup { replaced, ..Setup::default() }).run::<_, Out>(&rows)).fold(
        0.0,
        |worst, (row, out)| {
            let (view, normal) = (-exact(row.incoming).normalize(), exact(row.normal).normalize());
            let direction = exact(out.direction);
            let half_way: DVec3 = view + direction.normalize_or_zero();
            if out.event == ABSORBED || half_way.length() < 0.1 {
                return worst;
            }
            let facet = half_way.normalize();
            let pdf = visible(facet, view, normal, alpha) / (4.0 * view.dot(facet));
            let off = (f64::from(out.pdf) / pdf - 1.0).abs();
            if off.is_nan() { f64::MAX } else { worst.max(off) }
        },
    )
}

/// Answers at cosines down to 1e-20 that are not finite, on no side where the material answers, or have a weight above `most`.
fn wrong_at_grazing(material: &str, most: f32, row_of: impl Fn(usize, In) -> In) -> f64 {
    let mut random = Random(193);
    let rows: Vec<In> = (0..5000)
        .map(|i| {
            let cos = decades(&mut random, -20.0, -2.0);
            let row = row_of(i, arriving(&mut random, cos));
            In { u: uniforms(&mut random, i), front: i as u32 / 3 % 2, ..row }
        })
        .collect();
    let found = kernel(material, &[]).run::<_, Out>(&rows);
    let is_wrong = |(row, out): (&In, &Out)| {
        let direction = exact(out.direction);
        let is_good = out.event == ABSORBED
            || out.event == SCATTERED
                && (direction.length() - 1.0).abs() < 8.0 * U
                && (["rough_dielectric", "thin_dielectric"].contains(&material)
                    || direction.dot(exact(row.normal)) > -2.0 * U)
                && out.weight.iter().all(|w| (0.0..=most).contains(w))
                && (out.non_specular == 0
                    || out.pdf.is_finite() && out.value.iter().all(|v| v.is_finite() && *v >= 0.0));
        !is_good
    };
    rows.iter().zip(&found).filter(|pair| is_wrong(*pair)).count() as f64
}

/// The mean of a white material in a room that shines on all sides, seen at an angle, with light sampling.
fn in_a_furnace(material: &str, cos: f64, planted: bool) -> f64 {
    let scene = scene(&format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: ({}, 0, {cos}), look_at: (0, 0, 0), vertical_fov: 0.1),
    background: Solid((0, 0, 0)),
    materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)), \"white\": {material}}},
    objects: [
        Sphere(center: (0, 0, 0), radius: 9, material: \"lamp\"),
        Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"white\"),
    ],
)",
        -(1.0 - cos * cos).sqrt()
    ));
    let request = Request::spp(512).mis();
    let shot = match planted {
        true => render_planted(&scene, &request, &Overlay::new(&BY_PAPERS)),
        false => render(&scene, &request),
    };
    shot.mean_of_all().value[0]
}

/// The table's cells of roughness.
pub fn cells() -> Vec<Cell> {
    let mut all = Vec::new();
    for roughness in [0.0, 1e-4, 9.77e-4, 1e-2, 0.1, 0.5, 1.0] {
        let range = format!("roughness = {roughness:e}");
        let alpha = f64::from(roughness as f32).powi(2);
        let is_rough = roughness * 1024.0 >= 1.0;
        if is_rough {
            let cell = Cell::new(
                &range,
                "Largest relative error of the density of 5000 answers, with cosines from 1e-4 to 1",
                128.0 * U + 80.0 * U / alpha,
                "the half vector of two rounded directions, of a length of at least 0.1, is turned by up to 40 u, and its density changes by \
                 at most 2/alpha of that; 128 u for the formula.",
            )
            .achieved(density_error(roughness, &[]));
            let known = roughness < 0.02;
            all.push(if known { cell.planted(COSINE, density_error(roughness, &BY_PAPERS)) } else { cell });
        }
        let grazing = |what: &str, wrong: f64| {
            Cell::new(
                format!("{range}, {what}"),
                "Answers of 5000 that are not finite, on a wrong side or too bright, with cosines from 1e-20 to 1e-2",
                0.0,
                "none. A weight is at most 1, and at most 10 of glTF's material, whose lobes are drawn with a probability of at least 0.1.",
            )
            .achieved(wrong)
        };
        let metal = wrong_at_grazing("conductor", 1.0 + 1e-5, |_, row| conductor(row, roughness, None));
        let glass = wrong_at_grazing("rough_dielectric", 1.0 + 1e-5, |_, row| frosted(row, 1.5, roughness));
        let panes = wrong_at_grazing("thin_dielectric", 1.0 + 1e-5, |i, row| pane(row, INDICES[i % 4], roughness));
        let pbr = wrong_at_grazing("pbr", 10.0 + 1e-4, |_, row| In {
            material: data::Material { numbers: [roughness as f32, 0.04, 0.3], ..data::Material::default() },
            ..row
        });
        all.extend([
            grazing("a metal", metal),
            grazing("glass", glass),
            grazing("panes", panes),
            grazing("glTF's material", pbr),
        ]);
        for cos in [1.0, 0.1] {
            let metal = format!("Conductor(albedo: Rgb(1, 1, 1), roughness: {roughness:?})");
            let what = "Error of a white metal's radiance in a room that emits 1 everywhere, with light sampling";
            let (cell, error) = furnace(&format!("{range}, cosine {cos}"), what, &metal, roughness, cos);
            let known = roughness >= 0.5 && cos < 1.0;
            all.push(if known { cell.planted(UNCORRELATED, error(true)) } else { cell });
        }
        for ior in INDICES {
            let pane = format!("ThinDielectric(ior: {ior:?}, roughness: {roughness:?})");
            let what =
                "Error of a pane's radiance in a room that emits 1 everywhere, at a cosine of 0.1, with light sampling";
            let (cell, error) = furnace(&format!("{range}, ior = {ior:e}"), what, &pane, roughness, 0.1);
            all.push(if roughness >= 0.5 { cell.planted(UNCORRELATED, error(true)) } else { cell });
        }
    }
    all
}

/// The cell of a white material in a room that shines on all sides, and its error as it is or with the wrong form planted.
fn furnace(
    range: &str,
    what: &'static str,
    material: &str,
    roughness: f64,
    cos: f64,
) -> (Cell, impl Fn(bool) -> f64 + use<>) {
    let alpha = f64::from(roughness as f32).powi(2);
    let albedo = if roughness * 1024.0 >= 1.0 { directional_albedo(&Facets { alpha, cos_view: cos }) } else { 1.0 };
    let noise = 4.9 * (albedo * (1.0 - albedo)).max(0.0).sqrt() / (512.0f64 * 256.0).sqrt();
    let material = material.to_owned();
    let error = move |planted: bool| (in_a_furnace(&material, cos, planted) - albedo).abs();
    let cell = Cell::new(
        range,
        what,
        noise + 1e-3,
        "4.9 standard errors of 131 072 samples between 0 and 1 about what single scattering keeps in f64, and 1e-3 for the cosines over \
         the image.",
    );
    (cell.achieved(error(false)), error)
}
