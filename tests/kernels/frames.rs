//! scene/textured_colour with the host's frames: a texture is evaluated at the point in its object's own space, however
//! the object is turned, scaled and moved, and however far from its own origin it stands.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use glam::{DMat3, DVec3};
use gpu_rt::data::primitive_code;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::{Integrator, RenderOptions};
use gpu_rt::scene::Scene;

use crate::common::kernel::{Kernel, Setup, array, plan_of};
use crate::common::oracles::{perlin, turbulence};
use crate::common::rows::Aimed as In;
use crate::common::scenes::triple;
use crate::common::stats::Random;
use crate::common::vectors::{U, exact, rounded, unit};
use crate::textures::Image;

#[derive(Clone, Copy, Debug)]
enum Shape {
    Sphere { center: DVec3, radius: f64 },
    Quad { corner: DVec3, u: DVec3, v: DVec3 },
    Cuboid { min: DVec3, max: DVec3 },
}

/// An object in its own space, and the way from there to the world: scale, turn, move.
#[derive(Clone, Copy, Debug)]
struct Object {
    shape: Shape,
    scale: f64,
    axis: DVec3,
    degrees: f64,
    offset: DVec3,
    texture: usize,
}

/// A point on an object: its position and normal in its own space, and its texture coordinates.
struct SurfacePoint {
    point: DVec3,
    normal: DVec3,
    uv: (f64, f64),
    wraps: bool,
}

impl Object {
    /// Within a few units of the world's origin, and in its own space up to 1e4 away.
    fn random(random: &mut Random, kind: usize, texture: usize) -> Object {
        let far = [0.0, 3.0, 1e4][random.below(3)] * unit(random);
        let mut edge = || 0.5 + random.uniform();
        let shape = match kind {
            0 => Shape::Sphere { center: far, radius: edge() },
            1 => Shape::Quad { corner: far, u: DVec3::new(edge(), 0.2, 0.0), v: DVec3::new(0.1, edge(), 0.3) },
            _ => Shape::Cuboid { min: far, max: far + DVec3::new(edge(), edge(), edge()) },
        };
        let (scale, axis, degrees) = (0.5 + random.uniform(), unit(random), 360.0 * random.uniform());
        let turned = Object { shape, scale, axis, degrees, offset: DVec3::ZERO, texture };
        Object { offset: 3.0 * unit(random) - turned.world(far), ..turned }
    }

    fn world(&self, point: DVec3) -> DVec3 {
        self.scale * (DMat3::from_axis_angle(self.axis, self.degrees.to_radians()) * point) + self.offset
    }

    fn text(&self) -> String {
        let material = format!("material: \"{}\"", self.texture);
        let object = match self.shape {
            Shape::Sphere { center, radius } => {
                format!("Sphere(center: {}, radius: {radius:?}, {material})", triple(center))
            }
            Shape::Quad { corner, u, v } => {
                format!("Quad(corner: {}, u: {}, v: {}, {material})", triple(corner), triple(u), triple(v))
            }
            Shape::Cuboid { min, max } => format!("Box(min: {}, max: {}, {material})", triple(min), triple(max)),
        };
        format!(
            "Transformed(by: [Scale({:?}), Rotate(axis: {}, degrees: {:?}), Translate({})], object: {object})",
            self.scale,
            triple(self.axis),
            self.degrees,
            triple(self.offset)
        )
    }

