//! Coloured glass: what surfaces let pass, what the inside absorbs, and thin panes. (What a pane reflects is in scenes/test/pane_at_60_degrees.ron.)

use crate::common::render::{Request, render, scene};

/// Light of 1 through what stands before the camera: a view so narrow that all rays go straight ahead.
fn through(materials: &str, objects: &str) -> [f64; 3] {
    through_at(5.0, materials, objects)
}

fn through_at(distance: f64, materials: &str, objects: &str) -> [f64; 3] {
    let text = format!(
        "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, {distance}), look_at: (0, 0, 0), vertical_fov: 0.001),
        background: Solid((1, 1, 1)), materials: {{{materials}}}, objects: [{objects}], render: (samples: 4, max_depth: 9))"
    );
    render(&scene(&text), &Request::default()).pixel(0, 0)
}

fn near(found: [f64; 3], expected: [f64; 3]) {
    let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f64::max);
    // Rounding of a few products and one exp, whose argument is up to 3 (WGSL: 3 + 2 |x| ulps).
    assert!(off < 16.0 * f64::from(f32::EPSILON), "{found:?}, expected {expected:?}");
}

/// With an index of 1, nothing is reflected or bent.
#[test]
fn the_inside_absorbs_by_the_distance_and_each_surface_by_its_share() {
    let absorption = [0.25, 1.0, 0.0];
    let left = |distance: f64| absorption.map(|a| (-a * distance).exp());
    for glass in ["Dielectric(ior: 1", "RoughDielectric(ior: 1, roughness: 0.5"] {
        let material = format!("\"glass\": {glass}, absorption: (0.25, 1, 0))");
        let cube = "Box(min: (-1, -1, -1), max: (1, 1, 0.5), material: \"glass\")";
        near(through(&material, cube), left(1.5));
        near(through(&material, &format!("Transformed(by: [Scale(2)], object: {cube})")), left(3.0));
        near(through(&material, "Sphere(center: (0, 0, 0), radius: 0.5, material: \"glass\")"), left(1.0));
        let tinted = format!("\"glass\": {glass}, transmittance: Rgb(0.5, 0.8, 1), absorption: (0.25, 1, 0))");
        near(through(&tinted, cube), [0, 1, 2].map(|c| left(1.5)[c] * [0.25, 0.64, 1.0][c]));
    }
    let pane = "Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"pane\")";
    near(through("\"pane\": ThinDielectric(ior: 1, transmittance: Rgb(0.5, 0.8, 1))", pane), [0.5, 0.8, 1.0]);
    near(through("\"pane\": ThinDielectric(ior: 1)", pane), [1.0; 3]);
    let both = format!("{pane}, Quad(corner: (-1, -1, 1), u: (2, 0, 0), v: (0, 2, 0), material: \"pane\")");
    near(through("\"pane\": ThinDielectric(ior: 1, transmittance: Rgb(0.5, 0.8, 1))", &both), [0.25, 0.64, 1.0]);
}

/// The unit of length of the scene is that of the absorption, however large the scene is.
#[test]
fn absorption_is_per_scene_unit() {
    for unit in [1e-6, 1e6] {
        let material = format!("\"glass\": Dielectric(ior: 1, absorption: ({}, 0, 0))", 0.5 / unit);
        let ball = format!("Sphere(center: (0, 0, 0), radius: {unit}, material: \"glass\")");
        near(through_at(5.0 * unit, &material, &ball), [(-1.0_f64).exp(), 1.0, 1.0]);
    }
}
