//! The image is a function of scene, settings and sample range alone: not of the sizes that the work is cut into, nor of the place
//! and scale of the scene (design.md, section 5, invariants 1 and 3).
//!
//! What is compared is the film: the exact totals of every pixel, their squares, and the counts of samples and rays. What the user
//! gets is developed from it by a pure function. Equality has no noise, and so no false alarms; that it can fail at all is shown by
//! renders that must differ.

#[path = "common/device.rs"]
mod device;
#[path = "common/render.rs"]
mod render;
#[path = "common/stats.rs"]
mod stats;

use gpu_rt::film::Film;
use gpu_rt::plan::Scatter;
use gpu_rt::render::TuningWish;
use gpu_rt::scene::Scene;
use image::{Rgb, RgbImage};
use render::{Ask, Shot, render, render_each, same_expectation, scene_in};
use tempfile::TempDir;

/// A scene's numbers that the tests vary.
#[derive(Clone, Copy)]
struct World {
    /// Of all lengths, the camera's included.
    scale: f64,
    /// Of everything, the camera included.
    shift: [f64; 3],
    /// Of all radiance.
    brightness: f64,
    /// Of the camera alone, along x.
    camera_shift: f64,
    /// Of the lamp alone.
    lamp: f64,
}

impl Default for World {
    fn default() -> World {
        World { scale: 1.0, shift: [0.0; 3], brightness: 1.0, camera_shift: 0.0, lamp: 1.0 }
    }
}

/// The image file of the scene lives as long as this.
struct Everything(TempDir);

impl Everything {
    fn new() -> Everything {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let image = RgbImage::from_fn(8, 8, |x, y| Rgb([(x * 30) as u8, (y * 30) as u8, 200]));
        image.save(folder.path().join("image.png")).expect("the image is written");
        let octahedron = octahedron();
        std::fs::write(folder.path().join("octahedron.obj"), &octahedron).expect("the mesh is written");
        // Without its normals: flat-shaded.
        let flat: Vec<String> = octahedron
            .lines()
            .filter(|line| !line.starts_with("vn"))
            .map(|line| match line.starts_with('f') {
                true => line.split(' ').map(|c| c.split('/').next().unwrap_or_default()).collect::<Vec<_>>().join(" "),
                false => line.to_string(),
            })
            .collect();
        std::fs::write(folder.path().join("flat.obj"), flat.join("\n")).expect("the mesh is written");
        Everything(folder)
    }

