//! The two-level walk: it finds what asking every face of every instance finds, to the bit, at any scale and place; and rays that leave
//! an instance do not meet the face that they left, whatever transform placed it.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use gpu_rt::flatten::{Flat, flatten};
use gpu_rt::plan::{Tables, choices_of};
use gpu_rt::scene::Scene;

use crate::kernel::{Kernel, Setup, array};
use crate::scenes::triple;
use crate::stats::Random;
use crate::vectors::{decades, exact, rounded, unit};

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct In {
    origin: [f32; 3],
    root: u32,
    direction: [f32; 3],
    ask: u32,
    leaving: [f32; 3],
    padding: u32,
}

/// As the shader's Hit: code, instance, t as bits, steps.
type Hit = [u32; 4];

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Out {
    walked: Hit,
    asked: Hit,
    point: [f32; 3],
    again: f32,
    normal: [f32; 3],
    again_code: u32,
    start: [f32; 3],
    again_instance: u32,
}

const NOTHING: u32 = u32::MAX;

/// The corners and faces of an octahedron, each face cut into four so many times; on the unit sphere.
fn ball(cuts: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let mut corners = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut faces = vec![[4, 0, 2], [0, 5, 2], [5, 1, 2], [1, 4, 2], [0, 4, 3], [5, 0, 3], [1, 5, 3], [4, 1, 3]];
    for _ in 0..cuts {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize, corners: &mut Vec<DVec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                corners.push((corners[a] + corners[b]).normalize());
                corners.len() - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b, &mut corners), middle(b, c, &mut corners), middle(c, a, &mut corners));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (corners, faces)
}

/// The ball as an OBJ file, stretched along its axes.
fn ball_file(cuts: u32, stretch: DVec3) -> String {
    let (corners, faces) = ball(cuts);
    let mut text = String::new();
    for p in corners {
        let p = stretch * p;
        writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).expect("a string takes text");
    }
    for [a, b, c] in faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string takes text");
    }
    text
}

/// Objects of the material "m" around a camera at `eye`, with "ball.obj" beside the scene.
fn flat_around(eye: DVec3, mesh: &str, objects: &[String]) -> Flat {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ball.obj"), mesh).expect("the mesh is written");
    let at = eye + DVec3::X * eye.abs().max_element().max(1.0);
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: {}, look_at: {}, vertical_fov: 40),\n\
         background: Solid((1, 1, 1)), materials: {{\"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}}, objects: [{}])",
        triple(eye),
        triple(at),
        objects.join(",\n")
    );
    let scene = Scene::parse(&text, &folder.path().join("test.ron")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.location(&[]).file, folder.path().join(Path::new("test.ron")));
    flatten(&scene, (16, 16)).expect("the test's scene is small")
}

fn kernel(flat: &Flat, faces: usize, replaced: &[(&str, &str)]) -> Kernel {
    let plan = choices_of(&flat.features, &Tables::default());
    let (instances, faces) = (flat.instances.len().to_string(), faces.to_string());
    let values = [("instances", &*instances), ("faces", &*faces)];
    Kernel::with("test/meshes", &Setup { plan, values: &values, replaced, ..Setup::default() })
}

fn run(kernel: &Kernel, flat: &Flat, rays: &[In]) -> Vec<Out> {
    let tables = [
        array("nodes", &flat.nodes),
        array("spheres", &flat.spheres),
        array("instances", &flat.instances),
        array("meshes", &flat.meshes),
    ];
    kernel.run_with(rays, rays.len(), &tables)
}

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
fn rays(random: &mut Random, flat: &Flat, count: usize) -> Vec<In> {
    (0..count)
        .map(|i| {
            let instance = flat.instances[random.below(flat.instances.len())];
            let (target, near) = (exact(instance.place), f64::from(instance.scale));
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
            In { origin: rounded(origin), direction, root: flat.settings.root, ask: 1, ..In::default() }
        })
        .collect()
}

