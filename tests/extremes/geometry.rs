//! Surfaces close to each other, seen from afar, grazed, and around the camera: whole scenes whose light is known exactly.

use glam::{DMat3, DQuat, DVec3, EulerRot};
use gpu_rt::data::{LargeSphere, Sphere};
use gpu_rt::scene::{Background, Scene};

use crate::common::instances::ball_file;
use crate::common::kernel::{Fault, Kernel};
use crate::common::render::{Request, Shot, diagnostics, render, scene_in};
use crate::common::scenes::{flat, triple};
use crate::common::stats::Random;
use crate::common::trace::{In, NO_HIT, trace, tracer};
use crate::common::vectors::{U, exact, rounded, unit};
use crate::table::{BY_BITS, Cell, FIXED_OFFSET, FIXED_T_MIN, OFFSET_BY_BITS};

/// A scene of materials "clear" (glass of index 1), "lamp" (1 on its outside, black inside), "both" (1 on both sides), "grey" (a
/// Lambertian of 0.5), "mirror", "glass", and "weak" glass that traps no light in boxes; with the mesh "ball.obj" beside it.
pub fn scene(camera: &str, sky: f64, objects: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    if objects.contains("ball.obj") {
        std::fs::write(folder.path().join("ball.obj"), ball_file(3, DVec3::ONE)).expect("the mesh is written");
    }
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: {camera}, background: Solid(({sky:?}, {sky:?}, {sky:?})), materials: {{
            \"clear\": Dielectric(ior: 1), \"glass\": Dielectric(ior: 1.5),
            \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1), two_sided: false), \"both\": DiffuseLight(emit: Rgb(1, 1, 1)), \"mirror\": Metal(albedo: Rgb(1, 1, 1), fuzz: 0),
            \"weak\": Dielectric(ior: 1.2),
            \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }}, objects: [{objects}])"
    );
    scene_in(folder.path(), &text)
}

/// The farthest that any value of the image is from what all of them should be.
pub fn farthest(shot: &Shot, expected: f64) -> f64 {
    shot.picture.rgb.as_flattened().iter().map(|v| (f64::from(*v) - expected).abs()).fold(0.0, f64::max)
}

/// Two surfaces one behind the other as the camera sees them.
struct Pair {
    name: &'static str,
    camera: &'static str,
    /// The text of both for a gap and their materials, the one in front first.
    objects: fn(f64, &str, &str) -> String,
    /// The least gap, as a power of ten, that f32 holds there.
    least: i32,
}

fn tilted(object: &str) -> String {
    format!("Transformed(by: [RotateX(20), RotateY(35), RotateZ(-50)], object: {object})")
}

/// 10 x 10, at a height.
fn floor(height: f64, material: &str) -> String {
    format!("Quad(corner: (-5, {height:?}, -5), u: (0, 0, 10), v: (10, 0, 0), material: \"{material}\")")
}

/// Around the origin.
fn sphere(radius: f64, material: &str) -> String {
    ball(DVec3::ZERO, radius, material)
}

/// Around the origin, by half its edges.
fn cube(half: f64, material: &str) -> String {
    let (low, high) = (triple(DVec3::splat(-half)), triple(DVec3::splat(half)));
    format!("Box(min: {low}, max: {high}, material: \"{material}\")")
}

const ASIDE: &str = "(look_from: (1.08, 1.44, 2.4), look_at: (0, 0, 0), vertical_fov: 20)";

