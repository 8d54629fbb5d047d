//! The BVH where many objects lie in one place.

use std::path::Path;

#[path = "common/device.rs"]
mod device;

use gpu_rt::bvh::{self, Bounds, Quality};
use gpu_rt::data::HIT_NOTHING;
use gpu_rt::film::Film;
use gpu_rt::flatten::flatten;
use gpu_rt::plan::{Plan, Scatter};
use gpu_rt::render::{Goal, Job, Next, Renderer, TuningWish};
use gpu_rt::scene::Scene;

/// A camera that looks at so many coincident lamps, and behind them one of another colour.
fn coincident_lamps(count: usize) -> String {
    let lamp = "Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0), material: \"near\"),";
    format!(
        "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
         background: Solid((0, 0, 0)),
         materials: {{ \"near\": DiffuseLight(emit: Rgb(1, 1, 1)), \"far\": DiffuseLight(emit: Rgb(0, 1, 0)) }},
         objects: [{} Quad(corner: (-9, -9, -1), u: (18, 0, 0), v: (0, 18, 0), material: \"far\")])",
        lamp.repeat(count)
    )
}

fn render(count: usize, scatter: Scatter) -> Film {
    let scene = Scene::parse(&coincident_lamps(count), Path::new("lamps.ron")).expect("the scene is valid");
    let flat = flatten(&scene, (1, 1)).expect("it flattens");
    let plan = Plan::new(&flat.features, scatter).expect("it links");
    let job = Job { size: (1, 1), max_depth: 1, seed: 0, first_sample: 0, goal: Goal::Samples(8) };
    let wish = TuningWish { slots: Some(1), ..TuningWish::default() };
    let mut renderer = Renderer::new(device::software(), &flat, &plan, &job, wish, false).expect("it compiles");
    let mut film = Film::new(1, 1, flat.radiance_exponent).expect("a pixel fits");
    renderer.run(&job, &mut film, &mut |_, _| Next::GoOn).expect("it renders");
    film
}

/// A walk may take 48,000 steps. 30,000 coincident objects take 40,000 or so, and the picture is right; 100,000 take too
/// many, and then every sample is counted as cut short and none is taken for a colour.
#[test]
fn a_walk_is_right_or_counted_as_cut_short() {
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let right = render(30_000, scatter);
        assert_eq!(right.totals().rejected.total(), 0, "{scatter:?}");
        assert_eq!(right.develop().rgb[0], [1.0; 3], "{scatter:?}");
        let cut = render(100_000, scatter);
        assert_eq!(cut.totals().rejected.cut, 8, "{scatter:?}");
        assert_eq!(cut.develop().samples[0], 0, "{scatter:?}");
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
        ("one place", vec![unit; 10_000]),
        ("two places", (0..10_000).map(|i| moved((i % 2) as f32)).collect()),
        (
            "ever smaller",
            (0..100).map(|i| Bounds { min: glam::Vec3::ZERO, max: glam::Vec3::splat(0.5f32.powi(i)) }).collect(),
        ),
    ];
    for (name, boxes) in many {
        let codes: Vec<u32> = (0..boxes.len() as u32).map(|i| gpu_rt::data::PRIMITIVE_BIT | i).collect();
        let tree = bvh::build(&boxes, &codes, Quality::default());
        let mut found = vec![0; boxes.len()];
        let mut open = vec![tree.root];
        let mut deepest = 0;
        while let Some(code) = open.pop() {
            if code & gpu_rt::data::PRIMITIVE_BIT != 0 {
                found[(code & !gpu_rt::data::PRIMITIVE_BIT) as usize] += 1;
                continue;
            }
            let node = tree.nodes[code as usize];
            open.extend(node.children.iter().filter(|child| **child != HIT_NOTHING));
            deepest = deepest.max(open.len());
        }
        assert!(found.iter().all(|&times| times == 1), "{name}: each primitive once");
        assert!(tree.stack_size <= 3 * 64, "{name}: a stack of {}", tree.stack_size);
        assert!(deepest <= tree.stack_size as usize + 1, "{name}: {deepest} waiting, {} reserved", tree.stack_size);
    }
    assert_eq!(bvh::build(&[], &[], Quality::default()).root, HIT_NOTHING);
}
