//! camera/*: rays through pixels, from the scene's words through the host's settings to the device, against f64.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gpu_rt::data::Settings;

use crate::common::kernel::{Kernel, Setup};
use crate::common::rows::{CameraRay as Out, OnFilm as In, SeenRay};
use crate::common::scenes::{flat_with, triple};
use crate::common::stats::{Random, uniform_in_cells};
use crate::common::vectors::{U, decades, exact, unit};

/// A camera by the words of the scene file.
#[derive(Clone, Copy, Debug)]
struct Camera {
    look_from: DVec3,
    look_at: DVec3,
    up: DVec3,
    vertical_fov: f64,
    aperture: f64,
    focus_distance: f64,
    size: (u32, u32),
}

impl Camera {
    fn random(random: &mut Random, vertical_fov: f64) -> Camera {
        let look_from = decades(random, -3.0, 3.0) * unit(random);
        let look_at = look_from + decades(random, -3.0, 3.0) * unit(random);
        let size = [(64, 48), (48, 64), (1, 1), (1920, 3)][random.below(4)];
        Camera { look_from, look_at, up: unit(random), vertical_fov, aperture: 0.0, focus_distance: 1.0, size }
    }

    fn settings(&self) -> Settings {
        let camera = format!(
            "(look_from: {}, look_at: {}, up: {}, vertical_fov: {:?}, aperture: {:?}, focus_distance: {:?})",
            triple(self.look_from),
            triple(self.look_at),
            triple(self.up),
            self.vertical_fov,
            self.aperture,
            self.focus_distance
        );
        flat_with(&camera, self.size, &[]).settings
    }

    /// Right, up and forward. Where pixels are too narrow for the world's axes they are render space's own.
    fn axes(&self) -> [DVec3; 3] {
        if 2.0 * self.half_height() / f64::from(self.size.1) < 2f64.powi(-17) {
            return [DVec3::X, DVec3::Y, -DVec3::Z];
        }
        let forward = (self.look_at - self.look_from).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }

    /// Of the image at distance 1.
    fn half_height(&self) -> f64 {
        (0.5 * self.vertical_fov).to_radians().tan()
    }

    /// The ray through a point of the image in pixels from the top left corner, not normalised: one unit forward.
    fn towards(&self, x: f64, y: f64) -> DVec3 {
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let half = self.half_height();
        let [right, up, forward] = self.axes();
        let aspect = width / height;
        forward + half * aspect * (2.0 * x / width - 1.0) * right + half * (1.0 - 2.0 * y / height) * up
    }

    /// Lengths of the scene, over those of render space: a power of two that takes the extent to 1.
    fn unit_of_render_space(&self) -> f64 {
        let extent: f64 = if self.aperture > 0.0 { 0.5 * self.aperture } else { 1.0 };
        2f64.powi(extent.log2().floor() as i32 + 1)
    }
}

fn kernel(lens: &str) -> Kernel {
    let ray = "camera_ray(given[0].x, given[0].y, bitcast<vec4<f32>>(given[1]))";
    let both = format!("array(vec4({ray}.origin, 0.0), vec4({ray}.direction, 0.0))");
    Kernel::of([&format!("camera/{lens}"), "array<vec4<u32>, 2>", "array<vec4<f32>, 2>", &both], &[])
}

/// Corners, middle and other points of the image; on the lens the centre, the edge and others.
fn rows(random: &mut Random, size: (u32, u32)) -> Vec<In> {
    let last = 1.0 - U as f32;
    let (right, bottom) = (size.0 - 1, size.1 - 1);
    let mut rows = Vec::new();
    for (column, row) in [(0, 0), (right, 0), (0, bottom), (right, bottom), (size.0 / 2, size.1 / 2)] {
        for (x, y) in [(0.0, 0.0), (last, last), (0.5, 0.5)] {
            for (a, b) in [(0.0, 0.0), (last, 0.0), (last, last), (0.5, 0.25)] {
                rows.push(In { column, row, u: [x, y, a, b], ..In::default() });
            }
        }
    }
    for _ in 0..100 {
        let (column, row) = (random.below(size.0 as usize) as u32, random.below(size.1 as usize) as u32);
        let u = [0; 4].map(|_| (random.bits() >> 40) as f32 * U as f32);
        rows.push(In { column, row, u, ..In::default() });
    }
    rows
}

