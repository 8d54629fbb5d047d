//! Scenes whose image is known: those of scenes/test say themselves what they expect (scenes/test/README.md), and here are those that
//! need a second render, a file, or a ray tracer of their own to say it.
//!
//! Each scene is also given errors that it must find: 1 % of the radiance (`finds`), 10 % in one tile, and what its `fails` lines plant.

mod oracle;

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use crate::common::expect::Expectations;
use crate::common::files::{files, stem};
use crate::common::render::{Request, Shot, render, same_expectation, scene, scene_folder, scene_in};
use crate::common::stats::{sidak, student_two_sided};
use glam::{DMat3, DVec3};
use gpu_rt::data::Sampler;
use gpu_rt::scene::{Camera, Object, Transform};
use image::{DynamicImage, Rgb, Rgb32FImage};
use oracle::*;

/// A test for each scene file, by its name.
macro_rules! scene_tests {
    ($($name:ident)*) => {
        const SCENES: &[&str] = &[$(stringify!($name)),*];

        mod scenes {
            $(#[test] fn $name() { super::test_scene(stringify!($name)); })*
        }
    };
}

scene_tests! {
    camera_corners camera_rolled convex_box convex_quads convex_sphere floor_disk_light floor_quad_light floor_sphere_light fuzz_one fuzz_plane
    fuzz_sphere glass_depths glass_furnace glow_in_sphere gradient_sky lambertian_gradient lamp_in_sphere lamp_in_sphere_depths
    lamp_in_sphere_small lens_far lens_near lens_sharp medium_around_the_camera medium_furnace medium_in_glass medium_in_mesh
    medium_overlap medium_slab medium_sphere mirror_corridor mirror_plane mirror_sphere motion_checker motion_lamp motion_square no_objects one_sided_in_a_box
    one_sided_inside one_sided_quads pane_at_60_degrees rotations smooth_octahedron smooth_square transforms_in_order
}

#[test]
fn every_scene_file_is_tested() {
    let found: Vec<String> = files(scene_folder(), ".ron", false).iter().map(|path| stem(path)).collect();
    assert_eq!(found, SCENES);
}

fn test_scene(name: &str) {
    let text = fs::read_to_string(scene_folder().join(name).with_extension("ron")).expect("the scene is there");
    let expectations = Expectations::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
    for (way, request) in ways() {
        test_way(&format!("{name} by {way}"), &text, &expectations, &request);
    }
}

/// Ways to render all scenes, by name. The seeds are two: quads reach out by the bound of their rounding, and one camera ray of some 5000 in the
/// pixels beside the edge of lens_sharp meets the lamp by that, whichever the sampler is. Neither image has such a one.
fn ways() -> [(&'static str, Request); 2] {
    let plain = Request { seed: 1, ..Request::default() };
    let defaults = Request::default().seed(2).mis().sobol().roulette();
    [("scattered rays alone", plain), ("the program's defaults", defaults)]
}

fn test_way(name: &str, text: &str, expectations: &Expectations, request: &Request) {
    let camera = scene(text).camera;
    let shots = shots(text, expectations, request);
    check(expectations, &shots, &camera).unwrap_or_else(|error| panic!("{name}: {error}"));

    // From here on, errors are planted.
    let finds = |what: &str, shots: &Shots| {
        assert!(check(expectations, shots, &camera).is_err(), "{name} does not find {what}");
    };
    for (depth, shot) in &shots {
        if !expectations.any_light(*depth, shot, &camera) {
            continue;
        }
        for factor in [1.0 - expectations.finds, 1.0 + expectations.finds] {
            let changed = shot.changed(|_, _, rgb| rgb.map(|v| (f64::from(v) * factor) as f32));
            finds(&format!("radiance times {factor} at depth {depth:?}"), &vec![(*depth, changed)]);
        }
        if let Some((left, top)) = expectations.tile(*depth, shot, &camera) {
            let factor = 1.0 + expectations.finds_in_tile;
            let changed = shot.changed(|x, y, rgb| match x / 8 == left / 8 && y / 8 == top / 8 {
                true => rgb.map(|v| (f64::from(v) * factor) as f32),
                false => rgb,
            });
            finds(&format!("a tile times {factor} at depth {depth:?}"), &vec![(*depth, changed)]);
        }
    }
    for flip in &expectations.flips {
        let flipped = shots.iter().map(|(depth, shot)| (*depth, shot.flipped(*flip))).collect();
        finds(&format!("columns and rows flipped: {flip:?}"), &flipped);
    }
    for (old, new) in &expectations.planted {
        // In the scene, not in the comment that announces it.
        let start = text.find("\nScene(").expect("the scene follows the comment");
        let (comment, body) = text.split_at(start);
        assert!(body.contains(old), "{name}: `{old}` is not in the scene");
        let planted = format!("{comment}{}", body.replacen(old, new, 1));
        finds(&format!("`{new}` for `{old}`"), &self::shots(&planted, expectations, request));
    }
}

/// Renders by the depths at which something is expected.
type Shots = Vec<(Option<u32>, Shot)>;

fn shots(text: &str, expectations: &Expectations, request: &Request) -> Shots {
    let scene = scene(text);
    // Sobol points with rays to lights know as much by a fourth of the samples, but for media.
    let samples = match request.options.sampler == Sampler::Sobol && !text.contains("Medium(") {
        true => scene.render.samples.div_ceil(4).max(32),
        false => scene.render.samples,
    };
    let shot =
        |max_depth| (max_depth, render(&scene, &Request { max_depth, samples: Some(0..samples), ..request.clone() }));
    expectations.depths().into_iter().map(shot).collect()
}

fn check(expectations: &Expectations, shots: &Shots, camera: &Camera) -> Result<(), String> {
    shots.iter().try_for_each(|(depth, shot)| expectations.check(*depth, shot, camera))
}

// Textures, against a ray tracer of the tests' own.

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A checker as the scene file writes it and as docs/light-transport.md defines it: the parity of the sum of floor(p / scale).
fn checker(scale: f64, even: [f64; 3], odd: [f64; 3]) -> (String, Colour) {
    let text = format!("Checker(scale: {scale}, even: {}, odd: {})", triple(even), triple(odd));
    let colour = move |hit: &Hit| {
        let cell = (hit.point / scale).floor();
        Some(if (cell.x + cell.y + cell.z).rem_euclid(2.0) == 0.0 { even } else { odd })
    };
    (text, Box::new(colour))
}

fn triple([r, g, b]: [f64; 3]) -> String {
    format!("({r:?}, {g:?}, {b:?})")
}

/// Blocks of an image: `columns` by `rows` of them, row 0 on top, each of 16 x 16 texels of one colour. Nothing within a texel of a
/// block's edge, where the filter decides.
const BLOCK: u32 = 16;

fn block(colours: &[&[[f64; 3]]], u: f64, v: f64) -> Option<[f64; 3]> {
    let (columns, rows) = (colours[0].len() as f64, colours.len() as f64);
    let (across, down) = (u * columns, (1.0 - v) * rows);
    let margin = 1.01 / f64::from(BLOCK);
    let inside = |x: f64| (margin..1.0 - margin).contains(&x.fract());
    (inside(across) && inside(down)).then(|| colours[down as usize][across as usize])
}

fn image_of(colours: &[&[[f64; 3]]]) -> Rgb32FImage {
    let (columns, rows) = (colours[0].len() as u32, colours.len() as u32);
    Rgb32FImage::from_fn(columns * BLOCK, rows * BLOCK, |x, y| {
        Rgb(colours[(y / BLOCK) as usize][(x / BLOCK) as usize].map(|v| v as f32))
    })
}

const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const BLUE: [f64; 3] = [0.0, 0.0, 1.0];
const WHITE: [f64; 3] = [1.0, 1.0, 1.0];
/// Top row, bottom row.
const QUARTERS: &[&[[f64; 3]]] = &[&[RED, GREEN], &[BLUE, WHITE]];

/// A folder with the image of four quarters, its texture and its meaning. 0 and 1 are 0 and 255 in sRGB, exactly.
fn quarters() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let image = DynamicImage::ImageRgb32F(image_of(QUARTERS)).into_rgb8();
    image.save(folder.path().join("quarters.png")).expect("the image is written");
    (folder, "Image(path: \"quarters.png\")".to_owned())
}

fn quarter(hit: &Hit) -> Option<[f64; 3]> {
    block(QUARTERS, hit.uv.0, hit.uv.1)
}

/// Renders the things and compares; then the flipped image, and the image of things moved otherwise, must fail.
fn test_things(folder: &Path, things: &Things, colours: usize) {
    let scene = scene_in(folder, &things.text());
    let shot = render(&scene, &Request { seed: 2, ..Request::default() });
    things.check(&shot, &scene.camera, colours).unwrap_or_else(|error| panic!("{error}\n{}", things.text()));
    for flip in [(true, false), (false, true), (true, true)] {
        assert!(things.check(&shot.flipped(flip), &scene.camera, colours).is_err(), "flipped: {flip:?}");
    }
    for which in 0..things.things.len() {
        let mut other = scene_in(folder, &things.text());
        // The first transform of one thing alone is another.
        let plant = |m: &mut Transform| match m {
            Transform::Scale(factor) => *factor *= 1.2,
            Transform::Translate(by) => *by += 0.2,
            Transform::RotateX(a) | Transform::RotateY(a) | Transform::RotateZ(a) => *a += 12.0,
            Transform::Rotate { degrees, .. } => *degrees += 12.0,
        };
        plant(first_transform(&mut other.objects[which]));
        let planted = render(&other, &Request { seed: 2, ..Request::default() });
        assert!(things.check(&planted, &scene.camera, colours).is_err(), "thing {which} moved");
    }
}

fn first_transform(object: &mut Object) -> &mut Transform {
    let Object::Transformed { by, .. } = object else {
        panic!("things are transformed");
    };
    by.first_mut().expect("things have moves")
}

fn sphere_in_the_middle() -> Shape {
    Shape::Sphere { center: v(0.1, -0.2, 0.3), radius: 1.0 }
}

fn box_in_the_middle() -> Shape {
    Shape::Box { min: v(-0.7, -1.05, -0.62), max: v(0.8, 0.95, 0.73) }
}

/// Not a rectangle.
fn quad_in_the_middle() -> Shape {
    Shape::Quad { corner: v(-1.1, -0.9, 0.17), u: v(2.0, 0.3, 0.0), v: v(0.2, 1.9, 0.0) }
}

#[test]
fn checkers_lie_in_the_objects_own_space() {
    let black = |_| Some([0.0; 3]);
    let thing = |shape, moves: &[Move], scale, even, odd| {
        let (texture, colour) = checker(scale, even, odd);
        Thing { shape, moves: moves.to_vec(), texture, colour }
    };
    let things = Things {
        kind: Kind::Lamps,
        size: (96, 48),
        camera: "look_from: (1, 2, 12), look_at: (0, 0, 0), up: (0.1, 1, 0), vertical_fov: 18".into(),
        background: "Solid((0, 0, 0))".into(),
        sky: Box::new(black),
        things: vec![
            thing(
                quad_in_the_middle(),
                &[Move::X(20.0), Move::Scale(0.8), Move::Y(30.0), Move::Translate(v(-2.3, 0.0, 0.0))],
                0.4,
                [1.0, 2.0, 3.0],
                [0.5, 0.0, 0.25],
            ),
            thing(
                box_in_the_middle(),
                &[Move::Y(35.0), Move::Translate(v(0.0, 0.1, 0.0)), Move::Z(10.0), Move::X(25.0)],
                0.3,
                [4.0, 0.0, 1.0],
                [0.0, 4.0, 1.0],
            ),
            thing(
                sphere_in_the_middle(),
                &[
                    Move::Scale(50.0),
                    Move::Z(40.0),
                    Move::Scale(0.02),
                    Move::Y(-70.0),
                    Move::Translate(v(2.4, 0.2, 0.0)),
                ],
                0.37,
                [3.0, 3.0, 0.0],
                [0.0, 1.0, 2.0],
            ),
        ],
    };
    test_things(&scene_folder(), &things, 7);
}

#[test]
fn images_lie_upright_on_quads_boxes_and_spheres() {
    let (folder, texture) = quarters();
    let thing = |shape, moves: &[Move]| Thing {
        shape,
        moves: moves.to_vec(),
        texture: texture.clone(),
        colour: Box::new(quarter),
    };
    // From above, right and front, and from below, left and behind: all faces of the box, most of the sphere.
    for (from, dark) in [(v(4.0, 5.0, 11.0), 1.0), (v(-4.0, -5.0, -11.0), 0.5)] {
        let right = if from.z > 0.0 { 1.0 } else { -1.0 };
        let things = Things {
            kind: Kind::Lamps,
            size: (96, 48),
            camera: format!(
                "look_from: ({}, {}, {}), look_at: (0, 0, 0), up: (0, 1, 0), vertical_fov: 18",
                from.x, from.y, from.z
            ),
            background: format!("Solid(({dark}, 0.25, 0))"),
            sky: Box::new(move |_| Some([dark, 0.25, 0.0])),
            things: vec![
                thing(quad_in_the_middle(), &[Move::Y(10.0), Move::Translate(v(-2.6 * right, 0.0, 0.0))]),
                thing(box_in_the_middle(), &[Move::Y(5.0), Move::X(0.0), Move::Scale(0.9)]),
                thing(
                    sphere_in_the_middle(),
                    &[Move::Z(15.0), Move::Y(40.0), Move::Translate(v(2.5 * right, 0.0, 0.0))],
                ),
            ],
        };
        test_things(folder.path(), &things, 5);
    }
}

#[test]
fn textured_bodies_under_a_white_sky_show_their_albedo() {
    let (folder, texture) = quarters();
    for shape in [quad_in_the_middle(), box_in_the_middle(), sphere_in_the_middle()] {
        let (checker_texture, checker_colour) = checker(0.45, [0.9, 0.25, 0.125], [0.25, 0.5, 0.75]);
        let image_colour: Colour = Box::new(quarter);
        // The sky's white is a quarter's too.
        for (texture, colour, colours) in [(checker_texture, checker_colour, 3), (texture.clone(), image_colour, 3)] {
            let moves = vec![Move::Scale(0.5), Move::X(-30.0), Move::Y(-50.0), Move::Scale(2.0)];
            let things = Things {
                kind: Kind::Body,
                size: (40, 40),
                camera: "look_from: (0, 0, 8), look_at: (0, 0, 0), vertical_fov: 22".into(),
                background: "Solid((1, 1, 1))".into(),
                sky: Box::new(|_| Some(WHITE)),
                things: vec![Thing { shape, moves, texture, colour }],
            };
            test_things(folder.path(), &things, colours);
        }
    }
}

/// Eight colours around the sky, four above and four below the horizon.
const SKY: &[&[[f64; 3]]] = &[
    &[[0.25, 0.25, 4.0], [0.25, 4.0, 0.25], [0.25, 4.0, 4.0], [4.0, 0.25, 0.25]],
    &[[4.0, 0.25, 4.0], [4.0, 4.0, 0.25], [1.0, 2.0, 4.0], [4.0, 2.0, 1.0]],
];

#[test]
fn image_skies_stand_upright_with_minus_z_in_the_middle() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let image = image_of(SKY);
    image.save(folder.path().join("sky.hdr")).expect("the image is written");
    let sky = |d: DVec3| {
        let u = 0.5 + d.x.atan2(-d.z) / TAU;
        let v = 1.0 - d.y.acos() / PI;
        block(SKY, u, v)
    };
    // The middle: left of -z is the second block from the left, right of it the third, +x is right of the middle.
    assert_eq!(sky(v(-0.1, 0.4, -1.0).normalize()), Some(SKY[0][1]));
    assert_eq!(sky(v(1.0, -0.4, -0.1).normalize()), Some(SKY[1][2]));
    let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_y(2.0);
    let turned =
        format!("Image(path: \"sky.hdr\", by: [RotateY({}), RotateX({})])", 2f64.to_degrees(), 0.3f64.to_degrees());
    let plain = ("Image(path: \"sky.hdr\")", DMat3::IDENTITY);
    for (camera, colours, (background, turn)) in [
        ("look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 110", 4, plain),
        ("look_from: (5, 1, 7), look_at: (3, 1, 8), vertical_fov: 110", 4, plain),
        ("look_from: (0, 0, 0), look_at: (0.1, 1, 0.2), vertical_fov: 100", 4, plain),
        ("look_from: (0, 9, 0), look_at: (0, 8, 0), up: (0, 0.5, -1), vertical_fov: 100", 4, plain),
        ("look_from: (5, 1, 7), look_at: (3, 1, 8), vertical_fov: 110", 4, (&*turned, turn)),
        // Pixels so narrow that kernels have the camera's axes.
        ("look_from: (0, 0, 0), look_at: (0, -0.3, 0.01), up: (0, 0, 1), vertical_fov: 1e-5", 1, (&*turned, turn)),
    ] {
        let things = Things {
            kind: Kind::Lamps,
            size: (48, 32),
            camera: camera.into(),
            background: background.into(),
            sky: Box::new(move |direction| sky(turn.transpose() * direction)),
            // Far below, out of all views but the last, where it is one more colour.
            things: vec![Thing {
                shape: Shape::Sphere { center: v(0.0, -90.0, 0.0), radius: 9.0 },
                moves: vec![Move::Translate(v(0.0, 0.0, 0.0))],
                texture: "Rgb(7, 7, 7)".into(),
                colour: Box::new(|_| Some([7.0; 3])),
            }],
        };
        let scene = scene_in(folder.path(), &things.text());
        let shot = render(&scene, &Request { seed: 3, ..Request::default() });
        things.check(&shot, &scene.camera, colours).unwrap_or_else(|error| panic!("{camera}: {error}"));
        for flip in [(true, false), (false, true), (true, true)] {
            let is_found = things.check(&shot.flipped(flip), &scene.camera, colours).is_err();
            assert!(is_found || colours == 1, "{camera}: {flip:?}");
        }
    }
}