    /// Every primitive, every material, every texture, a lens, and a sky; objects inside others; two of them coincident; media in
    /// every kind of boundary, overlapping, textured, and one that fills a glass sphere.
    fn scene(&self, world: World) -> Scene {
        let World { scale, shift: [x, y, z], brightness, camera_shift, lamp } = world;
        let length = |l: f64| format!("{:e}", l * scale);
        let point = |p: [f64; 3]| {
            let [a, b, c] = [0, 1, 2].map(|i| p[i] * scale + world.shift[i]);
            format!("({a:e}, {b:e}, {c:e})")
        };
        let colour = |c: [f64; 3]| c.map(|v| format!("{:e}", v * brightness)).join(", ");
        let text = format!(
            "Scene(
    image: (width: 12, height: 9),
    camera: (look_from: {from}, look_at: {at}, up: (0.1, 1, 0), vertical_fov: 35, aperture: {aperture}, focus_distance: {focus}),
    background: Gradient(bottom: ({bottom}), top: ({top})),
    materials: {{
        \"checker\": Lambertian(albedo: Checker(scale: 0.4, even: (0.8, 0.7, 0.2), odd: (0.1, 0.2, 0.6))),
        \"image\": Lambertian(albedo: Image(path: \"image.png\")),
        \"noise\": Metal(albedo: Noise(scale: 3), fuzz: 0.3),
        \"marble\": Lambertian(albedo: Marble(scale: 5)),
        \"plain\": Lambertian(albedo: Rgb(0.5, 0.6, 0.7)),
        \"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb({lamp}), two_sided: false),
        \"screen\": DiffuseLight(emit: Checker(scale: 0.3, even: ({even}), odd: ({odd}))),
    }},
    objects: [Transformed(by: [Scale({scale:e}), Translate(({x:e}, {y:e}, {z:e}))], object: Group([
        Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"checker\"),
        Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
        Quad(corner: (-3, 0.3, -2.5), u: (1.5, 0, -0.4), v: (0, 1.5, 0), material: \"screen\"),
        Sphere(center: (-1.1, 0.7, 0), radius: 0.7, material: \"image\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.6, material: \"glass\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.25, material: \"plain\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.25, material: \"mirror\"),
        Transformed(by: [RotateY(30), Translate((1.3, 0, -0.7))], object: Box(min: (0, 0, 0), max: (0.8, 1.4, 0.9), material: \"marble\")),
        Transformed(by: [Scale(0.5), RotateX(20), RotateZ(10), Translate((-0.2, 0.4, -1.4))], object: Group([
            Box(min: (-1, -0.4, -1), max: (1, 1.3, 1), material: \"noise\"),
            Transformed(by: [Rotate(axis: (1, 2, 3), degrees: 50)], object: Sphere(center: (2.5, 0.5, 0), radius: 0.9, material: \"mirror\")),
        ])),
        Transformed(by: [Scale(0.5), RotateY(20), Translate((-0.4, 1.6, 0.3))], object: Mesh(path: \"octahedron.obj\", material: \"image\")),
        Transformed(by: [Scale(0.4), RotateX(10), Translate((0.9, 1.9, 0))], object: Mesh(path: \"octahedron.obj\", material: \"mirror\")),
        Transformed(by: [Scale(0.3), Translate((-1.4, 2, -0.5))], object: Mesh(path: \"flat.obj\", material: \"marble\")),
        Medium(boundary: Sphere(center: (0.4, 0.6, 0.6), radius: 0.6), density: {dense}, albedo: Rgb(0.2, 0.4, 0.9), anisotropy: 0.4),
        Medium(boundary: Box(min: (-2, 0.1, -1), max: (2, 1.5, 1.5)), density: {thin}, albedo: Checker(scale: 0.3, even: (0.9, 0.9, 0.9), odd: (0.2, 0.5, 0.2))),
        Medium(boundary: Transformed(by: [Scale(0.7), RotateZ(15), Translate((1.2, 0.8, 1))], object: Mesh(path: \"flat.obj\")), density: {thin}, albedo: Rgb(0.8, 0.8, 0.8), anisotropy: -0.3),
    ]))],
    render: (samples: 16, max_depth: 12),
)",
            from = point([0.5 + camera_shift, 1.7, 5.0]),
            at = point([0.0 + camera_shift, 0.7, 0.0]),
            dense = format_args!("{:e}", 4.0 / scale),
            thin = format_args!("{:e}", 0.5 / scale),
            aperture = length(0.3),
            focus = length(4.5),
            bottom = colour([0.1, 0.2, 0.3]),
            top = colour([0.6, 0.5, 0.9]),
            lamp = colour([5.0 * lamp, 4.0 * lamp, 3.0 * lamp]),
            even = colour([1.0, 0.0, 0.5]),
            odd = colour([0.0, 2.0, 0.5]),
        );
        scene_in(self.0.path(), &text)
    }
}

/// An octahedron with the normals of a sphere and texture coordinates.
fn octahedron() -> String {
    let mut text = String::new();
    for (x, y, z) in [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)] {
        text +=
            &format!("v {x} {y} {z}\nvn {x} {y} {z}\nvt {} {}\n", 0.3 + 0.4 * f64::from(x), 0.5 + 0.9 * f64::from(y));
    }
    for [a, b, c] in [[5, 1, 3], [1, 6, 3], [6, 2, 3], [2, 5, 3], [1, 5, 4], [6, 1, 4], [2, 6, 4], [5, 2, 4]] {
        text += &format!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n");
    }
    text
}

fn everything() -> (Everything, Scene) {
    let files = Everything::new();
    let scene = files.scene(World::default());
    (files, scene)
}

/// The film as a whole, and the picture bit by bit: two pictures compare as equal where a zero has the other sign, bits do not.
fn same(a: &Shot, b: &Shot) -> bool {
    let bits = |shot: &Shot| {
        let floats = shot.picture.rgb.iter().chain(&shot.picture.variance).flatten();
        floats.map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    a.film == b.film && bits(a) == bits(b) && a.picture.samples == b.picture.samples
}

/// Seeds, depth and samples change the image: else its sameness elsewhere would mean nothing.
#[test]
fn what_is_asked_changes_the_image() {
    let (_files, scene) = everything();
    let ask = Ask::spp(16);
    let usual = render(&scene, &ask);
    assert!(!same(&usual, &render(&scene, &ask.clone().seed(1))), "seed");
    assert!(!same(&usual, &render(&scene, &ask.clone().depth(5))), "depth");
    assert!(!same(&usual, &render(&scene, &Ask::spp(24))), "samples");
    let later = Ask { samples: Some(16..32), ..ask };
    assert!(!same(&usual, &render(&scene, &later)), "sample range");
}

#[test]
fn two_renders_in_a_row_are_the_same() {
    let (_files, scene) = everything();
    let usual = render(&scene, &Ask::spp(16));
    assert!(same(&usual, &render(&scene, &Ask::spp(16))), "made anew");
    // What a render leaves in the buffers must not reach the next.
    let again = render_each(&scene, &Ask::default(), &[0..16, 40..48, 0..16]);
    assert!(same(&usual, &again[0]) && same(&usual, &again[2]), "by one renderer");
}

#[test]
fn slots_workgroups_and_submissions_do_not_show() {
    let (_files, scene) = everything();
    // Whole runs, and runs cut at both ends. One path at a time, fewer than a row of pixels has, more than the image has runs; idle slots
    // cost time, so that the largest number comes only once with each kind of scatter.
    use Scatter::{Fused, Linked, Queues};
    let whole = [
        (Linked, 1, 64, 50),
        (Linked, 97, 1, 1),
        (Linked, 97, 256, 7),
        (Linked, 4096, 32, 50),
        (Queues, 1, 32, 7),
        (Queues, 97, 64, 1),
        (Queues, 4096, 256, 50),
        (Queues, 100_000, 64, 50),
        (Fused, 1, 64, 1),
        (Fused, 97, 32, 50),
        (Fused, 4096, 1, 7),
        (Fused, 100_000, 256, 50),
    ];
    let cut = [
        (Linked, 1, 1, 7),
        (Linked, 97, 32, 50),
        (Linked, 4096, 64, 1),
        (Linked, 100_000, 256, 7),
        (Queues, 1, 256, 50),
        (Queues, 97, 1, 7),
        (Queues, 4096, 32, 1),
        (Fused, 1, 32, 50),
        (Fused, 97, 1, 7),
        (Fused, 4096, 256, 1),
    ];
    for (samples, wishes) in [(0..16, whole.as_slice()), (3..21, cut.as_slice())] {
        let ask = |wish| Ask { samples: Some(samples.clone()), wish, ..Ask::default() };
        let usual = render(&scene, &ask(TuningWish::default()));
        for &(scatter, slots, workgroup, bounces) in wishes {
            let wish = TuningWish {
                slots: Some(slots),
                workgroup: Some(workgroup),
                bounces: Some(bounces),
                scatter: Some(scatter),
            };
            assert!(same(&usual, &render(&scene, &ask(wish))), "{samples:?}: {wish:?}");
        }
    }
}

#[test]
fn slots_and_parts_do_not_show_with_sobol_points() {
    use Scatter::{Fused, Linked, Queues};
    let (_files, scene) = everything();
    let ask = Ask::spp(24).sobol();
    let usual = render(&scene, &ask);
    assert!(!same(&usual, &render(&scene, &Ask::spp(24))), "the sampler changes the image");
    for (scatter, slots, workgroup, bounces) in [(Fused, 97, 32, 7), (Linked, 4096, 64, 50), (Queues, 97, 256, 7)] {
        let wish = TuningWish {
            slots: Some(slots),
            workgroup: Some(workgroup),
            bounces: Some(bounces),
            scatter: Some(scatter),
        };
        assert!(same(&usual, &render(&scene, &Ask { wish, ..ask.clone() })), "{wish:?}");
    }
    // Parity is that of the absolute number of a run; the first samples do not depend on how many there will be.
    let parts = render_each(&scene, &ask, &[8..24, 0..8]);
    assert!(joined([&parts[0].film, &parts[1].film]) == usual.film);
}

#[test]
fn bindings_do_not_show() {
    let (_files, scene) = everything();
    let usual = render(&scene, &Ask::spp(16));
    let ask = Ask { storage_tables: true, ..Ask::spp(16) };
    assert!(same(&usual, &render(&scene, &ask)), "all tables in storage bindings");
}

#[test]
fn parts_make_the_whole_in_any_order() {
    let (_files, scene) = everything();
    let parts = [0..8, 8..24, 24..32];
    let mut shots =
        render_each(&scene, &Ask::default(), &[0..32, parts[0].clone(), parts[1].clone(), parts[2].clone()]);
    let whole = shots.remove(0);
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        assert!(joined(order.map(|i| &shots[i].film)) == whole.film, "{order:?}");
    }
    // A part twice, or one of another seed, is another image.
    assert!(joined([0, 1, 1].map(|i| &shots[i].film)) != whole.film);
    let other = render(&scene, &Ask { samples: Some(24..32), ..Ask::default().seed(1) });
    assert!(joined([&shots[0].film, &shots[1].film, &other.film]) != whole.film);
}

fn joined<const N: usize>(films: [&Film; N]) -> Film {
    let mut all = films[0].clone();
    films[1..].iter().for_each(|film| all.merge(film).expect("parts of one image"));
    all
}

/// Cut within a run, the same samples are added in other groups: a sum of up to 8 positive values has 7 roundings of at most 2^-24
/// of itself on either side, and the picture one more each; 16 in all is 9.6e-7.
#[test]
fn parts_cut_within_a_run_make_the_whole_but_for_rounding() {
    let (_files, scene) = everything();
    let shots = render_each(&scene, &Ask::default(), &[0..32, 0..5, 5..19, 19..32]);
    let all = joined([&shots[1].film, &shots[2].film, &shots[3].film]);
    assert_eq!(all.totals(), shots[0].film.totals());
    let picture = all.develop();
    assert_eq!(picture.samples, shots[0].picture.samples);
    let differ = |bound: f32| {
        let pairs = picture.rgb.as_flattened().iter().zip(shots[0].picture.rgb.as_flattened());
        pairs.filter(|(a, b)| (*a - *b).abs() > bound * b.abs()).count()
    };
    assert_eq!(differ(9.6e-7), 0);
    assert!(differ(0.0) > 0, "all parts happen to have the same sums: this test has compared nothing");
}

#[test]
fn powers_of_two_of_the_scale_do_not_show() {
    let (files, scene) = everything();
    let usual = render(&scene, &Ask::spp(16));
    for exponent in [-40, -13, 13, 40] {
        let world = World { scale: 2f64.powi(exponent), ..World::default() };
        assert!(same(&usual, &render(&files.scene(world), &Ask::spp(16))), "2^{exponent}");
        let beside = World { camera_shift: 1e-6, ..world };
        assert!(!same(&usual, &render(&files.scene(beside), &Ask::spp(16))), "2^{exponent}, another camera");
    }
}

/// Other scales and places round the scene's numbers otherwise, so that some paths differ: other seeds and a statistical test tell
/// whether the image does. At 1e8 the scene is stored to 1.5e-8 of its unit.
///
/// The lamp is dim here, for little noise. The difference of two tiles of 8 x 8 pixels has a standard error of 0.7 % of them, up to 1.8 %
/// where the lamp is near (measured), so that 4 to 10 % of any tile are found, and 1.5 % of the whole. A camera moved by 0.1, a
/// fiftieth of its distance, changes the tiles with edges by more, and so does a lamp that is brighter by a half.
#[test]
fn scale_and_place_show_as_noise_at_most() {
    let files = Everything::new();
    let usual_world = World { lamp: 0.1, ..World::default() };
    let shot = |world: World, seed| render(&files.scene(world), &Ask::spp(256).size(32, 24).seed(seed));
    let usual = shot(usual_world, 10);
    let compare = |other: &Shot| same_expectation(&usual, other, 1e-5, 1e-6);
    let worlds = [
        World { scale: 1e3, ..usual_world },
        World { scale: 1e-7 / 3.0, ..usual_world },
        World { shift: [1e8, 0.0, 0.0], ..usual_world },
        World { shift: [-1e8 / 3.0, 1e8, -0.7e8], ..usual_world },
    ];
    for (seed, world) in (11..).zip(worlds) {
        let (scale, shift) = (world.scale, world.shift);
        compare(&shot(world, seed)).unwrap_or_else(|error| panic!("{scale} {shift:?}: {error}"));
    }
    let far = worlds[2];
    let moved = World { camera_shift: 0.1, ..far };
    assert!(compare(&shot(moved, 13)).is_err(), "a camera that is moved is not found");
    let bright = World { lamp: 0.15, ..far };
    assert!(compare(&shot(bright, 13)).is_err(), "a lamp that is brighter is not found");
}

#[test]
fn powers_of_two_of_the_radiance_scale_the_image_exactly() {
    let (files, scene) = everything();
    let usual = render(&scene, &Ask::spp(16));
    for exponent in [-60, 60] {
        let brightness = 2f64.powi(exponent);
        let world = World { brightness, ..World::default() };
        let scaled = |world: World| {
            let shot = render(&files.scene(world), &Ask::spp(16));
            assert_eq!(shot.film.totals(), usual.film.totals(), "paths and rays");
            shot.picture
        };
        let times = |v: f32, factor: f64| (f64::from(v) * factor) as f32;
        let picture = scaled(world);
        let expected: Vec<_> = usual.picture.rgb.iter().map(|rgb| rgb.map(|v| times(v, brightness))).collect();
        assert!(picture.rgb == expected, "2^{exponent}");
        // Variances scale with the square, as far as f32 holds them (the film overstates what it cannot hold).
        let pairs = picture.variance.as_flattened().iter().zip(usual.picture.variance.as_flattened());
        for (&found, &usual) in pairs {
            assert_eq!(found, times(usual, brightness * brightness).max(f32::MIN_POSITIVE.min(usual)), "2^{exponent}");
        }
        let one_lamp = World { lamp: 1.01, ..world };
        assert!(scaled(one_lamp).rgb != expected, "one lamp of three brighter by 1 % does not show");
    }
}
