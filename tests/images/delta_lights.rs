//! Lights without size: renders against closed forms, against a small sphere instead of them, and at the ends of their ranges.

use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::flatten::flatten;
use gpu_rt::options::{Integrator, RenderOptions, Scatter};

use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, same_expectation, scene};
use crate::common::rooms::{AROUND, open_room};
use crate::common::scenes::triple;
use crate::common::vectors::U;

const ALPHA: f64 = 1e-6;
/// Standard errors that a mean is off by once in 1e6.
const NOISE: f64 = 4.9;

/// A floor of albedo 1/2, of which a camera sees a spot around the origin; and lights.
fn floor(lights: &str) -> String {
    floor_of(1.0, lights)
}

/// The floor with all lengths but the lights' times a factor.
fn floor_of(scale: f64, lights: &str) -> String {
    let point = |p: [f64; 3]| triple(scale * DVec3::from(p));
    format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: {}, look_at: (0, 0, 0), vertical_fov: 0.001),
        background: Solid((0, 0, 0)), materials: {{\"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
        objects: [Quad(corner: {}, u: {}, v: {}, material: \"floor\"), {lights}], render: (samples: 16, max_depth: 4))",
        point([-1.0, 1.0, 0.7]),
        point([-3.0, 0.0, 3.0]),
        point([6.0, 0.0, 0.0]),
        point([0.0, 0.0, -6.0])
    )
}

/// Also where the film does not know the variance, because the light is too bright beside the unit of radiance.
fn mean(shot: &Shot) -> f64 {
    shot.picture.rgb.iter().map(|rgb| f64::from(rgb[1])).sum::<f64>() / shot.picture.rgb.len() as f64
}

/// One light over a floor: the scene's text of it, the radiance of the floor in the middle, and how far it may be off.
fn lights() -> Vec<(String, f64, f64)> {
    let mut found = Vec::new();
    // What the picture's width adds: a pixel is 1e-6 across.
    let off = 64.0 * U + 2e-5;
    for position in [[0.0, 1.0, 0.0], [0.5, 0.3, -0.2], [-0.9, 0.05, 0.4], [3.0, 40.0, 5.0], [0.0, 0.02, 0.0]] {
        let position = DVec3::from(position);
        let irradiance = 7.0 * position.y / position.length().powi(3);
        let at = triple(position);
        let width = 4e-6 / position.length();
        found.push((format!("PointLight(at: {at}, intensity: (1, 7, 2))"), irradiance, off + 6.0 * width));
        // The origin lies at these angles from the beam's middle.
        for angle in [0.0, 10.0, 20.1, 25.0, 29.0, 30.1, 80.0] {
            let to_origin = -position.normalize();
            let (x, _) = to_origin.any_orthonormal_pair();
            let towards = position + f64::to_radians(angle).cos() * to_origin + f64::to_radians(angle).sin() * x;
            let [cos, inner, outer] = [angle, 20.0, 30.0].map(|degrees: f64| degrees.to_radians().cos());
            let share = ((cos - outer) / (inner - outer)).clamp(0.0, 1.0);
            let linear = ((30.0 - angle) / 10.0f64).clamp(0.0, 1.0);
            for (falloff, fallen) in [
                ("", share * share),
                (", falloff: Linear", linear),
                (", falloff: Smooth", share * share * (3.0 - 2.0 * share)),
            ] {
                let light = format!(
                    "SpotLight(at: {at}, towards: {}, intensity: (1, 7, 2), inner: 20, outer: 30{falloff})",
                    triple(towards)
                );
                let more = if share > 0.0 { 60.0 * width / share } else { 0.0 };
                found.push((light, irradiance * fallen, off + more));
            }
        }
    }
    for direction in [[0.0, -1.0, 0.0], [3.0, -1.0, 2.0], [0.1, -1e3, 0.0], [1.0, 1.0, 0.0]] {
        let direction = DVec3::from(direction);
        let cosine = (-direction.normalize().y).max(0.0);
        let light = format!("DirectionalLight(direction: {}, irradiance: (1, 7, 2))", triple(direction));
        found.push((light, 7.0 * cosine, off));
    }
    found
}

/// Whether the render of a scene is the expected radiance, without noise.
fn is_expected(shot: &Shot, expected: f64, off: f64) -> bool {
    (mean(shot) - expected).abs() <= off * expected.max(1e-30)
}

#[test]
fn a_floor_is_lit_as_the_definitions_say() {
    let linear = Overlay::new(&[
        ("light/delta", "inverseSqrt(distance2), distance2)", "inverseSqrt(distance2), sqrt(distance2))"),
        ("light/falloff", "(share * share)", "share"),
        ("light/falloff", "3.0 - 2.0 * share", "1.0"),
    ]);
    let mut planted = 0;
    for (light, irradiance, off) in lights() {
        let expected = 0.5 / PI * irradiance;
        let scene = scene(&floor(&light));
        let request = Request::spp(16).mis();
        let shot = render(&scene, &request);
        assert!(is_expected(&shot, expected, off), "{light}: {}, expected {expected} to {off:e}", mean(&shot));
        planted += usize::from(!is_expected(&render_planted(&scene, &request, &linear), expected, off));
        for scatter in [Scatter::Linked, Scatter::Queues] {
            let other = render(&scene, &request.clone().scatter(scatter));
            assert_eq!(mean(&other), mean(&shot), "{light}: {scatter:?}");
        }
    }
    assert!(planted > 20, "without the squares, {planted} images are wrong");
}

/// What stands in the way: the shadow of a ball, a ball behind the light, and a medium that absorbs, along its full length or a part.
#[test]
fn shadow_rays_end_at_the_light_and_are_weakened_by_media() {
    let ball = |at: &str| format!("Sphere(center: {at}, radius: 0.1, material: \"floor\")");
    let fog = |at: &str, radius: f64| {
        format!("Medium(boundary: Sphere(center: {at}, radius: {radius:?}), density: 3, albedo: Rgb(0, 0, 0))")
    };
    let point = "PointLight(at: (0, 1, 0), intensity: (7, 7, 7))";
    let sun = "DirectionalLight(direction: (0, -1, 0), irradiance: (7, 7, 7))";
    let expected = 0.5 / PI * 7.0;
    let cases = [
        (point, ball("(0, 0.5, 0)"), 0.0),
        (point, ball("(0, 1.5, 0)"), 1.0),
        (sun, ball("(0, 1.5, 0)"), 0.0),
        (sun, ball("(0.3, 1.5, 0)"), 1.0),
        (sun, ball("(0, -1.5, 0)"), 1.0),
        // Half of the way, around the light; all of it; and beyond the light.
        (point, fog("(0, 1, 0)", 0.5), (-1.5f64).exp()),
        (point, fog("(0, 0.5, 0)", 0.25), (-1.5f64).exp()),
        (point, fog("(0, 2, 0)", 0.5), 1.0),
        (sun, fog("(0, 2, 0)", 0.5), (-3.0f64).exp()),
    ];
    for (light, other, share) in cases {
        let shot = render(&scene(&floor(&format!("{light}, {other}"))), &Request::spp(16).depth(1).mis());
        assert!(
            is_expected(&shot, expected * share, 1e-4),
            "{light}, {other}: {}, expected {}",
            mean(&shot),
            expected * share
        );
    }
}

/// Light scattered once by a medium, by its phase function: an integral along the ray, in f64.
#[test]
fn media_scatter_the_light_of_lights_without_size() {
    const G: f64 = 0.4;
    const DENSITY: f64 = 0.8;
    let of = |light: &str| {
        scene(&format!(
            "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 0.01),
            background: Solid((0, 0, 0)), materials: {{}},
            objects: [Medium(boundary: Box(min: (-1, -1, -1), max: (1, 1, 1)), density: {DENSITY:?}, albedo: Rgb(0.9, 0.9, 0.9),
                anisotropy: {G:?}), {light}], render: (samples: 256, max_depth: 1))"
        ))
    };
    let phase = |cosine: f64| (1.0 - G * G) / (4.0 * PI * (1.0 + G * G - 2.0 * G * cosine).powf(1.5));
    // From a point on the axis, light from above passes through the box up to y = 1.
    let along = |irradiance: &dyn Fn(f64) -> (f64, f64, f64)| {
        let steps = 4000;
        let width = 2.0 / f64::from(steps);
        let at = |i: i32| {
            let depth = (f64::from(i) + 0.5) * width;
            let (irradiance, cosine, within) = irradiance(1.0 - depth);
            0.9 * DENSITY * (-DENSITY * (depth + within)).exp() * phase(cosine) * irradiance * width
        };
        (0..steps).map(at).sum::<f64>()
    };
    // The cosine is that of the angle between the camera's ray, along -z, and the way to the light.
    let point = |z: f64| {
        let way = DVec3::new(0.0, 3.0, -z);
        (5.0 / way.length_squared(), way.z.mul_add(-1.0, 0.0) / way.length(), way.length() / 3.0)
    };
    let sun = |_: f64| (5.0, 0.0, 1.0);
    for (light, expected) in [
        ("PointLight(at: (0, 3, 0), intensity: (5, 5, 5))", along(&point)),
        ("DirectionalLight(direction: (0, -1, 0), irradiance: (5, 5, 5))", along(&sun)),
    ] {
        let shot = render(&of(light), &Request::default().mis());
        let all = shot.mean_of_all();
        let noise = NOISE * all.variance[0].sqrt();
        assert!(noise < 0.02 * expected, "{light}: the test finds nothing: {noise} of {expected}");
        assert!((all.value[0] - expected).abs() < noise, "{light}: {} +- {noise}, expected {expected}", all.value[0]);
    }
}

/// A room with matt and metal things, glass and fog in it.
fn room(bulb: &str) -> String {
    let materials = "\"steel\": Metal(albedo: Rgb(0.8, 0.8, 0.8), fuzz: 0.6),
        \"bulb\": DiffuseLight(emit: Rgb(6e7, 4e7, 2e7)), \"tile\": DiffuseLight(emit: Rgb(1, 2, 3))";
    let objects = "Quad(corner: (0.2, 1.99, -0.5), u: (0.5, 0, 0), v: (0, 0, 0.5), material: \"tile\"),
        Sphere(center: (-0.4, 0.4, -0.2), radius: 0.4, material: \"steel\"),
        Medium(boundary: Box(min: (-1, 0, -1), max: (1, 0.7, 1)), density: 0.5, albedo: Rgb(0.8, 0.8, 0.8), anisotropy: 0.2),";
    open_room(&["wall"; 3], 0.0, materials, &format!("{objects} {bulb}"), 5)
        .replace(AROUND, "background: Solid((0, 0, 0))")
        .replace("samples: 512", "samples: 256")
}

/// A sphere of a ten-thousandth has the intensity of its radiance times its cross section.
#[test]
fn a_point_light_is_a_small_sphere() {
    let cross_section = PI * 1e-8;
    let colour = |more: f64| triple(more * cross_section * DVec3::new(6e7, 4e7, 2e7));
    let point = |more: f64| scene(&room(&format!("PointLight(at: (0.3, 1.4, 0.3), intensity: {})", colour(more))));
    let sphere = scene(&room("Sphere(center: (0.3, 1.4, 0.3), radius: 1e-4, material: \"bulb\")"));
    let request = |seed: u32| Request::spp(1024).seed(seed).mis();
    let sphere = render(&sphere, &request(1));
    let own = render(&point(1.0), &request(2));
    same_expectation(&sphere, &own, 1e-5, ALPHA).unwrap_or_else(|error| panic!("{error}"));
    let brighter = render(&point(1.03), &request(2));
    assert!(same_expectation(&sphere, &brighter, 1e-5, ALPHA).is_err(), "3 % more is not found");
}

/// The light by a mirror that chance finds is counted for the sphere alone, and `--clamp` limits both alike.
#[test]
fn a_light_without_size_is_clamped_as_others() {
    let cross_section = PI * 1e-8;
    let colour = triple(cross_section * DVec3::new(6e7, 4e7, 2e7));
    let point = scene(&room(&format!("PointLight(at: (0.3, 1.4, 0.3), intensity: {colour})")));
    let sphere = scene(&room("Sphere(center: (0.3, 1.4, 0.3), radius: 1e-4, material: \"bulb\")"));
    let request = |seed: u32| Request::default().seed(seed).mis().with(|options| options.clamp = Some(0.01));
    let (sphere, clamped) = (render(&sphere, &request(1)), render(&point, &request(2)));
    same_expectation(&sphere, &clamped, 1e-5, ALPHA).unwrap_or_else(|error| panic!("{error}"));
    let usual = render(&point, &Request::default().seed(2).mis());
    assert!(same_expectation(&sphere, &usual, 1e-5, ALPHA).is_err(), "the clamp does nothing");
}

/// Far and near, bright and faint, in large and small scenes; on the floor, behind it, and at the point that is seen.
#[test]
fn lights_at_the_ends_of_their_ranges_light_as_defined() {
    let mut cases = Vec::new();
    for (distance, scale) in [(1e6, 1.0), (1e12, 1.0), (1e30, 1.0), (1e-6, 1.0), (1e-3, 1.0), (1e6, 1e6), (1e-6, 1e-6)]
    {
        for irradiance in [1.0, 1e-6, 1e6] {
            let intensity: f64 = irradiance * distance * distance;
            if !(1e-30..1e30).contains(&intensity) {
                continue;
            }
            let light = format!("PointLight(at: (0, {distance:e}, 0), intensity: {})", triple(DVec3::splat(intensity)));
            // A pixel of the small patch is 1.4e-6 scales across, so near lights light a part of it.
            let off = if distance < 1e-2 * scale { f64::INFINITY } else { 2e-4 };
            cases.push((floor_of(scale, &light), irradiance, off));
        }
    }
    for bright in [1e30, 1e-30] {
        let colour = triple(DVec3::splat(bright));
        cases.push((floor(&format!("PointLight(at: (0, 1, 0), intensity: {colour})")), bright, 2e-4));
        let sun = format!("DirectionalLight(direction: (0, -1, 0), irradiance: {colour})");
        cases.push((floor(&sun), bright, 2e-4));
    }
    // On the floor its own light grazes the floor; behind it there is none.
    cases.push((floor("PointLight(at: (0, 0, 0), intensity: (1, 1, 1))"), 0.0, f64::INFINITY));
    cases.push((floor("PointLight(at: (0.2, 0, 0.1), intensity: (1, 1, 1))"), 0.0, 1e-3));
    cases.push((floor("PointLight(at: (0, -1, 0), intensity: (1, 1, 1))"), 0.0, 0.0));
    cases.push((floor("PointLight(at: (0, -1e-4, 0), intensity: (1, 1, 1))"), 0.0, 0.0));
    // A lamp above a ceiling lights nothing below it.
    cases.push((under_a_ceiling(1.301), 0.0, 0.0));
    for (text, irradiance, off) in cases {
        // Every sample is finite, or this fails.
        let shot = render(&scene(&text), &Request::spp(16).mis());
        let expected = 0.5 / PI * irradiance;
        let error = (mean(&shot) - expected).abs();
        let scale = if irradiance > 0.0 { expected } else { 1.0 };
        assert!(mean(&shot).is_finite() && error <= off * scale, "{}, expected {expected}: {text}", mean(&shot));
    }
}

/// The floor under a ceiling at a height of 1.3, and a point light at another height.
fn under_a_ceiling(height: f64) -> String {
    let ceiling = "Quad(corner: (-3, 1.3, -3), u: (6, 0, 0.3), v: (0.2, 0, 6), material: \"floor\")";
    let light = format!("PointLight(at: (0.37, {height:?}, 0.11), intensity: (1, 1, 1))");
    floor(&format!("{light}, {ceiling}")).replace("max_depth: 4", "max_depth: 1")
}

/// A light on a ceiling lights what is below it, because shadow rays end a little before the light.
#[test]
fn a_light_on_a_ceiling_is_not_behind_it() {
    let scene = scene(&under_a_ceiling(1.3));
    let expected = 0.5 / PI * 1.3 / (0.37f64.powi(2) + 1.3f64.powi(2) + 0.11f64.powi(2)).powf(1.5);
    let shot = render(&scene, &Request::spp(16).mis());
    assert!(is_expected(&shot, expected, 2e-4), "{}, expected {expected}", mean(&shot));
    let full = Overlay::new(&[]).rewritten("light/delta_distance", |own| {
        own.replace("max(distance - rounding, 0.5 * distance)", "distance + rounding")
    });
    let planted = render_planted(&scene, &Request::spp(16).mis(), &full);
    assert!(!is_expected(&planted, expected, 2e-4), "rays up to the light are not found");
}

/// What flattening says of a scene of these objects and materials.
fn said(materials: &str, objects: &str, integrator: Integrator) -> Result<Vec<String>, String> {
    let scene = scene(&format!(
        "Scene(image: (width: 64, height: 64), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
background: Solid((0, 0, 0)), materials: {{\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), {materials}}},
objects: [
{objects}
])"
    ));
    let options = RenderOptions { integrator, ..RenderOptions::default() };
    flatten(&scene, (64, 64), &options).map(|flat| flat.warnings).map_err(|error| error.to_string())
}