fn film_point(row: &In) -> (f64, f64) {
    (f64::from(row.column) + f64::from(row.u[0]), f64::from(row.row) + f64::from(row.u[1]))
}

/// From a thousandth of a degree to 179.
const FIELDS: [f64; 9] = [1e-3, 0.1, 1.0, 20.0, 40.0, 90.0, 150.0, 170.0, 179.0];

#[test]
fn pinhole_rays_go_through_their_film_points() {
    let mut random = Random(101);
    let kernel = kernel("pinhole");
    for vertical_fov in FIELDS {
        for _ in 0..5 {
            let camera = Camera::random(&mut random, vertical_fov);
            let rows = rows(&mut random, camera.size);
            let found = kernel.run_with::<_, Out>(&rows, rows.len(), &[kernel.settings(&camera.settings())]);
            for (row, out) in rows.iter().zip(&found) {
                let (x, y) = film_point(row);
                let off = |x: f64, y: f64| (exact(out.direction) - camera.towards(x, y).normalize()).length();
                assert_eq!(out.origin, [0.0; 3]);
                // Three terms at right angles, so that none is longer than their sum: each is rounded as a vector, as a
                // factor, in the product and in a sum; then normalize, with 2.5 ulps to its root and quotient.
                assert!(off(x, y) <= 12.0 * U, "{camera:?} {row:?}: off by {} u", off(x, y) / U);
                // A tenth of a pixel beside is another ray, unless pixels are too fine for f32.
                if vertical_fov >= 1.0 && camera.size.0 < 100 && camera.size.1 > 1 && vertical_fov <= 150.0 {
                    assert!(off(x + 0.1, y) > 12.0 * U && off(x, y + 0.1) > 12.0 * U, "{camera:?} {row:?}");
                }
            }
        }
    }
}

#[test]
fn thin_lens_rays_of_a_film_point_meet_in_focus() {
    let mut random = Random(102);
    let kernel = kernel("thin_lens");
    for vertical_fov in [1e-3, 0.1, 40.0, 150.0] {
        for focus_exponent in [-4, -2, 0, 2, 5, 8] {
            let mut camera = Camera::random(&mut random, vertical_fov);
            camera.focus_distance = 10f64.powi(focus_exponent) * (1.0 + random.uniform());
            camera.aperture = decades(&mut random, -4.0, 1.0) * camera.focus_distance.min(1.0);
            let scale = camera.unit_of_render_space();
            let rows = rows(&mut random, camera.size);
            let found = kernel.run_with::<_, Out>(&rows, rows.len(), &[kernel.settings(&camera.settings())]);
            let [right, up, forward] = camera.axes();
            for (row, out) in rows.iter().zip(&found) {
                let (x, y) = film_point(row);
                let (origin, direction) = (exact(out.origin) * scale, exact(out.direction));
                // The lens lies across the view and has the aperture for its diameter.
                let on_lens = (origin.dot(right), origin.dot(up));
                let radius = 0.5 * camera.aperture;
                let expected = radius * f64::from(row.u[2]).sqrt();
                assert!((on_lens.0.hypot(on_lens.1) - expected).abs() <= 1e-6 * radius, "{camera:?} {row:?} {out:?}");
                assert!(origin.dot(forward).abs() <= 4.0 * U * radius, "{camera:?} {row:?} {out:?}");
                // The point in focus: where the ray through the middle of the lens is at the focus distance.
                let in_focus = camera.focus_distance * camera.towards(x, y);
                let towards = in_focus - origin;
                let off = (direction - towards.normalize()).length();
                // As a pinhole's, and the lens offset over the focus distance likewise.
                assert!(off <= 16.0 * U, "{camera:?} {row:?}: off by {} u", off / U);
                // How far the ray passes from the point.
                let miss = towards.cross(direction).length();
                assert!(miss <= 16.0 * U * towards.length(), "{camera:?} {row:?}: {miss:e}");
            }
            // The pinhole's rays do not meet there: the offset must bend the ray.
            let unbent = Settings { inverse_focus: 0.0, ..camera.settings() };
            let found = kernel.run_with::<_, Out>(&rows, rows.len(), &[kernel.settings(&unbent)]);
            let wrong = rows.iter().zip(&found).filter(|(row, out)| {
                let (x, y) = film_point(row);
                let towards = camera.focus_distance * camera.towards(x, y) - exact(out.origin) * scale;
                (exact(out.direction) - towards.normalize()).length() > 16.0 * U
            });
            if camera.aperture > 1e-4 * camera.focus_distance {
                assert!(wrong.count() > 50, "{camera:?}");
            }
        }
    }
}

