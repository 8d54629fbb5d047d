//! Layers of glTF's material with a share and a colour of their own (KHR_materials_specular).

use crate::common::render::{Request, render, same_expectation, scene};

const ALPHA: f64 = 1e-6;

/// A room of this material, with a lamp and a ball of a coloured layer.
fn room(material: &str) -> String {
    format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 1, 3.6), look_at: (0, 0.95, 0), vertical_fov: 38),
    background: Solid((0.1, 0.1, 0.1)),
    materials: {{
        \"wall\": {material},
        \"coat\": Pbr(base_color: Rgb(0.6, 0.2, 0.1), metallic: 0, roughness: 0.4, ior: 2, specular: 0.8, specular_color: Rgb(0.2, 1, 0.5)),
        \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false),
    }},
    objects: [
        Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"wall\"),
        Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (-0.5, 1.99, -0.5), u: (1, 0, 0), v: (0, 0, 1), material: \"lamp\"),
        Sphere(center: (0, 0.6, 0), radius: 0.5, material: \"coat\"),
    ], render: (samples: 512, max_depth: 6))"
    )
}

fn wall(specular: f64) -> String {
    room(&format!("Pbr(base_color: Rgb(0.2, 0.15, 0.1), metallic: 0, roughness: 0.5, ior: 2.5, specular: {specular})"))
}

/// A layer that reflects nothing leaves the matt body.
#[test]
fn without_its_layer_the_material_is_matt() {
    let matt = render(&scene(&room("Lambertian(albedo: Rgb(0.2, 0.15, 0.1))")), &Request::default().seed(1).mis());
    let render_with = |specular: f64| render(&scene(&wall(specular)), &Request::default().seed(2).mis());
    same_expectation(&matt, &render_with(0.0), 1e-5, ALPHA).unwrap_or_else(|error| panic!("{error}"));
    assert!(same_expectation(&matt, &render_with(0.2), 1e-5, ALPHA).is_err(), "a fifth of the layer is not found");
}

#[test]
fn light_sampling_changes_no_expectation_beside_layers() {
    let room = scene(&wall(0.7));
    let bsdf = render(&room, &Request::default().seed(1));
    same_expectation(&bsdf, &render(&room, &Request::default().seed(2).mis()), 1e-5, ALPHA)
        .unwrap_or_else(|error| panic!("{error}"));
    let sobol = render(&room, &Request::default().seed(3).mis().sobol());
    same_expectation(&bsdf, &sobol, 1e-5, ALPHA).unwrap_or_else(|error| panic!("{error}"));
    let more = render(&scene(&wall(0.9)), &Request::default().seed(2).mis());
    assert!(same_expectation(&bsdf, &more, 1e-5, ALPHA).is_err(), "a layer of 0.9 is not told from one of 0.7");
}
