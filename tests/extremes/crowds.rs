//! No object, one, a million, and ten thousand that coincide.

use std::io::Write;

use glam::{DVec3, Vec3};
use gpu_rt::bvh::{self, Bounds, Quality};
use gpu_rt::data::{PRIMITIVE_BIT, Sphere};
use gpu_rt::flatten::DeviceScene;

use crate::common::kernel::{Kernel, Overlay, Setup, plan_of};
use crate::common::render::{Request, diagnostics, render, render_planted, scene_in};
use crate::common::scenes::flat;
use crate::common::stats::Random;
use crate::common::trace::{ThroughTree, walk};
use crate::common::vectors::{U, decades, exact, rounded, unit};
use crate::geometry::{farthest, scene};
use crate::table::Cell;

const MILLION: usize = 1 << 20;

/// The table's cells of how many objects there are.
pub fn cells() -> Vec<Cell> {
    let mut all = few();
    all.extend(coincident());
    all.push(triangles());
    all.push(spheres());
    all
}

const CAMERA: &str = "(look_from: (1.08, 1.44, 2.4), look_at: (0, 0, 0), vertical_fov: 20)";

fn few() -> Vec<Cell> {
    let one = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")";
    [("0", "", 1.0), ("1", one, 0.5)]
        .map(|(range, objects, expected)| {
            let shot = render(&scene(CAMERA, 1.0, objects), &Request::spp(64));
            let figure = "Largest difference from the radiance of the sky, or of a convex body of albedo 0.5";
            let because = "none, because every path contributes the same radiance.";
            Cell::new(range, figure, 0.0, because).achieved(farthest(&shot, expected))
        })
        .into()
}

/// The number of bodies that coincide, all but the first lamps.
fn crowd(body: &str, count: usize, first: &str) -> String {
    body.replace("ITS", first) + "," + &(body.replace("ITS", "both") + ",").repeat(count - 1)
}

/// Bodies that coincide, of which the first is grey and the others are lamps.
fn coincident() -> Vec<Cell> {
    let bodies = [
        ("spheres", 10_000, "Sphere(center: (0, 0, 0), radius: 1, material: \"ITS\")"),
        ("quads", 10_000, "Quad(corner: (-2, -2, 0), u: (4, 0, 0), v: (0, 4, 0), material: \"ITS\")"),
        ("boxes", 10_000, "Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"ITS\")"),
        // A walk may take 48,000 steps where loops are limited, and through each of these it takes some ten.
        ("meshes", 2000, "Transformed(by: [Scale(1.1)], object: Mesh(path: \"ball.obj\", material: \"ITS\"))"),
    ];
    let mut all: Vec<Cell> = bodies.map(|(name, count, body)| coincident_cell(name, count, body)).into();
    all.push(too_many(10_000, bodies[3].2));
    all
}

fn coincident_cell(name: &str, count: usize, body: &str) -> Cell {
    let pixels = |count: usize, first: &str| {
        let shot = render(&scene(CAMERA, 1.0, &crowd(body, count, first)), &Request::spp(8).size(8, 8));
        shot.picture.rgb.into_flattened()
    };
    let one = pixels(1, "grey");
    let differ = |other: Vec<f32>| one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    Cell::new(
        format!("{count} coincident {name}"),
        "Largest difference from the image of the first object in the file",
        0.0,
        "none, because the first object in the file wins if two hits have the same distance.",
    )
    .achieved(differ(pixels(count, "grey")))
    .planted("image of another object", differ(pixels(count, "both")))
}

/// More coincident meshes than a walk may go through where loops are limited: the render counts and tells what it
/// cuts, and the scene is warned of.
fn too_many(count: usize, body: &str) -> Cell {
    let scene = scene(CAMERA, 1.0, &crowd(body, count, "grey"));
    let shot = render_planted(&scene, &Request::spp(8).size(8, 8), &Overlay::new(&[]));
    let totals = shot.film.totals;
    Cell::new(
        format!("{count} coincident meshes"),
        "Share of samples that are cut short; `check` may warn instead",
        0.0,
        "none, because a walk may take 48,000 steps if the driver limits loops, and 262,144 steps if not.",
    )
    .achieved(totals.rejected.cut as f64 / totals.paths as f64)
    .warns(diagnostics(&scene))
}