const PAIRS: &[Pair] = &[
    Pair {
        name: "floors of 10 x 10 seen from a height of 0.05",
        camera: "(look_from: (0.1, 0.05, 0.2), look_at: (0.9, -0.8, 0.1), vertical_fov: 40)",
        objects: |gap, front, back| [floor(0.0, front), floor(-gap, back)].join(", "),
        least: 7,
    },
    Pair {
        name: "spheres of radius 0.01 seen from 0.03, above a floor of 10 x 10",
        camera: "(look_from: (0.0108, 0.0144, 0.024), look_at: (0, 0, 0), vertical_fov: 25)",
        objects: |gap, front, back| [sphere(0.01, front), sphere(0.01 - gap, back), floor(-1.0, "grey")].join(", "),
        least: 7,
    },
    Pair {
        name: "spheres of radius 1 seen from 3 away",
        camera: "(look_from: (1.08, 1.44, 2.4), look_at: (0, 0, 0), vertical_fov: 25)",
        objects: |gap, front, back| [sphere(1.0, front), sphere(1.0 - gap, back)].join(", "),
        least: 5,
    },
    Pair {
        name: "spheres of radius 1 seen from their middle",
        camera: "(look_from: (0, 0, 0), look_at: (0.3, 0.5, -0.7), vertical_fov: 120)",
        objects: |gap, front, back| [sphere(1.0, front), sphere(1.0 + gap, &back.replace("lamp", "both"))].join(", "),
        least: 6,
    },
    Pair {
        name: "floors of 10 x 10 seen from a height of 1",
        camera: "(look_from: (0.1, 1, 0.2), look_at: (0.9, 0, 0.1), vertical_fov: 40)",
        objects: |gap, front, back| [floor(0.0, front), floor(-gap, back)].join(", "),
        least: 6,
    },
    Pair {
        name: "tilted quads of 10 x 10 seen from 1 away",
        camera: "(look_from: (0, 0, 0), look_at: (0.4, -1, 0.3), vertical_fov: 40)",
        objects: |gap, front, back| {
            let both = [floor(-1.0, front), floor(-1.0 - gap, back)].join(", ");
            format!("Transformed(by: [RotateX(20), RotateZ(-10)], object: Group([{both}]))")
        },
        least: 5,
    },
    Pair {
        name: "boxes of edge 2 seen from 3 away",
        camera: ASIDE,
        objects: |gap, front, back| [cube(1.0, front), cube(1.0 - gap, back)].join(", "),
        least: 5,
    },
    Pair {
        name: "tilted boxes of edge 2 seen from 3 away",
        camera: ASIDE,
        objects: |gap, front, back| [cube(1.0, front), cube(1.0 - gap, back)].map(|cube| tilted(&cube)).join(", "),
        least: 5,
    },
    Pair {
        name: "meshes of 512 triangles and radius 1 seen from 3 away",
        camera: ASIDE,
        objects: |gap, front, back| {
            let mesh = |material: &str| format!("Mesh(path: \"ball.obj\", material: \"{material}\")");
            let inner = format!("Transformed(by: [Scale({:?})], object: {})", 1.0 - gap, mesh(back));
            [mesh(front), inner].map(|mesh| tilted(&mesh)).join(", ")
        },
        least: 5,
    },
];

/// Not in general position, and in it.
const DIRECTIONS: [(&str, DVec3); 2] = [("", DVec3::NEG_Z), (", in general position", DVec3::new(-0.36, -0.48, -0.8))];

