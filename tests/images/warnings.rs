//! Warnings about numbers that are allowed and dangerous: each at its location, with the number and what to do, and none
//! for a twin scene just on the other side of its limit. The limits of surfaces near glass are compared with pictures.

use crate::common::files::files;
use crate::common::marked::{fault, unmarked};
use crate::common::{render, stats};
use std::fs;
use std::path::Path;

use gpu_rt::flatten::flatten;
use gpu_rt::options::RenderOptions;
use gpu_rt::scene::Scene;

/// A camera 5 units before the origin, one above it, and a telescope from far away.
const BEFORE: &str = "(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40)";
const ABOVE: &str = "(look_from: (0, 1, 5), look_at: (0, 0, 0), vertical_fov: 40)";
const FAR: &str = "(look_from: (0, 0, 1e7), look_at: (0, 0, 0), vertical_fov: 40)";
const TELESCOPE: &str = "(look_from: (0, 0, 1e7), look_at: (0, 0, 0), vertical_fov: 2e-5)";

const BALL: &str = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\"),";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scene of such objects, with materials of every kind.
fn scene(camera: &str, objects: &str) -> String {
    format!(
        "Scene(
    image: (width: 400, height: 300),
    camera: {camera},
    background: Solid((1, 1, 1)),
    materials: {{
        \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"steel\": Metal(albedo: Rgb(0.5, 0.5, 0.5)),
        \"glass\": Dielectric(ior: 1.5), \"lamp\": DiffuseLight(emit: Rgb(15, 15, 15)),
        \"spot\": DiffuseLight(emit: Rgb(15, 15, 15), two_sided: false),
        \"clear\": Dielectric(ior: 1), \"water\": Dielectric(ior: 1.33),
    }},
    objects: [
        {objects}
    ],
)
"
    )
}

