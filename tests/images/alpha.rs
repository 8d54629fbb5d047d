//! Cut-out and transparent surfaces: closed forms, one expectation with and without light sampling and by both samplers, and the same
//! bytes however the work is done.

use std::path::Path;

use gpu_rt::aov::Aovs;
use gpu_rt::bvh::Quality;
use gpu_rt::flatten::flatten;
use gpu_rt::options::{Integrator, RenderOptions, Scatter};
use gpu_rt::scene::Scene;
use image::{Rgba, RgbaImage};

use crate::common::everything::same;
use crate::common::faults::{ALPHA, agree, are_found};
use crate::common::kernel::Overlay;
use crate::common::render::{Mean, Request, render, render_planted, same_expectation, scene, scene_in};
use crate::light_sampling::{ALPHA_OF_LAMPS, PANES};

/// Of a mean, as a share of it.
const MOST_NOISE: f64 = 0.01;

/// A camera that looks along -z at sheets of one material that fill its view, before a sky; and more.
fn sheets(material: &str, count: usize, max_depth: u32, more: &str) -> String {
    let sheet = |k: usize| {
        format!("Quad(corner: (-4, -4, {}), u: (8, 0, 0), v: (0, 8, 0), material: \"sheet\"),", -0.01 * k as f64)
    };
    format!(
        "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
        background: Solid((1, 2, 3)), materials: {{\"sheet\": {material}, \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7))}},
        objects: [{} {more}], render: (samples: 512, max_depth: {max_depth}))",
        (0..count).map(sheet).collect::<String>()
    )
}

/// n sheets of coverage a leave (1 - a)^n of the sky, and show their own light by the rest. Neither max_depth nor roulette counts them.
#[test]
fn sheets_let_the_rest_of_the_light_pass() {
    for (count, alpha) in [(1, 0.3), (2, 0.5), (5, 0.1), (300, 0.003), (3, 0.0), (2, 1.0)] {
        let text = format!("Lambertian(albedo: Rgb(0, 0, 0), emission: Rgb(2, 2, 2), alpha: {alpha})");
        let left = (1.0f64 - alpha).powi(count);
        let expected = [1.0, 2.0, 3.0].map(|sky| left * sky + (1.0 - left) * 2.0);
        for (max_depth, request) in [
            (0, Request::default()),
            (2, Request::default().roulette().scatter(Scatter::Linked)),
            (2, Request::default().sobol().mis().roulette()),
        ] {
            let shot = render(&scene(&sheets(&text, count as usize, max_depth, "")), &request.seed(3));
            shot.mean_of_all()
                .is_near(expected, MOST_NOISE)
                .unwrap_or_else(|error| panic!("{count} x {alpha}: {error}"));
        }
    }
}

/// What no alpha shows sets no unit, is no light, and is none of what the image holds, however bright it is.
#[test]
fn an_emission_that_no_alpha_shows_is_as_none() {
    let materials = |emission: &str| {
        [
            format!("Lambertian(albedo: Rgb(0, 0, 0), emission: {emission}, alpha: 0)"),
            format!("Pbr(emission: {emission}, alpha: Checker(scale: 1, even: (0, 0, 0), odd: (0, 0, 0)))"),
            format!("Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: {emission}, alpha: 0.49, alpha_cutoff: 0.5)"),
            format!("Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: {emission}, alpha: 0, alpha_cutoff: 1e-3)"),
        ]
    };
    let lamp = "Quad(corner: (-1, -1, 2), u: (2, 0, 0), v: (0, 2, 0), material: \"lamp\"),
        Quad(corner: (-4, -4, -2), u: (8, 0, 0), v: (0, 8, 0), material: \"wall\"),";
    for more in ["", "Sphere(center: (0, 0, 0), radius: 1, material: \"sheet\"),"] {
        for (bright, dim) in materials("Rgb(1e30, 1e30, 1e30)").iter().zip(materials("Rgb(1e-9, 1e-9, 1e-9)")) {
            let of = |material: &str| {
                let text = sheets(material, 2, 4, &format!("{lamp}{more}"));
                let text = text.replace("{\"sheet\"", "{\"wall\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"sheet\"");
                // A sky that is far darker than f32 holds beside the emission.
                scene(&text.replace("Solid((1, 2, 3))", "Solid((1e-20, 2e-20, 3e-20))"))
            };
            for request in [Request::spp(64), Request::spp(64).mis().sobol()] {
                let [bright, dim] = [bright, &dim].map(|material| render(&of(material), &request));
                assert!(bright.mean_of_all().value[0] > 0.1, "{:?}", bright.mean_of_all().value);
                assert_eq!(bright.picture.rgb, dim.picture.rgb, "{more}");
            }
        }
    }
    // The control: where it shows, it does.
    let half = materials("Rgb(1e30, 1e30, 1e30)")[2].replace("0.49", "0.5");
    assert!(render(&scene(&sheets(&half, 1, 0, "")), &Request::spp(1)).picture.rgb[0][0] > 0.99e30);
}

/// Of a body, a ray from outside passes both sides, and one from inside passes one.
#[test]
fn bodies_let_the_rest_of_the_light_pass_on_both_sides() {
    for (shape, inside) in [
        ("Sphere(center: (0, 0, 0), radius: 2, material: \"sheet\")", 1),
        ("Sphere(center: (0, 0, 3), radius: 2, material: \"sheet\")", 0),
        ("Box(min: (-3, -3, -1), max: (3, 3, 1), material: \"sheet\")", 1),
        ("Box(min: (-3, -3, -1), max: (3, 3, 9), material: \"sheet\")", 0),
        ("Sphere(center: (0, 0, -5e4), radius: 5e4, material: \"sheet\")", 1),
    ] {
        for alpha in [0.3, 0.0] {
            let text = format!("Lambertian(albedo: Rgb(0, 0, 0), emission: Rgb(2, 2, 2), alpha: {alpha})");
            let bodies = format!("{shape}, {shape},");
            let left = (1.0f64 - alpha).powi(2 * (1 + inside));
            let expected = [1.0, 2.0, 3.0].map(|sky| left * sky + (1.0 - left) * 2.0);
            for request in [Request::default(), Request::default().sobol().mis().roulette()] {
                let shot = render(&scene(&sheets(&text, 0, 2, &bodies)), &request.seed(3));
                // A view over 30 degrees misses the corners of a ball.
                let mean = shot.mean(2..6, 2..6);
                mean.is_near(expected, 2.0 * MOST_NOISE).unwrap_or_else(|error| panic!("{shape}, {alpha}: {error}"));
            }
        }
    }
}

/// A box is its six faces: under a lamp and a sky, with a texture that has the same bytes from each side.
#[test]
fn a_box_with_an_alpha_is_its_six_faces() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = RgbaImage::from_fn(8, 8, |x, y| {
        let is_hole = (2..6).contains(&x) && (2..6).contains(&y);
        Rgba([200, 200, 200, if is_hole { 40 } else { 220 }])
    });
    image.save(folder.path().join("hole.png")).expect("it is written");
    let room = |shapes: &str| {
        scene_in(
            folder.path(),
            &format!(
                "Scene(image: (width: 16, height: 16), camera: (look_from: (1.5, 2.5, 4), look_at: (0, 0.4, 0), vertical_fov: 30),
                background: Solid((0.2, 0.3, 0.4)),
                materials: {{\"it\": Lambertian(albedo: Rgb(0.8, 0.5, 0.2), alpha: Image(path: \"hole.png\", channel: A)),
                    \"glass\": ThinDielectric(), \"floor\": Lambertian(albedo: Rgb(0.6, 0.6, 0.6)), \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7))}},
                objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
                    Sphere(center: (-1, 2.5, 1), radius: 0.4, material: \"lamp\"), Sphere(center: (0.9, 0.6, 1), radius: 0.3, material: \"glass\"),
                    {shapes}], render: (samples: 512, max_depth: 5))"
            ),
        )
    };
    let cuboid = room("Box(min: (-0.5, 0.1, -0.5), max: (0.5, 1.1, 0.5), material: \"it\")");
    let face = |corner: &str, u: &str, v: &str| format!("Quad(corner: {corner}, u: {u}, v: {v}, material: \"it\"),");
    let faces = room(
        &[
            face("(-0.5, 0.1, -0.5)", "(1, 0, 0)", "(0, 1, 0)"),
            face("(-0.5, 0.1, 0.5)", "(1, 0, 0)", "(0, 1, 0)"),
            face("(-0.5, 0.1, -0.5)", "(0, 0, 1)", "(0, 1, 0)"),
            face("(0.5, 0.1, -0.5)", "(0, 0, 1)", "(0, 1, 0)"),
            face("(-0.5, 0.1, -0.5)", "(1, 0, 0)", "(0, 0, 1)"),
            face("(-0.5, 1.1, -0.5)", "(1, 0, 0)", "(0, 0, 1)"),
        ]
        .concat(),
    );
    let request = |seed| Request::default().mis().seed(seed);
    let expected = render(&faces, &request(1));
    for request in
        [Request::default().seed(2), request(3).sobol(), request(4).scatter(Scatter::Queues), request(5).light_paths(4)]
    {
        agree("a box", &expected, &render(&cuboid, &request), 1e-4);
    }
    let faults = [
        ("scene/body_stops", "side < 2u", "side < select(2u, 1u, FAULT)"),
        ("scene/body_stops", "COVERAGE_OF_FAR_SIDE, is_far)", "COVERAGE_OF_FAR_SIDE, is_far && !FAULT)"),
    ];
    are_found("a box", &cuboid, &expected, &request(6), &faults, 1e-4);
}

/// A floor under bodies of these materials that emit on both sides and let light pass, beside a lamp.
fn bodies(folder: &Path, alpha: &str, objects: &str) -> Scene {
    scene_in(
        folder,
        &format!(
            "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 1, 4), look_at: (0, 0.5, 0), vertical_fov: 40, shutter: (0, 1)),
            background: Solid((0, 0, 0)),
            materials: {{\"it\": Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, emission: Rgb(3, 2, 1), alpha: {alpha}),
                \"matt\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: Rgb(1, 2, 3), alpha: {alpha}),
                \"cut it\": Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, emission: Rgb(3, 2, 1), alpha: {alpha}, alpha_cutoff: 0.5),
                \"cut matt\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: Rgb(1, 2, 3), alpha: {alpha}, alpha_cutoff: 0.5),
                \"leaf\": Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, emission: Rgb(1, 1, 1), alpha: {alpha}, diffuse_transmission: 0.8),
                \"floor\": Lambertian(albedo: Rgb(0.6, 0.6, 0.6)), \"lamp\": DiffuseLight(emit: Rgb(5, 5, 5)), \"glass\": ThinDielectric()}},
            objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"), {objects}
                Sphere(center: (2, 2, 0), radius: 0.3, material: \"lamp\")], render: (samples: 2048, max_depth: 4))"
        ),
    )
}

/// Bodies with an alpha that emit are sampled on both sides, from outside and from inside. Planted: one side that is found more often than its
/// density says by 8 %, the near side alone, and a density without the choice.
#[test]
fn bodies_with_an_alpha_are_sampled_on_both_sides() {
    let folder = tempfile::tempdir().expect("a folder");
    let holes = RgbaImage::from_fn(8, 8, |x, y| Rgba([200, 200, 200, if (x / 2 + y / 2) % 2 == 0 { 40 } else { 220 }]));
    holes.save(folder.path().join("holes.png")).expect("it is written");
    let ball = "Sphere(center: (0, 0.7, 0), radius: 0.6, material: \"it\"),";
    let cuboid = "Transformed(by: [RotateY(30), Translate((-0.9, 0.5, 0.3))],
        object: Box(min: (-0.4, -0.4, -0.4), max: (0.4, 0.4, 0.4), material: \"matt\")),";
    let image = "Image(path: \"holes.png\", channel: A)";
    // Bodies with an image and with a cutoff stand side by side in one room.
    let cut_out = |text: &str| text.replace("\"it\"", "\"cut it\"").replace("\"matt\"", "\"cut matt\"");
    let moved = |text: &str, x: f64| format!("Transformed(by: [Translate(({x}, 0, 0))], object: Group([{text}])),");
    let pair = format!("{ball}{cuboid}");
    for (name, alpha, objects) in [
        ("numbers", "0.5", pair.clone()),
        ("an image and a cutoff", image, moved(&pair, -0.6) + &moved(&cut_out(&pair), 0.9)),
        (
            "from inside",
            "0.6",
            "Box(min: (-2, -0.5, -2), max: (2, 3, 5), material: \"it\"), Sphere(center: (0.3, 0.6, 0), radius: 0.5, material: \"leaf\"),
             Sphere(center: (0, 0, -5e4), radius: 5e4, material: \"matt\"),"
                .to_string(),
        ),
        (
            "motion and a pane",
            "0.5",
            format!("Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0.7, 0.2, 0))])], object: {}),
                Sphere(center: (0.9, 0.6, 1), radius: 0.3, material: \"glass\"),", ball.trim_end_matches(',')),
        ),
    ] {
        let room = bodies(folder.path(), alpha, &objects);
        let flat = flatten(&room, (16, 16), &RenderOptions::default()).expect("it flattens");
        assert!(flat.features.reason("crossed_light").is_some() && flat.features.not_sampled.is_none(), "{name}");
        let bsdf = render(&room, &Request::default().seed(1).sobol());
        let mis = Request::default().mis().seed(2);
        for request in [
            mis.clone(),
            mis.clone().seed(3).sobol().scatter(Scatter::Linked),
            mis.clone().sobol().light_paths(4).seed(4),
        ] {
            agree(name, &bsdf, &render(&room, &request), 1e-4);
        }
        if name != "numbers" {
            continue;
        }
        // Of one event, without the lamp.
        let mut alone = room.clone();
        alone.objects.pop();
        let bsdf = render(&alone, &Request::spp(4096).seed(5).depth(1).sobol());
        let mis = Request::spp(4096).mis().seed(6).depth(1).sobol();
        agree(name, &bsdf, &render(&alone, &mis), 1e-4);
        let faults = [
            ("scene/light_crossings", "!= 0u), 0.5)", "!= 0u), select(0.5, 0.46, FAULT))"),
            ("scene/light_crossings", "if instance == FAR_SIDE {", "if instance == select(FAR_SIDE, 0u, FAULT) {"),
            (
                "scene/lights",
                "share_of_crossing(index, Ray(from_point, direction))",
                "select(share_of_crossing(index, Ray(from_point, direction)), 1.0, FAULT)",
            ),
        ];
        are_found(name, &alone, &bsdf, &mis, &faults, 1e-4);
    }
}

/// Each channel of a sheet is a times that of an opaque sheet plus 1 - a times that of none, whatever the material does.
#[test]
fn a_sheet_is_mixed_with_what_is_behind() {
    let lamp = "Quad(corner: (-1, 3, 2), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),";
    for (material, cutoff) in [
        ("Lambertian(albedo: Rgb(0.8, 0.5, 0.2)", ""),
        ("Pbr(base_color: Rgb(0.8, 0.5, 0.2), metallic: 0.5, roughness: 0.6", ""),
        ("Pbr(base_color: Rgb(0.8, 0.5, 0.2), metallic: 0", ", alpha_cutoff: 0.35"),
        ("Lambertian(albedo: Rgb(0.8, 0.5, 0.2)", ", alpha_cutoff: 0.36"),
    ] {
        let sheet = |alpha: &str| scene(&sheets(&format!("{material}{alpha})"), 1, 4, lamp));
        let request = |seed| Request::default().mis().sobol().seed(seed);
        let [opaque, mixed] = ["", &format!(", alpha: 0.35{cutoff}")].map(|alpha| render(&sheet(alpha), &request(1)));
        let share = match cutoff {
            "" => 0.35,
            ", alpha_cutoff: 0.35" => 1.0,
            _ => 0.0,
        };
        let (opaque, mixed) = (opaque.mean_of_all(), mixed.mean_of_all());
        let expected = [0, 1, 2].map(|c| share * opaque.value[c] + (1.0 - share) * (c + 1) as f64);
        let variance = [0, 1, 2].map(|c| mixed.variance[c] + opaque.variance[c]);
        Mean { variance, ..mixed }
            .is_near(expected, MOST_NOISE)
            .unwrap_or_else(|error| panic!("{material}{cutoff}: {error}"));
    }
}

/// A floor under a lamp without size, and horizontal sheets under the lamp. The camera is at this height.
fn shadow(alpha: f64, sheets: usize, height: f64) -> String {
    let sheet = |k: usize| {
        let y = 2.0 + 0.1 * k as f64;
        format!("Quad(corner: (-9, {y}, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"sheet\"),")
    };
    format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, {height}, 1), look_at: (0, 0, 0), vertical_fov: 10),
        background: Solid((0, 0, 0)),
        materials: {{\"sheet\": Lambertian(albedo: Rgb(0, 0, 0), alpha: {alpha}), \"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
        objects: [Quad(corner: (-9, 0, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"floor\"), {}
            PointLight(at: (0, 4, 0), intensity: (10, 10, 10))], render: (samples: 1024, max_depth: 1))",
        (0..sheets).map(sheet).collect::<String>()
    )
}

/// From below the sheets, the floor has lost what shadow rays lose; from above, what rays to it lose, too.
#[test]
fn shadow_rays_pass_as_other_rays_do() {
    let request = Request::default().mis().sobol();
    for (height, sheets, passed) in [(1.0, 1, 1), (1.0, 3, 3), (3.0, 1, 2)] {
        let bare = render(&scene(&shadow(1.0, 0, height)), &request).mean_of_all();
        let mean = |alpha: f64| render(&scene(&shadow(alpha, sheets, height)), &request.clone().seed(5)).mean_of_all();
        let expected = bare.value.map(|lit| 0.7f64.powi(passed) * lit);
        mean(0.3).is_near(expected, MOST_NOISE).unwrap_or_else(|error| panic!("{height}, {sheets}: {error}"));
        assert!(mean(0.31).is_near(expected, MOST_NOISE).is_err(), "{height}, {sheets}: another alpha is not found");
        // A shadow ray draws numbers of its own.
        let line = "begin_walk(path, DIMENSION_LIGHT);";
        let planted = Overlay::new(&[]).rewritten("step/light", |own| own.replace(line, ""));
        let planted = render_planted(&scene(&shadow(0.3, sheets, height)), &request, &planted).mean_of_all();
        assert!(
            height == 1.0 || planted.is_near(expected, MOST_NOISE).is_err(),
            "numbers that are drawn twice are not found"
        );
    }
}

/// A walk draws numbers at the surfaces and panes that it passes, in whatever order it meets them.
#[test]
fn the_bytes_do_not_depend_on_the_hierarchy() {
    for room in [ALPHA_OF_LAMPS.scene(), PANES.scene()] {
        let of = |quality: Quality| {
            render(&room, &Request::spp(16).seed(7).mis().sobol().with(|options| options.build = quality))
        };
        assert!(same(&of(Quality::Medium), &of(Quality::Best)));
    }
}

/// What is passed shows in no channel, and changes no byte: a sheet of alpha 0 before a wall is as no sheet.
#[test]
fn a_sheet_that_lets_all_pass_is_as_none() {
    let wall = "Quad(corner: (-5, -5, -1), u: (10, 0, 0), v: (0, 10, 0), material: \"wall\"),";
    let text = |sheet: &str| {
        format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((1, 2, 3)),
            materials: {{\"wall\": Lambertian(albedo: Rgb(0.8, 0.5, 0.2)), \"sheet\": Pbr(alpha: 0, metallic: 0)}},
            objects: [{wall} {sheet}], render: (samples: 16, max_depth: 4))"
        )
    };
    let sheet = "Quad(corner: (-2, -2, 0), u: (4, 0, 0), v: (0, 4, 0), material: \"sheet\"),";
    for integrator in [Integrator::Bsdf, Integrator::Mis] {
        let list = "albedo,normal,depth,position,object,material,direct,indirect";
        let request = Request::default().with(|options| {
            options.integrator = integrator;
            options.aov.set(Aovs::parse(list).expect("they are names"));
        });
        let [with, without] = [sheet, ""].map(|sheet| render(&scene(&text(sheet)), &request).film);
        for channel in with.aovs().channels() {
            let values = |film: &gpu_rt::film::Film| {
                (0..64).map(|pixel| film.channel(pixel, &channel).to_bits()).collect::<Vec<_>>()
            };
            assert!(values(&with) == values(&without), "{}", channel.name);
        }
        assert!(with.develop().rgb == without.develop().rgb);
    }
}

/// A floor under a lamp without size, and between them an upright and a level sheet of one material, to be seen and to cast shadows.
fn cut_out(folder: &Path, material: &str, width: f64) -> Scene {
    let left = 1.0 - width;
    let text = format!(
        "Scene(image: (width: 32, height: 32), camera: (look_from: (0, 1.5, 4), look_at: (0, 0.4, 0), vertical_fov: 40),
        background: Solid((0.2, 0.3, 0.4)),
        materials: {{\"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"sheet\": {material}}},
        objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
            Quad(corner: ({left}, 0.2, -0.6), u: ({width}, 0, 0), v: (0, 1, 0), material: \"sheet\"),
            Quad(corner: ({left}, 1, 0.8), u: ({width}, 0, 0), v: (0, 0, -1), material: \"sheet\"),
            PointLight(at: (0, 4, 0.5), intensity: (8, 8, 8))], render: (samples: 256, max_depth: 2))"
    );
    scene_in(folder, &text)
}

/// A sheet whose left half is cut out is a sheet of half the width.
#[test]
fn a_cut_out_surface_is_as_geometry() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pixel = |x: u32, _| Rgba([50, 200, 90, if x < 2 { 0 } else { 255 }]);
    RgbaImage::from_fn(4, 1, pixel).save(folder.path().join("half.png")).expect("the image is written");
    let cut = |cutoff: f64| {
        let alpha = format!("alpha: Image(path: \"half.png\", channel: A), alpha_cutoff: {cutoff}");
        cut_out(folder.path(), &format!("Lambertian(albedo: Rgb(0.8, 0.3, 0.2), {alpha})"), 2.0)
    };
    let half = cut_out(folder.path(), "Lambertian(albedo: Rgb(0.8, 0.3, 0.2))", 1.0);
    let request = Request::default().mis();
    let half = render(&half, &request.clone().seed(1));
    let found = same_expectation(&half, &render(&cut(0.5), &request.clone().seed(2)), 1e-4, ALPHA);
    found.unwrap_or_else(|error| panic!("{error}"));
    // The alpha rises from 0 to 1 over a quarter of the width, so that this moves the edge by a tenth of the half.
    let moved = render(&cut(0.3), &request.seed(2));
    assert!(same_expectation(&half, &moved, 1e-4, ALPHA).is_err(), "another edge is not found");
}

/// A texel's alpha is its code over 255, times the factor, and no sRGB code.
#[test]
fn an_image_of_one_alpha_is_as_its_number() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let image = RgbaImage::from_pixel(3, 2, Rgba([255, 0, 7, 102]));
    image.save(folder.path().join("veil.png")).expect("the image is written");
    let of = |alpha: &str| {
        let material = format!("Pbr(base_color: Rgb(0.8, 0.3, 0.2), metallic: 0, alpha: {alpha})");
        render(&cut_out(folder.path(), &material, 2.0), &Request::spp(32).mis().sobol()).picture.rgb
    };
    assert!(of("Image(path: \"veil.png\", channel: A)") == of("0.4"));
    assert!(of("Image(path: \"veil.png\", channel: A, tint: (0.5, 1, 1))") == of("0.2"));
    assert!(of("Image(path: \"veil.png\", channel: B)") != of("0.4"));
}