/// The table's cells of gaps, as whole scenes.
pub fn gaps() -> Vec<Cell> {
    let mut all = Vec::new();
    for pair in PAIRS {
        let of = |gap: f64, front, back| scene(pair.camera, 0.0, &(pair.objects)(gap, front, back));
        let shot = |gap: f64, front, back| render(&of(gap, front, back), &Request::spp(64));
        // Warnings are of what is too near, and not of such pairs.
        let said = diagnostics(&of(0.005, "clear", "lamp"));
        assert!(said.is_empty(), "{}: {said:?}", pair.name);
        for exponent in 1..=pair.least {
            let gap = 10f64.powi(-exponent);
            let cell = Cell::new(
                format!("1e-{exponent} between {}", pair.name),
                "Largest share of a lamp's light that is lost behind a clear surface in front of it",
                0.0,
                "none, because the offset of the ray that leaves the front surface is some u of its position and size, which is \
                 less than the gap.",
            );
            // The inner one is inside the outer one only where it is smaller.
            if gap < 0.01 || !pair.name.contains("0.01") {
                all.push(cell.achieved(farthest(&shot(gap, "clear", "lamp"), 1.0)));
            }
        }
        let gap = 10f64.powi(-pair.least);
        let cell = Cell::new(
            format!("1e-{} between {}", pair.least, pair.name),
            "Largest share of a lamp's light that passes a grey surface in front of it",
            0.0,
            "none, because the distances to both are off by less than the gap.",
        );
        all.push(cell.achieved(farthest(&shot(gap, "grey", "lamp"), 0.0)));
        for exponent in pair.least + 1..=7 {
            let gap = 10f64.powi(-exponent);
            let cell = |figure| {
                let range = format!("1e-{exponent} between {}", pair.name);
                Cell::new(range, figure, 0.0, "none, as with a gap that f32 resolves.")
            };
            let lost = "Largest share of a lamp's light that is lost behind a clear surface in front of it, with a gap that f32 does \
                        not resolve; `check` may warn instead";
            // Of meshes those get a warning that coincide within rounding, and not all that are nearer than rays start.
            if exponent == 7 || !pair.name.contains("meshes") {
                let cut = cell(lost).achieved(farthest(&shot(gap, "clear", "lamp"), 1.0));
                all.push(cut.warns(diagnostics(&of(gap, "clear", "lamp"))));
            }
            let passes = "Largest share of a lamp's light that passes a grey surface in front of it, with a gap that f32 does not \
                          resolve; `check` may warn instead";
            let cut = cell(passes).achieved(farthest(&shot(gap, "grey", "lamp"), 0.0));
            all.push(cut.warns(diagnostics(&of(gap, "grey", "lamp"))));
        }
    }
    all
}

/// The table's cells of gaps, ray by ray: with the wrong forms, which no scene can be rendered by.
pub fn gaps_by_rays() -> Vec<Cell> {
    const RAYS: usize = 1000;
    let mut all = Vec::new();
    for exponent in 1..=6 {
        let gap = 10f64.powi(-exponent);
        let spheres = flat(&[sphere(1.0, "m"), sphere(1.0 + gap, "m")]).shapes.spheres;
        let quads = flat(&[floor(-1.0, "m"), floor(-1.0 - gap, "m")]).shapes.quads;
        let mut random = Random(91);
        let rays: Vec<In> = (0..RAYS)
            .map(|_| {
                let mut direction = unit(&mut random);
                // At the floor at 30 degrees or more.
                direction.y = -direction.y.abs().max(0.6);
                In::new(0, DVec3::ZERO, direction.normalize())
            })
            .collect();
        let lost = |kind: &str, replaced: &[Fault<'_>]| {
            let kernel = tracer(kind, replaced);
            match kind {
                "sphere" => passed(&kernel, &spheres, &rays),
                _ => passed(&kernel, &quads, &rays),
            }
        };
        for (name, kind) in
            [("spheres of radius 1 from their middle", "sphere"), ("floors of 10 x 10 from a height of 1", "quad")]
        {
            let cell = Cell::new(
                format!("1e-{exponent} between {name}"),
                "Of 1000 rays, those that leave the first of two surfaces and miss the second",
                0.0,
                "none, as for the scenes.",
            );
            let mut cell = cell.achieved(lost(kind, &[]));
            if exponent >= 4 {
                cell = cell.planted(FIXED_T_MIN, lost(kind, &FIXED_OFFSET));
            }
            if exponent >= 6 {
                cell = cell.planted(OFFSET_BY_BITS, lost(kind, &[BY_BITS]));
            }
            all.push(cell);
        }
    }
    all
}

/// Rays that go on behind the first of two primitives and miss the second.
fn passed<P: bytemuck::Pod>(kernel: &Kernel, two: &[P], rays: &[In]) -> f64 {
    let second: Vec<In> = trace(kernel, two, rays)
        .iter()
        .map(|out| {
            assert!(out.t != NO_HIT, "every ray meets the first");
            In { origin: out.start, direction: out.leaving, primitive: 1, ..In::default() }
        })
        .collect();
    trace(kernel, two, &second).iter().filter(|out| out.t == NO_HIT).count() as f64
}

