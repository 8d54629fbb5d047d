//! Surfaces that emit and scatter: closed forms, and textures of their own.

use gpu_rt::options::Scatter;

use crate::common::render::{Request, render, scene, scene_in};

/// The inside of a ball that emits e and reflects a: from anywhere it shows e (1 + a + .. + a^n) after n events.
fn ball(max_depth: u32) -> String {
    format!(
        "Scene(image: (width: 8, height: 8), camera: (look_from: (0.1, 0.2, 0.3), look_at: (1, 0, 0), vertical_fov: 60),
        background: Solid((0, 0, 0)),
        materials: {{\"glow\": Lambertian(albedo: Rgb(0.5, 0.7, 0.2), emission: Rgb(2, 0.25, 0))}},
        objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"glow\")], render: (samples: 64, max_depth: {max_depth}))"
    )
}

#[test]
fn inside_a_ball_the_light_is_a_geometric_series() {
    for max_depth in [0, 1, 2, 5, 30] {
        let expected = [(2.0, 0.5), (0.25, 0.7), (0.0, 0.2)].map(|(emission, albedo): (f64, f64)| {
            emission * (1.0 - albedo.powi(max_depth as i32 + 1)) / (1.0 - albedo)
        });
        // By scattered rays alone there is no noise.
        let bsdf = render(&scene(&ball(max_depth)), &Request::default());
        for pixel in &bsdf.picture.rgb {
            let off = (0..3).map(|c| (f64::from(pixel[c]) - expected[c]).abs() / expected[0]).fold(0.0, f64::max);
            assert!(off < 1e-5, "{max_depth}: {pixel:?}, expected {expected:?}");
        }
        for scatter in [Scatter::Fused, Scatter::Linked] {
            let mis = render(&scene(&ball(max_depth)), &Request::spp(512).mis().scatter(scatter)).mean_of_all();
            for (channel, expected) in expected.into_iter().enumerate() {
                let (value, noise) = (mis.value[channel], 4.9 * mis.variance[channel].sqrt());
                assert!(noise < 0.02, "{max_depth}: {noise}");
                assert!(
                    (value - expected).abs() <= noise + 1e-5,
                    "{max_depth}: {value} +- {noise}, expected {expected}"
                );
            }
        }
    }
}

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
    let of = |material: &str| {
        let shot = render(&scene_in(folder.path(), &shapes(material)), &Request::default());
        shot.picture.rgb.as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
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