// Index 1.

/// A room with an inner light, and whatever else.
fn room(ior: f64, objects: &str) -> String {
    format!(
        "Scene(image: (width: 32, height: 32),
            camera: (look_from: (0, 1, 4), look_at: (0, 0.8, 0), vertical_fov: 40),
            background: Gradient(bottom: (0.2, 0.2, 0.2), top: (1, 1.5, 2)),
            materials: {{
                \"ball\": Dielectric(ior: {ior:?}),
                \"floor\": Lambertian(albedo: Checker(scale: 0.5, even: (0.8, 0.3, 0.2), odd: (0.1, 0.6, 0.7))),
                \"block\": Lambertian(albedo: Rgb(0.7, 0.6, 0.1)),
            }},
            objects: [
                Quad(corner: (-5, 0, 5), u: (10, 0, 0), v: (0, 0, -10), material: \"floor\"),
                Box(min: (-1.5, 0, -2), max: (0.3, 1.2, -1.2), material: \"block\"),
                {objects}
            ],
            render: (samples: 256))"
    )
}

#[test]
fn index_one_is_invisible() {
    // Before a sky, to the bit: the ray leaves the ball with the direction that it came with.
    let sky = |ball: &str| {
        scene(&format!(
            "Scene(image: (width: 32, height: 32),
                camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 40),
                background: Gradient(bottom: (1, 0.5, 0), top: (0, 1, 2)),
                materials: {{ \"ball\": Dielectric(ior: 1) }},
                objects: [Sphere(center: (0, 0, {ball}), radius: 1, material: \"ball\"),
                          Box(min: (-1.2, -1.2, {ball}), max: (-0.5, -0.7, {ball}.5), material: \"ball\")])"
        ))
    };
    let request = Request::spp(32).seed(4);
    let (with, without) = (render(&sky("0"), &request), render(&sky("9"), &request));
    assert!(with.picture.rgb == without.picture.rgb, "the ball shows before the sky");

    // In a room, within noise, as the path's random numbers are others after two more events. Deviations of pixels are some 50 % a
    // sample: the mean of 32 x 32 x 256 has a standard error of 0.1 %, a tile's 0.4 %, so that an index of 1.1 is found by far.
    let ball = "Sphere(center: (0.3, 0.9, 0.5), radius: 0.8, material: \"ball\"),";
    let request = |seed| Request::spp(256).seed(seed).depth(52);
    let empty = render(&scene(&room(1.0, "")), &request(5));
    let with = render(&scene(&room(1.0, ball)), &request(6));
    same_expectation(&with, &empty, 1e-6, 1e-6).expect("a ball of index 1 is invisible");
    let with = render(&scene(&room(1.1, ball)), &request(6));
    assert!(same_expectation(&with, &empty, 1e-6, 1e-6).is_err(), "a ball of index 1.1 is visible");
}

// A small lamp, which scattered rays hardly meet.

/// A lamp of r/R = 0.01 in the middle of a hollow sphere, as in scenes/test/lamp_in_sphere: f = 1e-4 of the light that a wall sends is met
/// by chance, and rays to the lamp carry all of it from each of the events, a dozen of them for red. 1e5 samples know the mean to some 0.1 %.
/// Planted is 1 % of the light.
#[test]
fn a_small_lamp_lights_a_hollow_sphere() {
    let f = 1e-4;
    let scene = scene(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0.2, 0, 0.7), look_at: (0.3, 0.2, 1), vertical_fov: 60),
    background: Solid((0, 0, 0)),
    materials: { \"lamp\": DiffuseLight(emit: Rgb(1e4, 1e4, 1e4)), \"wall\": Lambertian(albedo: Rgb(0.9, 0.75, 0.5)) },
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"wall\"), Sphere(center: (0, 0, 0), radius: 0.01, material: \"lamp\")],
    render: (samples: 512, max_depth: 400),
)",
    );
    let shot = render(&scene, &Request::default().seed(3).mis().sobol().roulette());
    let found = shot.mean_of_all();
    let p = |factor: f64, c: usize| {
        let a = [0.9, 0.75, 0.5][c];
        let expected = a * f * 1e4 / (1.0 - a * (1.0 - f));
        let t = (factor * found.value[c] - expected) / found.variance[c].sqrt();
        println!("channel {c}: {} times {factor}, expected {expected}, t = {t:.2}", found.value[c]);
        student_two_sided(t, found.degrees[c])
    };
    let threshold = sidak(1e-6, 3);
    assert!((0..3).all(|c| p(1.0, c) >= threshold));
    assert!([0.99, 1.01].iter().all(|&factor| (0..3).any(|c| p(factor, c) < threshold)), "1 % is not found");
}

// The comparators' own controls.

#[test]
fn expectations_that_make_no_sense_are_refused() {
    for comment in [
        "",
        "// expects: nothing",
        "// expect: mean = (1, 1) within noise",
        "// expect: mean = (1, 1, 1)",
        "// expect: mean in (3, 0, 1, 1) = (1, 1, 1) within noise",
        "// expect: pixel = (1, 1, 1) within noise",
        "// expect: pixel (1, 2, 3, 4) = (1, 1, 1) within noise",
        "// expect: all = (1, 1, 1) within noise",
        "// expect: mean = (1 +, 1, 1) within noise",
        "// expect: mean = (1, 1, 1) within reason",
        "// expect at noon: mean = (1, 1, 1) within noise",
        "// let x\n// expect: mean = (1, 1, 1) within noise",
        "// fails: something\n// expect: mean = (1, 1, 1) within noise",
        "// finds: much\n// expect: mean = (1, 1, 1) within noise",
    ] {
        assert!(Expectations::parse(comment).is_err(), "{comment}");
    }
}
