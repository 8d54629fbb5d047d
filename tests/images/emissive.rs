//! Surfaces that emit and scatter: textures of their own. (A closed form is in scenes/test/glow_in_sphere.ron.)

use crate::common::render::{Request, render, scene_in};

/// Shapes of one material, all turned.
fn shapes(material: &str) -> String {
    format!(
        "Scene(image: (width: 48, height: 32), camera: (look_from: (0, 1, 6), look_at: (0, 0, 0), vertical_fov: 50),
        background: Solid((0, 0, 0)), materials: {{\"one\": {material}}},
        objects: [Transformed(by: [RotateY(30), RotateX(20)], object: Group([
            Sphere(center: (-2, 0, 0), radius: 0.9, material: \"one\"),
            Quad(corner: (-0.9, -0.9, 0), u: (1.8, 0, 0), v: (0, 1.8, 0), material: \"one\"),
            Box(min: (1.2, -0.7, -0.7), max: (2.6, 0.7, 0.7), material: \"one\"),
            Mesh(path: \"quad.obj\", material: \"one\"),
        ]))], render: (samples: 4, max_depth: 0))"
    )
}

/// Each texture of a material has its own frame.
#[test]
fn an_emission_has_its_own_texture() {
    let folder = tempfile::tempdir().expect("a folder");
    let face = "v -1 1 0\nv 1 1 0\nv 1 2 0.5\nvt 0 0\nvt 3 0\nvt 3 2\nf 1/1 2/2 3/3\n";
    std::fs::write(folder.path().join("quad.obj"), face).expect("it is written");
    let image = image::RgbImage::from_fn(5, 3, |x, y| image::Rgb([50 * x as u8, 80 * y as u8, 9]));
    image.save(folder.path().join("stripes.png")).expect("it is written");
    let of = |material: &str| render(&scene_in(folder.path(), &shapes(material)), &Request::default()).bits();
    let emissions = [
        "Rgb(3, 2, 1)",
        "Checker(scale: 0.3, even: (1, 2, 3), odd: (0.1, 0, 0))",
        "Image(path: \"stripes.png\", tint: (4, 5, 6))",
        "Marble(scale: 3)",
    ];
    let bases = ["Rgb(0.5, 0.4, 0.3)", "Checker(scale: 0.11, even: (0, 0, 0), odd: (1, 1, 1))", "Noise(scale: 7)"];
    for emission in emissions {
        let alone = of(&format!("DiffuseLight(emit: {emission})"));
        for base in bases {
            assert!(alone == of(&format!("Lambertian(albedo: {base}, emission: {emission})")), "{base} {emission}");
            assert!(alone == of(&format!("Pbr(base_color: {base}, emission: {emission})")), "{base} {emission}");
        }
    }
    assert!(
        of(&format!("DiffuseLight(emit: {})", emissions[1])) != of(&format!("DiffuseLight(emit: {})", emissions[2]))
    );
}
