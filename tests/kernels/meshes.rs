//! The two-level walk: it finds what a test of every face of every instance finds, to the bit, at any scale and position. The rays that leave
//! instances are in tests/extremes.

use glam::DVec3;
use gpu_rt::flatten::DeviceScene;

use crate::common::instances::{In, NOTHING, Out, ball_file, flat_around, kernel, run};
use crate::common::scenes::triple;
use crate::common::stats::Random;
use crate::common::vectors::{decades, exact, rounded, unit};

/// Instances of a ball of any size and turn within `extent` of the origin, all scaled and moved.
fn crowd(random: &mut Random, count: usize, extent: f64, scale: f64, shift: DVec3) -> Vec<String> {
    (0..count)
        .map(|_| {
            let size = extent * decades(random, -2.0, -0.3);
            format!(
                "Transformed(by: [Scale({size:?}), Rotate(axis: {}, degrees: {:?}), Translate({}), Scale({scale:?}), \
                 Translate({})], object: Mesh(path: \"ball.obj\", material: \"m\"))",
                triple(unit(random)),
                360.0 * random.uniform(),
                triple(extent * random.uniform() * unit(random)),
                triple(shift),
            )
        })
        .collect()
}

/// Rays within render space's unit cube at what stands there: from the eye, among it, and from afar; a quarter of them along axes.
fn rays(random: &mut Random, flat: &DeviceScene, count: usize) -> Vec<In> {
    (0..count)
        .map(|i| {
            let instance = flat.shapes.instances[random.below(flat.shapes.instances.len())];
            let (target, near) = (exact(instance.translation), f64::from(instance.scale));
            let origin = match i % 3 {
                0 => DVec3::ZERO,
                1 => target + near * random.uniform() * unit(random),
                _ => target + 10.0 * near * unit(random),
            };
            let mut direction = target + 1.5 * near * random.uniform() * unit(random) - origin;
            if i % 4 == 0 {
                direction[random.below(3)] = 0.0;
                direction[random.below(3)] = [0.0, -0.0, 1e-20][random.below(3)];
            }
            let direction = rounded(direction.normalize_or(DVec3::X));
            In { origin: rounded(origin), direction, root: flat.settings.root, request: 1, ..In::default() }
        })
        .collect()
}

/// An error that one ray in 11,000 shows is found but once in 1e6 times, and by `make test-long` one in 72,000.
#[test]
fn the_walk_finds_what_asking_every_face_finds() {
    walks_are_right(40_000);
}

#[test]
#[ignore = "minutes: make test-long"]
fn the_walks_of_a_million_rays_find_what_asking_every_face_finds() {
    walks_are_right(250_000);
}

/// With so many rays at each place.
fn walks_are_right(count: usize) {
    let mut random = Random(61);
    let stretch = DVec3::new(1.0, 0.7, 1.3);
    let mesh = ball_file(2, stretch);
    let faces = 8 * 16;
    // As it is; a million times smaller; far from the origin of the file, the camera with it; and far from the camera.
    for (scale, shift, eye) in [
        (1.0, DVec3::ZERO, DVec3::ZERO),
        (1e-6, DVec3::ZERO, DVec3::ZERO),
        (1.0, DVec3::new(1e6, -3e5, 2e6), DVec3::new(1e6, -3e5, 2e6)),
        (1.0, DVec3::new(300.0, -50.0, 100.0), DVec3::ZERO),
    ] {
        let flat = flat_around(eye, &mesh, &crowd(&mut random, 6, 1.0, scale, shift));
        let kernel = kernel(&flat, faces, &[]);
        let rays = rays(&mut random, &flat, count);
        let found = run(&kernel, &flat, &rays);
        let hits = found.iter().filter(|out| out.walked[0] != NOTHING).count();
        assert!(hits * 3 > rays.len(), "{hits} hits of {}", rays.len());
        let wrong = |found: &[Out]| found.iter().filter(|out| out.walked[..3] != out.brute_force[..3]).count();
        assert_eq!(wrong(&found), 0, "scale {scale:e}, moved by {shift}: of {}", rays.len());

        // A hierarchy whose upper planes are two steps too low misses some.
        let mut smaller = flat.clone();
        for node in &mut smaller.nodes {
            let shrink = |word: u32| (0..4).map(|i| (word >> (8 * i) & 255).saturating_sub(2) << (8 * i)).sum();
            node.high = node.high.map(shrink);
        }
        let missed = wrong(&run(&kernel, &smaller, &rays[..20_000]));
        assert!(missed > 20, "{missed}");
    }
}
