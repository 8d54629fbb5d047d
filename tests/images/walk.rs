//! The BVH where many objects coincide.

use std::path::Path;

use crate::common::device;
use crate::common::render::render_job;
use gpu_rt::bvh::{self, Bounds, Quality};
use gpu_rt::data::{HIT_NOTHING, PRIMITIVE_BIT, Sampler};
use gpu_rt::film::Film;
use gpu_rt::gpu::probe;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{Integrator, RenderOptions, Scatter, Switch, Walk};
use gpu_rt::scene::Scene;

const QUALITIES: [Quality; 2] = [Quality::Medium, Quality::Best];

fn codes(count: usize) -> Vec<u32> {
    (0..count as u32).map(|i| PRIMITIVE_BIT | i).collect()
}

/// A lamp that is met first.
const LAMP: &str = "DiffuseLight(emit: Rgb(1, 1, 1))";
/// A surface that lets all light pass.
const NOTHING: &str = "Lambertian(albedo: Rgb(1, 1, 1), alpha: 0)";

/// A camera that looks at so many coincident quads of a material, and behind them a lamp.
fn coincident(material: &str, count: usize) -> String {
    let lamp = "Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0), material: \"near\"),";
    format!(
        "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
         background: Solid((0, 0, 0)),
         materials: {{ \"near\": {material}, \"far\": DiffuseLight(emit: Rgb(0, 1, 0)) }},
         objects: [{} Quad(corner: (-9, -9, -1), u: (18, 0, 0), v: (0, 18, 0), material: \"far\")])",
        lamp.repeat(count)
    )
}

fn render(material: &str, count: usize, scatter: Scatter) -> Film {
    let scene = Scene::parse(&coincident(material, count), Path::new("lamps.ron")).expect("the scene is valid");
    let options = RenderOptions {
        integrator: Integrator::Bsdf,
        roulette: Switch::Off,
        scatter: Some(scatter),
        slots: Some(1),
        ..RenderOptions::default()
    };
    let job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(8) };
    render_job(&scene, &options, &job, Sampler::Independent, |_| {}, &mut ()).0
}

/// A walk may take 48,000 steps where loops are limited, and 262,144 elsewhere. 30,000 coincident objects take 40,000 or so, and the
/// picture is right; 100,000 take too many for the first, and 250,000 for the second: then every sample is counted as cut short
/// and none is taken for a colour.
#[test]
fn a_walk_is_right_or_counted_as_cut_short() {
    let found = probe::numerics(device::software()).expect("the probe runs");
    let limited = found.loop_iterations < gpu_rt::gpu::numerics::LOOPS;
    for scatter in [Scatter::Fused, Scatter::Linked] {
        for (count, is_cut) in [(30_000, false), (100_000, limited), (250_000, true)] {
            let film = render(LAMP, count, scatter);
            let cut = if is_cut { 8 } else { 0 };
            assert_eq!((film.totals.rejected.cut, film.totals.rejected.total()), (cut, cut), "{scatter:?}, {count}");
            assert_eq!(u64::from(film.develop().samples[0]), 8 - cut, "{scatter:?}, {count}");
            if !is_cut {
                assert_eq!(film.develop().rgb[0], [1.0; 3], "{scatter:?}, {count}");
            }
        }
    }
}

/// Of quads that are passed, the lamp behind them is met, or the sample is counted as cut short.
#[test]
fn a_walk_that_passes_all_is_right_or_counted_as_cut_short() {
    for (count, cut) in [(30_000, 0), (250_000, 8)] {
        let film = render(NOTHING, count, Scatter::Fused);
        assert_eq!((film.totals.rejected.cut, film.totals.rejected.total()), (cut, cut), "{count}");
        assert!(cut > 0 || film.develop().rgb[0] == [0.0, 1.0, 0.0], "{count}");
    }
}

/// A mesh of coincident faces is right or counted as cut short, after as many steps by either walk.
#[test]
fn a_walk_through_a_mesh_is_right_or_counted_as_cut_short() {
    let folder = tempfile::tempdir().expect("a folder");
    for (count, cut) in [(20_000, 0), (300_000, 8)] {
        let faces = "f 1 2 3\n".repeat(count);
        std::fs::write(folder.path().join("faces.obj"), format!("v -9 -9 0\nv 9 -9 0\nv 0 18 0\n{faces}"))
            .expect("it is written");
        let text = coincident(LAMP, 1)
            .replace("Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0),", "Mesh(path: \"faces.obj\",");
        let scene = Scene::parse(&text, &folder.path().join("lamps.ron")).expect("the scene is valid");
        let [coded, siblings] = [Walk::Coded, Walk::Siblings].map(|walk| {
            let options = RenderOptions { walk, integrator: Integrator::Bsdf, ..RenderOptions::default() };
            let job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(8) };
            render_job(&scene, &options, &job, Sampler::Independent, |_| {}, &mut ()).0
        });
        assert_eq!(coded.totals, siblings.totals, "{count}");
        assert_eq!((coded.totals.rejected.cut, coded.totals.rejected.total()), (cut, cut), "{count}");
        assert_eq!(coded.develop().rgb, siblings.develop().rgb, "{count}");
        assert!(cut > 0 || coded.develop().rgb[0] == [1.0; 3], "{count}");
    }
}

/// Every primitive is reached exactly once from the root, however the boxes lie; and coincident boxes make no deep tree.
#[test]
fn every_primitive_is_in_the_tree_once() {
    let unit = Bounds { min: glam::Vec3::ZERO, max: glam::Vec3::ONE };
    let moved = |by: f32| Bounds { min: unit.min + by, max: unit.max + by };
    let many: Vec<(&str, Vec<Bounds>)> = vec![
        ("one", vec![unit]),
        ("two", vec![unit, moved(3.0)]),
        ("a row", (0..1000).map(|i| moved(i as f32)).collect()),
        (
            "one line",
            (0..10_000).map(|i| Bounds { min: glam::Vec3::X * i as f32, max: glam::Vec3::X * i as f32 }).collect(),
        ),
        ("one place", vec![unit; 10_000]),
        (
            "the whole range",
            (0..10_000).map(|i| Bounds { min: unit.max * (-3e34 * i as f32), max: unit.max * 3e38 }).collect(),
        ),
        ("two places", (0..10_000).map(|i| moved((i % 2) as f32)).collect()),
        (
            "ever smaller",
            (0..100).map(|i| Bounds { min: glam::Vec3::ZERO, max: glam::Vec3::splat(0.5f32.powi(i)) }).collect(),
        ),
    ];
    for (name, boxes, quality) in many.iter().flat_map(|(name, boxes)| QUALITIES.map(|quality| (name, boxes, quality)))
    {
        let codes = codes(boxes.len());
        let tree = bvh::build(boxes, &codes, quality);
        let mut found = vec![0; boxes.len()];
        let mut open = vec![(tree.root, 0)];
        let mut deepest = 0;
        while let Some((code, depth)) = open.pop() {
            if code & PRIMITIVE_BIT != 0 {
                found[(code & !PRIMITIVE_BIT) as usize] += 1;
                continue;
            }
            let node = tree.nodes[code as usize];
            let children = node.children.iter().filter(|child| **child != HIT_NOTHING);
            open.extend(children.map(|child| (*child, depth + 1)));
            deepest = deepest.max(depth);
        }
        assert!(found.iter().all(|&times| times == 1), "{name}: each primitive once");
        assert!(tree.stack_size <= 64, "{name}: a stack of {}", tree.stack_size);
        assert_eq!(deepest, tree.stack_size, "{name}");
    }
    assert_eq!(bvh::build(&[], &[], Quality::default()).root, HIT_NOTHING);
}

/// The nodes are the same on every run and for any number of threads; and they fit the bytes that a mesh has for them.
#[test]
fn threads_change_nothing_in_the_tree() {
    // Enough for several pieces of work, some of which coincide.
    let boxes: Vec<Bounds> = (0..100_000u32)
        .map(|i| {
            let at = |factor: u32| (i.wrapping_mul(factor) >> 8) as f32 / (1 << 24) as f32;
            let min = match i % 8 {
                0 => glam::Vec3::ZERO,
                _ => glam::Vec3::new(at(2_654_435_769), at(2_246_822_519), at(3_266_489_917)),
            };
            Bounds { min, max: min + 0.01 }
        })
        .collect();
    let codes = codes(boxes.len());
    for quality in QUALITIES {
        let one = bvh::build_with_threads(&boxes, &codes, quality, 1);
        for threads in [2, 3, 16] {
            assert!(bvh::build_with_threads(&boxes, &codes, quality, threads) == one, "{quality:?}, {threads} threads");
        }
        // Of 64 bytes each: 40 bytes a triangle is what there is room for.
        assert!(one.nodes.len() * 64 < 40 * boxes.len(), "{quality:?}: {} nodes", one.nodes.len());
    }
    let codes: Vec<u32> = codes.into_iter().rev().collect();
    let other = bvh::build_with_threads(&boxes, &codes, Quality::Medium, 1);
    assert!(
        other != bvh::build(&boxes, &self::codes(boxes.len()), Quality::Medium),
        "the comparison sees a difference"
    );
}
