//! Motion while the shutter is open. The host knows the pose of everything at a time in f64; the device finds it for each sample in f32.
//!
//! Kernels in which each sample has the same time render what the host places there, but for rounding: that compares all that moves, shapes, lights,
//! media, textures and the camera, with the same random numbers. Images that are known in closed form are scenes/test/motion_*.ron.

use glam::DVec3;
use gpu_rt::options::Scatter;
use gpu_rt::scene::{CameraKey, Object, Scene, Transform};

use crate::common::everything::{Everything, World, same};
use crate::common::faults::{agree, changed, differ};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_each, render_planted, scene, scene_in};

fn translate(x: f64, y: f64, z: f64) -> Transform {
    Transform::Translate(DVec3::new(x, y, z))
}

/// Keys of all kinds of transforms: with a jump, with a key inside the shutter, and with turns by the shortest arc.
fn keys() -> Vec<(f64, Vec<Transform>)> {
    let turn = |x: f64, degrees: f64| Transform::Rotate { axis: DVec3::new(x, 1.0, 0.3), degrees };
    let key = |time: f64, scale: f64, degrees: f64, turn: Transform, x: f64| {
        let by = vec![Transform::Scale(scale), Transform::RotateY(degrees), turn, translate(x, 0.1 * x, -0.3 * x)];
        (time, by)
    };
    vec![
        key(-3.0, 0.9, 0.0, turn(0.0, 0.0), 0.0),
        key(10.1, 0.95, 5.0, turn(0.2, 3.0), 0.05),
        key(10.4, 1.0, -3.0, turn(-0.5, 7.0), 0.1),
        key(10.4, 1.02, 4.0, turn(0.4, 2.0), -0.05),
        key(12.0, 1.05, 60.0, turn(1.0, 30.0), 0.4),
    ]
}

/// Lights without size, which the scene with everything lacks.
const LIGHTS: &str = "PointLight(at: (1, 2.5, 1.5), intensity: (2, 2.5, 3)),
    SpotLight(at: (-1, 2.8, 1), towards: (0.2, 0.3, 0.4), intensity: (6, 5, 4), inner: 10, outer: 35),
    DirectionalLight(direction: (1, -2, -1), irradiance: (0.4, 0.3, 0.5)),";

/// All of a scene moves: within a group that moves, and that is turned.
fn moving(scene: &Scene, files: &Everything, shutter: (f64, f64)) -> Scene {
    let lights = scene_in(
        files.folder(),
        &format!(
            "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vertical_fov: 40),
         background: Solid((0, 0, 0)), objects: [{LIGHTS}])"
        ),
    );
    let inner = Object::Moving {
        keys: vec![(10.0, vec![translate(0.0, 0.0, 0.0)]), (11.0, vec![translate(-0.2, 0.1, 0.15)])],
        object: Box::new(Object::Group([scene.objects.as_slice(), &lights.objects].concat())),
    };
    let turned =
        Object::Transformed { by: vec![Transform::RotateX(7.0)], object: Box::new(Object::Group(vec![inner])) };
    let mut all = scene.clone();
    all.objects = vec![Object::Moving { keys: keys(), object: Box::new(turned) }];
    all.camera.shutter = shutter;
    let key = |shift: DVec3| CameraKey { look_from: all.camera.look_from + shift, look_at: all.camera.look_at - shift };
    all.camera.moving = vec![(9.9, key(DVec3::ZERO)), (11.3, key(DVec3::new(0.2, -0.1, 0.3)))];
    all
}

/// When the shutter of these tests is open.
const SHUTTER: (f64, f64) = (10.0, 11.0);

fn request() -> Request {
    Request::spp(16).mis().sobol()
}

/// Kernels in which all samples have this share of the shutter's time.
fn at_time(share: f64) -> Overlay {
    Overlay::new(&[]).rewritten("motion/time", |text| {
        let random = "random4((*path).pixel, (*path).sample, DIMENSION_TIME, settings.seed).x";
        text.replace(random, &format!("f32({share:?})"))
    })
}