/// A camera at `from` that looks in a direction, with so many degrees from top to bottom.
fn looking(from: DVec3, towards: DVec3, degrees: f64) -> String {
    let up = if towards.x.abs() + towards.z.abs() < 1e-9 { DVec3::X } else { DVec3::Y };
    let (at, from, up) = (triple(from + towards), triple(from), triple(up));
    format!("(look_from: {from}, look_at: {at}, up: {up}, vertical_fov: {degrees:?})")
}

fn ball(center: DVec3, radius: f64, material: &str) -> String {
    format!("Sphere(center: {}, radius: {radius:?}, material: \"{material}\")", triple(center))
}

/// The table's cells of spheres seen from afar, as whole scenes: an image two diameters high with the ball in its middle.
pub fn distances() -> Vec<Cell> {
    let mut all = Vec::new();
    for (label, direction) in DIRECTIONS {
        for exponent in 1..=7 {
            let distance = 10f64.powi(exponent);
            let degrees = 2.0 * (2.0 / distance).atan().to_degrees();
            let objects = ball(distance * direction, 1.0, "grey");
            let shot = render(&scene(&looking(DVec3::ZERO, direction, degrees), 1.0, &objects), &Request::spp(64));
            // The cone that touches the ball, in the plane through its middle; the image is 16 square radii.
            let silhouette = std::f64::consts::PI * distance * distance / (distance * distance - 1.0);
            let expected = 1.0 - 0.5 * silhouette / 16.0;
            // Of the 256 pixels some 40 are mixed; the mean of 64 draws of a half is off by at most half of that in each.
            let noise = 40f64.sqrt() * 0.25 / 8.0 / 256.0;
            // In general position directions are off by u, and the picture by u D radii. From 1e5 on a pixel, 1/4 of D,
            // is below the 2^-17 of its distance at which the view has axes of its own.
            let blur = if direction == DVec3::NEG_Z || exponent > 4 { 0.0 } else { 2.0 * U * distance };
            let cell = Cell::new(
                format!("D/r = 1e{exponent}{label}"),
                "Spheres in scenes: error of the mean image radiance of a grey ball in front of the sky",
                5.0 * noise + blur * silhouette / 16.0,
                "five standard errors of the 40 pixels on the edge. In general position also the rounding of directions, u D radii, \
                 unless render space has the camera's axes.",
            );
            all.push(cell.achieved((shot.mean_of_all().value[0] - expected).abs()));
        }
    }
    for exponent in 6..=8 {
        // In a wide view f32 cannot hold the outline: the warning is the answer.
        let without_warning = |exponent: i32| {
            let objects = ball(10f64.powi(exponent) * DIRECTIONS[1].1, 1.0, "grey");
            f64::from(u8::from(
                diagnostics(&scene(&looking(DVec3::ZERO, DIRECTIONS[1].1, 40.0), 1.0, &objects)).is_empty(),
            ))
        };
        let cell = Cell::new(
            format!("D/r = 1e{exponent}, in general position, 40 degrees"),
            "Spheres in scenes: views that are too wide to resolve the outline, without a warning of `check`",
            0.0,
            "none, because the outline is off by 2 u D, more than a tenth of the radius.",
        );
        all.push(
            cell.achieved(without_warning(exponent)).planted("D/r = 1e4, which is no diagnostic", without_warning(4)),
        );
    }
    for exponent in 2..=7 {
        let distance = 10f64.powi(exponent);
        let degrees = 2.0 * (2.0 / distance).atan().to_degrees();
        let scene =
            scene(&looking(DVec3::ZERO, DVec3::NEG_Z, degrees), 1.0, &ball(distance * DVec3::NEG_Z, 1.0, "mirror"));
        let mut sloped = scene;
        sloped.background = Background::Gradient { bottom: DVec3::ZERO, top: DVec3::ONE };
        let shot = render(&sloped, &Request::spp(1024));
        let half = |rows| shot.mean(0..16, rows).value[0];
        // The mirror sends a ray that meets it at height y and ρ from the axis to 2 y sqrt(1 - ρ²) up: over the upper half of
        // the disk the mean is 1/2, and with the sky around it 1/2 ± (π / 2) / 8 / 4.
        let expected = std::f64::consts::PI / 32.0;
        let cell = Cell::new(
            format!("D/r = 1e{exponent}"),
            "Spheres in scenes: relative error of the difference between the upper and the lower half of a mirror ball, in a sky from 0 \
             to 1",
            0.03 + 10.0 / distance,
            "five standard errors of 2^17 samples per half, with a deviation of at most 0.3 in the ball and 0.13 in the image. The \
             sky around the ball, up to 2 r/D above the horizon, adds 10 r/D of the difference.",
        );
        all.push(cell.achieved(((half(0..8) - half(8..16)) / expected - 1.0).abs()));
    }
    all
}

