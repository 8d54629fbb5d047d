//! Ways to estimate one expectation: rays sent to lights beside those that are scattered (mis) or not (bsdf), dark paths ended at random
//! or not. Each pair renders the same scenes with different seeds, and may differ by noise alone, in tiles and in the mean.
//!
//! Noise without rare values is what the comparison is for: lamps here are large, or the room is bright.

use crate::common::render;

use crate::common::faults::{ALPHA, Fault, agree, changed, differ};
use crate::common::instances::{ball_file, smooth_ball_file};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_all, render_planted, scene_with};
use crate::common::rooms::{AROUND, open_room};
use crate::common::stats::{same_expectation_paired, sidak, welch_t};
use glam::DVec3;
use gpu_rt::flatten::{MOST_LIGHTS, flatten};
use gpu_rt::options::RenderOptions;

use gpu_rt::scene::Scene;
use image::{Rgb, Rgb32FImage};

/// The walls' albedo, and one that makes paths dark soon.
const GREY: &str = "0.7, 0.6, 0.5";
const DARK: &str = "0.5, 0.45, 0.4";

/// What more light each comparison of an image without rays to lights finds, as a share of it.
const FOUND: f32 = 0.01;

/// Of all rays, what roulette saves at least in rooms of dark walls.
const LEAST_SAVED: f64 = 0.05;

/// A room of grey walls, open to the front, with a lamp and other things in it.
fn room(background: &str, materials: &str, objects: &str, depth: u32) -> String {
    open_room(&["wall"; 4], 0.0, materials, objects, depth).replace(AROUND, &format!("background: {background}"))
}

const CEILING: &str = "Quad(corner: (-0.6, 1.99, -0.6), u: (1.2, 0, 0), v: (0, 0, 1.2), material: \"lamp\"),";

fn octahedron() -> String {
    ball_file(0, DVec3::ONE)
}

/// Scenes by name: all kinds of lights, of materials that answer to them, media, and the sky.
fn scenes() -> Vec<(&'static str, Scene)> {
    scenes_of(GREY, None)
}