/// The share of the pixels' channels that differ by more than a thousandth.
fn differing(a: &Shot, b: &Shot) -> f64 {
    let pairs = || a.picture.rgb.as_flattened().iter().zip(b.picture.rgb.as_flattened());
    let count = pairs().filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs().max(b.abs())).count();
    count as f64 / pairs().count() as f64
}

/// What rounding may do: an event whose choice lies within 1e-5 of another one goes another way. Of 16 paths of some 10 events with three choices
/// each, one in 200 does so, and a pixel is then another one.
const OTHER_WAYS: f64 = 0.05;

/// Everything moves, the camera too, and is found by scattered rays alone: which of several lights is chosen depends on the boxes of their ways.
#[test]
fn poses_are_those_of_stills() {
    let files = Everything::new();
    let scene = files.scene(World::default());
    let moving = |shutter| {
        let mut all = moving(&scene, &files, shutter);
        remove_lights(&mut all.objects);
        all
    };
    for (share, scatter) in [(0.37, Scatter::Linked), (0.81, Scatter::Fused)] {
        let time = SHUTTER.0 + share * (SHUTTER.1 - SHUTTER.0);
        let request = Request::spp(16).sobol().scatter(scatter);
        let still = render(&moving((time, time)), &request);
        let posed = render_planted(&moving(SHUTTER), &request, &at_time(share));
        let found = differing(&still, &posed);
        assert!(found < OTHER_WAYS, "{scatter:?} at {share}: {found} of the pixels differ");
        // A hundredth of the time makes another image.
        let opened_later = (SHUTTER.0 + 0.01, SHUTTER.1 + 0.01);
        let later = render_planted(&moving(opened_later), &request, &at_time(share));
        let found = differing(&still, &later);
        assert!(found > 0.5, "{scatter:?}: a hundredth of the time changes {found} of the pixels");
    }
}

/// Removes the lights without size.
fn remove_lights(objects: &mut Vec<Object>) {
    objects.retain(|object| object.delta_light().is_none());
    for object in objects {
        let mut inside = object;
        while let Object::Moving { object, .. } | Object::Transformed { object, .. } = inside {
            inside = object;
        }
        if let Object::Group(inner) = inside {
            remove_lights(inner);
        }
    }
}

/// One light above a floor and a glass ball, as it moves.
fn under(light: &str, shutter: (f64, f64)) -> Scene {
    let text = format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 3, 4), look_at: (0, 0.4, 0), vertical_fov: 40, shutter: {shutter:?}),
    background: Solid((0.1, 0.1, 0.1)),
    materials: {{
        \"floor\": Lambertian(albedo: Rgb(0.8, 0.7, 0.6)),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Checker(scale: 0.3, even: (8, 6, 4), odd: (4, 6, 8))),
    }},
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
        Sphere(center: (0.4, 0.6, 0), radius: 0.5, material: \"glass\"),
        Moving(keys: [(10, [RotateX(0), RotateZ(10), Translate((0, 1.8, 0))]), (11, [RotateX(25), RotateZ(-30), Translate((-0.8, 2.2, 0.3))])],
            object: {light}),
    ],
)"
    );
    scene(&text)
}

