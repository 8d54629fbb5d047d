//! Metals that make up for light that microfacets scatter more than once: the light that they return, and both integrators.

use crate::common::kernel::Overlay;
use crate::common::microfacets::{Facets, directional_albedo, masking, schlick, shadowing};
use crate::common::render::{Request, in_a_furnace, render, render_planted, same_expectation, scene};

const ALPHA: f64 = 1e-6;
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

/// A room with metals, one of which loses light.
const ROOM: &str =
    "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 1, 3.6), look_at: (0, 0.95, 0), vertical_fov: 38),
    background: Solid((0.1, 0.1, 0.1)),
    materials: {
        \"wall\": Pbr(base_color: Rgb(0.7, 0.6, 0.5), metallic: 0.5, roughness: 0.7, multiscatter: true),
        \"metal\": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.8, multiscatter: true),
        \"lossy\": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.8),
        \"gold\": Conductor(eta: (0.14, 0.37, 1.44), k: (3.98, 2.38, 1.6), roughness: 0.5, multiscatter: true),
        \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false),
    },
    objects: [
        Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"metal\"),
        Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (-0.5, 1.99, -0.5), u: (1, 0, 0), v: (0, 0, 1), material: \"lamp\"),
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: \"lossy\"),
        Sphere(center: (-0.4, 0.45, 0), radius: 0.4, material: \"gold\"),
    ], render: (samples: 512, max_depth: 6))";

#[test]
fn light_sampling_changes_no_expectation_beside_metals_that_lose_nothing() {
    let room = scene(ROOM);
    let bsdf = render(&room, &Request::default().seed(1));
    let mis = Request::default().seed(2).mis();
    same_expectation(&bsdf, &render(&room, &mis), 1e-5, ALPHA).unwrap_or_else(|error| panic!("{error}"));
    let lossy = Overlay::new(&[])
        .rewritten("material/conductor_eval", |own| own.replace("compensated(single, f0, hit)", "single"));
    let lossy = render_planted(&room, &mis, &lossy);
    assert!(same_expectation(&bsdf, &lossy, 1e-5, ALPHA).is_err(), "light that is lost in one of the two is not found");
}