fn parse(text: &str) -> Scene {
    Scene::parse(&unmarked(text), &root().join("x.ron")).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// What flattening says of a text, marks and all.
fn warnings(text: &str) -> Vec<String> {
    let scene = parse(text);
    let size = (scene.image.width, scene.image.height);
    flatten(&scene, size, &RenderOptions::default()).unwrap_or_else(|e| panic!("{e}")).warnings
}

/// Flattening says one thing of a text.
fn warns(text: &str, field: &str, words: &[&str]) {
    is_one(&warnings(text), text, field, words);
}

/// There is one warning about a marked text, there, about this field, in these words.
fn is_one(found: &[String], text: &str, field: &str, words: &[&str]) {
    let [warning] = found else { panic!("expected one warning: {found:#?}\n{text}") };
    fault(warning, &root().join("x.ron"), text, field, words).unwrap_or_else(|fault| panic!("{fault}"));
}

fn silent(text: &str) {
    assert_eq!(warnings(text), Vec::<String>::new(), "{text}");
}

#[test]
fn features_below_the_rounding_of_their_position_are_warned_of() {
    // Each along its own direction, in which the camera is near or far.
    let cuboid = |max: &str| scene(BEFORE, &format!("§Box(min: (0, 0, 0), max: {max}, material: \"grey\"),"));
    warns(
        &cuboid("(1, 1, 2.3e-6)"),
        "objects[0].Box",
        &["a side of 2.3e-6 at a distance of 5", "no size below 2.384e-6", "bring it nearer"],
    );
    silent(&cuboid("(1, 1, 2.4e-6)"));
    silent(&cuboid("(2.3e-6, 1, 1)"));
    let quad = |u: &str| {
        scene(BEFORE, &format!("Quad(corner: (1, 0, 0), u: (0, 1, 0), v: §({u}, 0, 0), material: \"grey\"),"))
    };
    warns(&quad("4.7e-7"), "objects[0].Quad.v", &["an edge of 4.7e-7", "no size below 4.768e-7"]);
    silent(&quad("4.8e-7"));
    let mesh = |scale: &str| {
        let mesh = "§Mesh(path: \"scenes/meshes/star.ply\", material: \"grey\")";
        scene(BEFORE, &format!("Transformed(by: [Scale({scale})], object: {mesh}),"))
    };
    warns(&mesh("1e-7"), "objects[0].Transformed.object.Mesh", &["a size of", "at a distance of 5"]);
    silent(&mesh("1e-5"));
}

#[test]
fn spheres_whose_outline_is_rounded_are_warned_of() {
    let sphere = |r: &str| format!("Sphere(center: (0, 0, 0), radius: §{r}, material: \"grey\"),");
    let words = ["a radius of 4.9e-5 at a distance of 5", "no size below 5e-5"];
    warns(&scene(BEFORE, &sphere("4.9e-5")), "objects[0].Sphere.radius", &words);
    silent(&scene(BEFORE, &sphere("5.1e-5")));
    // By the distance, whatever the direction, and on the axis of a narrow view by nothing.
    let aside = "(look_from: (30, 40, 120), look_at: (0, 0, 0), vertical_fov: 40)";
    let words = ["at a distance of 130", "no size below 0.0013"];
    warns(&scene(aside, &sphere("0.00128")), "objects[0].Sphere.radius", &words);
    silent(&scene(aside, &sphere("0.00132")));
    silent(&scene(&aside.replace("40)", "1e-4)"), &sphere("0.00128")));
}

#[test]
fn no_sphere_with_the_camera_near_its_surface_is_warned_of() {
    let ground = |r: &str| {
        let sphere = format!("Sphere(center: (0, -{r}, 0), radius: §{r}, material: \"grey\"),");
        scene("(look_from: (0, 1, 0), look_at: (0, 2, 1), vertical_fov: 40)", &sphere)
    };
    for r in ["1e3", "42000", "4.2e6", "1e12"] {
        let above = ground(r);
        silent(&above);
        // From within one that shines: another one would be a dark room.
        let inside = above.replace("(0, 1, 0)", "(0, -1, 0)").replace("(0, 2, 1)", "(0, -2, 1)");
        silent(&inside.replace("material: \"grey\"", "material: \"lamp\""));
    }
    silent(&ground("1").replace("(0, 1, 0)", "(0, 0, 0)"));
}

#[test]
fn huge_objects_do_not_hide_warnings_about_near_ones() {
    let ground = "Sphere(center: (0, -1e9, 0), radius: 1e9, material: \"grey\"),";
    let above = "(look_from: (0, 1, 0), look_at: (0, 0, 1), vertical_fov: 40)";
    // Neither the ground nor its fog set the scene's extent: 2^-40 of 1e9 is 1e-3.
    let fog = "Medium(boundary: Sphere(center: (0, 1e9, 0), radius: 1e9), density: 0.1, albedo: Rgb(0.5, 0.5, 0.5)),";
    let small = "Sphere(center: (0, 1e-4, 0), radius: 1e-4, material: \"grey\"),";
    silent(&scene(above, &format!("{ground}{fog}{small}")));
    // Two grounds with the same numbers coincide, and a millimetre apart they do not.
    let other = "§Sphere(center: (0, -1e9, 0), radius: 1e9, material: \"spot\"),";
    warns(
        &scene(above, &format!("{ground}{other}")),
        "objects[1].Sphere",
        &["it touches the sphere at", "coincides with it"],
    );
    silent(&scene(above, &format!("{ground}{}", other.replace("radius: 1e9", "radius: 1000000000.001"))));
    let clear = other.replace("spot", "clear");
    warns(
        &scene(above, &format!("{ground}{clear}")),
        "objects[1].Sphere",
        &["rays that leave one of the two start behind the other"],
    );
    // A lamp in the ground that faces up has something before it.
    let lamp = "Quad(corner: (-1, -0.5, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"lamp\"),";
    silent(&scene(above, &format!("{}{lamp}", ground.replace("grey", "clear"))));
}

#[test]
fn a_telescope_keeps_what_lies_across_the_view() {
    let sphere = |material: &str| format!("Sphere(center: (0, 0, 0), radius: §1, material: \"{material}\"),");
    let words = ["a radius of 1 at a distance of 1e7", "no size below 100"];
    warns(&scene(FAR, &sphere("grey")), "objects[0].Sphere.radius", &words);
    silent(&scene(TELESCOPE, &sphere("grey")));
    // Rays through it cross it in depth.
    warns(&scene(TELESCOPE, &sphere("glass")), "objects[0].Sphere.radius", &words);
    let aside = "Sphere(center: (3e6, 0, 0), radius: §1, material: \"grey\"),";
    warns(&scene(TELESCOPE, aside), "objects[0].Sphere.radius", &["no size below 30"]);
}

#[test]
fn warnings_stand_at_the_innermost_object() {
    let inner = "Sphere(center: (0, 0, 0), radius: §1e-6, material: \"grey\")";
    let ball = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")";
    let fog = "Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1))";
    let nothing = fog.replace("density: 1", "density: 0");
    let group = format!("{ball}, {fog}, {nothing},\n Transformed(by: [Scale(2)], object: Group([{ball}, {inner}])),");
    let field = "objects[3].Transformed.object.Group[1].Sphere.radius";
    warns(&scene(BEFORE, &group), field, &["a radius of 2e-6"]);
    let boundary = fog.replace("Sphere(center: (0, 0, 0), radius: 1)", "§Sphere(center: (0, 0, 0), radius: 1e-6)");
    warns(&scene(BEFORE, &format!("{ball}, {nothing}, {boundary}")), "objects[2].Medium.boundary", &["of 1e-6"]);
}

#[test]
fn of_a_kind_the_worst_is_reported_and_the_others_are_counted() {
    let sphere = |x: usize, r: &str| format!("Sphere(center: ({x}, 0, 0), radius: {r}, material: \"grey\"),\n");
    let many: String = (0..42).map(|x| sphere(x, if x == 20 { "§1e-8" } else { "1e-7" })).collect();
    let words = ["a radius of 1e-8 ", "(and 41 more like it)"];
    warns(&scene(BEFORE, &many), "objects[20].Sphere.radius", &words);
    let two: String = (0..2).map(|x| sphere(x, if x == 1 { "§1e-8" } else { "1e-7" })).collect();
    warns(&scene(BEFORE, &two), "objects[1].Sphere.radius", &["(and 1 more like it)"]);
}

#[test]
fn sizes_below_a_share_of_the_extent_are_warned_of() {
    let grain = |r: &str| {
        scene(BEFORE, &format!("{BALL} Sphere(center: (0, 0, 4.9999999), radius: §{r}, material: \"grey\"),"))
    };
    let words = ["a radius of 5.4e-12 at a distance of 1e-7", "no size below 5.457e-12", "leave it out"];
    warns(&grain("5.4e-12"), "objects[1].Sphere.radius", &words);
    silent(&grain("5.5e-12"));
}

/// A lamp that lights a floor a long way off: at twice the warning's distance nothing arrives, and before it what should.
#[test]
fn lights_too_small_for_where_they_shine_are_warned_of() {
    // The irradiance does not depend on the distance: the floor has a radiance of 0.5.
    let lit = |distance: f64, lamp: &str| {
        let radiance = distance * distance;
        format!(
            "Scene(image: (width: 8, height: 4), render: (samples: 64, max_depth: 4),
              camera: (look_from: (0, 0, 0.1), look_at: (0, -{distance:e}, 0), up: (0, 0, 1), vertical_fov: 4),
              background: Solid((0, 0, 0)),
              materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
                           \"lamp\": DiffuseLight(emit: Rgb({radiance:e}, {radiance:e}, {radiance:e})) }},
              objects: [Quad(corner: (-{distance:e}, -{distance:e}, -{distance:e}), u: (0, 0, {two:e}), v: ({two:e}, 0, 0), material: \"grey\"),
                        §{lamp}])",
            two = 2.0 * distance,
        )
    };
    let ball = "Sphere(center: (0, 2, 0), radius: 1, material: \"lamp\")";
    let square = "Quad(corner: (-1, 2, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\")";
    let seen = |text: &str| {
        let shot = render::render(
            &render::scene(&unmarked(text)),
            &render::Request::default().with(|options| *options = RenderOptions::default()),
        );
        shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / shot.picture.rgb.len() as f64
    };
    for (lamp, field, expected) in
        [(ball, "objects[1].Sphere", 0.5), (square, "objects[1].Quad", 2.0 / std::f64::consts::PI)]
    {
        let words = ["this light has a size of", "get none of its light"];
        warns(&lit(1e10, lamp), field, &words);
        // The largest that is silent: the light goes √3 and 1 times as far as the floor at the most.
        silent(&lit(3e8, lamp));
        let found = seen(&lit(3e8, lamp));
        assert!((found / expected - 1.0).abs() < 0.02, "{field}: {found}");
        assert!(seen(&lit(1e10, lamp)) < 0.01 * expected, "{field}");
    }
}

#[test]
fn media_whose_free_path_is_shorter_than_rounding_are_warned_of() {
    let fog = |density: &str| {
        let boundary = "boundary: Sphere(center: (0, 0, 0), radius: 1)";
        scene(BEFORE, &format!("Medium({boundary}, density: §{density}, albedo: Rgb(0.5, 0.5, 0.5)),"))
    };
    let words = [
        "the mean free path is 2.857e-6",
        "at 6 from the camera",
        "no length below 2.861e-6",
        "a density below 349500",
    ];
    warns(&fog("350000"), "objects[0].Medium.density", &words);
    silent(&fog("349000"));
}

#[test]
fn spheres_that_coincide_are_warned_of() {
    let pair = |r: &str, material: &str| {
        scene(BEFORE, &format!("{BALL}\n§Sphere(center: (0, 0, 0), radius: {r}, material: \"{material}\"),"))
    };
    let field = "objects[1].Sphere";
    warns(
        &pair("1", "steel"),
        field,
        &["it touches the sphere at", "x.ron:12:9, which coincides with it: rounding", "remove one"],
    );
    // 6 u (5 + 1) and 4 u of the radius.
    warns(&pair("1.0000023", "steel"), field, &["is 2.3e-6 away, less than f32 resolves there (2.384e-6): "]);
    silent(&pair("1.0000025", "steel"));
    silent(&pair("1", "grey"));
    // What fills glass is no surface.
    let boundary = "boundary: Sphere(center: (0, 0, 0), radius: 1)";
    let filled = format!(
        "Sphere(center: (0, 0, 0), radius: 1, material: \"glass\"), Medium({boundary}, density: 1, albedo: Rgb(1, 1, 1)),"
    );
    silent(&scene(BEFORE, &filled));
}

/// Wherever they are, and where the grid that finds them has its edges.
#[test]
fn spheres_whose_centres_differ_by_less_than_rounding_are_warned_of() {
    let mut random = stats::Random(7);
    let mut number = |low: f64, high: f64| low + (high - low) * random.uniform();
    let camera = "(look_from: (0, 0, 50), look_at: (0, 0, 0), vertical_fov: 40)";
    for _ in 0..1000 {
        let (center, r) = ([0; 3].map(|_| number(-10.0, 10.0)), number(0.1, 5.0));
        let ball = |shift: f64, r: f64, material: &str| {
            let [x, y, z] = center.map(|x| x + shift);
            format!("Sphere(center: ({x:?}, {y:?}, {z:?}), radius: {r:?}, material: \"{material}\"),")
        };
        // 4 u of the largest coordinate, 2 u of the distance and 10 u of the radius; half of it by the centres and a tenth by the radii.
        let relative = [center[0].abs(), center[1].abs(), 50.0 - center[2]];
        let distance = relative.iter().map(|x| x * x).sum::<f64>().sqrt();
        let bound = 2.0_f64.powi(-24) * (4.0 * relative.into_iter().fold(0.0, f64::max) + 2.0 * distance + 10.0 * r);
        let with = |share: f64| {
            let other = ball(share * 0.5 * bound / 3.0_f64.sqrt(), r + share * 0.1 * bound, "steel");
            scene(camera, &format!("{}\n§{other}", ball(0.0, r, "grey")))
        };
        warns(&with(1.0), "objects[1].Sphere", &["away, less than"]);
        silent(&with(2.0));
    }
}

#[test]
fn clear_spheres_that_coincide_are_warned_of() {
    // The mark is at the clear one if only one of them is clear.
    let pair = |r: &str, material: &str, other: &str| {
        let marks = if other == "grey" { ["§", ""] } else { ["", "§"] };
        let first = format!("{}Sphere(center: (0, 0, 0), radius: 1, material: \"{material}\"),", marks[0]);
        let second = format!("{}Sphere(center: (0, 0, 0), radius: {r}, material: \"{other}\"),", marks[1]);
        scene(BEFORE, &format!("{first}\n{second}"))
    };
    // Rays start 6 u (5 + 1) off, and 4 u of the radius is the next distance's.
    let words = ["this glass touches the sphere at", "coincides with it: rays that leave one", "more than 2.384e-6"];
    warns(&pair("1", "glass", "glass"), "objects[1].Sphere", &words);
    warns(&pair("1", "glass", "water"), "objects[1].Sphere", &words[..1]);
    let words = ["this glass touches the sphere", "is 2.3e-6 away, less than f32 resolves there (2.384e-6): "];
    for (one, other, field) in [("grey", "glass", "objects[1].Sphere"), ("glass", "grey", "objects[0].Sphere")] {
        warns(&pair("0.9999977", one, other), field, &words);
        silent(&pair("0.9999975", one, other));
    }
}

#[test]
fn meshes_that_coincide_are_warned_of() {
    let placed = |by: &str, material: &str| {
        format!("Transformed(by: [{by}], object: §Mesh(path: \"scenes/meshes/star.ply\", material: \"{material}\")),")
    };
    let pair = |by: &str, material: &str| {
        scene(BEFORE, &format!("{}\n{}", unmarked(&placed("RotateY(20)", "grey")), placed(by, material)))
    };
    let field = "objects[1].Transformed.object.Mesh";
    let words = ["it touches the mesh at", "coincides with it"];
    warns(&pair("RotateY(20)", "steel"), field, &words);
    warns(&pair("RotateY(20), Translate((0, 1e-7, 0))", "steel"), field, &["is 1e-7 away"]);
    warns(&pair("RotateY(20)", "glass"), field, &["this glass touches the mesh at"]);
    silent(&pair("RotateY(20)", "grey"));
    silent(&pair("RotateY(20), Translate((0, 1e-5, 0))", "steel"));
    silent(&pair("RotateY(21)", "steel"));
    let clear = scene(BEFORE, &[unmarked(&placed("Scale(1)", "glass")), placed("Scale(1)", "glass")].concat());
    warns(&clear, field, &["this glass touches"]);
}

/// A quad of two by two over the height y, from (x, z) on.
fn tile(x: f64, y: f64, z: f64, material: &str) -> String {
    format!("Quad(corner: ({x:?}, {y:?}, {z:?}), u: (2, 0, 0), v: (0, 0, 2), material: \"{material}\"),")
}

#[test]
fn quads_that_overlap_in_a_plane_are_warned_of() {
    let floor = tile(-1.0, 0.0, -1.0, "grey");
    let with = |other: &str| scene(ABOVE, &format!("{floor}\n{other}"));
    let rug = |x: f64, y: f64, material: &str| with(&format!("§{}", tile(x, y, 0.5, material)));
    let words = ["it touches the quad at", "x.ron:12:9", "coincides", "their order in the file", "remove one"];
    warns(&rug(0.0, 0.0, "steel"), "objects[1].Quad", &words);
    warns(&rug(0.0, 2.3e-7, "steel"), "objects[1].Quad", &["is 2.3e-7 away, less than", "2.384e-7"]);
    silent(&rug(0.0, 2.5e-7, "steel"));
    // Where rays start: 4 u of the height, and the rounding of both.
    let words = ["this glass touches the quad at", "is 4.7e-7 away, less than f32 resolves there (4.768e-7): "];
    warns(&rug(0.0, 4.7e-7, "glass"), "objects[1].Quad", &words);
    silent(&rug(0.0, 4.8e-7, "glass"));
    silent(&rug(0.0, 0.0, "grey"));
    // Side by side, and turned about so that only the boxes around them overlap.
    silent(&rug(1.0, 0.0, "steel"));
    let turned = |x: f64| {
        let quad = format!("§Quad(corner: ({x:?}, 0, 0.1), u: (1, 0, 1), v: (1, 0, -1), material: \"steel\")");
        with(&format!("{quad},"))
    };
    silent(&turned(0.9 + 0.15));
    warns(&turned(0.8), "objects[1].Quad", &["touches"]);
    // Far away and turned, where f64 rounds too.
    let moved = |y: f64| {
        let [one, other] = [&floor, &tile(0.0, y, 0.5, "steel")].map(|quad| quad.trim_end_matches(',').to_string());
        let by = "by: [Rotate(axis: (1, 2, 3), degrees: 50), Translate((1e6, 2e6, 3e6))]";
        let camera = "(look_from: (1e6, 2e6, 3000005), look_at: (1e6, 2e6, 3e6), vertical_fov: 40)";
        scene(camera, &format!("Transformed({by}, object: {one}),\nTransformed({by}, object: §{other}),"))
    };
    warns(&moved(0.0), "objects[1].Transformed.object.Quad", &["coincides"]);
    silent(&moved(1e-5));
}

/// A disk counts by the square within it: two whose squares around them overlap may not touch.
#[test]
fn disks_that_overlap_in_a_plane_are_warned_of() {
    let disk = |x: f64, y: f64, material: &str| {
        format!("§Disk(center: ({x:?}, 0, {y:?}), normal: (0, 1, 0), radius: 1, material: \"{material}\"),")
    };
    let field = "objects[1].Disk";
    warns(&scene(ABOVE, &(tile(-1.0, 0.0, -1.0, "steel") + &disk(0.0, 0.0, "grey"))), field, &["touches the quad"]);
    let pair = |x: f64, y: f64| scene(ABOVE, &(unmarked(&disk(0.0, 0.0, "steel")) + &disk(x, y, "grey")));
    warns(&pair(1.0, 0.5), field, &["touches the disk"]);
    silent(&pair(1.5, 1.5));
    silent(&pair(2.0, 0.0));
}

#[test]
fn boxes_that_share_a_plane_are_warned_of() {
    let cuboid =
        |min: &str, max: &str, material: &str| format!("Box(min: {min}, max: {max}, material: \"{material}\"),");
    let floor = tile(-1.0, 0.0, -1.0, "grey");
    let block = cuboid("(-0.5, 0, -0.5)", "(0.5, 1, 0.5)", "steel");
    // It may rest on a floor, and against another; what hides the floor from below is seen there.
    silent(&scene(ABOVE, &format!("{floor}\n{block}")));
    silent(&scene(ABOVE, &format!("{block}\n{}", cuboid("(0.5, 0, -0.5)", "(1.5, 0.9, 0.5)", "grey"))));
    silent(&scene(ABOVE, &format!("{block}\n{}", cuboid("(0.5, 0, -0.5)", "(1.5, 1, 0.5)", "grey"))));
    let below = "(look_from: (0, -1, 5), look_at: (0, 0, 0), vertical_fov: 40)";
    warns(&scene(below, &format!("{floor}\n§{block}")), "objects[1].Box", &["the quad at", "coincides"]);
    let lid = tile(-1.0, 1.0, -1.0, "grey");
    let up = ABOVE.replace("(0, 1, 5)", "(0, 3, 5)");
    warns(&scene(&up, &format!("{block}\n§{lid}")), "objects[1].Quad", &["the box at"]);
    warns(&scene(&up, &format!("{block}\n§{}", block.replace("steel", "grey"))), "objects[1].Box", &["box at"]);
    // In a room, flush with its wall: a picture is seen or not, a cupboard hides the wall.
    let room = cuboid("(-6, -6, -6)", "(6, 6, 6)", "grey");
    let bulb = "Sphere(center: (3, 3, 3), radius: 0.5, material: \"lamp\"),";
    let picture = "Quad(corner: (-1, -1, -6), u: (2, 0, 0), v: (0, 2, 0), material: \"steel\"),";
    warns(&scene(BEFORE, &format!("{room}\n§{picture}\n{bulb}")), "objects[1].Quad", &["the box at"]);
    silent(&scene(BEFORE, &format!("{room}\n{}\n{bulb}", cuboid("(-1, -1, -6)", "(1, 1, -5)", "steel"))));
    // Glass that stands on something, whichever is first in the file.
    let glass = block.replace("steel", "glass");
    let words = [
        "this glass touches the quad at",
        "x.ron:13:1, which coincides with it",
        "let an opaque one reach into the glass",
    ];
    warns(&scene(ABOVE, &format!("§{glass}\n{floor}")), "objects[0].Box", &words);
    warns(&scene(ABOVE, &format!("{floor}\n§{glass}")), "objects[1].Box", &["the quad at", "x.ron:12:9, which"]);
    warns(&scene(below, &format!("{floor}\n§{glass}")), "objects[1].Box", &["the quad at"]);
    silent(&scene(ABOVE, &format!("{floor}\n{}", glass.replace("(-0.5, 0, ", "(-0.5, -0.01, "))));
    silent(&scene(ABOVE, &format!("{floor}\n{}", glass.replace("(-0.5, 0, ", "(-0.5, 0.01, "))));
    // The bottom of what stands on it is seen through it.
    let upon = cuboid("(-0.2, 1, -0.2)", "(0.2, 1.2, 0.2)", "grey");
    warns(&scene(&up, &format!("{upon}\n§{glass}")), "objects[1].Box", &["this glass touches the box at"]);
    // Opaque ones beside it may still rest on a floor.
    let apart = glass.replace("(-0.5, 0, -0.5)", "(2, 1, 0)").replace("(0.5, 1, 0.5)", "(3, 2, 1)");
    silent(&scene(ABOVE, &format!("{floor}\n{block}\n{apart}")));
    let fog = "Medium(boundary: Box(min: (-0.5, 0, -0.5), max: (0.5, 1, 0.5)), density: 1, albedo: Rgb(1, 1, 1)),";
    silent(&scene(ABOVE, &format!("{glass}\n{fog}\n{}", tile(-1.0, -0.1, -1.0, "grey"))));
}

#[test]
fn clear_solids_that_touch_are_warned_of() {
    let cuboid = |low: &str, high: &str, material: &str| {
        format!("Box(min: (-1, {low}, -1), max: (1, {high}, 1), material: \"{material}\"),")
    };
    let words = ["this glass touches the box at", "x.ron:12:9, which coincides with it"];
    for (one, other) in [("glass", "water"), ("water", "glass"), ("glass", "glass")] {
        let stacked = |low: &str| format!("{}\n§{}", cuboid("-1", "0", one), cuboid(low, "1", other));
        warns(&scene(ABOVE, &stacked("0")), "objects[1].Box", &words);
        warns(&scene(ABOVE, &stacked("1e-7")), "objects[1].Box", &["is 1e-7 away"]);
        silent(&scene(ABOVE, &stacked("1e-5")));
    }
    // Side by side and not in touch, one within the other, and filled by a medium.
    let beside = cuboid("-1", "0", "glass").replace("(-1, ", "(1.1, ").replace("(1, ", "(2, ");
    silent(&scene(ABOVE, &(cuboid("-1", "0", "glass") + &beside)));
    let medium = "Medium(boundary: Box(min: (-1, -1, -1), max: (1, 0, 1)), density: 1, albedo: Rgb(0.5, 0.5, 0.5)),";
    silent(&scene(ABOVE, &(cuboid("-1", "0", "glass") + medium)));
    let inner = "Box(min: (-0.9, -0.9, -0.9), max: (0.9, -0.1, 0.9), material: \"water\"),";
    silent(&scene(ABOVE, &(cuboid("-1", "0", "glass") + inner)));
    let flush = inner.replace("-0.1,", "0,");
    warns(&scene(ABOVE, &format!("{}§{flush}", cuboid("-1", "0", "glass"))), "objects[1].Box", &["this glass touches"]);
}

/// The objects of a scene with a gap of this width.
type Objects = Box<dyn Fn(f64) -> String>;

/// The gap from which on a warning says that all is well.
fn limit(warning: &str) -> f64 {
    let words: Vec<&str> = warning.split(' ').collect();
    let at = words.windows(2).rposition(|pair| pair == ["more", "than"]);
    let number = at.and_then(|at| words[at + 2].trim_end_matches(',').parse().ok());
    number.unwrap_or_else(|| panic!("no limit in {warning}"))
}

/// A lamp behind a clear surface is seen where the gap is a little more than the warning's limit. At half of the limit most pixels are wrong.
#[test]
fn pictures_are_wrong_where_it_is_warned_of_and_right_beyond() {
    let quads = |half: f64| {
        move |gap: f64| {
            let quad = |y: f64, material: &str| {
                let (corner, edge) = (format!("({:?}, {y:?}, {:?})", -half, -half), 2.0 * half);
                format!("Quad(corner: {corner}, u: (0, 0, {edge:?}), v: ({edge:?}, 0, 0), material: \"{material}\")")
            };
            let group = format!("Group([{}, {}])", quad(-1.0, "clear"), quad(-1.0 - gap, "spot"));
            format!("Transformed(by: [RotateX(20), RotateZ(-10)], object: {group}),")
        }
    };
    let boxes = |gap: f64| {
        let cuboid = |h: f64, material: &str| {
            let corners = format!("min: ({:?}, {:?}, {:?}), max: ({h:?}, {h:?}, {h:?})", -h, -h, -h);
            format!("Box({corners}, material: \"{material}\")")
        };
        let group = format!("Group([{}, {}])", cuboid(1.0, "clear"), cuboid(1.0 - gap, "spot"));
        format!("Transformed(by: [RotateX(20), RotateY(35), RotateZ(-50)], object: {group}),")
    };
    let spheres = |gap: f64| {
        let ball =
            |r: f64, material: &str| format!("Sphere(center: (0, 0, 0), radius: {r:?}, material: \"{material}\"),");
        ball(1.0, "clear") + &ball(1.0 - gap, "spot")
    };
    let down = "(look_from: (0, 0, 0), look_at: (0.4, -1, 0.3), vertical_fov: 40)";
    let aside = "(look_from: (1.08, 1.44, 2.4), look_at: (0, 0, 0), vertical_fov: 20)";
    let cases: [(&str, &str, Objects); 4] = [
        ("quads of 10", down, Box::new(quads(5.0))),
        ("quads of 100", down, Box::new(quads(50.0))),
        ("boxes", aside, Box::new(boxes)),
        ("spheres", aside, Box::new(spheres)),
    ];
    for (what, camera, objects) in cases {
        let text = |gap: f64| {
            let sky = "background: Gradient(bottom: (0, 0, 0), top: (1, 1, 1))";
            let text = scene(camera, &objects(gap)).replace("background: Solid((1, 1, 1))", sky);
            text.replace("width: 400, height: 300", "width: 16, height: 16").replace("15, 15, 15", "1, 1, 1")
        };
        let red = |gap: f64| {
            let pixels = render::render(&parse(&text(gap)), &render::Request::spp(16)).picture.rgb;
            pixels.iter().map(|pixel| f64::from(pixel[0])).collect::<Vec<_>>()
        };
        let right = red(1e-3);
        // What glass reflects is chosen by the same random numbers: what differs is the path.
        let wrong = |gap: f64| {
            let pixels = red(gap);
            pixels.iter().zip(&right).filter(|(a, b)| (*a - *b).abs() > 0.02).count() as f64 / pixels.len() as f64
        };
        let found = warnings(&text(1e-7));
        let [warning] = &found[..] else { panic!("{what}: {found:#?}") };
        let limit = limit(warning);
        assert_eq!(warnings(&text(0.99 * limit)).len(), 1, "{what}");
        silent(&text(1.01 * limit));
        assert!(wrong(0.5 * limit) > 0.8, "{what}: {} wrong at half of {limit}", wrong(0.5 * limit));
        assert_eq!(wrong(1.01 * limit), 0.0, "{what}: above {limit}");
        assert_eq!(wrong(1.5 * limit), 0.0, "{what}: half above {limit}");
    }
}

#[test]
fn among_many_tiles_in_a_plane_those_that_overlap_are_warned_of() {
    let tiles = |mark: Option<usize>| -> String {
        let tile = |i: usize| {
            let (x, z) = ((i % 30) as f64 * 2.0, (i / 30) as f64 * 2.0);
            let x = if Some(i) == mark { x - 0.5 } else { x };
            let quad = tile(x - 30.0, 0.0, -z, if (i % 30 + i / 30).is_multiple_of(2) { "grey" } else { "steel" });
            format!("{}{quad}\n", if Some(i) == mark { "§" } else { "" })
        };
        (0..900).map(tile).collect()
    };
    silent(&scene(ABOVE, &tiles(None)));
    warns(&scene(ABOVE, &tiles(Some(444))), "objects[444].Quad", &["touches the quad at"]);
    // One under all of them.
    for material in ["lamp", "glass"] {
        let quad = "Quad(corner: (-40, 0, -60), u: (100, 0, 0), v: (0, 0, 70), material: ";
        let found = warnings(&scene(ABOVE, &format!("{}{quad}{material:?}),", tiles(None))));
        assert!(found.len() == 1 && found[0].contains("more like it"), "{found:?}");
    }
}

#[test]
fn lights_that_no_path_reaches_are_warned_of() {
    let with = |light: &str, around: &str, material: &str| {
        let around = around.replace("..", &format!("material: \"{material}\""));
        scene(BEFORE, &format!("§{light}\n{around}"))
    };
    let lamp = "Sphere(center: (0, 0, 0), radius: 0.5, material: \"lamp\"),";
    let quad = "Quad(corner: (-0.3, 0, -0.3), u: (0.6, 0, 0), v: (0, 0, 0.6), material: \"lamp\"),";
    let ball = "Sphere(center: (0.1, 0, 0), radius: 0.61, ..),";
    let cuboid = "Transformed(by: [RotateY(30)], object: Box(min: (-0.51, -0.51, -0.51), max: (0.51, 1, 1), ..)),";
    for (light, kind) in [(lamp, "Sphere"), (quad, "Quad")] {
        for (around, name) in [(ball, "sphere"), (cuboid, "box")] {
            let words = [&*format!("the opaque {name} at"), "x.ron:13:", "encloses it, and the camera is outside"];
            warns(&with(light, around, "steel"), &format!("objects[0].{kind}"), &words);
            silent(&with(light, around, "glass"));
        }
    }
    // One that sticks out is reached.
    silent(&with(lamp, &ball.replace("0.61", "0.59"), "grey"));
    silent(&with(lamp, &cuboid.replace("-0.51", "-0.49"), "grey"));
    silent(&with(quad, &ball.replace("0.61", "0.49"), "grey"));
    // The camera within.
    let room = "Box(min: (-6, -6, -6), max: (6, 6, 6), ..),";
    let beyond = "Sphere(center: (0, 0, -8), radius: 1, material: \"lamp\"),";
    silent(&with(lamp, room, "grey"));
    warns(&with(beyond, room, "grey"), "objects[0].Sphere", &["encloses the camera, and the light is outside"]);
    silent(&with(&beyond.replace("-8", "-6.5"), room, "grey"));
}

/// Each straight way from the lamp to the rest goes through the floor, and not if either of both reaches beyond it, or the floor lets light pass.
#[test]
fn lights_behind_a_floor_are_warned_of() {
    let floor = "Quad(corner: (-9, 0, -9), u: (18, 0, 0), v: (0, 0, 18), material: \"grey\"),";
    let ball = "Sphere(center: (0.5, 1, 0), radius: 1, material: \"grey\"),";
    let with = |light: &str, floor: &str, more: &str| scene(ABOVE, &format!("§{light}\n{floor}{more}"));
    let lamps = [
        ("Sphere(center: (0, -1.5, 0), radius: 0.5, material: \"lamp\"),", "Sphere"),
        ("Quad(corner: (-1, -0.1, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),", "Quad"),
        ("PointLight(at: (0, -1, 0), intensity: (5, 5, 5)),", "PointLight"),
        ("DirectionalLight(direction: (0.1, 1, 0), irradiance: (5, 5, 5)),", "DirectionalLight"),
    ];
    let disk = "Disk(center: (0, 0, 0), normal: (0, -1, 0), radius: 14, material: \"grey\"),";
    let slab = "Box(min: (-9, -0.05, -9), max: (9, 0, 9), material: \"grey\"),";
    for (lamp, kind) in lamps {
        for (floor, name) in [(floor, "quad"), (disk, "disk"), (slab, "box")] {
            let words = [&*format!("behind the opaque {name} at"), "x.ron:13:", "move the light to the front"];
            warns(&with(lamp, floor, ball), &format!("objects[0].{kind}"), &words);
        }
        for (floor, more) in [
            (floor.to_string(), ball.replace("0.5, 1, 0", "0.5, 0.9, 0")),
            (floor.to_string(), ball.replace("0.5, 1, 0", "30, 1, 0")),
            (floor.replace("(-9, 0, -9), u: (18", "(-9, 0, -9), u: (9.2"), ball.to_string()),
            (
                floor.to_string(),
                format!(
                    "Medium(boundary: {} density: 0.1, albedo: Rgb(1, 1, 1)),",
                    ball.replace(", material: \"grey\"", "").replace("0.5, 1, 0", "0, 0, 0")
                ),
            ),
        ] {
            silent(&with(lamp, &floor, &more));
        }
        // Beside glass, lights without size have another warning.
        if !kind.ends_with("Light") {
            silent(&with(lamp, &floor.replace("grey", "clear"), ball));
        }
        let cut_out = "\"grey\": Lambertian(alpha: 0.9, ";
        silent(&with(lamp, floor, ball).replace("\"grey\": Lambertian(", cut_out));
    }
    // What stands beside the lamp does not matter, if it is hidden too; one above the floor is lit.
    let beside = "Sphere(center: (2, -2, 0), radius: 1, material: \"grey\"),";
    warns(&with(lamps[0].0, floor, &format!("{ball}{beside}")), "objects[0].Sphere", &["behind the opaque quad"]);
    silent(&with(&lamps[0].0.replace("-1.5", "1.5"), floor, ""));
    // Light reaches the far side of a wall past its edge.
    silent(&with("PointLight(at: (0, -90, 0), intensity: (5, 5, 5)),", floor, &ball.replace("0.5, 1, 0", "12, 9, 0")));
}

#[test]
fn spot_lights_that_aim_at_nothing_are_warned_of() {
    let floor = "Quad(corner: (-9, 0, -9), u: (18, 0, 0), v: (0, 0, 18), material: \"grey\"),";
    let ball = "Sphere(center: (3, 1, 0), radius: 1, material: \"grey\"),";
    let spot = |towards: &str, outer: f64| {
        format!("§SpotLight(at: (0, 3, 0), towards: {towards}, intensity: (5, 5, 5), outer: {outer}),\n")
    };
    let words = ["no object is in the cone", "aim it with towards"];
    for (towards, outer) in [("(0, 9, 0)", 45.0), ("(9, 9, 0)", 40.0), ("(-9, 3, 0)", 1.0), ("(0, 9, 0)", 89.0)] {
        let of = |objects: &str| scene(ABOVE, &format!("{}{objects}", spot(towards, outer)));
        warns(&of(&format!("{floor}{ball}")), "objects[0].SpotLight", &words);
        let fog = "Medium(boundary: Sphere(center: (0, 3, 0), radius: 9), density: 0.1, albedo: Rgb(1, 1, 1)),";
        silent(&of(&format!("{floor}{fog}")));
    }
    for (towards, outer) in [("(0, 0, 0)", 1.0), ("(3, 2.1, 0)", 1.0), ("(9, 3, 0)", 25.0), ("(0, 9, 0)", 120.0)] {
        silent(&scene(ABOVE, &format!("{}{floor}{ball}", spot(towards, outer))));
    }
    // The limits of the angle: a ball seen at 33.7 degrees below the horizon, of a radius of 16.1.
    let [near, far] = [17.3, 17.9].map(|outer| scene(ABOVE, &format!("{}{ball}", spot("(9, 3, 0)", outer))));
    warns(&near, "objects[0].SpotLight", &words);
    silent(&far);
    let moving = ball
        .replace("Sphere", "Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0, 9, 0))])], object: Sphere");
    let moving = moving.replace("\"grey\")", "\"grey\"))");
    let open = ABOVE.replace("40)", "40, shutter: (0, 1))");
    silent(&scene(&open, &format!("{}{moving}", spot("(9, 9, 0)", 5.0))));
}

/// Warnings of single values, and no others.
fn said(text: &str) -> Vec<String> {
    parse(text).warnings().into_iter().filter(|text| !text.contains("no object uses this material")).collect()
}

#[test]
fn emission_motion_and_focus_that_do_not_show_are_warned_of() {
    // An emission that no alpha shows.
    let with = |fields: &str| {
        scene(BEFORE, BALL).replace("\"grey\": Lambertian(", &format!("\"grey\": Lambertian({fields}, "))
    };
    for fields in [
        "emission: §Rgb(5, 5, 5), alpha: 0",
        "emission: §Rgb(5, 5, 5), alpha: 0.3, alpha_cutoff: 0.5",
        "emission: §Rgb(5, 5, 5), alpha: Checker(scale: 1, even: (0.3, 0.3, 0.3), odd: (0, 0, 0)), alpha_cutoff: 0.31",
    ] {
        warns(&with(fields), "materials[\"grey\"].Lambertian.emission", &["shows nowhere", "raise the alpha"]);
    }
    for fields in [
        "emission: Rgb(5, 5, 5), alpha: 0.001",
        "emission: Rgb(5, 5, 5), alpha: Checker(scale: 1, even: (0.3, 0.3, 0.3), odd: (0, 0, 0)), alpha_cutoff: 0.3",
        "alpha: 0",
    ] {
        silent(&with(fields));
    }
    // Motion while the shutter is shut. A camera and objects that only seem to move have no warning.
    let assert_said = |text: &str, field: &str, words: &[&str]| is_one(&said(text), text, field, words);
    let moving = |to: f64| {
        let keys = format!("§[(2, [Translate((0, 0, 0))]), (3.5, [Translate(({to}, 0, 0))])]");
        format!("Moving(keys: {keys}, object: Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")),")
    };
    let shutter = |times: &str| BEFORE.replace("40)", &format!("40, shutter: {times})"));
    for times in ["(0, 0)", "(2.5, 2.5)"] {
        let text = scene(&shutter(times), &moving(1.0));
        assert_said(&text, "objects[0].Moving.keys", &["the shutter opens and closes at", "such as (2, 3.5)"]);
        assert!(said(&scene(&shutter(times), &moving(0.0))).is_empty());
        let two = scene(&shutter(times), &(moving(1.0) + &moving(2.0).replace('§', "")));
        assert_said(&two, "objects[0].Moving.keys", &["(and 1 more like it)"]);
    }
    assert!(said(&scene(&shutter("(2, 3)"), &moving(1.0))).is_empty());
    let keys = "[(0, (look_from: (0, 0, 5), look_at: (0, 0, 0))), (1, (look_from: (0, 1, 5), look_at: (0, 0, 0)))]";
    let camera = |shutter: &str| BEFORE.replace("40)", &format!("40, shutter: {shutter}, moving: §{keys})"));
    assert_said(&scene(&camera("(0.5, 0.5)"), BALL), "camera.moving", &["such as (0, 1)"]);
    assert!(said(&scene(&camera("(0, 0.5)"), BALL)).is_empty());
    assert!(said(&scene(&camera("(0, 0)").replace("0, 1, 5", "0, 0, 5"), BALL)).is_empty());
    // A lens that is in focus within itself, and a spot light without a cone.
    let lens = |aperture: f64, focus: &str| BEFORE.replace("40)", &format!("40, aperture: {aperture}{focus})"));
    assert_said(
        &scene(&lens(2.0, ", focus_distance: §0.9"), BALL),
        "camera.focus_distance",
        &["radius of 1", "focus distance of 0.9", "below 1.8"],
    );
    assert!(said(&scene(&lens(2.0, ", focus_distance: 1.1"), BALL)).is_empty());
    assert!(said(&scene(&lens(9.9, ""), BALL)).is_empty());
    assert_eq!(said(&scene(&lens(10.1, ""), BALL)).len(), 1);
    let spot = |outer: &str| {
        format!("SpotLight(at: (0, 3, 0), towards: (0, 0, 0), intensity: (5, 5, 5), outer: §{outer}), {BALL}")
    };
    assert_said(&scene(BEFORE, &spot("0")), "objects[0].SpotLight.outer", &["no cone", "above 0"]);
    silent(&scene(BEFORE, &spot("0")).replace('§', ""));
    assert!(said(&scene(BEFORE, &spot("1e-3"))).is_empty());
}

