//! lib/perlin and the frames of textures: noise far from the origin of its space.

use glam::DVec3;
use gpu_rt::data::PRIMITIVE_BIT;
use gpu_rt::flatten::flatten;

use crate::common::kernel::{Kernel, Setup, array, plan_of};
use crate::common::oracles::{LINEAR_NOISE, NOISE, NOISE_ERROR, perlin, turbulence};
use crate::common::render::scene;
use crate::common::rows::Aimed as In;
use crate::common::stats::Random;
use crate::common::vectors::{exact, rounded, unit};
use crate::table::Cell;

const PLANTED: &str = "truncated cells, no fade, a period of 255";

fn kernels() -> [Kernel; 2] {
    [&[][..], &LINEAR_NOISE].map(|replaced| Kernel::of(NOISE, replaced))
}

fn evaluate(kernel: &Kernel, points: &[DVec3]) -> Vec<[f64; 2]> {
    let rows: Vec<[f32; 4]> = points.iter().map(|p| rounded(*p)).map(|[x, y, z]| [x, y, z, 0.0]).collect();
    kernel.run::<_, [f32; 2]>(&rows).into_iter().map(|out| out.map(f64::from)).collect()
}

/// Points whose coordinates f32 holds exactly, up to this far away on each axis.
fn points(random: &mut Random, count: usize, reach: f64) -> Vec<DVec3> {
    let mut coordinate = || f64::from(((2.0 * random.uniform() - 1.0) * reach) as f32);
    (0..count).map(|_| DVec3::new(coordinate(), coordinate(), coordinate())).collect()
}

/// Noise and turbulence of the very numbers given, cells counted in integers of 64 bits.
pub fn values() -> Vec<Cell> {
    let [own, linear] = kernels();
    let mut random = Random(81);
    let mut all = Vec::new();
    for reach in [1e-7, 1.0, 128.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9] {
        let mut points = points(&mut random, 5000, reach);
        points.extend([0.0, -0.0, 1e-40, -1e-40].map(DVec3::splat));
        let worst = |kernel: &Kernel| {
            evaluate(kernel, &points).iter().zip(&points).fold([0.0f64; 2], |worst, (found, &p)| {
                let off = [found[0] - perlin(p), found[1] - turbulence(p)];
                [worst[0].max(off[0].abs()), worst[1].max(off[1].abs())]
            })
        };
        let (found, wrong) = (worst(&own), worst(&linear));
        let planted = |cell: Cell, i: usize| if reach < 1.0 { cell } else { cell.planted(PLANTED, wrong[i]) };
        let cell = |figure, limit, because| Cell::new(format!("p up to {reach:e}"), figure, limit, because);
        all.push(planted(
            cell(
                "Largest error of Perlin noise",
                NOISE_ERROR,
                "eight products of a weight and a dot product below 1.8, with about ten roundings each; the weights sum to 1.",
            )
            .achieved(found[0]),
            0,
        ));
        all.push(planted(
            cell(
                "Largest error of turbulence, seven octaves",
                2.0 * NOISE_ERROR,
                "octave i adds 2^-i of the error above.",
            )
            .achieved(found[1]),
            1,
        ));
    }
    all
}

/// The planes between cells, across zero and far away: one step of the numbers to each side, against the same step in f64.
pub fn seams() -> Vec<Cell> {
    let [own, linear] = kernels();
    let mut random = Random(84);
    let mut all = Vec::new();
    for reach in [1.0, 128.0, 1e3, 1e4, 1e5, 1e6] {
        // Steps that f32 holds at this distance.
        let step = (2.0 * reach * 2f64.powi(-23)).log2().ceil().exp2().max(2f64.powi(-10));
        let mut pairs = Vec::new();
        for (i, p) in points(&mut random, 3000, reach).into_iter().enumerate() {
            let axis = i % 3;
            for side in [-1.0, 1.0] {
                let mut at = p;
                at[axis] = (if i % 2 == 0 { 0.0 } else { p[axis].round() }) + side * step;
                pairs.push(at);
            }
        }
        // The points are those of f32: the step there is known, however long it is.
        let steps: Vec<f64> = pairs.chunks_exact(2).map(|pair| perlin(pair[1]) - perlin(pair[0])).collect();
        let worst = |kernel: &Kernel| {
            let found = evaluate(kernel, &pairs);
            let errors = found.chunks_exact(2).zip(&steps).map(|(v, step)| (v[1][0] - v[0][0] - step).abs());
            errors.fold(0.0f64, f64::max)
        };
        let cell = Cell::new(
            format!("p up to {reach:e}, {step:.0e} to each side"),
            "Largest error of the step of Perlin noise across a plane between cells",
            2.0 * NOISE_ERROR,
            "the errors of two values.",
        );
        all.push(cell.achieved(worst(&own)).planted(PLANTED, worst(&linear)));
    }
    all
}