/// The table's cells of radii.
pub fn radii() -> Vec<Cell> {
    let mut all = Vec::new();
    for exponent in -6..=7 {
        let radius = 10f64.powi(exponent);
        let direction = DIRECTIONS[1].1;
        let objects =
            ball(4.0 * radius * direction, radius, "grey") + ", " + &ball(DVec3::new(2.0, 3.0, 1.0), 1.0, "both");
        let shot = render(&scene(&looking(DVec3::ZERO, direction, 15.0), 1.0, &objects), &Request::spp(64));
        let cell = Cell::new(
            format!("r = 1e{exponent}"),
            "Grey balls seen from 4 radii, beside a lamp of radius 1 that is as bright as the sky: largest difference from half of \
             that radiance",
            0.0,
            "none, because every path hits the ball once, and then the sky or the lamp.",
        );
        all.push(cell.achieved(farthest(&shot, 0.5)));
    }
    for exponent in 0..=12 {
        let ground = Ground::new(10f64.powi(exponent));
        let camera = looking(DVec3::ZERO, ground.downs[0], 40.0);
        let warnings = diagnostics(&scene(&camera, 1.0, &ground.texts[0].replace("\"m\"", "\"grey\"")));
        assert!(warnings.is_empty(), "{warnings:?}");
        let range = format!("r = 1e{exponent}");
        if ground.large_spheres.is_empty() {
            let cell = Cell::new(
                &range,
                "Ground spheres from a height h of 1.25: largest relative error of the distance within 45 degrees of straight down",
                4.0 * U * (ground.radius / HEIGHT + 1.0) * std::f64::consts::SQRT_2 + 16.0 * U,
                "the centre and the radius are rounded, and the length of o - c by 2 u: together 4 u (r + h), relative to the height \
                 and divided by the cosine.",
            );
            let larger: Vec<Sphere> = ground
                .spheres
                .iter()
                .map(|sphere| Sphere { radius: sphere.radius * (1.0 + 2e-6), ..*sphere })
                .collect();
            let cell = cell.achieved(ground.worst("sphere", &ground.spheres));
            all.push(cell.planted("radius 2e-6 too large", ground.worst("sphere", &larger)));
        } else {
            let cell = Cell::new(
                &range,
                "Ground spheres of more than 1024 heights, from a height h of 1.25: largest relative error of the distance within 45 degrees \
                 of straight down",
                16.0 * U,
                "the nearest point, the normal and their products are rounded relative to the height: 8 u, divided by the cosine, and \
                 the quotient.",
            );
            let cell = cell.achieved(ground.worst("large_sphere", &ground.large_spheres));
            all.push(cell.planted("by centre and radius", ground.worst("sphere", &ground.as_spheres())));
        }
    }
    all
}

const HEIGHT: f64 = 1.25;

/// Large spheres in all directions, `HEIGHT` away from the eye.
struct Ground {
    radius: f64,
    downs: Vec<DVec3>,
    texts: Vec<String>,
    /// In render space: all are spheres, or all are large spheres.
    spheres: Vec<Sphere>,
    large_spheres: Vec<LargeSphere>,
    scale: f64,
}

