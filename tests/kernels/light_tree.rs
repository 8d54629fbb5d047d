//! scene/light_tree: lights are chosen as often as their probability says, which is told alike before and after; together they have all of
//! it, and each that can reach a point a part.

use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::data::{
    KIND_DELTA_LIGHT, LIGHT_NODE_LEAF, LIGHT_NODE_TWO_SIDED, Light, MAX_PRIMITIVES, PRIMITIVE_KIND_SHIFT,
};
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::gpu::link::reason_of;
use gpu_rt::options::RenderOptions;
use gpu_rt::scene::Scene;
use image::{Rgb, Rgb32FImage};

use crate::common::kernel::{Kernel, Setup, array, plan_of};
use crate::common::rows::rows;
use crate::common::scenes::triple;
use crate::common::stats::{Random, chi_square, sidak};
use crate::common::vectors::{U, exact, rounded, unit};

const ALPHA: f64 = 1e-6;

/// Draws for each point. Chi-square of 300 cells over 2^17 of them finds probabilities that are off by 4 % in the root mean square.
const DRAWS: usize = 1 << 17;

rows! {
    struct In { from: [f32; 3], padding: u32 }

    struct Out { index: u32, probability: f32, again: f32, of_row: f32 }
}

const SKY: &str = "Image(path: \"sky.hdr\")";

/// Lights of all shapes, of powers over three decades and turned anywhere, within a unit or so; among them lights without size.
fn lights(random: &mut Random, sky: bool, without_size: bool) -> DeviceScene {
    let mut objects: Vec<String> = (0..300)
        .map(|i| {
            let position = unit(random) * random.uniform();
            let size = 10f64.powf(-1.0 - 2.0 * random.uniform());
            let lamp = i % 8;
            match i % 7 {
                0..=1 => format!("Sphere(center: {}, radius: {size:?}, material: \"{lamp}\")", triple(position)),
                2 => {
                    let max = triple(position + DVec3::new(size, 0.5 * size, 2.0 * size));
                    format!("Box(min: {}, max: {max}, material: \"{lamp}\")", triple(position))
                }
                _ => {
                    let u = unit(random);
                    let v = u.cross(unit(random));
                    let (u, v) = (triple(size * u), triple(size * v));
                    format!("Quad(corner: {}, u: {u}, v: {v}, material: \"{lamp}\")", triple(position))
                }
            }
        })
        .collect();
    for i in (0..90).filter(|_| without_size) {
        let (at, towards) = (triple(random.uniform() * unit(random)), triple(unit(random)));
        let colour = triple(DVec3::splat(10f64.powf(-4.0 + 3.0 * random.uniform())));
        let outer = 10.0 + 80.0 * random.uniform();
        objects.push(match i % 9 {
            0..4 => format!("PointLight(at: {at}, intensity: {colour})"),
            4..8 => format!("SpotLight(at: {at}, towards: {towards}, intensity: {colour}, outer: {outer:?})"),
            _ => format!("DirectionalLight(direction: {towards}, irradiance: {colour})"),
        });
    }
    let lamp = |i: i32| {
        let emit = 2f64.powi(i);
        format!("\"{i}\": DiffuseLight(emit: Rgb({emit:?}, {emit:?}, {emit:?}), two_sided: {})", i == 3)
    };
    let lamps: Vec<String> = (0..8).map(lamp).collect();
    let background = if sky { SKY } else { "Solid((0, 0, 0))" };
    flattened((0, -1), background, &lamps.join(","), &objects.join(","))
}

/// Lights are sampled where something answers to them.
const GREY: &str = "\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))";
const RECEIVER: &str = "Quad(corner: (0, 0, 0.1), u: (0.01, 0, 0), v: (0, 0.01, 0), material: \"grey\")";