#[test]
fn lights_behind_meshes_are_warned_of() {
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("{e}"));
    // A tent of four faces, and one that lacks its floor.
    let tent = "v -2 -1 -2\nv 2 -1 -2\nv 2 -1 2\nv -2 -1 2\nv 0 2 0\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n";
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap_or_else(|e| panic!("{e}"));
        path
    };
    let closed = write("closed.obj", &format!("{tent}f 1 2 3 4\n"));
    let open = write("open.obj", tent);
    // Inside out.
    let turned: Vec<String> = format!("{tent}f 1 2 3 4\n").lines().map(turned_face).collect();
    let turned = write("turned.obj", &turned.join("\n"));
    let mesh = |path: &Path, material: &str| {
        let by = "by: [Scale(0.5), RotateY(40), Translate((0, 0.2, 0))]";
        format!("Transformed({by}, object: Mesh(path: {path:?}, material: \"{material}\")),")
    };
    let lamp = |x: f64, y: f64| format!("Sphere(center: ({x:?}, {y:?}, 0), radius: 0.1, material: \"lamp\"),");
    let with = |mesh: String, lamp: String| scene(BEFORE, &format!("§{lamp}\n{mesh}"));
    let words = ["the opaque mesh at", "x.ron:13:", "encloses it, and the camera is outside"];
    warns(&with(mesh(&closed, "grey"), lamp(0.1, 0.2)), "objects[0].Sphere", &words);
    warns(&with(mesh(&turned, "grey"), lamp(0.1, 0.2)), "objects[0].Sphere", &words);
    silent(&with(mesh(&closed, "glass"), lamp(0.1, 0.2)));
    silent(&with(mesh(&open, "grey"), lamp(0.1, 0.2)));
    // Through its wall, and in a corner of the box around it.
    silent(&with(mesh(&closed, "grey"), lamp(0.75, 0.2)));
    silent(&with(mesh(&closed, "grey"), lamp(0.8, 0.9)));
    // The camera within, and the light beyond.
    let room = |path: &Path| mesh(path, "grey").replace("0.5", "20");
    let beyond = lamp(0.0, 0.0).replace("(0.0, 0.0, 0)", "(0, 0, -60)");
    let words = ["the opaque mesh at", "encloses the camera, and the light is outside"];
    warns(&with(room(&closed), beyond.clone()), "objects[0].Sphere", &words);
    silent(&with(room(&open), beyond));
    silent(&with(room(&closed), lamp(0.1, 0.2)));
    // A light itself, around the camera.
    let shell = |path: &Path, material: &str| {
        let text = mesh(path, material).replace("0.5", "20").replace("object: Mesh", "object: §Mesh");
        scene(BEFORE, &text)
    };
    let field = "objects[0].Transformed.object.Mesh";
    warns(&shell(&closed, "spot"), field, &["the camera is inside this mesh, which emits outwards only"]);
    silent(&shell(&turned, "spot"));
    silent(&shell(&closed, "lamp"));
}

