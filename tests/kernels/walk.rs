//! scene/traverse: the walk through the BVH finds what asking every primitive finds, to the bit.

use glam::DVec3;
use gpu_rt::data::Node;

use crate::common::kernel::{Kernel, Setup, plan_of};
use crate::common::scenes::{flat, triple};
use crate::common::stats::Random;
use crate::common::trace::{ThroughTree, walk};
use crate::common::vectors::{decades, rounded, unit};

/// Spheres, quads and boxes of sizes over three decades within a few units, every tenth twice, and a floor below them.
fn clutter(random: &mut Random) -> Vec<String> {
    let mut objects: Vec<String> = (0..270)
        .map(|i| {
            let at = 4.0 * unit(random) * random.uniform();
            let size = decades(random, -2.5, 0.3);
            let mut vector = || unit(random) * size;
            match i % 3 {
                0 => format!("Sphere(center: {}, radius: {size:?}, material: \"m\")", triple(at)),
                1 => {
                    let (u, v) = (vector(), vector());
                    format!("Quad(corner: {}, u: {}, v: {}, material: \"m\")", triple(at), triple(u), triple(v))
                }
                _ => {
                    let edges = vector().abs() + 0.01 * size;
                    let cuboid = format!("Box(min: {}, max: {}, material: \"m\")", triple(at), triple(at + edges));
                    match i % 2 {
                        0 => cuboid,
                        _ => format!("Transformed(by: [RotateY(30), RotateX(20)], object: {cuboid})"),
                    }
                }
            }
        })
        .collect();
    let twice: Vec<String> = objects.iter().step_by(10).cloned().collect();
    objects.extend(twice);
    objects.push("Quad(corner: (-10, -3, -10), u: (0, 0, 20), v: (20, 0, 0), material: \"m\")".to_string());
    objects
}

#[test]
fn the_walk_finds_what_asking_every_primitive_finds() {
    let mut random = Random(41);
    let scene = flat(&clutter(&mut random));
    let counts =
        [scene.shapes.spheres.len(), scene.shapes.quads.len(), scene.shapes.cuboids.len()].map(|n| n.to_string());
    let plan = plan_of(&scene.features);
    let values = [("spheres", &*counts[0]), ("quads", &*counts[1]), ("cuboids", &*counts[2])];
    let kernel = Kernel::with("test/walk", &Setup { plan, values: &values, ..Setup::default() });
    let rays: Vec<ThroughTree> = (0..20_000)
        .map(|i| {
            // From the eye, from among the objects, and from afar, at something among them.
            let origin = [0.0, 0.2, 3.0][i % 3] * unit(&mut random);
            let mut direction = 0.2 * random.uniform() * unit(&mut random) - origin;
            if i % 4 == 0 {
                // Along an axis, or in a plane of two.
                direction[random.below(3)] = 0.0;
                direction[random.below(3)] = [0.0, -0.0, 1e-20, 1e-40][random.below(4)];
            }
            let towards = rounded(direction.normalize_or(DVec3::X));
            ThroughTree { origin: rounded(origin), direction: towards, root: scene.settings.root, padding: 0 }
        })
        .collect();
    let wrong =
        |found: &[[[u32; 4]; 2]]| found.iter().filter(|[walked, brute_force]| walked[..2] != brute_force[..2]).count();
    let found = walk(&kernel, &scene, &scene.nodes, &rays);
    let hits = found.iter().filter(|[walked, _]| walked[0] != u32::MAX).count();
    assert!(hits * 2 > rays.len(), "{hits} hits of {}", rays.len());
    assert_eq!(wrong(&found), 0, "of {}", rays.len());
    // The walk looks at few of the 298 primitives and their nodes: measured 23 a ray.
    let steps: u32 = found.iter().map(|[walked, _]| walked[2]).sum();
    assert!(steps < 40 * rays.len() as u32, "{} steps a ray", f64::from(steps) / rays.len() as f64);

    // Upper planes two steps of their grid too low: a few rays in a thousand find something else.
    let smaller = scene.nodes.iter().map(|node| {
        let shrink = |word: u32| (0..4).map(|i| (word >> (8 * i) & 255).saturating_sub(2) << (8 * i)).sum();
        Node { high: node.high.map(shrink), ..*node }
    });
    let missed = wrong(&walk(&kernel, &scene, &smaller.collect::<Vec<_>>(), &rays));
    assert!(missed > 20, "{missed}");
}
