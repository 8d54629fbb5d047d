//! geometry/bounds: a child of a BVH node is never said to be missed where the ray meets what it holds.

use glam::{DVec3, Vec3};
use gpu_rt::bvh::{self, Bounds, Quality};
use gpu_rt::data::{Node, PRIMITIVE_BIT};

use crate::common::cuboids::within;
use crate::common::kernel::{Kernel, Plant, Setup, array};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// `CHILD_MISSED` of shaders/geometry/bounds.wgsl.
const CHILD_MISSED: u32 = 0xffff_ffff;
/// `VERY_FAR` of shaders/lib/float.wgsl, where the walk starts: 2^126.
const VERY_FAR: f32 = f32::from_bits(0x7e80_0000);

rows! {
    /// Hits count from the distance `begin` on.
    struct In {
        origin: [f32; 3], nearest: f32,
        direction: [f32; 3], node: u32,
        begin: f32, padding: [f32; 3],
    }

    struct Out {
        keys: [u32; 4],
        sorted: [u32; 4],
    }
}

/// The nodes over some boxes, and for each node its boxes by child.
#[derive(Default)]
struct Nodes {
    nodes: Vec<Node>,
    boxes: Vec<[Option<Bounds>; 4]>,
}

impl Nodes {
    /// Nodes of two to four boxes from flat to square, 1e-6 to 1 of the unit wide, up to 1000 units from the origin.
    fn assorted(random: &mut Random, count: usize, unit_length: f64) -> Nodes {
        let mut all = Nodes::default();
        for _ in 0..count {
            let middle = decades(random, -3.0, 3.0) * unit(random);
            let boxes: Vec<Bounds> = (0..2 + random.below(3))
                .map(|_| {
                    let size = decades(random, -6.0, 0.0);
                    let mut extent = size * DVec3::new(random.uniform(), random.uniform(), random.uniform());
                    if random.below(4) == 0 {
                        extent[random.below(3)] = 0.0;
                    }
                    let low = middle + decades(random, -6.0, 0.0) * unit(random);
                    let (low, high) = (unit_length * low, unit_length * (low + extent));
                    Bounds { min: Vec3::from(rounded(low)), max: Vec3::from(rounded(high)) }
                })
                .collect();
            let codes: Vec<u32> = (0..boxes.len() as u32).map(|i| PRIMITIVE_BIT | i).collect();
            let built = bvh::build(&boxes, &codes, Quality::default());
            assert_eq!(built.nodes.len(), 1, "up to four boxes make one node");
            let node = built.nodes[0];
            all.boxes.push(node.children.map(|code| boxes.get((code & !PRIMITIVE_BIT) as usize).copied()));
            all.nodes.push(node);
        }
        all
    }

    /// The box of a child as the grid has it, in f64, moved out by some roundings of what the ray meets on the way.
    fn decoded(&self, node: usize, child: usize, origin: DVec3) -> (DVec3, DVec3) {
        let node = &self.nodes[node];
        let at = exact([0, 1, 2].map(|axis| f32::from_bits(node.grid[axis])));
        let byte = |planes: [u32; 3]| DVec3::from_array(planes.map(|word| f64::from(word >> (8 * child) & 255)));
        let scale = DVec3::from_array(
            [0, 1, 2].map(|axis| f64::from(f32::from_bits((node.grid[3] >> (8 * axis) & 255) << 23))),
        );
        let blur = 24.0 * U * ((at - origin).abs() + 255.0 * scale);
        (at + byte(node.low) * scale - blur, at + byte(node.high) * scale + blur)
    }
}

/// Where a ray is within a closed box, in f64, from its origin on.
fn span(ray: &In, low: DVec3, high: DVec3) -> Option<(f64, f64)> {
    within(exact(ray.origin), exact(ray.direction), low, high, 0.0)
}

/// Rays at the insides, faces, edges and corners of the nodes' boxes; every other one is parallel to one or two axes, or
/// all but parallel. Every eighth is aimed beside.
fn rays_at(random: &mut Random, nodes: &Nodes, count: usize, unit_length: f64) -> Vec<In> {
    const SMALL: [f64; 8] = [0.0, -0.0, 1e-40, -1e-40, 1e-20, -1e-20, 1e-12, -1e-12];
    (0..count)
        .map(|i| {
            let node = i % nodes.nodes.len();
            let boxes: Vec<Bounds> = nodes.boxes[node].into_iter().flatten().collect();
            let at = boxes[random.below(boxes.len())];
            let (low, high) = (at.min.as_dvec3(), at.max.as_dvec3());
            let point = DVec3::from_array([0; 3].map(|_| match random.below(4) {
                0 => 0.0,
                1 => 1.0,
                _ => random.uniform(),
            }));
            let mut target = low + point * (high - low);
            if i % 8 == 0 {
                target += 3.0 * (high - low).length() * unit(random);
            }
            let target = rounded(target);
            let mut direction = unit(random);
            if i % 2 == 0 {
                let kept = random.below(3);
                for axis in 0..3 {
                    if axis != kept && random.below(4) != 0 {
                        direction[axis] = SMALL[random.below(SMALL.len())];
                    }
                }
            }
            let mut ray = In { direction: rounded(direction), node: node as u32, nearest: VERY_FAR, ..In::default() };
            ray.origin = rounded(exact(target) - unit_length * decades(random, -3.0, 3.0) * exact(ray.direction));
            // A ray along an axis stays in the plane that it is aimed at.
            for (axis, &target) in target.iter().enumerate() {
                if ray.direction[axis].abs() < 1e-10 {
                    ray.origin[axis] = target;
                }
            }
            ray
        })
        .collect()
}