/// Chi-square of 31 x 17 cells over 2^18 rays finds a density that is off by 3.3 % in the root mean square with a
/// probability of 99.9 %.
#[test]
fn rays_leave_all_parts_of_the_lens_alike() {
    const RAYS: usize = 1 << 18;
    let mut random = Random(103);
    let camera = Camera { aperture: 0.3, ..Camera::random(&mut random, 40.0) };
    let rows: Vec<In> =
        (0..RAYS).map(|_| In { u: [0; 4].map(|_| (random.bits() >> 40) as f32 * U as f32), ..In::default() }).collect();
    let kernel = kernel("thin_lens");
    let found = kernel.run_with::<_, Out>(&rows, RAYS, &[kernel.settings(&camera.settings())]);
    let [right, up, _] = camera.axes();
    let scale = camera.unit_of_render_space() / (0.5 * camera.aperture);
    let p = |share: fn(f64) -> f64| {
        let points = found.iter().map(|out| {
            let (x, y) = (exact(out.origin).dot(right) * scale, exact(out.origin).dot(up) * scale);
            (share(x.hypot(y)), (y.atan2(x) + PI) / TAU)
        });
        uniform_in_cells((31, 17), points)
    };
    assert!(p(|r| r * r) > 1e-6, "p = {:e}", p(|r| r * r));
    // Uniform by radius instead of by area.
    assert!(p(|r| r) < 1e-6);
}

/// A camera of OpenCV, of 64 x 48 pixels, with its distortion.
fn calibrated(distortion: &str) -> String {
    format!("Calibrated(fx: 40, fy: 44, cx: 30, cy: 25, distortion: {distortion})")
}

/// Where a camera at the origin that looks along -z sees a unit direction, in pixels of an image of 64 x 48 from its left upper corner: by the
/// formulas of docs/scene.md, and of OpenCV's documentation ("Camera Calibration and 3D Reconstruction", and its fisheye model).
fn seen(projection: &str, [x, y, z]: [f64; 3]) -> [f64; 2] {
    let (right, down, forward) = (x, -y, -z);
    let across = right.hypot(down);
    let angle = across.atan2(forward);
    // A fisheye whose fov of 140 degrees is the height of the image.
    let fisheye = |r: fn(f64) -> f64| {
        let pixels = 24.0 / r(70f64.to_radians());
        let scale = if across > 0.0 { r(angle) / across * pixels } else { 0.0 };
        [32.0 + right * scale, 24.0 + down * scale]
    };
    let flat = |at: &dyn Fn(f64, f64) -> [f64; 2]| {
        let [x, y] = at(right / forward, down / forward);
        [30.0 + 40.0 * x, 25.0 + 44.0 * y]
    };
    match projection.split(['(', ':', ',']).filter(|word| !word.trim().is_empty()).collect::<Vec<_>>()[..] {
        ["Equirectangular", _, from, to, ..] => {
            let number = |text: &str| text.trim_matches(|c| " ()".contains(c)).parse::<f64>().unwrap().to_radians();
            let (from, to) = (number(from), number(to));
            let (bottom, top) = ((-50f64).to_radians(), 80f64.to_radians());
            let longitude = (right.atan2(forward) - from).rem_euclid(TAU);
            [64.0 * longitude / (to - from), 48.0 * (top - y.asin()) / (top - bottom)]
        }
        ["Fisheye", _, " Equidistant", ..] => fisheye(|t| t),
        ["Fisheye", _, " Equisolid", ..] => fisheye(|t| 2.0 * (t / 2.0).sin()),
        ["Fisheye", _, " Stereographic", ..] => fisheye(|t| 2.0 * (t / 2.0).tan()),
        ["Fisheye", ..] => fisheye(f64::sin),
        _ if projection.contains("Brown") => flat(&|x, y| {
            let (k1, k2, p1, p2, k3) = (-0.2, 0.04, 0.01, -0.02, 0.001);
            let r2 = x * x + y * y;
            let radial = 1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3);
            [
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ]
        }),
        _ if projection.contains("KannalaBrandt") => {
            let t = angle;
            let distance = t * (1.0 - 0.02 * t.powi(2) + 0.003 * t.powi(4) - 0.001 * t.powi(6) + 0.0001 * t.powi(8));
            let scale = if across > 0.0 { distance / across } else { 1.0 };
            [30.0 + 40.0 * right * scale, 25.0 + 44.0 * down * scale]
        }
        _ => flat(&|x, y| [x, y]),
    }
}