/// A scene seen along z from one place to another.
fn flattened((from, to): (i32, i32), background: &str, materials: &str, objects: &str) -> DeviceScene {
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, {from}), look_at: (0, 0, {to}), vertical_fov: 40),
        background: {background}, materials: {{{GREY}, {materials}}}, objects: [{objects}, {RECEIVER}])"
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let image = Rgb32FImage::from_pixel(16, 8, Rgb([1.0, 2.0, 3.0]));
    image::DynamicImage::from(image).save(folder.path().join("sky.hdr")).expect("the sky is written");
    let scene = Scene::parse(&text, &folder.path().join("test.ron")).expect("the test's scene is valid");
    flatten(&scene, (16, 16), &RenderOptions::default()).expect("the test's scene is small")
}

/// The kernel of a scene's lights, and answers to a point: `count` draws, which say the probability of as many lights.
fn kernel(flat: &DeviceScene) -> Kernel {
    let plan = plan_of(&flat.features);
    let lights = flat.features.quantities.lights.to_string();
    assert!(reason_of(&plan.facts, "several_lights").is_some(), "the light tree chooses one");
    Kernel::with("test/light_choice", &Setup { plan, values: &[("lights", &*lights)], ..Setup::default() })
}

fn draws(kernel: &Kernel, flat: &DeviceScene, from: [f32; 3], count: usize) -> Vec<Out> {
    let more = [array("lights", &flat.lights), array("light_nodes", &flat.light_nodes)];
    kernel.run_with(&[In { from, padding: 0 }], count, &more)
}

/// The probabilities of all lights at a point of render space: those with a position first and the sky last.
fn probabilities(flat: &DeviceScene, from: DVec3) -> Vec<f64> {
    let found = draws(&kernel(flat), flat, rounded(from), flat.lights.len());
    found.iter().map(|out| f64::from(out.of_row)).collect()
}

/// Whether the light's front is turned towards the point by more than rounding.
fn reaches(flat: &DeviceScene, light: &Light, from: DVec3) -> bool {
    let (kind, index) = (light.code >> PRIMITIVE_KIND_SHIFT & 15, light.code as usize % MAX_PRIMITIVES);
    if kind == KIND_DELTA_LIGHT {
        let spot = &flat.delta_lights[index];
        let way = (from - exact(spot.position)).normalize();
        return spot.has_position == 0.0
            || 0.5 * (way - exact(spot.axis)).length_squared() < f64::from(spot.height) - 1e-6;
    }
    if kind != 1 {
        return true;
    }
    let quad = &flat.shapes.quads[index];
    let to_point = (from - exact(quad.corner)).normalize();
    flat.materials[quad.material as usize].numbers[0] != 0.0 || to_point.dot(exact(quad.normal)) > 1e-3
}