/// Each kind of light by itself (a texture of one luminance is not cut into several): its directions, its density, and what it emits; and the light paths that start at it.
#[test]
fn lights_are_where_those_of_stills_are() {
    let lights = [
        "Sphere(center: (0.1, 0, 0), radius: 0.3, material: \"lamp\")",
        "Quad(corner: (-0.5, 0, -0.5), u: (1, 0, 0), v: (0, 0, 1), material: \"lamp\")",
        "Disk(center: (0.1, 0, 0), normal: (0.1, -1, 0), radius: 0.4, material: \"lamp\")",
        "Box(min: (-0.3, -0.2, -0.4), max: (0.3, 0.1, 0.2), material: \"lamp\")",
        "PointLight(at: (0.2, 0, 0), intensity: (5, 6, 7))",
        "SpotLight(at: (0, 0, 0), towards: (0, -1, 0.2), intensity: (16, 15, 14), inner: 20, outer: 45)",
        "DirectionalLight(direction: (0.3, -1, 0.2), irradiance: (1, 2, 3))",
    ];
    let share = 0.6;
    let time = SHUTTER.0 + share;
    for (light, light_paths) in lights.into_iter().zip([8, 0, 0, 0, 8, 0, 8]) {
        let request = request().light_paths(light_paths);
        let (still, moving) = (under(light, (time, time)), under(light, SHUTTER));
        let still = render(&still, &request);
        let found = differing(&still, &render_planted(&moving, &request, &at_time(share)));
        assert!(found < OTHER_WAYS, "{light}: {found} of the pixels differ");
        let opened_later = under(light, (SHUTTER.0 + 0.02, SHUTTER.1 + 0.02));
        let later = differing(&still, &render_planted(&opened_later, &request, &at_time(share)));
        assert!(later > 0.3, "{light}: a fiftieth of the time changes {later} of the pixels");
        if light_paths > 0 {
            let library = at_time(share)
                .rewritten("light_path/light_sample", |text| text.replace("begin_time(path);", "now = 0.0;"))
                .rewritten("stage/light_path", |text| text.replace("begin_time(&path);", "now = 0.0;"));
            let found = differing(&still, &render_planted(&moving, &request, &library));
            assert!(found > 0.1, "{light}: light paths of another time change {found} of the pixels");
        }
    }
}

/// Before the first key, an object has the pose of that key: a shutter that is open for no time has the bytes of the scene with that pose.
#[test]
fn a_shutter_that_is_open_for_no_time_changes_no_byte() {
    let files = Everything::new();
    let scene = files.scene(World::default());
    let mut moving = scene.clone();
    moving.objects = vec![Object::Moving { keys: keys(), object: Box::new(Object::Group(scene.objects.clone())) }];
    let mut still = scene.clone();
    still.objects =
        vec![Object::Transformed { by: keys().remove(0).1, object: Box::new(Object::Group(scene.objects)) }];
    for seconds in [-7.0, -3.0] {
        moving.camera.shutter = (seconds, seconds);
        assert!(same(&render(&still, &request()), &render(&moving, &request())), "at {seconds} s");
    }
    moving.camera.shutter = (-2.0, -2.0);
    assert!(!same(&render(&still, &request()), &render(&moving, &request())), "it has moved");
}

/// Nor do keys that do not differ, and an open shutter where nothing moves.
#[test]
fn what_rests_changes_no_byte() {
    let files = Everything::new();
    let scene = files.scene(World::default());
    let usual = render(&scene, &request());
    let mut resting = scene.clone();
    let key = vec![Transform::RotateX(0.0), translate(0.0, 0.0, 0.0)];
    resting.objects = vec![Object::Moving {
        keys: vec![(0.0, key.clone()), (0.5, key.clone()), (1.0, key)],
        object: Box::new(Object::Group(scene.objects)),
    }];
    resting.camera.shutter = (0.0, 1.0);
    assert!(same(&usual, &render(&resting, &request())));
}

/// The room, whose kernels compile sooner than those of the scene with everything in it. (Cuts of moving scenes are in tests/unchanged.rs.)
#[test]
fn parts_of_moving_scenes_join_to_the_whole() {
    let mut scene = scene(&room());
    let mut parts = render_each(&scene, &request(), &[0..16, 8..16, 0..8]);
    let whole = parts.remove(0);
    let first = parts.remove(1);
    parts[0].film.merge(&first.film).expect("parts of one image");
    assert!(parts[0].film == whole.film);
    scene.camera.shutter = (0.5, 0.5);
    assert!(!same(&whole, &render(&scene, &request())), "nothing moves");
}