/// Spheres of radius 1 so far from the origin of their own space, moved back before the camera: the host reduces the position by
/// the noise's period before it becomes f32.
pub fn far_objects() -> Vec<Cell> {
    const SCALE: f64 = 4.0;
    const SPHERES: usize = 20;
    let mut random = Random(112);
    let mut all = Vec::new();
    for far in [0.0, 1e3, 1e6, 1e9] {
        // Whole numbers, so that the sphere's own centre is exact at any of these distances.
        let centers: Vec<DVec3> = (0..SPHERES).map(|_| (far * unit(&mut random)).round()).collect();
        let objects: Vec<String> = centers
            .iter()
            .map(|c| {
                let triple = |v: DVec3| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
                let sphere = format!("Sphere(center: {}, radius: 1, material: \"m\")", triple(*c));
                format!("Transformed(by: [Translate({})], object: {sphere})", triple(-*c))
            })
            .collect();
        let scene = scene(&format!(
            "Scene(image: (width: 16, height: 16), background: Solid((1, 1, 1)),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40),
             materials: {{\"m\": Lambertian(albedo: Noise(scale: {SCALE}))}}, objects: [{}])",
            objects.join(", ")
        ));
        let flat = flatten(&scene, (16, 16), &crate::common::render::plain()).expect("the test's scene is small");
        let to_render = f64::from(flat.shapes.spheres[0].radius);
        let (mut rays, mut points) = (Vec::new(), Vec::new());
        for (index, center) in (0u32..).zip(&centers) {
            for _ in 0..200 {
                let n = unit(&mut random);
                rays.push(In {
                    origin: rounded(2.0 * n * to_render),
                    code: PRIMITIVE_BIT | index,
                    direction: rounded(-n),
                    padding: 0,
                });
                points.push((*center, n));
            }
        }
        let plan = plan_of(&flat.features);
        let kernel = Kernel::with("test/colour", &Setup { plan, ..Setup::default() });
        let buffers = [
            array("spheres", &flat.shapes.spheres),
            array("materials", &flat.materials),
            array("textures", &flat.textures),
            array("frames", &flat.frames),
        ];
        let found = kernel.run_with::<_, [f32; 4]>(&rays, rays.len(), &buffers);
        // The position as it is, and as it would be in f32: cells are counted in integers in both.
        let worst = |in_f32: bool| {
            points.iter().zip(&found).fold(0.0f64, |worst, ((center, n), out)| {
                // The period, taken off in integers, leaves the position its digits in f64 too.
                let full = (SCALE * *center).to_array().map(|x| x.rem_euclid(256.0));
                let p = SCALE * *n + DVec3::from_array(full);
                let expected = 0.5 * (1.0 + perlin(p));
                let reduced = match in_f32 {
                    true => 0.5 * (1.0 + perlin(exact(rounded(SCALE * (*center + *n))))),
                    false => f64::from(out[0]),
                };
                worst.max((reduced - expected).abs())
            })
        };
        // The point on the sphere is off by 4 u of its radius and distance, the ray's by 8 u, reduced positions up to 256 by u.
        let cell = Cell::new(
            format!("object {far:e} from the origin of its space"),
            "Largest error of a noise texture on a sphere that is far from the origin of its own space",
            0.5 * (10.0 * (SCALE * 16.0 + 256.0) * crate::common::vectors::U + NOISE_ERROR),
            "a slope of at most 10 times the error of the position: 16 u on the sphere, and u of the 256 to which the host reduces \
             the position.",
        )
        .achieved(worst(false));
        all.push(if far >= 1e6 { cell.planted("position in f32, not reduced by the host", worst(true)) } else { cell });
    }
    all
}
