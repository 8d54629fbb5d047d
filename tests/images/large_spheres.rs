//! Spheres of any radius, as grounds below the camera and as domes around it: against planes, closed forms, and the other form of a
//! sphere where the two meet (src/shape/large_sphere.rs).

use glam::DVec3;
use gpu_rt::flatten::flatten;
use gpu_rt::scene::{DiffuseLight, Material, Scene, Texture};

use crate::common::instances::ball_file;
use crate::common::render::{Request, Shot, diagnostics, plain, render, same_expectation, scene_in};
use crate::common::scenes::triple;

/// False alarms of each test here.
const ALPHA: f64 = 1e-6;

/// A scene that `check` says nothing about.
fn scene(camera: &str, sky: f64, objects: &str) -> Scene {
    let scene = unchecked(camera, sky, objects);
    assert_eq!(diagnostics(&scene), Vec::<String>::new());
    scene
}

/// The mesh "ball.obj" and the image "image.png" are beside it.
fn unchecked(camera: &str, sky: f64, objects: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ball.obj"), ball_file(3, DVec3::ONE)).expect("the mesh is written");
    let image = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * 4) as u8, (y * 4) as u8, 128]));
    image.save(folder.path().join("image.png")).expect("the image is written");
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: {camera}, background: Solid(({sky:?}, {sky:?}, {sky:?})), materials: {{
            \"clear\": Dielectric(ior: 1), \"glass\": Dielectric(ior: 1.5),
            \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1), two_sided: false), \"both\": DiffuseLight(emit: Rgb(1, 1, 1)),
            \"bright\": DiffuseLight(emit: Rgb(9, 8, 7)), \"steel\": Metal(albedo: Rgb(0.8, 0.8, 0.7), fuzz: 0.2),
            \"checker\": Lambertian(albedo: Checker(scale: 0.3, even: (0.8, 0.7, 0.2), odd: (0.1, 0.2, 0.6))),
            \"noise\": Lambertian(albedo: Noise(scale: 3)), \"marble\": Lambertian(albedo: Marble(scale: 5)),
            \"image\": Lambertian(albedo: Image(path: \"image.png\")),
            \"blue\": Lambertian(albedo: Rgb(0.2, 0.3, 0.7)), \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
            objects: [{objects}])"
    );
    scene_in(folder.path(), &text)
}

/// How many of a scene's spheres are large spheres.
fn large_spheres(scene: &Scene) -> usize {
    flatten(scene, (16, 16), &plain()).expect("the scene flattens").shapes.large_spheres.len()
}

/// A ground that reaches up to this height.
fn ground(radius: f64, top: f64, material: &str) -> String {
    format!(
        "Transformed(by: [Translate((0, {top:?}, 0))], object: Sphere(center: (0, -{radius:?}, 0), radius: {radius:?}, material: \"{material}\"))"
    )
}

fn plane(top: f64, material: &str) -> String {
    format!("Quad(corner: (-5e3, {top:?}, -5e3), u: (0, 0, 1e4), v: (1e4, 0, 0), material: \"{material}\")")
}