/// A line of an OBJ file, of faces with their corners the other way round.
fn turned_face(line: &str) -> String {
    match line.strip_prefix("f ") {
        Some(corners) => format!("f {}", corners.split(' ').rev().collect::<Vec<_>>().join(" ")),
        None => line.to_string(),
    }
}

#[test]
fn closed_lights_around_the_camera_are_warned_of() {
    let around = |shape: &str, material: &str| scene(BEFORE, &format!("{BALL}\n§{shape}, material: \"{material}\"),"));
    let sphere = "Sphere(center: (0, 0, 0), radius: 20";
    let cuboid = "Box(min: (-20, -20, -20), max: (20, 20, 20)";
    for (shape, name, field) in [(sphere, "sphere", "objects[1].Sphere"), (cuboid, "box", "objects[1].Box")] {
        let words = [&*format!("the camera is inside this {name}"), "its inside is black", "Make it two_sided"];
        warns(&around(shape, "spot"), field, &words);
        silent(&around(shape, "lamp"));
        silent(&around(&shape.replace("20", "4"), "spot"));
    }
}

#[test]
fn closed_rooms_around_the_camera_are_warned_of() {
    let room = |material: &str| format!("§Box(min: (-9, -9, -9), max: (9, 9, 9), material: \"{material}\"),");
    let words = ["the camera is inside this opaque box, and no light is: the image is black", "put a light inside"];
    warns(&scene(BEFORE, &room("grey")), "objects[0].Box", &words);
    let ball = "§Sphere(center: (0, 0, 0), radius: 9, material: \"steel\"),";
    warns(&scene(BEFORE, ball), "objects[0].Sphere", &["inside this opaque sphere"]);
    // One that light passes or comes from, one with a light inside, one beside the camera, and one with an open side.
    silent(&scene(BEFORE, &room("glass")));
    silent(&scene(BEFORE, &room("lamp")));
    let lamp = "Sphere(center: (0, 0, 0), radius: 1, material: \"lamp\"),";
    silent(&scene(BEFORE, &(room("grey") + lamp)));
    silent(&scene(BEFORE, &room("grey").replace("9)", "4)")));
    let wall = "Quad(corner: (-9, -9, -9), u: (18, 0, 0), v: (0, 18, 0), material: \"grey\"),";
    silent(&scene(BEFORE, wall));
    // With nothing that emits light, that is what is said.
    let dark = scene(BEFORE, &room("grey")).replace("Solid((1, 1, 1))", "Solid((0, 0, 0))");
    assert!(warnings(&dark).iter().all(|warning| !warning.contains("inside this opaque")), "{dark}");
}