/// The scenes with walls of this albedo, and this max_depth.
fn scenes_of(albedo: &str, max_depth: Option<u32>) -> Vec<(&'static str, Scene)> {
    let black = "Solid((0, 0, 0))";
    let grey = "Solid((0.2, 0.2, 0.2))";
    let mut many = String::new();
    for i in 0..64 {
        let (x, z) = (f64::from(i % 8) * 0.25 - 0.87, f64::from(i / 8) * 0.25 - 0.87);
        let (y, material) = (1.6 + 0.01 * f64::from(i % 5), if i % 3 == 0 { "lamp" } else { "dim" });
        many += &format!("Sphere(center: ({x}, {y}, {z}), radius: 0.06, material: \"{material}\"),");
    }
    // Enough for the tree over lights: a ceiling of tiles, some of which shine upwards as well.
    let (mut tiles, mut shades) = (String::new(), String::new());
    for i in 0..300 {
        let (x, z, shade) = (f64::from(i % 20) * 0.095 - 0.95, f64::from(i / 20) * 0.125 - 0.95, i * 7 % 5);
        tiles +=
            &format!("Quad(corner: ({x}, 1.9, {z}), u: (0.09, 0, 0), v: (0, 0, 0.12), material: \"tile{shade}\"),");
    }
    for i in 0..5 {
        let emit = 0.5 * 2f64.powi(i);
        let (blue, two_sided) = (4.0 - 0.5 * emit.min(6.0), i == 3);
        shades += &format!("\"tile{i}\": DiffuseLight(emit: Rgb({emit}, 1, {blue}), two_sided: {two_sided}),");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("octahedron.obj"), octahedron()).expect("the mesh is written");
    let sky = Rgb32FImage::from_fn(16, 8, |x, y| match (x, y) {
        (3, 2) => Rgb([20.0, 15.0, 10.0]),
        (_, 0..=3) => Rgb([0.5, 0.6, 0.8]),
        _ => Rgb([0.1, 0.1, 0.1]),
    });
    image::DynamicImage::from(sky).save(folder.path().join("sky.hdr")).expect("the sky is written");
    let sky = "Image(path: \"sky.hdr\")";
    let metal = "\"metal\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0.4), \"rough\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 1),";
    let block = "Box(min: (-0.5, 0, -0.5), max: (0.1, 0.8, 0.1), material: \"wall\"),";
    let fog = "Medium(boundary: Box(min: (-0.8, 0, -0.8), max: (0, 1.2, 0.4)), density: 2, albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.5),";
    let rooms = [
        ("a room", black, "", format!("{CEILING} {block}"), 8),
        (
            "metals",
            grey,
            metal,
            format!(
                "{CEILING} Sphere(center: (-0.5, 0.5, 0), radius: 0.45, material: \"metal\"),
                 Sphere(center: (0.5, 0.5, 0), radius: 0.45, material: \"rough\"),"
            ),
            8,
        ),
        (
            "glass",
            grey,
            "\"glass\": Dielectric(ior: 1.5), \"mirror\": Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0),",
            format!(
                "{CEILING} Sphere(center: (-0.5, 0.5, 0), radius: 0.4, material: \"glass\"),
                 Sphere(center: (0.5, 0.5, 0), radius: 0.4, material: \"mirror\"),"
            ),
            8,
        ),
        (
            "microfacets",
            grey,
            "\"brushed\": Conductor(albedo: Rgb(0.9, 0.8, 0.7), roughness: 0.35),
             \"gold\": Conductor(eta: (0.14, 0.37, 1.44), k: (3.98, 2.39, 1.6), roughness: 1),
             \"frosted\": RoughDielectric(ior: 1.5, roughness: 0.6),
             \"plastic\": Pbr(base_color: Rgb(0.2, 0.4, 0.9), metallic: 0.2, roughness: 0.4),",
            format!(
                "{CEILING} Sphere(center: (-0.5, 0.4, 0), radius: 0.4, material: \"brushed\"),
                 Transformed(by: [Scale(0.5), RotateX(20), Translate((0.5, 0.5, 0))], object: Mesh(path: \"octahedron.obj\", material: \"gold\")),
                 Sphere(center: (0, 1.3, 0.3), radius: 0.35, material: \"frosted\"),
                 Sphere(center: (0, 0.3, 0.6), radius: 0.3, material: \"plastic\"),"
            ),
            8,
        ),
        ("many lights", black, "\"dim\": DiffuseLight(emit: Rgb(1, 1, 2)),", many, 4),
        (
            "lamps of all shapes",
            black,
            "\"both\": DiffuseLight(emit: Checker(scale: 0.2, even: (6, 3, 1), odd: (1, 2, 5))),",
            "Box(min: (-0.8, 0.1, -0.7), max: (-0.3, 0.5, -0.2), material: \"both\"),
             Transformed(by: [Scale(0.35), RotateY(20), Translate((0.4, 1.4, 0))], object: Mesh(path: \"octahedron.obj\", material: \"lamp\")),
             Sphere(center: (0.5, 0.4, 0.3), radius: 0.25, material: \"both\"),"
                .to_string(),
            4,
        ),
        (
            "smoke",
            black,
            "",
            format!(
                "{CEILING} {fog} Medium(boundary: Sphere(center: (0.3, 0.7, 0.2), radius: 0.5), density: 3, albedo: Rgb(0.5, 0.8, 0.9)),
                 Medium(boundary: Transformed(by: [Scale(0.4), Translate((0.5, 1.2, -0.3))], object: Mesh(path: \"octahedron.obj\")), density: 4, albedo: Rgb(0.9, 0.9, 0.9), anisotropy: -0.4),"
            ),
            8,
        ),
        ("a tree over lights", black, &shades, format!("{tiles} {block}"), 4),
        (
            "a tree, a sky and smoke",
            sky,
            &shades,
            format!(
                "{tiles} {fog}
                 Transformed(by: [Scale(0.3), RotateY(20), Translate((0.4, 0.6, 0))], object: Mesh(path: \"octahedron.obj\", material: \"lamp\")),"
            ),
            4,
        ),
        ("a sky", sky, metal, "Sphere(center: (0, 0.5, 0), radius: 0.5, material: \"metal\"),".to_string(), 6),
    ];
    let adapted = |(name, background, materials, objects, depth): (_, &str, &str, String, u32)| {
        let text = room(background, materials, &objects, max_depth.unwrap_or(depth)).replace(GREY, albedo);
        (name, render::scene_in(folder.path(), &text))
    };
    rooms.into_iter().map(adapted).collect()
}

/// By Sobol points either way, whose pixels each have scrambles of their own: Welch's test of tiles and of the full image. The difference of the
/// means is known to 0.05 to 0.15 % of them (printed), of which 5.5 standard errors are found, 0.4 to 0.8 %: 1 % more light is planted, and found
/// in each scene. A small lamp is hardly met by chance: it has closed forms instead (tests/extremes/lights.rs has
/// one above a floor, and tests/images/closed_form.rs one that lights a room).
#[test]
fn sending_rays_to_lights_changes_no_expectation() {
    for (name, scene) in scenes() {
        // Cut after few events, each way sees the same part of the light: of surfaces, of glass, and in media.
        let cut = ["microfacets", "glass", "smoke"].contains(&name);
        let short = cut.then(|| (format!("{name} at depth 1"), Some(1), 2048));
        // More where the planted density is to be found, and where scattered rays meet small lamps.
        let samples = match name {
            "lamps of all shapes" => 8192,
            "many lights" => 4096,
            _ => 2048,
        };
        for (what, depth, samples) in std::iter::once((name.to_string(), None, samples)).chain(short) {
            let seed = 2 * u32::from(depth.is_some());
            let shot = |request: Request| render(&scene, &Request { max_depth: depth, ..request.sobol() });
            let bsdf = shot(Request::spp(samples).seed(seed + 1));
            let mis = shot(Request::spp(1024).seed(seed + 2).mis());
            known(&what, &bsdf, &mis);
            agree(&what, &bsdf, &mis, 1e-5);
            differ(&what, &bsdf, &brighter(&mis), 1e-5);
            // The share of each light that is met, by a density that is off by a tenth.
            if what == "lamps of all shapes" {
                let density = "pdf = ${name}_light_pdf(from_point";
                let wrong = changed(&[("scene/lights", density, &density.replace("= ", "= 1.1 * "))]);
                let wrong = render_planted(&scene, &Request::spp(1024).seed(2).mis().sobol(), &wrong);
                differ("a density off by a tenth", &bsdf, &wrong, 1e-5);
            }
        }
    }
}

/// 1 % more light.
fn brighter(shot: &Shot) -> Shot {
    shot.changed(|_, _, rgb| rgb.map(|v| (1.0 + FOUND) * v))
}

/// Four bodies with vertex normals, one in each tile of the image, scaled and turned, near lamps of all shapes: it matters from where a lamp is
/// chosen and aimed at, since their facets lie well below the points that light is sent from.
fn smooth_bodies() -> Scene {
    scene_with(
        &[("octahedron.obj", smooth_ball_file(0)), ("ball.obj", smooth_ball_file(1)), ("lamp.obj", octahedron())],
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 7), look_at: (0, 0, 0), vertical_fov: 17),
    background: Solid((0, 0, 0)),
    materials: {
        \"grey\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)),
        \"brushed\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0.8),
        \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false),
        \"both\": DiffuseLight(emit: Checker(scale: 0.2, even: (4, 3, 1), odd: (3, 2, 4))),
    },
    objects: [
        Transformed(by: [Scale(0.55), RotateX(35), RotateZ(25), Translate((-0.5, 0.5, 0))], object: Mesh(path: \"octahedron.obj\", material: \"grey\")),
        Transformed(by: [Scale(0.5), RotateX(10), Translate((0.5, 0.5, 0))], object: Mesh(path: \"ball.obj\", material: \"brushed\")),
        Transformed(by: [Scale(0.5), RotateY(30), Translate((-0.5, -0.5, 0))], object: Mesh(path: \"ball.obj\", material: \"grey\")),
        Transformed(by: [Scale(0.55), RotateY(50), RotateX(-30), Translate((0.5, -0.5, 0))], object: Mesh(path: \"octahedron.obj\", material: \"brushed\")),
        Sphere(center: (1.6, 1.3, 1), radius: 0.8, material: \"lamp\"),
        Sphere(center: (0, 0, 0.45), radius: 0.12, material: \"lamp\"),
        Quad(corner: (-1.5, -1, 0), u: (0, 2, 0), v: (0.3, 0, 1.6), material: \"both\"),
        Transformed(by: [Scale(0.7), RotateY(20), Translate((0.3, -1.8, 0.8))], object: Mesh(path: \"lamp.obj\", material: \"lamp\")),
    ],
    render: (samples: 512, max_depth: 2),
)",
    )
}

/// Light that is aimed at from the facet, as it once was.
const FROM_THE_FACET: Fault =
    ("step/surface_light", "sample_light(path, side.point)", "sample_light(path, surface.point)");

/// Compares the expectation of so many scattered rays alone with that of half as many with rays to lights. Planted are 1 % more light, and an error, in
/// so many samples.
fn expects_the_same(name: &str, scene: &Scene, samples: u32, fault: Fault<'_>, of_fault: u32) {
    let by_lights = |samples: u32| Request::spp(samples).seed(2).mis().sobol();
    let bsdf = render(scene, &Request::spp(samples).seed(1).sobol());
    let mis = render(scene, &by_lights(samples / 2));
    known(name, &bsdf, &mis);
    agree(name, &bsdf, &mis, 1e-5);
    differ(name, &bsdf, &brighter(&mis), 1e-5);
    differ(fault.2, &bsdf, &render_planted(scene, &by_lights(of_fault), &changed(&[fault])), 1e-5);
}

/// An event on a mesh with vertex normals has one point, the lifted one: light is aimed at from there, leaves there, and both densities are
/// those there.
#[test]
fn smooth_meshes_expect_the_same_with_rays_to_lights() {
    expects_the_same("smooth bodies", &smooth_bodies(), 8192, FROM_THE_FACET, 1024);
}

/// A smooth body of frosted glass around a lamp and beside another: light passes each facet both ways.
fn frosted_bodies() -> Scene {
    scene_with(
        &[("octahedron.obj", smooth_ball_file(0))],
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 7), look_at: (0, 0, 0), vertical_fov: 17),
    background: Solid((0, 0, 0)),
    materials: {
        \"frosted\": RoughDielectric(ior: 1.3, roughness: 0.8),
        \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2)),
    },
    objects: [
        Transformed(by: [Scale(0.9), RotateX(35), RotateZ(25)], object: Mesh(path: \"octahedron.obj\", material: \"frosted\")),
        Sphere(center: (0, 0, 0), radius: 0.25, material: \"lamp\"),
        Sphere(center: (1, 0.8, 0.6), radius: 0.3, material: \"lamp\"),
    ],
    render: (samples: 512, max_depth: 3),
)",
    )
}

/// A material that answers on both sides of a smooth mesh aims at a light from the point of the side that it has chosen. Planted is the
/// point of the near side for both.
#[test]
fn frosted_smooth_meshes_expect_the_same_with_rays_to_lights() {
    let near_side = ("scene/both_sides", "select(point, facet_point, below)", "point");
    expects_the_same("frosted bodies", &frosted_bodies(), 8192, near_side, 4096);
}

/// A slab of frosted glass over a floor, under a sky with a sun: from each of its surfaces the sky is sampled on both sides, and a path meets it
/// behind the other surface. Planted is a density of the sky that is off by a tenth where it is sampled.
#[test]
fn a_frosted_slab_under_a_sun_expects_the_same_with_rays_to_lights() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sky = Rgb32FImage::from_fn(64, 32, |x, y| match (x, y) {
        (20..24, 6..10) => Rgb([20.0, 18.0, 15.0]),
        (_, y) => Rgb([0.45 - 0.01 * y as f32; 3]),
    });
    image::DynamicImage::from(sky).save(folder.path().join("sky.hdr")).expect("the sky is written");
    let text = "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0.8, 1.5, 5), look_at: (0, -0.2, 0), vertical_fov: 26),
    background: Image(path: \"sky.hdr\"),
    materials: {
        \"frosted\": RoughDielectric(ior: 1.5, roughness: 0.3),
        \"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
    },
    objects: [
        Quad(corner: (-3, -1.2, -3), u: (0, 0, 6), v: (6, 0, 0), material: \"floor\"),
        Box(min: (-1.5, -1, -0.15), max: (1.5, 1, 0.15), material: \"frosted\"),
    ],
    render: (samples: 512, max_depth: 32),
)";
    let scene = render::scene_in(folder.path(), text);
    let density = ("scene/sky_light", "from_world(direction), sky_pdf", "from_world(direction), 1.1 * sky_pdf");
    expects_the_same("a frosted slab under a sun", &scene, 16384, density, 4096);
}

/// Says how well the difference of the means of two images is known, as a share of them.
fn known(name: &str, bsdf: &Shot, mis: &Shot) {
    let (a, b) = (bsdf.mean_of_all(), mis.mean_of_all());
    let share = |variance: f64| variance.sqrt() / a.value[1];
    println!(
        "{name}: the mean is known to {:.5}, with rays to lights to {:.5}; {:.4} of it is found",
        share(a.variance[1]),
        share(b.variance[1]),
        5.4 * share(a.variance[1] + b.variance[1])
    );
}

/// The face of a smooth octahedron that looks at the camera, beside a lamp of r = 0.15: in the middle of the image the lifted point is 5/9 (1, 1, 1),
/// from where L = a Le (r/D)² cos = 0.0982. Over the half degree of the image it changes by 3 % each way, and its mean is within 0.1 % of that
/// (second order). With rays to lights 1e5 samples know it to 0.01 %. From the facet the lamp was aimed at past itself: 0.068.
#[test]
fn a_smooth_octahedron_beside_a_lamp_has_its_closed_form() {
    let scene = scene_with(
        &[("octahedron.obj", smooth_ball_file(0))],
        "Scene(image: (width: 16, height: 16),
            camera: (look_from: (4, 4, 4), look_at: (0, 0, 0), vertical_fov: 0.5),
            background: Solid((0, 0, 0)),
            materials: { \"body\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"lamp\": DiffuseLight(emit: Rgb(10, 10, 10)) },
            objects: [Mesh(path: \"octahedron.obj\", material: \"body\"),
                      Sphere(center: (1.3, 1, 0.4), radius: 0.15, material: \"lamp\")],
            render: (samples: 512, max_depth: 1))",
    );
    let lifted = 5.0 / 9.0;
    let to_lamp = [1.3 - lifted, 1.0 - lifted, 0.4 - lifted];
    let d2: f64 = to_lamp.iter().map(|v| v * v).sum();
    let cosine = to_lamp.iter().sum::<f64>() / (3.0 * d2).sqrt();
    let expected = 0.5 * 10.0 * 0.15 * 0.15 / d2 * cosine;
    assert!((expected - 0.0982).abs() < 1e-4);
    let mean = |shot: &Shot| {
        let mean = shot.mean_of_all();
        println!("{} +- {}, expected {expected}", mean.value[0], mean.variance[0].sqrt());
        mean.value[0]
    };
    let request = Request::spp(512).seed(2).mis();
    assert!((mean(&render(&scene, &request)) / expected - 1.0).abs() < 2e-3);
    assert!(mean(&render_planted(&scene, &request, &changed(&[FROM_THE_FACET]))) < 0.8 * expected);
    // Scattered rays meet the lamp once in fifty times: 2e6 of them know the mean to 0.5 %.
    let bsdf = render(&scene, &Request::spp(8192).seed(3).sobol());
    assert!((mean(&bsdf) / expected - 1.0).abs() < 0.03);
}

/// With half of the light absorbed at every event and 24 events, roulette saves 9 to 28 % of the rays. The seeds are the same: what differs is
/// what became of dark paths. That step is the same whatever a path has met: here are walls, glass, smoke and a sky. Planted are survivors that are worth no more than before, which loses 0.3 to 1.7 % of the light, and 1 % less light.
#[test]
fn roulette_changes_no_expectation() {
    let unweighted = Overlay::new(&[("step/roulette", "throughput / q", "throughput")]);
    let some = ["a room", "glass", "smoke", "a sky"];
    for (name, scene) in scenes_of(DARK, Some(24)).into_iter().filter(|(name, _)| some.contains(name)) {
        let request = Request::spp(512).seed(5).mis();
        let off = render(&scene, &request);
        let request = request.roulette();
        let on = render(&scene, &request);
        let saved = 1.0 - on.film.totals.rays as f64 / off.film.totals.rays as f64;
        let wrong = render_planted(&scene, &request, &unweighted);
        let lost = 1.0 - wrong.mean_of_all().value[0] / off.mean_of_all().value[0];
        println!("{name}: roulette saves {saved:.3} of the rays; unweighted it loses {lost:.4} of the light");
        assert!(saved > LEAST_SAVED, "{name}: roulette saves {saved:.3} of the rays");
        let paired = |other: &Shot| same_expectation_paired(&off.picture.rgb, &other.picture.rgb, ALPHA);
        paired(&on).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(paired(&wrong).is_err(), "{name}: a wrong weight is not found");
        let planted = on.changed(|_, _, rgb| rgb.map(|v| 0.99 * v));
        assert!(paired(&planted).is_err(), "{name}: 1 % less light is not found");
    }
}

/// By 16 seeds of 64 samples of either sampler, with rays to lights: nothing is assumed about the points of one image. In tiles and the
/// full image, by Welch's test, whose 17 to 30 degrees of freedom take some 8 standard errors: 2 % of the light is found in each scene, not less. A sampler knows
/// nothing of a scene but how many numbers are drawn: here are the materials and the lights that draw the most.
#[test]
fn both_samplers_expect_the_same_with_rays_to_lights() {
    const SEEDS: u32 = 16;
    let some = ["microfacets", "lamps of all shapes", "a tree, a sky and smoke"];
    for (name, scene) in scenes().into_iter().filter(|(name, _)| some.contains(name)) {
        let means = |request: &Request, first: u32| -> Vec<Vec<f64>> {
            let seeds = (first..first + SEEDS).map(|seed| (seed, 0..64));
            let mut rows = Vec::new();
            render_all(&scene, request, seeds, |shot| {
                let tiles = (0..4).map(|i| shot.mean(8 * (i % 2)..8 * (i % 2) + 8, 8 * (i / 2)..8 * (i / 2) + 8));
                rows.push(tiles.chain([shot.mean_of_all()]).flat_map(|mean| mean.value).collect());
            });
            rows
        };
        let (drawn, spread) = (means(&Request::default().mis(), 0), means(&Request::default().mis().sobol(), 100));
        let worst = |factor: f64| {
            let column =
                |rows: &[Vec<f64>], i: usize, factor: f64| rows.iter().map(|row| row[i] * factor).collect::<Vec<_>>();
            let p = |i| welch_t(&column(&spread, i, factor), &column(&drawn, i, 1.0)).p;
            (0..drawn[0].len()).map(p).fold(1.0, f64::min)
        };
        let threshold = sidak(ALPHA, drawn[0].len());
        println!(
            "{name}: p {:.1e}, with 2 % more {:.1e}, 3 % {:.1e}, of {threshold:.1e}",
            worst(1.0),
            worst(1.02),
            worst(1.03)
        );
        assert!(worst(1.0) > threshold, "{name}: p = {:e}", worst(1.0));
        assert!(worst(1.02) < threshold, "{name}: 2 % more is not found");
    }
}

/// More faces emit than lights are sampled: a mesh of them is left to BSDF sampling, and the small mesh next to it is sampled. Planted is a
/// density of what is not sampled.
#[test]
fn lights_beyond_the_limit_are_found_by_bsdf_sampling() {
    const SIDE: u32 = 725;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        (SIDE + 1) * (SIDE + 1),
        2 * SIDE * SIDE
    )
    .into_bytes();
    let at = |i: u32| 1.8 * i as f32 / SIDE as f32 - 0.9;
    for (x, z) in (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (x, z))) {
        [at(x), 1.99, at(z)].iter().for_each(|v| ply.extend(v.to_le_bytes()));
    }
    for (x, z) in (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| (x, z))) {
        let corner = |x: u32, z: u32| z * (SIDE + 1) + x;
        let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
        for face in [[a, b, d], [a, d, c]] {
            ply.push(3);
            face.iter().for_each(|v| ply.extend(v.to_le_bytes()));
        }
    }
    std::fs::write(folder.path().join("octahedron.obj"), octahedron()).expect("the mesh is written");
    std::fs::write(folder.path().join("ceiling.ply"), ply).expect("the mesh is written");
    let objects = "Mesh(path: \"ceiling.ply\", material: \"dim\"), Transformed(by: [Scale(0.2), Translate((0.3, 0.6, 0.2))], object: Mesh(path: \"octahedron.obj\", material: \"lamp\")),";
    let dim = "\"dim\": DiffuseLight(emit: Rgb(1, 1, 1)),";
    let scene = render::scene_in(folder.path(), &room("Solid((0, 0, 0))", dim, objects, 2));
    let flat = flatten(&scene, (16, 16), &RenderOptions::default()).expect("it flattens");
    let not_sampled = flat.features.not_sampled.as_ref().expect("something is left out");
    let faces = u64::from(2 * SIDE * SIDE);
    assert!(faces > MOST_LIGHTS as u64);
    assert_eq!((flat.features.quantities.lights, not_sampled.lights, not_sampled.total), (8, faces, faces + 8));
    assert!(
        flat.warnings
            .iter()
            .any(|warning| warning.contains("materials[\"dim\"]") && warning.contains("BSDF sampling alone"))
    );
    let bsdf = render(&scene, &Request::spp(1024).seed(1));
    let mis = render(&scene, &Request::spp(256).seed(2).mis());
    agree("scattered rays and light sampling", &bsdf, &mis, 1e-5);
    let wrong = changed(&[("scene/lights", "index >= NOT_SAMPLED", "index == 0x7fffffffu")]);
    differ(
        "a density of what is not sampled",
        &bsdf,
        &render_planted(&scene, &Request::spp(256).seed(2).mis(), &wrong),
        1e-5,
    );
}