const POINT: &str = "PointLight(at: (0, 0, 0), intensity: (1, 1, 1)),";
const SUN: &str = "DirectionalLight(direction: (0, -1, 0), irradiance: (1, 1, 1)),";
const BALL: &str = "Sphere(center: (2, 0, 0), radius: 0.5, material: \"grey\"),";

#[test]
fn bsdf_sampling_refuses_lights_that_chance_cannot_find() {
    for (light, name) in [(POINT, "PointLight"), (SUN, "DirectionalLight")] {
        let inside = format!("{BALL}\nGroup([Transformed(by: [Scale(2)], object: {light})]),");
        let error = said("", &inside, Integrator::Bsdf).expect_err("it is refused");
        let words = format!("a {name} has no size, so that no path can hit it: --integrator bsdf");
        assert!(error.contains("test.ron:5:44") && error.contains(&words), "{error}");
        assert!(error.contains("objects[1].Group[0].Transformed.object"), "{error}");
        assert_eq!(said("", &inside, Integrator::Mis), Ok(Vec::new()));
    }
}

/// A warning is given where light cannot arrive, and none where it can.
#[test]
fn warnings_know_lights_without_size() {
    let one = |materials: &str, objects: &str, words: &[&str]| {
        let found = said(materials, objects, Integrator::Mis).expect("it is valid");
        let [warning] = &found[..] else { panic!("expected one warning: {found:#?}\n{objects}") };
        words.iter().for_each(|words| assert!(warning.contains(words), "{warning}"));
    };
    let none = |materials: &str, objects: &str| {
        assert_eq!(said(materials, objects, Integrator::Mis), Ok(Vec::new()), "{objects}");
    };
    // Black without a light.
    one("", BALL, &["nothing in this scene emits light"]);
    none("", &format!("{BALL}{POINT}"));
    one("", &format!("{BALL}PointLight(at: (0, 0, 0), intensity: (0, 0, 0)),"), &["nothing in this scene emits light"]);
    // In a closed ball, and the camera outside; and the camera inside with the light.
    let wall = |center: &str, radius: f64| format!("Sphere(center: {center}, radius: {radius:?}, material: \"grey\"),");
    one(
        "",
        &format!("{POINT}\n{}", wall("(0, 0, 0)", 1.0)),
        &["test.ron:4:1", "no path reaches this light", "test.ron:5:1"],
    );
    one(
        "",
        &format!("{POINT}\n{}", wall("(0, 0, 5)", 1.0)),
        &["test.ron:4:1", "no path reaches this light", "the camera"],
    );
    none("", &format!("{POINT}\n{}", wall("(0, 0, 0)", 10.0)));
    one(
        "",
        &format!("{SUN}\n{}", wall("(0, 0, 0)", 10.0)),
        &["test.ron:5:1", "the camera is inside this opaque sphere"],
    );
    none("", &format!("{SUN}\n{POINT}\n{}", wall("(0, 0, 0)", 10.0)));
    // What mirrors and glass stop.
    let glass = "\"glass\": Dielectric(ior: 1.5)";
    let clear = "Sphere(center: (-2, 0, 0), radius: 0.5, material: \"glass\"),";
    one(
        glass,
        &format!("{BALL}{clear}\n{SUN}{POINT}"),
        &["test.ron:5:1", "by a mirror or through glass", "\"glass\" at", "(and 1 more"],
    );
    none(glass, &format!("{clear}{POINT}"));
}