#[test]
fn lights_that_face_away_from_everything_are_warned_of() {
    let spot = |u: &str, v: &str, material: &str| {
        scene(BEFORE, &format!("{BALL} §Quad(corner: (-1, 3, -1), u: {u}, v: {v}, material: \"{material}\"),"))
    };
    let (x, z) = ("(2, 0, 0)", "(0, 0, 2)");
    warns(
        &spot(z, x, "spot"),
        "objects[1].Quad",
        &["the whole scene is on its other side", "exchange a quad's u and v"],
    );
    silent(&spot(x, z, "spot"));
    silent(&spot(z, x, "lamp"));
    let disk = |normal: &str| {
        scene(BEFORE, &format!("{BALL} §Disk(center: (0, 3, 0), normal: {normal}, radius: 1, material: \"spot\"),"))
    };
    warns(&disk("(0, 2, 0)"), "objects[1].Disk", &["reverse a disk's normal"]);
    silent(&disk("(0, -2, 0)"));
}

#[test]
fn a_scene_without_light_is_warned_of() {
    let dark = |emit: &str| {
        scene(BEFORE, "Sphere(center: (0, 0, 0), radius: 1, material: \"lamp\"), ")
            .replace("\"grey\":", &format!("\"other\": DiffuseLight(emit: Rgb({emit})), \"grey\":"))
            .replace("background: Solid((1, 1, 1))", "background: §Solid((0, 0, 0))")
    };
    let of_lamp = |text: String, material: &str| text.replace("material: \"lamp\"", &format!("material: {material:?}"));
    // What no object is made of does not count.
    warns(&of_lamp(dark("1, 1, 1"), "grey"), "background", &["nothing in this scene emits light", "DiffuseLight"]);
    silent(&of_lamp(dark("0, 0, 1e-20"), "other"));
}