#[test]
fn lights_are_chosen_as_often_as_is_said() {
    let mut random = Random(77);
    for (sky, without_size) in [(false, false), (true, false), (false, true), (true, true)] {
        let flat = lights(&mut random, sky, without_size);
        let count = flat.lights.len();
        assert_eq!(flat.light_nodes.len(), 2 * (count - 1));
        let kernel = kernel(&flat);
        // Among the lights, at the middle of one, and from afar.
        let mut points: Vec<[f32; 3]> = (0..6).map(|_| rounded(0.5 * random.uniform() * unit(&mut random))).collect();
        points.push(flat.shapes.spheres[3].center);
        points.extend([1.0, 30.0].map(|distance| rounded(distance * unit(&mut random))));
        for (i, from) in points.iter().enumerate() {
            let found = draws(&kernel, &flat, *from, DRAWS);
            let said: Vec<f64> = found[..count].iter().map(|out| f64::from(out.of_row)).collect();
            let sum: f64 = said.iter().sum();
            // Some twenty roundings of each on the way.
            assert!((sum - 1.0).abs() < 20.0 * U, "point {i}: {sum}");
            let mut chosen = vec![0u64; count];
            for out in &found {
                assert_eq!(out.probability.to_bits(), out.again.to_bits(), "point {i}: {out:?}");
                assert_eq!(f64::from(out.probability), said[out.index as usize], "point {i}: {out:?}");
                chosen[out.index as usize] += 1;
            }
            for (light, said) in flat.lights.iter().zip(&said) {
                assert!(*said > 0.0 || !reaches(&flat, light, exact(*from)), "point {i}: {light:?} is never chosen");
            }
            let expected = |of: &dyn Fn(usize) -> f64| (0..count).map(|i| DRAWS as f64 * of(i)).collect::<Vec<f64>>();
            let p = chi_square(&chosen, &expected(&|i| said[i]), 1);
            assert!(p > sidak(ALPHA, 2 * points.len()), "point {i}: p = {p:e}");
            // Planted: the neighbour's probability, and a tenth more for every other light.
            let neighbour = chi_square(&chosen, &expected(&|i| said[(i + 1) % count].max(1e-9)), 1);
            let more = |i: usize| said[i] * if i.is_multiple_of(2) { 1.1 } else { 1.0 };
            let all: f64 = (0..count).map(more).sum();
            let tenth = chi_square(&chosen, &expected(&|i| more(i) / all), 1);
            assert!(neighbour < ALPHA, "point {i}: shuffled probabilities are not found");
            assert!(i > 5 || tenth < 1e-3, "point {i}: {tenth:e}, 10 % more for every other light is not found");
        }
    }
}

#[test]
fn nearer_lights_and_those_turned_towards_a_point_are_chosen_more_often() {
    let flat = lights(&mut Random(78), false, false);
    let kernel = kernel(&flat);
    // At a sphere's middle nothing is nearer.
    let points: Vec<[f32; 3]> = flat.shapes.spheres.iter().map(|sphere| sphere.center).collect();
    let leaf = |light: u32| {
        let found = flat.light_nodes.iter().find(|node| node.child & !LIGHT_NODE_TWO_SIDED == LIGHT_NODE_LEAF | light);
        f64::from(found.expect("each light is a leaf").intensity)
    };
    let all: f64 = (0..flat.lights.len() as u32).map(leaf).sum();
    let share = |light: u32| leaf(light) / all;
    let gain = |from: [f32; 3], light: u32| {
        let found = draws(&kernel, &flat, from, flat.lights.len());
        (f64::from(found[light as usize].of_row) / share(light)).ln()
    };
    let mean = |shift: usize| {
        let other = |i: usize| flat.shapes.spheres[(i + shift) % points.len()].light;
        let gains = points.iter().enumerate().map(|(i, from)| gain(*from, other(i)));
        (gains.sum::<f64>() / points.len() as f64).exp()
    };
    assert!(mean(0) > 4.0, "{} times as often as by intensity", mean(0));
    assert!(mean(1) < 2.0, "another light {} times as often", mean(1));
}

