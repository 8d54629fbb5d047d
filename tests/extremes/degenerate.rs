//! Scenes that have no picture: refused, with the location in the file.

use std::path::Path;

use gpu_rt::error::Error;
use gpu_rt::scene::Scene;

use crate::table::Cell;

/// What is degenerate, its text with `HERE` for the number, a number that is, and one that is not.
const CASES: &[(&str, &str, &str, &str)] = &[
    ("sphere of radius 0", "Sphere(center: (0, 0, 0), radius: HERE, material: \"m\")", "0", "1e-30"),
    ("sphere of radius NaN", "Sphere(center: (0, 0, 0), radius: HERE, material: \"m\")", "NaN", "1"),
    ("sphere of infinite radius", "Sphere(center: (0, 0, 0), radius: HERE, material: \"m\")", "inf", "1e30"),
    ("sphere whose centre is NaN", "Sphere(center: (0, HERE, 0), radius: 1, material: \"m\")", "NaN", "1"),
    ("quad with an edge of 0", "Quad(corner: (0, 0, 0), u: (HERE, 0, 0), v: (0, 1, 0), material: \"m\")", "0", "1e-30"),
    (
        "quad whose edges are parallel",
        "Quad(corner: (0, 0, 0), u: (1, HERE, 0), v: (2, 0, 0), material: \"m\")",
        "0",
        "1e-5",
    ),
    ("disk of radius 0", "Disk(center: (0, 0, 0), normal: (0, 1, 0), radius: HERE, material: \"m\")", "0", "1e-30"),
    (
        "disk without a normal",
        "Disk(center: (0, 0, 0), normal: (0, HERE, 0), radius: 1, material: \"m\")",
        "0",
        "1e-30",
    ),
    ("box without a height", "Box(min: (0, 0, 0), max: (1, HERE, 1), material: \"m\")", "0", "1e-30"),
    ("box inside out", "Box(min: (0, 0, 0), max: (1, HERE, 1), material: \"m\")", "-1", "1"),
    (
        "object scaled to nothing",
        "Transformed(by: [Scale(HERE)], object: Sphere(center: (0, 0, 0), radius: 1, material: \"m\"))",
        "0",
        "1e-30",
    ),
    (
        "medium of density NaN",
        "Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: HERE, albedo: Rgb(1, 1, 1))",
        "NaN",
        "1",
    ),
];

/// 0 where the scene is refused at this number, else 1.
fn taken(object: &str, number: &str) -> f64 {
    let text = format!(
        "Scene(image: (width: 8, height: 8), background: Solid((1, 1, 1)),
         camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
         materials: {{ \"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }}, objects: [{}])",
        object.replace("HERE", number)
    );
    match Scene::parse(&text, Path::new("test.ron")) {
        Err(Error::Scene { location, field, .. }) => {
            f64::from(u8::from(location.line != 3 || !field.starts_with("objects[0]")))
        }
        _ => 1.0,
    }
}

/// The table's cells of degenerate scenes.
pub fn cells() -> Vec<Cell> {
    let cell = |(what, object, wrong, right): &(&'static str, &str, &str, &str)| {
        Cell::new(
            *what,
            "Scenes that are accepted, or refused without the object's line and field",
            0.0,
            "none, because such a scene has no meaningful image.",
        )
        .achieved(taken(object, wrong))
        .planted("the same with a number that is allowed", taken(object, right))
    };
    CASES.iter().map(cell).collect()
}