/// What no object is made of neither decides the film's unit nor is warned of.
#[test]
fn lights_that_are_not_used_do_not_count() {
    let with = |sun: &str, object: &str| {
        let ball = format!("Sphere(center: (0, 0, 0), radius: 1, material: \"lamp\"), {object}");
        scene(BEFORE, &ball)
            .replace("\"lamp\": ", &format!("\"sun\": DiffuseLight(emit: Rgb({sun}, {sun}, {sun})), \"lamp\": "))
            .replace(
                "\"lamp\": DiffuseLight(emit: Rgb(15, 15, 15))",
                "\"lamp\": DiffuseLight(emit: Rgb(1e-3, 1e-3, 1e-3))",
            )
            .replace("Solid((1, 1, 1))", "Solid((0, 0, 0))")
    };
    let exponent = |text: &str| {
        flatten(&parse(text), (40, 30), &RenderOptions::default()).unwrap_or_else(|e| panic!("{e}")).radiance_exponent
    };
    let unused = with("1e30", "");
    silent(&unused);
    assert_eq!(exponent(&unused), exponent(&with("1e-3", "")));
    let used = with("1e30", "Sphere(center: (3, 0, 0), radius: 1, material: \"sun\"),");
    assert_eq!(exponent(&used), 100);
}

#[test]
fn lights_of_no_emission_are_warned_of() {
    let of = |emit: &str| {
        let lamp = "Sphere(center: (0, 0, 0), radius: 1, material: \"lamp\"),";
        scene(BEFORE, lamp)
            .replace("\"lamp\": DiffuseLight(emit: Rgb(15, 15, 15))", &format!("\"lamp\": DiffuseLight(emit: §{emit})"))
    };
    let dark = of("Rgb(0, 0, 0)");
    is_one(&said(&dark), &dark, "materials[\"lamp\"].DiffuseLight.emit", &["an emission of 0"]);
    assert_eq!(said(&of("Rgb(0, 1e-30, 0)")), Vec::<String>::new());
}