/// Each ray is seen where it comes from, by formulas of others, and light paths see it there. The density of light paths is the one over the solid
/// angle of a pixel, by differences of these formulas.
#[test]
fn projections_are_seen_where_their_rays_come_from() {
    let mut random = Random(104);
    let projections = [
        ("equirectangular", "Equirectangular(horizontal: (-170, 100), vertical: (-50, 80))".to_owned()),
        ("equirectangular", "Equirectangular(horizontal: (20, 300), vertical: (-50, 80))".to_owned()),
        ("fisheye", "Fisheye(model: Equidistant, fov: 140)".to_owned()),
        ("fisheye", "Fisheye(model: Equisolid, fov: 140)".to_owned()),
        ("fisheye", "Fisheye(model: Stereographic, fov: 140)".to_owned()),
        ("fisheye", "Fisheye(model: Orthographic, fov: 140)".to_owned()),
        ("calibrated", "Calibrated(fx: 40, fy: 44, cx: 30, cy: 25)".to_owned()),
        ("calibrated", calibrated("Brown(k1: -0.2, k2: 0.04, p1: 0.01, p2: -0.02, k3: 0.001)")),
        ("calibrated_fisheye", calibrated("KannalaBrandt(k1: -0.02, k2: 0.003, k3: -0.001, k4: 0.0001)")),
    ];
    for (number, (fact, projection)) in projections.iter().enumerate() {
        let has_lens = projection.contains("Calibrated") && !projection.contains("KannalaBrandt");
        // The width of a whole turn of the panoramas, in pixels.
        let turn = 64.0 * 360.0 / if number == 0 { 270.0 } else { 280.0 };
        let around = |x: f64| if *fact == "equirectangular" { x - turn * (x / turn).round() } else { x };
        for (mirror, aperture) in [(false, 0.0), (true, 0.0), (true, if has_lens { 0.3 } else { 0.0 })] {
            let camera = format!(
                "(look_from: (0, 0, 0), look_at: (0, 0, -1), projection: {projection}, mirror: {mirror}, aperture: {aperture:?})"
            );
            let flat = flat_with(&camera, (64, 48), &[]);
            let name = format!("projection.{fact}");
            let model = flat.features.quantities.fisheye.to_string();
            let facts = [("projection", true), (name.as_str(), true), ("lens", aperture > 0.0)];
            let setup = Setup { facts: &facts, values: &[("fisheye", &model)], ..Setup::default() };
            let kernel = Kernel::with("test/projection", &setup);
            let rows = rows(&mut random, (64, 48));
            let found = kernel.run_with::<_, SeenRay>(&rows, rows.len(), &[kernel.settings(&flat.settings)]);
            let mut with_direction = 0;
            for (row, out) in rows.iter().zip(&found) {
                let (x, y) = film_point(row);
                if out.direction == [0.0; 3] {
                    continue;
                }
                with_direction += 1;
                let miss = (f64::from(out.point[0]) - x).hypot(f64::from(out.point[1]) - y);
                assert!(miss < 1e-3, "{projection} {mirror} {row:?} {out:?}: light paths are off by {miss} pixels");
                if aperture > 0.0 {
                    continue;
                }
                let [at_x, at_y] = seen(projection, exact(out.direction).to_array());
                let at_x = if mirror { 64.0 - at_x } else { at_x };
                // Pixels are wider than 2^-7, and a direction has 12 u (above) and those of its angles: 30 u.
                let miss = around(at_x - x).hypot(at_y - y);
                assert!(
                    miss < 1e-3,
                    "{number} {projection} {mirror} {row:?} {out:?}: off by {miss} pixels, {at_x} {at_y}"
                );
                // The area on the film of a small solid angle around the direction.
                let step = 1e-5;
                let middle = exact(out.direction).normalize();
                let across = middle.any_orthonormal_vector();
                let [u, v] = [across, middle.cross(across)].map(|side| {
                    let ends = [-step, step].map(|by| seen(projection, (middle + by * side).normalize().to_array()));
                    [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]].map(|x| around(x) / (2.0 * step))
                });
                let density = (u[0] * v[1] - u[1] * v[0]).abs();
                let off = (f64::from(out.density) / density - 1.0).abs();
                assert!(off < 1e-3, "{projection} {mirror} {row:?} {out:?}: the density is off by {off}, {density}");
            }
            // An equidistant fisheye is no equisolid one.
            let wrong = rows.iter().zip(&found).filter(|(row, out)| {
                let [x, y] = seen("Fisheye(model: Equisolid", exact(out.direction).to_array());
                (x - film_point(row).0).hypot(y - film_point(row).1) > 0.1
            });
            assert!(!projection.contains("Equidistant") || mirror || wrong.count() > 20);
            assert!(with_direction > rows.len() / 3, "{projection}: {with_direction} of {}", rows.len());
        }
    }
}