impl Ground {
    fn new(radius: f64) -> Ground {
        let mut random = Random(92);
        // Turned from straight below, where f64 holds the height exactly.
        let turns: Vec<(DVec3, f64)> = (0..20).map(|_| (unit(&mut random), 360.0 * random.uniform())).collect();
        let text = |(axis, degrees): &(DVec3, f64)| {
            let below = ball(-(radius + HEIGHT) * DVec3::Y, radius, "m");
            format!("Transformed(by: [Rotate(axis: {}, degrees: {degrees:?})], object: {below})", triple(*axis))
        };
        let down = |(axis, degrees): &(DVec3, f64)| DQuat::from_axis_angle(*axis, degrees.to_radians()) * DVec3::NEG_Y;
        let (downs, texts): (Vec<_>, Vec<_>) = turns.iter().map(|turn| (down(turn), text(turn))).unzip();
        let shapes = flat(&texts).shapes;
        let of_spheres = shapes.spheres.first().map(|sphere| f64::from(sphere.radius));
        let of_large_spheres = shapes.large_spheres.first().map(|large_sphere| 1.0 / f64::from(large_sphere.curvature));
        let on_device = of_spheres.or(of_large_spheres).expect("they are one or the other");
        let scale = 2f64.powf((on_device / radius).log2().round());
        Ground { radius, downs, texts, spheres: shapes.spheres, large_spheres: shapes.large_spheres, scale }
    }

    /// By their centres and radii.
    fn as_spheres(&self) -> Vec<Sphere> {
        let radius = self.scale * self.radius;
        let center = |down: &DVec3| rounded(self.scale * (self.radius + HEIGHT) * *down);
        let sphere = |down| Sphere { center: center(down), radius: radius as f32, ..Sphere::default() };
        self.downs.iter().map(sphere).collect()
    }

    /// The largest relative error of a distance, of rays within 45 degrees of straight down.
    fn worst<P: bytemuck::Pod>(&self, kind: &str, primitives: &[P]) -> f64 {
        let (mut random, r) = (Random(93), self.radius);
        let rays: Vec<In> = (0..4000)
            .map(|i| {
                let down = self.downs[i % self.downs.len()];
                In::new(
                    i % self.downs.len(),
                    DVec3::ZERO,
                    (down + 0.7 * random.uniform() * unit(&mut random)).normalize(),
                )
            })
            .collect();
        let mut worst = 0.0f64;
        for (ray, out) in rays.iter().zip(&trace(&tracer(kind, &[]), primitives, &rays)) {
            let d = exact(ray.direction);
            let along = (r + HEIGHT) * self.downs[ray.primitive as usize].dot(d);
            // The sphere's equation at the eye, without its cancellation.
            let power = HEIGHT * (2.0 * r + HEIGHT);
            let root = (along * along - power * d.length_squared()).sqrt();
            // At the limb of small ones little is known of the distance.
            if root > 0.5 * r {
                let t = if out.t == NO_HIT { f64::INFINITY } else { f64::from(out.t) / self.scale };
                worst = worst.max((t * (along + root) / power - 1.0).abs());
            }
        }
        worst
    }
}

