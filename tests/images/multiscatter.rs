//! Metals that make up for light that microfacets scatter more than once: the light that they return.

use crate::common::microfacets::{Facets, directional_albedo, masking, schlick, shadowing};
use crate::common::render::in_a_furnace;

/// The most by which the table is off (tests/kernels/rough.rs).
const TABLE: f64 = 0.008;

/// What a metal of this albedo returns by Turquin's formula, or by single scattering.
fn returned(albedo: f64, facets: &Facets, multiscatter: bool) -> f64 {
    let (view, all) = (facets.view(), directional_albedo(facets));
    let mut sum = 0.0;
    facets.integrate(facets.alpha, |_, facet, share| {
        let cos_light = 2.0 * view.dot(facet) * facet.z - view.z;
        if cos_light > 0.0 {
            let shadowed = shadowing(view.z, cos_light, facets.alpha) / masking(view.z, facets.alpha);
            sum += share * schlick(view.dot(facet), albedo) * shadowed;
        }
    });
    if multiscatter { sum * (1.0 + albedo * (1.0 - all) / all) } else { sum }
}

#[test]
fn metals_return_the_light_that_single_scattering_loses() {
    for (roughness, cos) in [(0.1f64, 0.05), (0.3, 0.1), (0.5, 1.0), (0.5, 0.3), (1.0, 1.0), (1.0, 0.1)] {
        let facets = Facets { alpha: roughness.powi(2), cos_view: cos };
        let albedo = [1.0, 0.6, 0.2];
        let colour = "Rgb(1, 0.6, 0.2)";
        let cases: Vec<(bool, String)> = [true, false]
            .into_iter()
            .flat_map(|multiscatter| {
                let numbers = format!("roughness: {roughness}, multiscatter: {multiscatter}");
                let [conductor, pbr] =
                    ["Conductor(albedo", "Pbr(base_color"].map(|head| format!("{head}: {colour}, {numbers})"));
                [(multiscatter, conductor), (multiscatter, pbr)]
            })
            .collect();
        let materials: Vec<String> = cases.iter().map(|(_, material)| material.clone()).collect();
        for ((multiscatter, material), (found, errors)) in cases.iter().zip(in_a_furnace(&materials, cos, 256)) {
            for c in 0..3 {
                let expected = returned(albedo[c], &facets, *multiscatter);
                let off = (found[c] - expected).abs();
                let limit = 4.9 * errors[c] + TABLE * expected;
                assert!(limit < 0.04, "{material}: {limit}");
                assert!(off < limit, "{material}, cosine {cos}, channel {c}: {found:?}, {expected}");
                assert!(c > 0 || !multiscatter || (expected - 1.0).abs() < 1e-9);
            }
        }
    }
}