/// Four scenes are warned of: three show that a light is black from behind, and one has a sun without size, of which a mirror shows no caustic.
#[test]
fn the_scenes_that_come_with_it_are_safe() {
    let mut seen = 0;
    for path in
        ["scenes", "scenes/test", "tests/references"].into_iter().flat_map(|folder| files(folder, ".ron", false))
    {
        let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let (width, height) = (scene.image.width, scene.image.height);
        let warned = ["one_sided_quads.ron", "one_sided_inside.ron", "one_sided_in_a_box.ron", "window.ron"];
        let expected = usize::from(warned.iter().any(|name| path.ends_with(name)));
        // As large as the file says, and as on a wall.
        for factor in [1, 4] {
            let flat = flatten(&scene, (factor * width, factor * height), &RenderOptions::default())
                .unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(flat.warnings.len(), expected, "{:#?}", flat.warnings);
        }
        seen += 1;
    }
    assert!(seen > 40, "{seen} scenes");
}

/// Whatever its numbers are, a scene is flattened, and warnings have numbers in them.
#[test]
fn warnings_of_the_largest_and_smallest_numbers_do_not_fail() {
    let (large, small) = ("1e90", "1e-90");
    let mut scenes = vec![scene(BEFORE, ""), scene(BEFORE, "Group([]), Group([Group([Group([])])]),")];
    for (coordinate, size) in
        [(large, large), (large, small), (small, small), (small, large), ("0", small), ("0", large)]
    {
        let at = format!("({coordinate}, {coordinate}, {coordinate})");
        let ball = format!("Sphere(center: {at}, radius: {size}, material: \"lamp\"),");
        let quad = format!("Quad(corner: {at}, u: ({size}, 0, 0), v: (0, {size}, 0), material: \"spot\"),");
        let other = quad.replace("spot", "glass");
        let cuboid =
            format!("Box(min: (-{size}, -{size}, -{size}), max: ({size}, {size}, {size}), material: \"grey\"),");
        let fog = format!(
            "Medium(boundary: {}, density: {size}, albedo: Rgb(1, 1, 1)),",
            ball.replace(", material: \"lamp\"),", ")")
        );
        let all = [ball, quad, other, cuboid, fog];
        scenes.extend(all.iter().map(|object| scene(BEFORE, object)));
        scenes.push(scene(BEFORE, &format!("Group([{}]),", all.concat())));
        let far = BEFORE.replace("(0, 0, 5)", &format!("(0, 0, {coordinate})")).replace("(0, 0, 0)", "(0, 0, -1)");
        scenes.push(scene(&far, &all.concat()));
    }
    let mut flattened = 0;
    for text in &scenes {
        // A scene that is out of range altogether is refused.
        let scene = Scene::parse(text, &root().join("x.ron"));
        let Ok(flat) = scene.and_then(|scene| flatten(&scene, (40, 30), &RenderOptions::default())) else { continue };
        for warning in &flat.warnings {
            assert!(!["NaN", "inf", "{"].iter().any(|wrong| warning.contains(wrong)), "{warning}");
        }
        flattened += 1;
    }
    assert!(flattened * 4 > scenes.len() * 3, "{flattened} of {}", scenes.len());
}

