//! Materials whose back is black: closed forms from both sides, however the light is found.

use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, scene};
use crate::common::scenes::triple;
use glam::DVec3;

/// Rounding of a product of a few f32.
const ROUNDING: f64 = 1e-5;

/// Materials that reflect or emit, and what they show of a white sky of radiance 1, if that has a closed form.
const MATERIALS: [(&str, Option<f64>); 6] = [
    ("Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: Rgb(0.25, 0.25, 0.25), one_sided: true)", Some(0.75)),
    ("Metal(albedo: Rgb(0.5, 0.5, 0.5), one_sided: true)", Some(0.5)),
    ("Metal(albedo: Rgb(0.5, 0.5, 0.5), fuzz: 0.4, one_sided: true)", None),
    ("Conductor(albedo: Rgb(0.5, 0.5, 0.5), roughness: 0.5, one_sided: true)", None),
    ("Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, roughness: 0.5, coat: 1, one_sided: true)", None),
    ("Pbr(emission: Rgb(1, 1, 1), sheen: Rgb(1, 1, 1), one_sided: true)", None),
];

/// A small film that sees one thing of the material alone, under a white sky.
fn seen(from: DVec3, thing: &str, material: &str) -> String {
    format!(
        "Scene(image: (width: 8, height: 8), camera: (look_from: {}, look_at: (0, 0, 0), vertical_fov: 10),
        background: Solid((1, 1, 1)), materials: {{\"one\": {material}}}, objects: [{thing}],
        render: (samples: 16, max_depth: 8))",
        triple(from)
    )
}

/// The largest value of a pixel.
fn largest(shot: &Shot) -> f64 {
    shot.picture.rgb.iter().flatten().fold(0.0, |most, value| most.max(f64::from(*value)))
}

/// A quad whose u × v is +z, and a ball around the camera: from the front they have their closed form, and from behind they are black. A kernel that
/// takes the front for the back, or has no backs, is found.
#[test]
fn backs_are_black() {
    let quad = "Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"one\")";
    let ball = "Sphere(center: (0, 0, 0), radius: 1, material: \"one\")";
    let cube = "Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"one\")";
    let front = DVec3::new(0.3, 0.2, 3.0);
    let inside = DVec3::new(0.1, 0.0, 0.5);
    let no_backs = Overlay::new(&[("scene/one_sided", "return !front &&", "return false &&")]);
    let emission = ("extension/emission", "!= 0.0 || front)", "!= 0.0 || !front)");
    let turned = Overlay::new(&[("scene/one_sided", "return !front &&", "return front &&"), emission]);
    for (material, expected) in MATERIALS {
        for request in [Request::spp(16), Request::spp(16).mis()] {
            for (behind, thing) in [(-front, quad), (inside, ball), (inside, cube)] {
                let back = scene(&seen(behind, thing, material));
                assert_eq!(largest(&render(&back, &request)), 0.0, "{material}, {thing}, from behind");
                // The same from the front, where each of its pixels has light.
                let lit = scene(&seen(front, thing, material));
                let shot = render(&lit, &request);
                let least = shot.picture.rgb.iter().map(|rgb| rgb[1]).fold(f32::MAX, f32::min);
                assert!(least > 0.1, "{material}, {thing}: {least}");
                if let Some(expected) = expected {
                    let off = (shot.mean_of_all().value[1] - expected).abs();
                    assert!(off < ROUNDING, "{material}, {thing}: off by {off}");
                }
            }
        }
        let back = scene(&seen(-front, quad, material));
        assert!(largest(&render_planted(&back, &Request::spp(16).mis(), &no_backs)) > 0.1, "{material}");
        let lit = scene(&seen(front, quad, material));
        assert_eq!(largest(&render_planted(&lit, &Request::spp(16).mis(), &turned)), 0.0, "{material}");
    }
}

/// Where the emission alone is that of the front, both sides reflect.
#[test]
fn an_emission_may_be_of_the_front_alone() {
    let quad = "Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"one\")";
    let matt = "Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: Rgb(0.25, 0.25, 0.25), one_sided_emission: true)";
    let front = DVec3::new(0.3, 0.2, 3.0);
    let planted = Overlay::new(&[("extension/emission", "!= 0.0 || front)", "!= 0.0 || !front)")]);
    for request in [Request::spp(16), Request::spp(16).mis()] {
        for (from, expected, turned) in [(front, 0.75, 0.5), (-front, 0.5, 0.75)] {
            let scene = scene(&seen(from, quad, matt));
            let found = render(&scene, &request).mean_of_all().value[1];
            assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
            let found = render_planted(&scene, &request, &planted).mean_of_all().value[1];
            assert!((found - turned).abs() < ROUNDING, "{found} {turned}");
        }
    }
}

/// The back blocks a lamp without size, and takes none of its light; the front has that of the definition.
#[test]
fn a_back_blocks_light() {
    let floor = |y: f64| {
        format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, {y}, 0.5), look_at: (0, 0, 0), vertical_fov: 0.001),
            background: Solid((0, 0, 0)), materials: {{\"one\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5), one_sided: true)}},
            objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"one\"), LIGHTS])"
        )
    };
    let radiance = |y: f64, lights: &str| {
        let text = floor(y).replace("LIGHTS", lights);
        largest(&render(&scene(&text), &Request::spp(4).mis()))
    };
    let [above, below] = [1, -1].map(|y| format!("PointLight(at: (0, {y}, 0), intensity: (2, 2, 2))"));
    // Albedo over pi times the intensity, at distance 1, straight on it.
    let expected = 0.5 / std::f64::consts::PI * 2.0;
    let found = radiance(1.0, &above);
    // A pixel is 1e-6 across.
    assert!((found - expected).abs() < 1e-4 * expected, "{found}, {expected}");
    assert_eq!(radiance(1.0, &below), 0.0);
    assert_eq!(radiance(-1.0, &below), 0.0);
    assert_eq!(radiance(-1.0, &above), 0.0);
}