/// Where curves of calibrated lenses bend twice, plain steps of Newton go in circles: a third of these points had no direction with them.
#[test]
fn calibrated_lenses_have_each_direction_before_their_fold() {
    for (fact, model, k, focal) in [
        ("calibrated_fisheye", "KannalaBrandt", [-0.25, -0.08, 0.17, -0.02], 1.2),
        ("calibrated_fisheye", "KannalaBrandt", [-1.14, -0.08, 3.32, -0.26], 0.01),
        ("calibrated_fisheye", "KannalaBrandt", [0.0, 0.0, 0.0, 1e9], 1e-9),
        ("calibrated", "Brown", [-0.25, -0.08, 0.17, 0.0], 4.0),
        ("calibrated", "Brown", [0.54, 0.29, -0.05, 0.0], 4.0),
        ("calibrated", "Brown", [0.0, 0.0, 1e3, 0.0], 1e-4),
    ] {
        let distance = |x: f64| (1..).zip(k).fold(x, |sum, (power, k)| sum + k * x.powi(2 * power + 1));
        let steps = (0..3000).map(|step| f64::from(step) * 1e-3).take_while(|x| distance(x + 1e-3) > distance(*x));
        let [k1, k2, k3, k4] = k;
        let others = format!("k1: {k1:?}, k2: {k2:?}");
        let distortion = match model {
            "Brown" => format!("Brown({others}, k3: {k3:?})"),
            _ => format!("KannalaBrandt({others}, k3: {k3:?}, k4: {k4:?})"),
        };
        let projection = format!("Calibrated(fx: {focal:?}, fy: {focal:?}, cx: 32, cy: 24, distortion: {distortion})");
        let camera = format!("(look_from: (0, 0, 0), look_at: (0, 0, -1), projection: {projection})");
        let flat = flat_with(&camera, (64, 48), &[]);
        let name = format!("projection.{fact}");
        let setup = Setup { facts: &[("projection", true), (name.as_str(), true)], ..Setup::default() };
        let kernel = Kernel::with("test/projection", &setup);
        let (radii, rows): (Vec<f64>, Vec<In>) = steps
            .map(|x| focal * distance(x))
            .enumerate()
            .map(|(number, r)| {
                let (sine, cosine) = (0.7 * number as f64).sin_cos();
                let at = [32.0 + r * cosine, 24.0 + r * sine];
                let [x, y] = at.map(f64::floor);
                let u = [(at[0] - x) as f32, (at[1] - y) as f32, 0.0, 0.0];
                (r, In { column: x as u32, row: y as u32, u, ..In::default() })
            })
            .filter(|(r, _)| *r < 23.0)
            .unzip();
        assert!(rows.len() > 300, "{projection}: {}", rows.len());
        let found = kernel.run_with::<_, SeenRay>(&rows, rows.len(), &[kernel.settings(&flat.settings)]);
        for (r, out) in radii.iter().zip(&found) {
            let direction = exact(out.direction);
            let angle = direction.truncate().length().atan2(-direction.z);
            let off = focal * distance(if model == "Brown" { angle.tan() } else { angle }) - r;
            // A pixel is a number of 24 bits from 32 on, and the kernel allows 1e-5 of the distance in focal lengths.
            let allowed = 1e-4 + 1e-5 * (focal + r);
            assert!(
                direction.length() > 0.9 && off.abs() < allowed,
                "{projection}: {r} pixels from the middle: {out:?} {off}"
            );
        }
    }
}