#[test]
fn the_walk_finds_what_asking_every_face_finds() {
    let mut random = Random(61);
    let stretch = DVec3::new(1.0, 0.7, 1.3);
    let mesh = ball_file(2, stretch);
    let faces = 8 * 16;
    let mut asked = 0;
    // As it is; a million times smaller; far from the origin of the file, the camera with it; and far from the camera.
    for (scale, shift, eye) in [
        (1.0, DVec3::ZERO, DVec3::ZERO),
        (1e-6, DVec3::ZERO, DVec3::ZERO),
        (1.0, DVec3::new(1e6, -3e5, 2e6), DVec3::new(1e6, -3e5, 2e6)),
        (1.0, DVec3::new(300.0, -50.0, 100.0), DVec3::ZERO),
    ] {
        let flat = flat_around(eye, &mesh, &crowd(&mut random, 6, 1.0, scale, shift));
        let kernel = kernel(&flat, faces, &[]);
        let rays = rays(&mut random, &flat, 250_000);
        let found = run(&kernel, &flat, &rays);
        let hits = found.iter().filter(|out| out.walked[0] != NOTHING).count();
        assert!(hits * 3 > rays.len(), "{hits} hits of {}", rays.len());
        let wrong = |found: &[Out]| found.iter().filter(|out| out.walked[..3] != out.asked[..3]).count();
        assert_eq!(wrong(&found), 0, "scale {scale:e}, moved by {shift}: of {}", rays.len());
        asked += rays.len();

        // A hierarchy whose upper planes are two steps too low misses some.
        let mut smaller = flat.clone();
        for node in &mut smaller.nodes {
            let shrink = |word: u32| (0..4).map(|i| (word >> (8 * i) & 255).saturating_sub(2) << (8 * i)).sum();
            node.high = node.high.map(shrink);
        }
        let missed = wrong(&run(&kernel, &smaller, &rays[..20_000]));
        assert!(missed > 20, "{missed}");
    }
    assert_eq!(asked, 1_000_000);
}

/// Rays from the eye at a ball of a relative size, placed by a transform; what happens to those that leave it again. The result is
/// how many there were, and how many met the face that they left, met the ball though they left it outwards, and lost the inside though
/// they went in.
fn leave(random: &mut Random, size: f64, place: f64, replaced: &[(&str, &str)]) -> [usize; 4] {
    const RAYS: usize = 20_000;
    let mesh = ball_file(3, DVec3::ONE);
    let center = place * unit(random);
    let object = format!(
        "Transformed(by: [Rotate(axis: {}, degrees: 77), Scale({size:?}), Translate({})], object: Mesh(path: \"ball.obj\", \
         material: \"m\"))",
        triple(unit(random)),
        triple(center)
    );
    let flat = flat_around(DVec3::ZERO, &mesh, &[object]);
    let instance = flat.instances[0];
    let (at, radius) = (exact(instance.place), f64::from(instance.scale));
    let rays: Vec<In> = (0..RAYS)
        .map(|i| {
            let target = at + 0.9 * radius * random.uniform() * unit(random);
            let origin = target + 3.0 * radius * unit(random);
            let direction = rounded((target - origin).normalize());
            let leaving = rounded(unit(random));
            let origin = if i % 2 == 0 { rounded(origin) } else { rounded(at + 0.5 * radius * unit(random)) };
            In { origin, direction, root: flat.settings.root, leaving, ..In::default() }
        })
        .collect();
    let found = run(&kernel(&flat, 8 * 64, replaced), &flat, &rays);
    let mut counts = [0; 4];
    for (out, ray) in found.iter().zip(&rays) {
        if out.walked[0] == NOTHING {
            continue;
        }
        let cosine = exact(ray.leaving).dot(exact(out.normal));
        counts[0] += 1;
        counts[1] += usize::from(out.again >= 0.0 && out.again_code == out.walked[0]);
        counts[2] += usize::from(cosine > 0.0 && out.again >= 0.0);
        // At less than a tenth to the surface, a facet's chord is as short as what rounding moves a point by.
        counts[3] += usize::from(cosine < -0.1 && out.again < 0.0);
    }
    counts
}

#[test]
fn rays_that_leave_an_instance_do_not_meet_it_again() {
    let mut random = Random(62);
    // The size of the ball, and the distance of its middle from the eye. Beyond a ratio of 1e5 the inside of the ball is some hundred
    // floats wide, and chords near its edge are lost.
    for (size, place) in
        [(1.0, 0.0), (1.0, 1.0), (1e-4, 0.0), (1e4, 3e3), (1e-4, 1e-2), (1.0, 1e3), (1e-4, 1.0), (1e4, 1e8)]
    {
        let [rays, same, outwards, lost] = leave(&mut random, size, place, &[]);
        assert!(rays > 10_000, "{rays}");
        assert_eq!([same, outwards, lost], [0, 0, 0], "size {size:e} at {place:e}, of {rays}");
    }
    // Without the offset many do.
    let planted = [("geometry/offset", "test/control/offset_none")];
    let [rays, same, ..] = leave(&mut random, 1.0, 1e3, &planted);
    assert!(same > 100, "{same} of {rays}");
}