/// A plate of 2^20 triangles with its vertices moved about within it, all of it a lamp: no ray passes between them.
fn triangles() -> Cell {
    const SIDES: [usize; 2] = [1024, 512];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut random = Random(81);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        (SIDES[0] + 1) * (SIDES[1] + 1),
        MILLION,
    )
    .into_bytes();
    for i in 0..=SIDES[0] {
        for j in 0..=SIDES[1] {
            let at = DVec3::new(i as f64, j as f64, 0.0) + 0.3 * unit(&mut random);
            for x in rounded(at / SIDES[1] as f64 - DVec3::new(1.0, 0.5, 0.0)) {
                bytes.extend(x.to_le_bytes());
            }
        }
    }
    let at = |i: usize, j: usize| (i * (SIDES[1] + 1) + j) as u32;
    for i in 0..SIDES[0] {
        for j in 0..SIDES[1] {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for face in [[a, b, c], [a, c, d]] {
                bytes.push(3);
                face.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
            }
        }
    }
    let mut file = std::fs::File::create(folder.path().join("plate.ply")).expect("the mesh is created");
    file.write_all(&bytes).expect("the mesh is written");
    let scene = scene_in(
        folder.path(),
        "Scene(image: (width: 64, height: 64), camera: (look_from: (0.1, 0.2, 1), look_at: (0, 0, 0), vertical_fov: 40),
         background: Solid((0, 0, 0)), materials: { \"both\": DiffuseLight(emit: Rgb(1, 1, 1)) },
         objects: [Transformed(by: [RotateX(10)], object: Mesh(path: \"plate.ply\", material: \"both\"))])",
    );
    let shot = render(&scene, &Request::spp(8));
    Cell::new(
        "2^20 triangles of a mesh",
        "Largest share of light that is lost between two triangles",
        0.0,
        "none, because a ray through an edge hits one of its two triangles.",
    )
    .achieved(farthest(&shot, 1.0))
}

/// 2^20 spheres of radii over two decades in a ball around the eye: the walk, against every one of them in f64.
fn spheres() -> Cell {
    const RAYS: usize = 128;
    let mut random = Random(82);
    let spheres: Vec<Sphere> = (0..MILLION)
        .map(|order| {
            let center = rounded(random.uniform().cbrt() * unit(&mut random));
            let radius = decades(&mut random, -4.5, -2.5) as f32;
            Sphere { center, radius, order: order as u32, ..Sphere::default() }
        })
        .collect();
    let bounds: Vec<Bounds> = spheres
        .iter()
        .map(|sphere| {
            let (center, reach) = (Vec3::from(sphere.center), sphere.radius + 16.0 * U as f32);
            Bounds { min: center - reach, max: center + reach }
        })
        .collect();
    let codes: Vec<u32> = (0..MILLION as u32).map(|i| PRIMITIVE_BIT | i).collect();
    let tree = bvh::build(&bounds, &codes, Quality::default());
    let rays: Vec<ThroughTree> = (0..RAYS)
        .map(|_| {
            let origin = rounded(0.9 * random.uniform() * unit(&mut random));
            ThroughTree { origin, direction: rounded(unit(&mut random)), root: tree.root, padding: 0 }
        })
        .collect();
    // Linked as for a scene of spheres alone, with a stack for this tree.
    let one = flat(&["Sphere(center: (0, 0, -2), radius: 1, material: \"m\")".to_string()]);
    let mut features = one.features.clone();
    features.quantities.stack_size = tree.stack_size.max(1);
    let plan = plan_of(&features);
    let values = [("spheres", "0"), ("quads", "0"), ("cuboids", "0")];
    let kernel = Kernel::with("test/walk", &Setup { plan, values: &values, ..Setup::default() });
    // Nearest crossing ahead in f64; what is within the error of the edge, or of the distance of another, may be
    // decided either way.
    let truth: Vec<(f64, f64)> = rays.iter().map(|ray| nearest(ray, &spheres)).collect();
    let mut scene = DeviceScene::default();
    scene.shapes.spheres = spheres;
    let wrong = |found: &[[[u32; 4]; 2]]| {
        let off = found.iter().zip(&truth).filter(|([walked, _], (surely, maybe))| {
            let t = if walked[0] == u32::MAX { f64::INFINITY } else { f64::from(f32::from_bits(walked[1])) };
            !(t >= maybe - 1e-5 && t <= surely + 1e-5)
        });
        off.count() as f64
    };
    let found = walk(&kernel, &scene, &tree.nodes, &rays);
    assert!(found.iter().filter(|[walked, _]| walked[0] != u32::MAX).count() > RAYS / 4);
    let smaller: Vec<_> = tree
        .nodes
        .iter()
        .map(|node| {
            let shrink = |word: u32| (0..4).map(|i| (word >> (8 * i) & 255).saturating_sub(40) << (8 * i)).sum();
            gpu_rt::data::Node { high: node.high.map(shrink), ..*node }
        })
        .collect();
    Cell::new(
        "2^20 spheres",
        "Of 128 rays, those whose nearest hit differs from a test of every sphere in f64",
        0.0,
        "none, because the hierarchy's boxes are widened by the rounding of the walk.",
    )
    .achieved(wrong(&found))
    .planted("boxes a sixth too small", wrong(&walk(&kernel, &scene, &smaller, &rays)))
}

/// The nearest hit in f64 of spheres that are surely met, and of those that may be: lines within 1e-6 of the edge.
fn nearest(ray: &ThroughTree, spheres: &[Sphere]) -> (f64, f64) {
    let (o, d) = (exact(ray.origin), exact(ray.direction));
    let (mut surely, mut maybe) = (f64::INFINITY, f64::INFINITY);
    for sphere in spheres {
        let f = o - exact(sphere.center);
        let k = -f.dot(d);
        let (l2, r) = ((f + k * d).length_squared(), f64::from(sphere.radius));
        if l2 > (r + 1e-6) * (r + 1e-6) {
            continue;
        }
        let first = |r: f64| {
            let h = (r * r - l2).max(0.0).sqrt();
            if k - h > 0.0 {
                k - h
            } else if k + h > 0.0 {
                k + h
            } else {
                f64::INFINITY
            }
        };
        maybe = maybe.min(first(r + 1e-6));
        if l2 < (r - 1e-6) * (r - 1e-6) {
            surely = surely.min(first(r - 1e-6));
        }
    }
    (surely, maybe)
}