/// What was found about the answers for all children of all rays' nodes.
#[derive(Debug, Default)]
struct Verdict {
    /// Children that the ray meets, and those of them that were denied or given an entry too late.
    hits: usize,
    denied: usize,
    /// Children that the ray passes by, and those of them that were entered.
    passed: usize,
    entered: usize,
}

fn judge(kernel: &Kernel, nodes: &Nodes, rays: &[In]) -> Verdict {
    let answers = kernel.run_with::<In, Out>(rays, rays.len(), &[array("nodes", &nodes.nodes)]);
    let mut found = Verdict::default();
    for (ray, out) in rays.iter().zip(&answers) {
        let mut sorted = out.keys;
        sorted.sort_unstable();
        assert_eq!(out.sorted, sorted);
        let node = ray.node as usize;
        let (begin, nearest) = (f64::from(ray.begin), f64::from(ray.nearest));
        for child in 0..4 {
            let key = out.keys[child];
            let Some(held) = nodes.boxes[node][child] else {
                assert_eq!(key, CHILD_MISSED, "a child that is not there was met");
                continue;
            };
            let (low, high) = nodes.decoded(node, child, exact(ray.origin));
            match span(ray, held.min.as_dvec3(), held.max.as_dvec3()) {
                // What is no farther than the nearest hit so far may replace it, a tie included.
                Some((enter, leave)) if enter <= nearest && leave >= begin => {
                    found.hits += 1;
                    let entry = f64::from(f32::from_bits(key & !3));
                    found.denied +=
                        usize::from(key == CHILD_MISSED || key & 3 != child as u32 || entry > enter.max(begin));
                }
                _ if span(ray, low, high).is_none_or(|(enter, leave)| enter > nearest || leave < begin) => {
                    found.passed += 1;
                    found.entered += usize::from(key != CHILD_MISSED);
                }
                _ => {}
            }
        }
    }
    found
}

/// This distance, or one within 5 % of it.
fn at_or_about(random: &mut Random, distance: f64) -> f32 {
    match random.below(2) {
        0 => distance as f32,
        _ => (distance * (1.0 + 0.1 * (random.uniform() - 0.5))) as f32,
    }
}

fn planted(number: usize) -> Kernel {
    const PLANTED: [Plant; 2] = [
        ("geometry/bounds", "8.0 * UNIT_ROUNDOFF * farthest", "0.0"),
        ("geometry/bounds", "farthest < FARTHEST_PLANE", "true"),
    ];
    Kernel::with("test/bounds", &Setup { plants: &PLANTED, ..Setup::default() }).planted(number)
}

#[test]
fn a_child_is_never_missed_where_the_ray_meets_what_it_holds() {
    let mut random = Random(31);
    let nodes = Nodes::assorted(&mut random, 5000, 1.0);
    let rays = rays_at(&mut random, &nodes, 100_000, 1.0);
    // Where the walk has found something already, at about the distance of one of the boxes, or just there.
    let later: Vec<In> = rays
        .iter()
        .map(|ray| {
            let boxes = nodes.boxes[ray.node as usize].into_iter().flatten();
            let mut entries = boxes.filter_map(|b| span(ray, b.min.as_dvec3(), b.max.as_dvec3()));
            let Some((enter, _)) = entries.next_back() else { return *ray };
            In { nearest: at_or_about(&mut random, enter), ..*ray }
        })
        .collect();
    // Where the walk begins behind something, at about the end of one of the boxes, or just there.
    let behind: Vec<In> = rays
        .iter()
        .map(|ray| {
            let boxes = nodes.boxes[ray.node as usize].into_iter().flatten();
            let mut ends = boxes.filter_map(|b| span(ray, b.min.as_dvec3(), b.max.as_dvec3()));
            let Some((_, leave)) = ends.next_back() else { return *ray };
            In { begin: at_or_about(&mut random, leave), ..*ray }
        })
        .collect();
    let own = Kernel::new("test/bounds");
    let narrow = planted(0);
    // A box that ends within rounding of where a walk begins may be entered: the distance to a plane along a ray that is all but parallel to it has
    // a larger error than `decoded` has. It costs a step.
    for (rays, share) in [(&rays, 0.0), (&later, 0.0), (&behind, 2e-3)] {
        let found = judge(&own, &nodes, rays);
        assert!(found.hits > 30_000 && found.passed > 100_000, "{found:?}");
        assert_eq!(found.denied, 0, "{found:?}");
        assert!(found.entered as f64 <= share * found.passed as f64, "{found:?}");
        // Without the allowance, edges, flat boxes and rays in faces are missed.
        let found = judge(&narrow, &nodes, rays);
        assert!(found.denied > 300, "{found:?}");
    }
}

/// Boxes for which the products of coordinates and reciprocals overflow.
#[test]
fn boxes_that_are_too_far_for_floats_are_never_missed() {
    let own = Kernel::new("test/bounds");
    let overflows = planted(1);
    let mut denied = 0;
    for unit_length in [1e10, 1e18, 1e25, 1e30] {
        let mut random = Random(32);
        let nodes = Nodes::assorted(&mut random, 1000, unit_length);
        let rays = rays_at(&mut random, &nodes, 20_000, unit_length);
        let found = judge(&own, &nodes, &rays);
        assert!(found.hits > 6000, "{found:?}");
        assert_eq!(found.denied, 0, "boxes of {unit_length:e}: {found:?}");
        denied += judge(&overflows, &nodes, &rays).denied;
    }
    assert!(denied > 1000, "{denied}");
}