    fn random_point(&self, random: &mut Random) -> SurfacePoint {
        match self.shape {
            Shape::Sphere { center, radius } => {
                let n = unit(random);
                let uv = (((-n.z).atan2(n.x) + PI) / TAU, (-n.y).acos() / PI);
                SurfacePoint { point: center + radius * n, normal: n, uv, wraps: true }
            }
            Shape::Quad { corner, u, v } => {
                let (a, b) = (random.uniform(), random.uniform());
                SurfacePoint { point: corner + a * u + b * v, normal: u.cross(v).normalize(), uv: (a, b), wraps: false }
            }
            Shape::Cuboid { min, max } => {
                // As tests/kernels/cuboid.rs has the faces' coordinates.
                let (axis, side) = (random.below(3), if random.below(2) == 0 { 1.0 } else { -1.0 });
                let normal = side * DVec3::AXES[axis];
                let (right, up) = match axis {
                    1 => (DVec3::X, normal.cross(DVec3::X)),
                    _ => (DVec3::Y.cross(normal), DVec3::Y),
                };
                let (u, v) = (random.uniform(), random.uniform());
                let within = normal + (2.0 * u - 1.0) * right + (2.0 * v - 1.0) * up;
                let point = 0.5 * (min + max) + 0.5 * (max - min) * within;
                SurfacePoint { point, normal, uv: (u, v), wraps: false }
            }
        }
    }

    fn kind(&self) -> u32 {
        match self.shape {
            Shape::Sphere { .. } => 0,
            Shape::Quad { .. } => 1,
            Shape::Cuboid { .. } => 2,
        }
    }
}

const CHECKER_SCALE: f64 = 0.32;
const NOISE_SCALE: f64 = 4.0;
const MARBLE_SCALE: f64 = 5.0;

/// The colour's red at a point, in f64, and how far f32 may be off; `None` where rounding decides.
fn expected(object: &Object, at: &SurfacePoint, texels: &[[f32; 3]]) -> Option<(f64, f64)> {
    // The world's few units in f32, with the distance and the point each some roundings off: 1e-6 on the surface.
    const POINT: f64 = 4e-6;
    let p = at.point;
    match object.texture {
        0 => {
            let cell = p / CHECKER_SCALE;
            let clear = (cell - cell.round()).abs().min_element() > POINT / CHECKER_SCALE;
            let even = cell.floor().to_array().iter().map(|c| *c as i64).sum::<i64>().rem_euclid(2) == 0;
            clear.then_some((if even { 1.0 } else { 0.25 }, 0.0))
        }
        // Slopes are below 10 (tests/kernels/perlin.rs).
        1 => Some((0.5 * (1.0 + perlin(NOISE_SCALE * p)), 0.5 * 10.0 * NOISE_SCALE * POINT)),
        // Ten times seven octaves of one slope; and the sine to 4 u.
        2 => {
            let angle = MARBLE_SCALE * p.z + 10.0 * turbulence(p);
            Some((0.5 * (1.0 + angle.sin()), 4.0 * U + 0.5 * (10.0 * 7.0 * 10.0 + MARBLE_SCALE) * POINT))
        }
        // A texel is a sixteenth of the width; the angle by 10 π u (tests/kernels/textures.rs) and the point, larger at the poles.
        _ => {
            let image = Image { first: 0, width: 16, height: 8 };
            let polar = at.normal.x.hypot(at.normal.z).max(1e-3);
            let colour = image.at(texels, at.uv.0, at.uv.1, [at.wraps, false]);
            let turn = if at.wraps { 10.0 * PI * U + POINT / polar } else { 2.0 * POINT };
            Some((colour.x, 32.0 * turn))
        }
    }
}

fn scene(objects: &[Object], folder: &std::path::Path) -> DeviceScene {
    let mut random = Random(111);
    let pixels = image::RgbImage::from_fn(16, 8, |_, _| image::Rgb([0; 3].map(|_| random.bits() as u8)));
    pixels.save(folder.join("image.png")).expect("the image can be written");
    let mut text = String::from(
        "Scene(image: (width: 16, height: 16), background: Solid((1, 1, 1)),\n\
         camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40), materials: {\n\
         \"0\": Lambertian(albedo: Checker(scale: 0.32, even: (1, 1, 1), odd: (0.25, 0.25, 0.25))),\n\
         \"1\": Lambertian(albedo: Noise(scale: 4)), \"2\": Lambertian(albedo: Marble(scale: 5)),\n\
         \"3\": Lambertian(albedo: Image(path: \"image.png\")) }, objects: [\n",
    );
    for object in objects {
        writeln!(text, "{},", object.text()).expect("a string takes text");
    }
    text.push_str("])");
    let scene = Scene::parse(&text, &folder.join("test.ron")).expect("the test's scene is valid");
    flatten(&scene, (16, 16), &RenderOptions { integrator: Integrator::Bsdf, ..RenderOptions::default() })
        .expect("the test's scene is small")
}