/// A room in which all lamps move: a sphere, a quad that turns, a disk, a box and a mesh. So do what blocks their light, and fog.
fn room() -> String {
    "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 1, 3.4), look_at: (0, 0.9, 0), vertical_fov: 40, shutter: (0, 1)),
    background: Solid((0.1, 0.1, 0.1)),
    materials: {
        \"wall\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)),
        \"lamp\": DiffuseLight(emit: Rgb(3, 4, 2), two_sided: true),
        \"one\": DiffuseLight(emit: Rgb(4, 3, 3)),
    },
    objects: [
        Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"wall\"),
        Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
        Moving(keys: [(0, [Translate((-0.6, 0.4, 0))]), (0.5, [Translate((-0.2, 0.5, 0.3))]), (1, [Translate((-0.5, 1.3, 0))])],
            object: Sphere(center: (0, 0, 0), radius: 0.3, material: \"one\")),
        Moving(keys: [(0, [Translate((-0.9, 0.2, 0.2))]), (1, [Translate((0.6, 0.2, 0.2))])],
            object: Box(min: (-0.25, 0, -0.25), max: (0.25, 0.5, 0.25), material: \"wall\")),
        Moving(keys: [(0, [RotateX(0), Translate((0.5, 1.5, 0))]), (1, [RotateX(150), Translate((0.5, 1.5, 0))])],
            object: Quad(corner: (-0.3, 0, -0.3), u: (0.6, 0, 0), v: (0, 0, 0.6), material: \"one\")),
        Moving(keys: [(0, [Scale(0.5), RotateZ(0), Translate((0.6, 0.5, 0.2))]), (1, [Scale(1), RotateZ(300), Translate((0.6, 0.6, 0.2))])],
            object: Group([
                Disk(center: (0, 0.2, 0), normal: (1, 1, 0), radius: 0.3, material: \"one\"),
                Box(min: (-0.2, -0.3, -0.1), max: (0.1, -0.1, 0.2), material: \"lamp\"),
            ])),
        Moving(keys: [(0, [RotateY(0), Translate((0, 1.7, -0.4))]), (1, [RotateY(90), Translate((0, 1.4, -0.4))])],
            object: Transformed(by: [Scale(0.2)], object: Mesh(path: \"smooth_octahedron.obj\", material: \"one\"))),
        Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0.5, 0.2, 0))])],
            object: Medium(boundary: Box(min: (-0.9, 0.1, -0.8), max: (0.2, 0.8, 0.8)), density: 0.7, albedo: Rgb(0.8, 0.8, 0.9))),
    ],
    render: (samples: 2048, max_depth: 4),
)"
    .to_owned()
}

const PASSING: &str = "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 3, 3), look_at: (0, 0, 0), vertical_fov: 50, shutter: (0, 1)),
    background: Solid((0, 0, 0)),
    materials: {
        \"floor\": Lambertian(albedo: Rgb(0.8, 0.8, 0.8)),
        \"lamp\": DiffuseLight(emit: Rgb(4, 4, 4)),
    },
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
        Moving(keys: [(0, [Translate((-2, 1, 0))]), (1, [Translate((2, 1, 0))])],
            object: Sphere(center: (0, 0, 0), radius: 0.7, material: \"lamp\")),
        Moving(keys: [(0, [Translate((1.5, 0, 0.8))]), (1, [Translate((-1.5, 0, 0.8))])],
            object: Box(min: (-0.5, 0, -0.1), max: (0.5, 0.8, 0.1), material: \"floor\")),
    ],
    render: (samples: 2048, max_depth: 3),
)";

#[test]
fn ways_to_find_moving_lamps_have_one_expectation() {
    // Of one kernel: the errors below are planted in its stages.
    let by_lights = Request::default().mis().sobol().roulette().seed(1).scatter(Scatter::Fused);
    let same = |scene: &Scene| {
        let by_rays = render(scene, &Request::default());
        agree("light sampling", &by_rays, &render(scene, &by_lights), 1e-5);
        by_rays
    };
    same(&scene(&room()));
    // Errors are planted where nothing hides them: a large lamp and a wall that pass each other.
    let passing = scene(PASSING);
    let by_rays = same(&passing);
    let later = "fn later_hit(path: ptr<function, Path>, limit: Hit) -> Hit {\n now = fract(now + 0.4);\n \
                 return shadow_hit(path, limit);\n}\n\n//@ without";
    for changes in [
        // The density of a lamp where it was when the shutter opened.
        [(
            "scene/lights",
            "direction, moved_${name}(${name}_at(of_kind, instance), pose)",
            "direction, ${name}_at(of_kind, instance)",
        )]
        .as_slice(),
        // A direction to it there.
        &[(
            "scene/lights",
            "from_point, moved_${name}(${name}_at(index, light.instance), pose)",
            "from_point, ${name}_at(index, light.instance)",
        )],
        // A shadow ray at another time.
        &[
            ("step/light", "let hit = shadow_hit(path, limit);", "let hit = later_hit(path, limit);"),
            ("step/light", "//@ without", later),
        ],
    ] {
        differ(changes[0].2, &by_rays, &render_planted(&passing, &by_lights, &changed(changes)), 1e-5);
    }
}

/// A caustic of a glass ball and a lamp that move in opposite directions, with light paths and without. (Errors of their time are planted in
/// `lights_are_where_those_of_stills_are`.)
#[test]
fn light_paths_change_no_expectation_of_what_moves() {
    let text = "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 3, 0.01), look_at: (0, 0, 0), vertical_fov: 50, shutter: (0, 1)),
    background: Solid((0, 0, 0)),
    materials: {
        \"floor\": Lambertian(albedo: Rgb(0.8, 0.8, 0.8)),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(25, 25, 25)),
    },
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
        Moving(keys: [(0, [Translate((-0.5, 0.7, 0))]), (1, [Translate((0.5, 0.7, 0))])],
            object: Sphere(center: (0, 0, 0), radius: 0.5, material: \"glass\")),
        Moving(keys: [(0, [Translate((1, 4, 0))]), (1, [Translate((-1, 4, 0))])],
            object: Sphere(center: (0, 0, 0), radius: 0.3, material: \"lamp\")),
    ],
    render: (samples: 4096, max_depth: 6),
)";
    let scene = scene(text);
    let camera_paths = render(&scene, &Request::default().mis().seed(2));
    let both = Request::default().mis().light_paths(8);
    agree("light paths", &camera_paths, &render(&scene, &both), 1e-5);
}

/// A scene at the origin, and the same far away. Positions there are known to 1e8 × 2^-53 = 1.1e-8 of its extent of some units, which is less than
/// half a rounding of f32.
#[test]
fn far_from_the_origin_motion_is_as_near_to_it() {
    let files = Everything::new();
    let scene = files.scene(World::default());
    let placed = |shift: DVec3| {
        let mut placed = scene.clone();
        let inner = Object::Moving { keys: keys(), object: Box::new(Object::Group(scene.objects.clone())) };
        placed.objects = vec![Object::Transformed { by: vec![Transform::Translate(shift)], object: Box::new(inner) }];
        placed.camera.look_from += shift;
        placed.camera.look_at += shift;
        placed.camera.shutter = SHUTTER;
        let key = |by: DVec3| CameraKey { look_from: placed.camera.look_from + by, look_at: placed.camera.look_at };
        placed.camera.moving = vec![(10.0, key(DVec3::ZERO)), (11.0, key(DVec3::new(0.1, 0.1, -0.1)))];
        render(&placed, &request())
    };
    let (near, far) = (placed(DVec3::ZERO), placed(DVec3::new(1e8, -3e7, 5e7)));
    let found = differing(&near, &far);
    assert!(found < OTHER_WAYS, "{found} of the pixels differ");
}

/// Within 1e-12 s, a motion of some units a second is none.
#[test]
fn a_very_short_shutter_shows_a_still() {
    let files = Everything::new();
    let scene = files.scene(World::default());
    let [short, still] =
        [(11.0, 11.0 + 2e-12), (11.0, 11.0)].map(|shutter| render(&moving(&scene, &files, shutter), &request()));
    let found = differing(&short, &still);
    assert!(found < OTHER_WAYS, "{found} of the pixels differ");
}