/// A scene has the same warnings whatever its unit of length is.
#[test]
fn warnings_do_not_depend_on_the_unit() {
    let of = |unit: f64| {
        let p = |x: f64, y: f64, z: f64| format!("({:e}, {:e}, {:e})", unit * x, unit * y, unit * z);
        let camera = format!("(look_from: {}, look_at: {}, vertical_fov: 40)", p(0.0, 1.0, 5.0), p(0.0, 0.0, 0.0));
        let floor = |material: &str| {
            let edges = format!("u: {}, v: {}", p(2.0, 0.0, 0.0), p(0.0, 0.0, 2.0));
            format!("Quad(corner: {}, {edges}, material: \"{material}\"),", p(-1.0, 0.0, -1.0))
        };
        let ball = |r: f64, material: &str| {
            format!("Sphere(center: {}, radius: {:e}, material: \"{material}\"),", p(0.0, 2.0, 0.0), unit * r)
        };
        let objects = [floor("grey"), floor("steel"), ball(0.5, "grey"), ball(0.5, "steel"), ball(1e-7, "lamp")];
        warnings(&scene(&camera, &objects.concat())).len()
    };
    assert_eq!(of(1.0), 4);
    for unit in [1e-60, 1e-30, 1e30, 1e60] {
        assert_eq!(of(unit), 4, "{unit}");
    }
}

/// A search that ends early, so that it may miss something, ends.
#[test]
fn crowds_are_flattened_in_time() {
    let n = 3000;
    let stack = |i: usize| tile(-1.0, 0.0, -1.0, if i.is_multiple_of(2) { "grey" } else { "steel" }) + "\n";
    let shells =
        |i: usize| format!("Sphere(center: (0, 0, 0), radius: {:?}, material: \"lamp\"),\n", 1.0 + i as f64 * 1e-5);
    for text in [(0..n).map(stack).collect::<String>(), (0..n).map(shells).collect()] {
        let begun = std::time::Instant::now();
        let found = warnings(&scene(ABOVE, &text));
        assert!(!found.is_empty() && begun.elapsed().as_secs() < 5, "{found:?} in {:?}", begun.elapsed());
    }
}