#[test]
fn textures_are_evaluated_in_their_objects_own_space() {
    let mut random = Random(112);
    let objects: Vec<Object> = (0..240).map(|i| Object::random(&mut random, i % 3, i / 3 % 4)).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flat = scene(&objects, folder.path());
    // Render space is the world scaled by a power of two: as the spheres' radii show.
    let Shape::Sphere { radius, .. } = objects[0].shape else { panic!("the first object is a sphere") };
    let to_render = 2f64.powf((f64::from(flat.shapes.spheres[0].radius) / (radius * objects[0].scale)).log2().round());

    let mut counts = [0u32; 3];
    let mut rays = Vec::new();
    let mut of = Vec::new();
    for object in &objects {
        let kind = object.kind();
        let index = counts[kind as usize];
        counts[kind as usize] += 1;
        for _ in 0..40 {
            let at = object.random_point(&mut random);
            let target = object.world(at.point);
            let normal = (object.world(at.point + at.normal) - target).normalize();
            let side = if kind == 1 && random.below(2) == 0 { -1.0 } else { 1.0 };
            let away = (side * normal + 0.5 * unit(&mut random)).normalize();
            rays.push(In {
                origin: rounded((target + 2.0 * away) * to_render),
                code: primitive_code(kind, index),
                direction: rounded(-away),
                padding: 0,
            });
            of.push((object, at));
        }
    }
    let plan = plan_of(&flat.features);
    let kernel = Kernel::with("test/colour", &Setup { plan, ..Setup::default() });
    let texels: Vec<[f32; 3]> = flat.images.iter().flat_map(|(_, image)| image.texels()).collect();
    let words = flat.texel_words().collect::<Vec<_>>().concat();
    let judge = |frames: &[gpu_rt::data::Frame]| {
        let buffers = [
            array("spheres", &flat.shapes.spheres),
            array("quads", &flat.shapes.quads),
            array("cuboids", &flat.shapes.cuboids),
            array("materials", &flat.materials),
            array("textures", &flat.textures),
            array("frames", frames),
            array("texels", &words),
        ];
        let found = kernel.run_with::<_, [f32; 4]>(&rays, rays.len(), &buffers);
        let mut wrong = [0usize; 4];
        let (mut hits, mut first) = (0, None);
        for ((object, at), out) in of.iter().zip(&found) {
            let (Some((colour, allowed)), true) = (expected(object, at, &texels), out[3] > 0.0) else {
                continue;
            };
            hits += 1;
            if (f64::from(out[0]) - colour).abs() > allowed {
                wrong[object.texture] += 1;
                first = first.or(Some(format!("{object:?} at {}: {} is not {colour}", at.point, out[0])));
            }
        }
        (hits, wrong, first)
    };
    let (hits, wrong, first) = judge(&flat.frames);
    // Of 9600, less those at the edges of quads and checkers.
    assert!(hits > 9000, "{hits}");
    assert_eq!(wrong, [0; 4], "of {hits}; the first: {first:?}");

    // In world space instead of the object's: frames without their turn.
    let unturned: Vec<_> = flat
        .frames
        .iter()
        .map(|frame| {
            let along = |v: [f32; 3], axis: DVec3| rounded(exact(v).length() * axis);
            let (x, y, z) = (along(frame.x, DVec3::X), along(frame.y, DVec3::Y), along(frame.z, DVec3::Z));
            gpu_rt::data::Frame { x, y, z, ..*frame }
        })
        .collect();
    let (_, wrong, _) = judge(&unturned);
    assert!(wrong.iter().all(|&n| n > 100), "{wrong:?}");
}