/// A ball, glass, a box and a mesh that touch the ground, a wall, and a lamp.
const FIVE: &str = "Sphere(center: (0, 0.5, 0), radius: 0.5, material: \"grey\"),
    Sphere(center: (1.1, 0.4, 0.4), radius: 0.4, material: \"glass\"),
    Transformed(by: [RotateY(20), Translate((-1.2, 0, 0.1))], object: Box(min: (-0.3, 0, -0.3), max: (0.3, 0.7, 0.3), material: \"steel\")),
    Transformed(by: [Scale(0.25), Translate((0.3, 0.25, 1))], object: Mesh(path: \"ball.obj\", material: \"blue\")),
    Quad(corner: (-1, 0, -0.9), u: (2, 0, 0), v: (0, 0.9, 0), material: \"blue\"),
    Sphere(center: (1, 3, 1.5), radius: 0.4, material: \"bright\")";

/// From 1 above the ground; it fills the view.
const ABOVE: &str = "(look_from: (0.4, 1, 4), look_at: (0.1, 0, 0.5), vertical_fov: 29)";

fn request() -> Request {
    Request::spp(32).size(48, 48).mis().seed(3)
}

/// The largest difference (below) that rounding makes. The largest that was measured is 0.002, at the edges of a checker.
const MOST: f64 = 0.003;

/// The mean difference of the pixels of two images of one seed, as a share of their mean. Rounding changes the course of few paths.
fn difference(a: &Shot, b: &Shot) -> f64 {
    let values = |shot: &Shot| -> Vec<f64> { shot.picture.rgb.as_flattened().iter().map(|v| f64::from(*v)).collect() };
    let (a, b) = (values(a), values(b));
    let apart: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
    let difference = apart / b.iter().sum::<f64>();
    println!("{difference}");
    difference
}

#[test]
fn a_ground_of_any_radius_has_the_picture_of_a_plane() {
    let on = |ground: &str| render(&scene(ABOVE, 0.2, &format!("{ground}, {FIVE}")), &request());
    for exponent in 0..=15 {
        // No ground is warned of.
        let _ = scene(ABOVE, 0.2, &format!("{}, {FIVE}", ground(10f64.powi(exponent), 0.0, "grey")));
    }
    let flat = on(&plane(0.0, "grey"));
    for exponent in [6, 8, 9, 12, 15] {
        let text = ground(10f64.powi(exponent), 0.0, "grey");
        assert_eq!(large_spheres(&scene(ABOVE, 0.2, &text)), 1);
        let found = difference(&on(&text), &flat);
        assert!(found < MOST, "1e{exponent}: {found}");
        // A hundredth lower, the objects do not touch it, and light gets below them.
        let found = difference(&on(&ground(10f64.powi(exponent), -0.01, "grey")), &flat);
        assert!(found > 3.0 * MOST, "1e{exponent}, a ground that is a hundredth lower: {found}");
    }
}

#[test]
fn a_ground_turned_scaled_and_moved_with_everything_is_the_same() {
    let camera = |transform: &dyn Fn(DVec3) -> DVec3, up: DVec3| {
        let [from, at] = [DVec3::new(0.4, 1.0, 4.0), DVec3::new(0.1, 0.0, 0.5)].map(transform).map(triple);
        format!("(look_from: {from}, look_at: {at}, up: {}, vertical_fov: 29)", triple(up))
    };
    for radius in [1e6, 1e12] {
        let objects = format!("{}, {FIVE}", ground(radius, 0.0, "grey"));
        let usual = render(&scene(ABOVE, 0.2, &objects), &request());
        // About x by 30 degrees, and by a quarter turn about z.
        let (s, c) = (0.5, 0.75f64.sqrt());
        let turned = |v: DVec3| DVec3::new(-(c * v.y - s * v.z), v.x, s * v.y + c * v.z);
        let moved = |v: DVec3| 100.0 * turned(v) + DVec3::new(3e5, 0.0, -1e5);
        let by = "RotateX(30), RotateZ(90), Scale(100), Translate((3e5, 0, -1e5))";
        let group = |objects: &str| format!("Transformed(by: [{by}], object: Group([{objects}]))");
        let shot =
            |objects: &str| render(&scene(&camera(&moved, turned(DVec3::Y)), 0.2, &group(objects)), &request().seed(4));
        same_expectation(&shot(&objects), &usual, 1e-4, ALPHA).unwrap_or_else(|error| panic!("{radius}: {error}"));
        let lowered = objects.replace("Translate((0, 0.0, 0))", "Translate((0, -0.05, 0))");
        assert!(same_expectation(&shot(&lowered), &usual, 1e-4, ALPHA).is_err(), "a lower ground");
    }
}

#[test]
fn small_things_on_a_huge_ground_keep_their_shape() {
    let shrunk = |ground: &str| {
        let camera = "(look_from: (4e-6, 1e-5, 4e-5), look_at: (1e-6, 0, 5e-6), vertical_fov: 29)";
        let five = format!("Transformed(by: [Scale(1e-5)], object: Group([{FIVE}]))");
        render(&scene(camera, 0.2, &format!("{ground}, {five}")), &request())
    };
    let on = |top: f64| shrunk(&ground(1e12, top, "grey"));
    let flat = shrunk(&plane(0.0, "grey").replace("5e3", "5e-2").replace("1e4", "0.1"));
    let found = difference(&on(0.0), &flat);
    assert!(found < MOST, "{found}");
    let found = difference(&on(-1e-7), &flat);
    assert!(found > 3.0 * MOST, "a ground that is a hundredth of the objects' size lower: {found}");
}

/// A camera 1 above the ground looks level over it; the picture is some dips of the horizon high.
#[test]
fn the_horizon_dips_as_the_radius_says() {
    const SIZE: u32 = 64;
    let lit = |radius: f64, dip: f64| {
        let camera = format!(
            "(look_from: (0, 1, 0), look_at: (0, 1, -1), vertical_fov: {:?})",
            2.0 * (4.0 * dip).atan().to_degrees()
        );
        let scene = scene(&camera, 0.0, &ground(radius, 0.0, "both"));
        render(&scene, &Request::spp(64).size(SIZE, SIZE)).mean_of_all().value[0]
    };
    for exponent in [0, 1, 2, 3, 4, 5, 6, 8, 10, 12] {
        let radius = 10f64.powi(exponent);
        // The tangent of the angle of the horizon below the level.
        let dip = (1.0 + 2.0 * radius).sqrt() / radius;
        // A ray (x, y, -1) meets the ground if it points more than the dip downwards: y < - dip sqrt(1 + x²).
        let columns = 1000;
        let share = |i: i32| {
            let x = 4.0 * dip * (2.0 * (f64::from(i) + 0.5) / f64::from(columns) - 1.0);
            0.5 - dip * (1.0 + x * x).sqrt() / (8.0 * dip)
        };
        let expected = (0..columns).map(share).map(|share| share.max(0.0)).sum::<f64>() / f64::from(columns);
        // The edge has about 64 pixels; a pixel's share is off by at most 0.5 / 8.
        let bound = 5.0 * 64f64.sqrt() * 0.5 / 8.0 / f64::from(SIZE * SIZE);
        let found = lit(radius, dip);
        assert!((found - expected).abs() < bound, "1e{exponent}: {found} for {expected}");
        let larger = lit(1.03 * radius, dip);
        assert!((larger - expected).abs() > bound, "1e{exponent}: a radius that is too large: {larger}");
    }
}

/// Just below and just above the limit, with the same seed.
#[test]
fn where_the_two_forms_of_a_sphere_meet_nothing_shows() {
    let of = |objects: &str| scene(ABOVE, 0.2, &format!("{objects}, {FIVE}"));
    let grey = |radius: f64| of(&ground(radius, -0.005, "grey"));
    // The camera is some 1.01 above the ground, and not quite over its top. The limit of the radius is between these two.
    let (mut low, mut high) = (1020.0, 1045.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if large_spheres(&grey(middle)) == 0 { low = middle } else { high = middle }
    }
    let check = |name: &str, objects: &dyn Fn(f64) -> String, other: String| {
        let (sphere, large_sphere) = (of(&objects(low)), of(&objects(high)));
        assert_eq!([large_spheres(&sphere), large_spheres(&large_sphere)], [0, 1]);
        let sphere = render(&sphere, &request());
        let found = difference(&render(&large_sphere, &request()), &sphere);
        assert!(found < MOST, "{name}: {found}");
        let found = difference(&render(&of(&other), &request()), &sphere);
        assert!(found > MOST, "{name}, another one: {found}");
    };
    // (Other textures than the checker are evaluated at the same points: `textures_of_a_huge_ground_are_those_of_a_plane`.)
    for material in ["grey", "checker", "glass"] {
        let objects = |radius: f64| ground(radius, -0.005, material);
        check(material, &objects, ground(high, -0.03, material));
    }
    // The sides of the image, not its edge.
    let turned = |radius: f64, degrees: f64| {
        let center = -radius - 0.005;
        format!(
            "Transformed(by: [RotateX({degrees:?}), RotateY(50), Translate((0, {center:?}, 0))],
                object: Sphere(center: (0, 0, 0), radius: {radius:?}, material: \"image\"))"
        )
    };
    check("image", &|radius| turned(radius, 70.0), turned(high, 72.0));
    // Fog below the horizon, in layers.
    let fog = |radius: f64, scale: f64| {
        let boundary = ground(radius, -0.005, "").replace(", material: \"\"", "");
        let albedo = format!("Checker(scale: {scale:?}, even: (0.9, 0.5, 0.1), odd: (0.1, 0.5, 0.9))");
        format!("Medium(boundary: {boundary}, density: 2, albedo: {albedo})")
    };
    check("fog", &|radius| fog(radius, 0.3), fog(high, 0.31));
}

#[test]
fn textures_of_a_huge_ground_are_those_of_a_plane() {
    for material in ["checker", "noise", "marble"] {
        let on = |ground: &str| render(&scene(ABOVE, 0.2, &format!("{ground}, {FIVE}")), &request());
        // In the object's own space at a height at which the checker does not change.
        let sphere = |radius: f64| {
            let center = -radius - 0.125;
            format!("Sphere(center: (0, {center:?}, 0), radius: {radius:?}, material: \"{material}\")")
        };
        let flat = on(&plane(-0.125, material).replace("5e3", "500").replace("1e4", "1e3"));
        for radius in [1e7, 1e12] {
            let found = difference(&on(&sphere(radius)), &flat);
            assert!(found < MOST, "{material} on {radius}: {found}");
        }
        // The texture turns with its object.
        let turned = format!("Transformed(by: [RotateY(20)], object: {})", sphere(1e12));
        let found = difference(&on(&turned), &flat);
        assert!(found > 5.0 * MOST, "{material}, turned: {found}");
    }
}

#[test]
fn a_texture_of_fog_in_a_huge_sphere_is_that_of_fog_in_a_box() {
    let on = |boundary: &str, scale: f64| {
        let albedo = format!("Checker(scale: {scale:?}, even: (0.9, 0.5, 0.1), odd: (0.1, 0.5, 0.9))");
        let fog = format!("Medium(boundary: {boundary}, density: 2, albedo: {albedo})");
        render(&scene(ABOVE, 0.2, &format!("{fog}, {FIVE}")), &request())
    };
    let flat = on("Box(min: (-500, -500, -500), max: (500, -0.125, 500))", 0.3);
    for radius in [1e7, 1e12] {
        let sphere = format!("Sphere(center: (0, {:?}, 0), radius: {radius:?})", -radius - 0.125);
        let found = difference(&on(&sphere, 0.3), &flat);
        assert!(found < MOST, "{radius}: {found}");
        let found = difference(&on(&sphere, 0.31), &flat);
        assert!(found > MOST, "{radius}, another scale: {found}");
    }
}

/// The farthest that any value of the image is from what all of them should be.
fn farthest(shot: &Shot, expected: f64) -> f64 {
    shot.picture.rgb.as_flattened().iter().map(|v| (f64::from(*v) - expected).abs()).fold(0.0, f64::max)
}

#[test]
fn clear_and_glass_grounds_lose_no_light() {
    let down = "(look_from: (0, 1, 0), look_at: (0.1, 0, 0.2), vertical_fov: 40)";
    for radius in [1e4, 1e6, 1e9, 1e12] {
        let clear = format!(
            "{}, Quad(corner: (-2, -0.5, -2), u: (0, 0, 4), v: (4, 0, 0), material: \"lamp\")",
            ground(radius, 0.0, "clear")
        );
        assert_eq!(farthest(&render(&scene(down, 0.0, &clear), &Request::spp(64)), 1.0), 0.0, "a lamp below {radius}");
        let glass = scene(down, 1.0, &ground(radius, 0.0, "glass"));
        assert_eq!(farthest(&render(&glass, &Request::spp(64).depth(1000)), 1.0), 0.0, "glass of {radius}");
        // From within.
        let within = scene(&down.replace("(0, 1, 0)", "(0, -1, 0)"), 1.0, &ground(radius, 0.0, "clear"));
        assert_eq!(farthest(&render(&within, &Request::spp(64)), 1.0), 0.0, "from within {radius}");
    }
}

fn mean(shot: &Shot) -> (f64, f64) {
    let mean = shot.mean_of_all();
    (mean.value[0], mean.variance[0].sqrt())
}

#[test]
fn a_ground_that_emits_lights_what_is_above_it() {
    // A grey square faces the ground from 3 above it, and the camera is between.
    let camera = "(look_from: (0, 1, 0), look_at: (0, 2, 0), up: (0, 0, 1), vertical_fov: 40)";
    let square = "Quad(corner: (-3, 3, -3), u: (6, 0, 0), v: (0, 0, 6), material: \"grey\")";
    for radius in [1.1e3, 1e4, 1e6, 1e12] {
        let of = |square: &str| scene(camera, 0.0, &format!("{}, {square}", ground(radius, 0.0, "lamp")));
        // A sphere in full view (r/D)² lights a surface that faces it.
        let expected = 0.5 * (radius / (radius + 3.0)).powi(2);
        for request in [Request::spp(256), Request::spp(256).mis(), Request::spp(256).mis().sobol().roulette()] {
            let (found, error) = mean(&render(&of(square), &request));
            // Off the middle, less of the sphere faces the square: at most 3 % of the dip.
            // Few paths miss it.
            let missing = 1.0 - 2.0 * expected;
            let slack = 5.0 * (error + 0.5 * (missing / 65536.0).sqrt()) + 1e-3 * missing;
            assert!((found - expected).abs() < slack, "{radius}: {found} for {expected}");
            let (dimmer, _) = mean(&render(&of(&square.replace("grey", "blue")), &request));
            assert!((dimmer - expected).abs() > slack);
        }
    }
}

#[test]
fn a_dome_that_emits_lights_everything_within() {
    let ball = "Sphere(center: (0, -2, -4), radius: 1, material: \"grey\")";
    let camera = "(look_from: (0, -2, 0), look_at: (0, -2, -4), vertical_fov: 20)";
    // With the camera near the surface, and in the middle of a sky.
    for (radius, top) in [(1e4, 0.0), (1e6, 0.0), (1e12, 0.0), (1e9, 1e9)] {
        let of = |material: &str| scene(camera, 0.0, &format!("{}, {ball}", ground(radius, top, material)));
        assert_eq!(large_spheres(&of("both")), usize::from(top == 0.0));
        assert_eq!(farthest(&render(&of("both"), &Request::spp(64)), 0.5), 0.0, "{radius}");
        let (found, error) = mean(&render(&of("both"), &Request::spp(256).mis()));
        assert!((found - 0.5).abs() < 5.0 * error && error < 0.01, "{radius}: {found} ± {error}");
        // A lamp of one side emits outwards, and `check` says so.
        let dark = render(
            &unchecked(camera, 0.0, &format!("{}, {ball}", ground(radius, top, "lamp"))),
            &Request::spp(64).mis(),
        );
        assert_eq!(farthest(&dark, 0.0), 0.0, "{radius}");
    }
}

/// Beside a lamp, which the tree over the lights chooses or not.
#[test]
fn light_sampling_keeps_the_image_of_grounds_and_domes_that_emit() {
    for (name, around) in [
        ("a ground", ground(1e6, 0.0, "both")),
        ("a ground", ground(1e12, 0.0, "both")),
        // Everything stands on its bottom.
        ("a dome", "Sphere(center: (0, 1e7, 0), radius: 1e7, material: \"both\")".to_string()),
    ] {
        let shot = |request: Request, emit: &str| {
            let mut scene = scene(ABOVE, 0.0, &format!("{around}, {FIVE}"));
            assert_eq!(large_spheres(&scene), 1);
            for (name, material) in &mut scene.materials {
                if name == emit
                    && let Material::DiffuseLight(DiffuseLight { emit, .. }) = material
                {
                    *emit = Texture::Rgb(1.03, 1.03, 1.03);
                }
            }
            render(&scene, &request.size(32, 32))
        };
        let found = shot(Request::spp(256).mis().seed(5), "");
        let plain = shot(Request::spp(1024).seed(6), "");
        same_expectation(&found, &plain, 1e-5, ALPHA).unwrap_or_else(|error| panic!("{name}: {error}"));
        let brighter = shot(Request::spp(1024).seed(6), "both");
        assert!(same_expectation(&found, &brighter, 1e-5, ALPHA).is_err(), "{name}: light that is 3 % brighter");
    }
}

#[test]
fn fog_in_a_huge_sphere_is_as_thick_as_its_distances_say() {
    // From 1 below the surface of fog, the sky is seen through 1 / cos of it.
    let camera = "(look_from: (0, -1, 0), look_at: (0, 0, 0), up: (0, 0, 1), vertical_fov: 90)";
    for radius in [2e3, 1e6, 1e12] {
        let of = |density: f64| {
            let boundary = ground(radius, 0.0, "").replace(", material: \"\"", "");
            let fog = format!("Medium(boundary: {boundary}, density: {density:?}, albedo: Rgb(0, 0, 0))");
            mean(&render(&scene(camera, 1.0, &fog), &Request::spp(1024)))
        };
        let steps = 200;
        let coordinate = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0;
        let all = (0..steps).flat_map(|i| (0..steps).map(move |j| (coordinate(i), coordinate(j))));
        let expected = all.map(|(x, y)| (-(1.0 + x * x + y * y).sqrt()).exp()).sum::<f64>() / f64::from(steps * steps);
        let (found, error) = of(1.0);
        assert!((found - expected).abs() < 5.0 * error + 1e-3, "{radius}: {found} ± {error} for {expected}");
        let (thicker, _) = of(1.03);
        assert!((thicker - expected).abs() > 5.0 * error + 1e-3, "{radius}: fog that is too thick");
    }
}

#[test]
fn fog_below_the_horizon_hides_what_is_in_it() {
    // A lamp 1 below the surface, seen from 1 above it.
    let camera = "(look_from: (0, 1, 0), look_at: (0, 0, 0), up: (0, 0, 1), vertical_fov: 1)";
    for radius in [2e3, 1e6, 1e12] {
        let boundary = ground(radius, 0.0, "").replace(", material: \"\"", "");
        let fog = format!("Medium(boundary: {boundary}, density: 1, albedo: Rgb(0, 0, 0))");
        let lamp = "Quad(corner: (-1, -1, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"lamp\")";
        let (found, error) = mean(&render(&scene(camera, 0.0, &format!("{fog}, {lamp}")), &Request::spp(1024)));
        let expected = (-1.0f64).exp();
        assert!((found - expected).abs() < 5.0 * error, "{radius}: {found} ± {error} for {expected}");
        assert!(error < 0.002);
    }
}