/// The table's cells of floors that are grazed by the eye and by light, as whole scenes.
pub fn grazing() -> Vec<Cell> {
    let mut all = Vec::new();
    let tilt = DMat3::from_euler(EulerRot::XYZ, 0.4, 0.7, -0.9);
    for (label, turned) in [("", DMat3::IDENTITY), (", tilted", tilt)] {
        for exponent in 1..=7 {
            let angle = 10f64.powi(-exponent);
            // From a height of `angle` over a grey floor that ends 1 ahead: its edge is at `angle` below the horizon,
            // three quarters down.
            let triple = |v: DVec3| triple(turned * v);
            let camera = format!(
                "(look_from: (0, 0, 0), look_at: {}, up: {}, vertical_fov: {:?})",
                triple(DVec3::NEG_Z),
                triple(DVec3::Y),
                2.0 * (2.0 * angle).atan().to_degrees()
            );
            let (corner, u, v) = (DVec3::new(-1.0, -angle, -1.0), 1.5 * DVec3::Z, 2.0 * DVec3::X);
            let floor =
                format!("Quad(corner: {}, u: {}, v: {}, material: \"grey\")", triple(corner), triple(u), triple(v));
            let shot = render(&scene(&camera, 1.0, &floor), &Request::spp(64));
            let off = |rows: std::ops::Range<u32>, expected: f64| {
                rows.flat_map(|y| (0..16).map(move |x| (x, y)))
                    .map(|(x, y)| (shot.pixel(x, y)[0] - expected).abs())
                    .fold(0.0, f64::max)
            };
            let cell = Cell::new(
                format!("1e-{exponent}{label}"),
                "Floors in scenes, by the angle of the view: largest difference from half of the sky's radiance on the floor, and \
                 from the sky's radiance above",
                0.0,
                "none, because heights have a small relative error, and the edge is off by at most 1/64 of the floor, a tenth of a row.",
            );
            all.push(cell.achieved(off(0..11, 1.0).max(off(12..16, 0.5))));
        }
    }
    for exponent in 1..=7 {
        let angle = 10f64.powi(-exponent);
        // A lamp 1 away, from half to one and a half times `angle` above the floor; the eye right above, at a hundredth of it.
        let (height, low) = (0.01 * angle, 0.5 * angle);
        let objects = format!(
            "Quad(corner: (-{height:?}, 0, -{height:?}), u: (0, 0, {0:?}), v: ({0:?}, 0, 0), material: \"grey\"),
             Quad(corner: (1, {low:?}, -0.1), u: (0, 0, 0.2), v: (0, {angle:?}, 0), material: \"both\")",
            2.0 * height
        );
        let camera = looking(height * DVec3::Y, DVec3::NEG_Y, 40.0);
        let shot = render(&scene(&camera, 0.0, &objects), &Request::spp(64).mis());
        // a/π times the integral of y / d⁴ over the lamp, by Simpson's rule in z, and in y exactly for the smallest part of it.
        let steps = 200;
        let inner = |z: f64| {
            let (y0, y1) = (low, low + angle);
            // (1 / (1 + y0² + z²) - 1 / (1 + y1² + z²)) / 2, without its cancellation.
            0.5 * (y1 - y0) * (y1 + y0) / ((1.0 + y0 * y0 + z * z) * (1.0 + y1 * y1 + z * z))
        };
        let integral: f64 = (0..=steps)
            .map(|i| {
                let weight = if i % steps == 0 { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
                weight * inner(-0.1 + 0.2 * f64::from(i) / f64::from(steps))
            })
            .sum::<f64>()
            * 0.2
            / (3.0 * f64::from(steps));
        let expected = 0.5 / std::f64::consts::PI * integral;
        let cell = Cell::new(
            format!("1e-{exponent}"),
            "Floors in scenes, by the angle of the light: relative error of their radiance",
            0.012,
            "five standard errors of 2^14 samples, whose cosines have a deviation of 0.29 of their mean; and the change of the \
             lamp's distance over the floor.",
        );
        all.push(cell.achieved((shot.mean_of_all().value[0] / expected - 1.0).abs()));
    }
    all
}

pub fn on_surfaces() -> Vec<Cell> {
    let mut all = Vec::new();
    let on = |height: f64| {
        let (top, general) = (-height, DIRECTIONS[1].1);
        [
            (
                "a floor",
                DVec3::NEG_Y,
                format!("Quad(corner: (-5, {top:?}, -5), u: (0, 0, 10), v: (10, 0, 0), material: \"grey\")"),
            ),
            ("a box", DVec3::NEG_Y, format!("Box(min: (-1, -1, -1), max: (1, {top:?}, 1), material: \"grey\")")),
            ("a sphere", DVec3::NEG_Y, ball((1.0 + height) * DVec3::NEG_Y, 1.0, "grey")),
            ("a sphere in general position", general, ball((1.0 + height) * general, 1.0, "grey")),
            (
                "a mesh",
                DVec3::NEG_Y,
                format!(
                    "Transformed(by: [Translate((0, {:?}, 0))], object: Mesh(path: \"ball.obj\", material: \"grey\"))",
                    -1.0 - height
                ),
            ),
        ]
    };
    for (name, down, objects) in on(0.0) {
        // In general position, the side of the sphere on which the eye is is not known.
        if name.contains("general") {
            continue;
        }
        let shot = render(&scene(&looking(DVec3::ZERO, -down, 90.0), 1.0, &objects), &Request::spp(64));
        let cell = Cell::new(
            format!("on {name}"),
            "The camera on a surface, looking away from it: largest difference from the radiance of the sky",
            0.0,
            "none, because a hit at a distance of 0 does not count.",
        );
        all.push(cell.achieved(farthest(&shot, 1.0)));
    }
    for exponent in [1, 3, 5, 6, 7, 20] {
        let height = 10f64.powi(-exponent);
        for (name, down, objects) in on(height) {
            // The height over an object whose position is far below is known to 4 u of that distance, but not over a sphere; in f64, 1e-20 above it is upon it.
            if exponent > 6 && !name.contains("floor") && !(name.contains("sphere") && exponent == 7) {
                continue;
            }
            let shot = render(&scene(&looking(DVec3::ZERO, down, 40.0), 1.0, &objects), &Request::spp(64));
            let cell = Cell::new(
                format!("1e-{exponent} above {name}"),
                "The camera above a grey surface of size 1, looking down: largest difference from half of the sky's radiance",
                0.0,
                "none, because every path hits the surface once, and then the sky.",
            );
            all.push(cell.achieved(farthest(&shot, 0.5)));
        }
    }
    all
}

pub fn inside_glass() -> Vec<Cell> {
    let mut all = Vec::new();
    let mut push = |range: String, objects: String, towards: DVec3| {
        let shot = render(&scene(&looking(DVec3::ZERO, towards, 120.0), 1.0, &objects), &Request::spp(64).depth(1000));
        let cell = Cell::new(
            range,
            "The camera inside glass in a sky of 1: largest difference from 1",
            0.0,
            "none, because every path leaves in the end and loses nothing.",
        );
        all.push(cell.achieved(farthest(&shot, 1.0)));
    };
    let direction = DIRECTIONS[1].1;
    for offset in [0.0, 0.3, 0.6] {
        // Farther out some paths are caught by total reflection for ever.
        let range = format!("in a ball of index 1.5, {offset} radii from its middle");
        push(range, ball(offset * direction, 1.0, "glass"), DVec3::NEG_Z);
    }
    for exponent in [1, 2, 3, 4, 5, 6] {
        let depth = 10f64.powi(-exponent);
        let objects = ball((1.0 - depth) * direction, 1.0, "clear");
        push(format!("in a ball of index 1, 1e-{exponent} below its surface"), objects.clone(), direction);
        push(format!("in a ball of index 1, 1e-{exponent} below its surface, looking out"), objects, -direction);
        let cuboid = format!("Box(min: (-1, -1, -1), max: (1, {depth:?}, 1), material: \"weak\")");
        push(format!("in a box of index 1.2, 1e-{exponent} below its face"), tilted(&cuboid), DVec3::NEG_Z);
    }
    all
}

pub fn inside_media() -> Vec<Cell> {
    let mut all = Vec::new();
    for exponent in [0, 1, 3, 5, 6, 7] {
        let depth = 10f64.powi(-exponent);
        let boundary = format!("Sphere(center: {}, radius: 1)", triple((1.0 - depth) * DIRECTIONS[1].1));
        let objects = format!("Medium(boundary: {boundary}, density: 2, albedo: Rgb(1, 1, 1))");
        let camera = looking(DVec3::ZERO, DIRECTIONS[1].1, 150.0);
        let shot = render(&scene(&camera, 1.0, &objects), &Request::spp(64).depth(1000));
        let cell = Cell::new(
            format!("in a ball of fog of optical radius 2, 1e-{exponent} below its surface"),
            "The camera inside a medium of albedo 1 in a sky of 1: largest difference from 1",
            0.0,
            "none, because every path leaves in the end and loses nothing.",
        );
        all.push(cell.achieved(farthest(&shot, 1.0)));
    }
    all
}