/// Two lights are chosen by the tree as more are, and one with a sky; the sky as often as what it sends to every point says beside
/// what a lamp does, and between a tenth and nine tenths of all.
#[test]
fn the_tree_chooses_from_two_lights_and_from_a_lamp_and_its_sky() {
    let lamp = "\"lamp\": DiffuseLight(emit: Rgb(1000, 1000, 1000))";
    let sphere = |x: f64| format!("Sphere(center: ({x:?}, 0, 0), radius: 0.01, material: \"lamp\")");
    let scene = |background: &str, objects: &str| flattened((2, 0), background, lamp, objects);
    let probability = |flat: &DeviceScene, light: usize, from: DVec3| -> f64 {
        // The scene moved so that the camera is at the origin, and scaled by a power of two.
        let scale = f64::from(flat.shapes.spheres[0].radius) / 0.01;
        probabilities(flat, scale * (from - DVec3::new(0.0, 0.0, 2.0)))[light]
    };
    // At distances of 1 and 2, but for the balls around them.
    let two = scene("Solid((0, 0, 0))", &format!("{}, {}", sphere(0.0), sphere(3.0)));
    let found = probability(&two, 0, DVec3::X);
    assert!((found - 0.8).abs() < 1e-4, "{found}");
    // The lamp's radiance times its cross section over the squared distance, and half of what the sky sends in all.
    let flat = scene(SKY, &sphere(0.0));
    let sky = 0.5 * 4.0 * PI * (0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722);
    let of_lamp = |distance: f64| 1000.0 * PI * 1e-4 / (distance * distance);
    for distance in [0.02, 0.15, 0.3, 0.5, 10.0] {
        let expected = (sky / (sky + of_lamp(distance))).clamp(0.1, 0.9);
        let found = probability(&flat, 1, distance * DVec3::X);
        // The sky's cells are 16 by 8: their sines are off by 1e-2 together.
        assert!((found - expected).abs() < 1e-2, "{distance}: {found}, expected {expected}");
    }
    let least = probability(&flat, 1, DVec3::splat(1e-4));
    assert!((least - 0.1).abs() < 2.0 * U, "beside a lamp the sky keeps a tenth: {least}");
}

/// Lights without size beside each other: a spot is chosen just where its beam reaches, and as a point light there; directional lights
/// by their irradiance, against a sky and a point light between a tenth and nine tenths.
#[test]
fn lights_without_size_are_chosen_by_their_irradiance() {
    let scene = |background: &str, lights: &str| flattened((0, -1), background, "", lights);
    // Render space is the scene's, but for its scale of 8; the receiver's reach is 0.1.
    let probabilities = |flat: &DeviceScene, from: DVec3| probabilities(flat, 8.0 * from);
    let close = |found: &[f64], expected: &[f64]| {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.len() == expected.len() && off < 1e-4, "{found:?}, expected {expected:?}");
    };
    let point = "PointLight(at: (0, 0, 0), intensity: (1, 1, 1))";
    let spot = "SpotLight(at: (2, 0, 0), towards: (2, -1, 0), intensity: (1, 1, 1), outer: 45)";
    let two = scene("Solid((0, 0, 0))", &format!("{point}, {spot}"));
    // In the beam at distances of 1 and of the root of 5; beside it, and behind the light.
    close(&probabilities(&two, DVec3::new(2.0, -1.0, 0.0)), &[1.0 / 6.0, 5.0 / 6.0]);
    close(&probabilities(&two, DVec3::new(3.1, -1.0, 0.0)), &[1.0, 0.0]);
    close(&probabilities(&two, DVec3::new(2.0, 1.0, 0.0)), &[1.0, 0.0]);
    let suns = "DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3)),
        DirectionalLight(direction: (0, 0, -1), irradiance: (1, 1, 1))";
    close(&probabilities(&scene("Solid((0, 0, 0))", suns), DVec3::ONE), &[0.75, 0.25]);
    let beside = scene("Solid((0, 0, 0))", &format!("{point}, {suns}"));
    for (distance, of_point) in [(0.5, 0.5), (1.0, 0.2), (0.01, 0.9), (100.0, 0.1)] {
        let suns = 1.0 - of_point;
        close(&probabilities(&beside, distance * DVec3::X), &[of_point, 0.75 * suns, 0.25 * suns]);
    }
    // The sky has half of 4 pi times its luminance, and at least a tenth of the lights without a position.
    let luminance = 0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722;
    let sky = 2.0 * PI * luminance;
    let all = scene(SKY, &format!("{point}, {suns}"));
    let found = probabilities(&all, 0.5 * DVec3::X);
    let of_point = 4.0 / (8.0 + sky);
    let of_suns = (1.0 - of_point) * 4.0 / (4.0 + sky);
    let off =
        [of_point, 0.75 * of_suns, 0.25 * of_suns].iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-2 && found.len() == 4, "{found:?}");
}
