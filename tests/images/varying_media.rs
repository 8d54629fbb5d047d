//! Media whose density varies: what passes them, against quadrature in f64; and against media that are known to be the same.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};
use gpu_rt::scene::Scene;

use crate::common::faults::{Fault, agree, are_found};
use crate::common::render::{Mean, Request, Shot, render, scene_in};
use crate::common::vdb::{TestGrid, scaled, vdb};

const VOXEL: f64 = 0.1;

/// A scene of these objects, with these grids in the file grids.vdb.
fn scene_of(grids: &[(&str, TestGrid<'_>)], camera: &str, background: &str, objects: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("grids.vdb"), vdb(grids)).expect("the file is written");
    let text = format!(
        "Scene(image: (width: 64, height: 64), camera: ({camera}), background: {background},
            materials: {{ \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)), \"white\": Lambertian(albedo: Rgb(1, 1, 1)) }},
            objects: [{objects}])"
    );
    scene_in(folder.path(), &text)
}

const CUBE: &[[[i32; 3]; 2]] = &[[[-20; 3], [20; 3]]];
const AHEAD: &str = "look_from: (0.3, 0.1, 12), look_at: (0, 0, 0), vertical_fov: 18";

fn grid<'a>(value: &'a dyn Fn([i32; 3]) -> f32) -> TestGrid<'a> {
    TestGrid { boxes: CUBE, background: 0.0, map: scaled(VOXEL, [0.0; 3]), value }
}

/// A linear density, and one that a hash gives each voxel.
fn linear([x, ..]: [i32; 3]) -> f32 {
    0.006 * (x + 21) as f32
}

fn rough([x, y, z]: [i32; 3]) -> f32 {
    let hash = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77)
        ^ (z as u32).wrapping_mul(0xc2b2_ae3d);
    let hash = (hash ^ hash >> 15).wrapping_mul(0x2c1b_3c6d);
    f64::from((hash ^ hash >> 13) >> 8) as f32 / (1 << 24) as f32
}

/// The density at a point: trilinear between the voxels of CUBE, 0 beyond.
fn density(value: &dyn Fn([i32; 3]) -> f32, at: DVec3) -> f64 {
    let at = at / VOXEL;
    let (cell, within) = (at.floor(), at - at.floor());
    let corner = |i: usize| {
        let high = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let voxel = (cell + high).as_ivec3();
        let weight = (high * within + (1.0 - high) * (1.0 - within)).to_array().iter().product::<f64>();
        let is_there = voxel.abs().max_element() <= 20;
        if is_there { weight * f64::from(value(voxel.to_array())) } else { 0.0 }
    };
    (0..8).map(corner).sum()
}

/// The transmittance from one point to another, by the midpoint rule.
fn transmittance(density: &dyn Fn(DVec3) -> f64, from: DVec3, to: DVec3, steps: usize) -> f64 {
    let step = (to - from) / steps as f64;
    let sum: f64 = (0..steps).map(|i| density(from + (i as f64 + 0.5) * step)).sum();
    (-sum * step.length()).exp()
}

/// The mean over the image of AHEAD of a function of the rays, from four in each pixel.
fn mean_over_image(of_ray: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let eye = DVec3::new(0.3, 0.1, 12.0);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let (up, half) = (right.cross(forward), (9f64.to_radians()).tan());
    let across = 128;
    let at = |i: i32| ((f64::from(i) + 0.5) * 2.0 / f64::from(across) - 1.0) * half;
    let rays = (0..across).flat_map(|y| (0..across).map(move |x| (x, y)));
    let sum: f64 = rays.map(|(x, y)| of_ray(eye, (forward + at(x) * right - at(y) * up).normalize())).sum();
    sum / f64::from(across * across)
}

/// The image's mean is this transmittance within its noise, 4.9 standard errors, which is at most `most`.
fn is_transmittance(name: &str, shot: &Shot, expected: f64, most: f64) {
    let Mean { value, variance, .. } = shot.mean_of_all();
    let noise = 4.9 * variance[0].sqrt();
    println!("{name}: {} +- {noise:.1e}, expected {expected}", value[0]);
    assert!(noise < most, "{name}: noise {noise}");
    // Kernels round by 1e-6 of a transmittance.
    assert!((value[0] - expected).abs() < noise + 1e-6, "{name}: {} +- {noise}, expected {expected}", value[0]);
}

#[test]
fn light_passes_what_quadrature_says() {
    before_a_sky(1024, 7e-4);
}

#[test]
fn shadow_rays_pass_what_quadrature_says() {
    to_a_floor(512, 1e-3);
}

#[test]
#[ignore = "minutes: make test-long"]
fn light_passes_what_quadrature_says_within_1e_4() {
    before_a_sky(65_536, 1e-4);
}

#[test]
#[ignore = "minutes: make test-long"]
fn shadow_rays_pass_what_quadrature_says_within_1e_4() {
    to_a_floor(65_536, 1e-4);
}

/// Clouds before a white sky.
fn before_a_sky(samples: u32, most: f64) {
    let black = "albedo: Rgb(0, 0, 0)";
    let request = Request::spp(samples).seed(3).sobol().mis();
    let along = |value: &'static dyn Fn([i32; 3]) -> f32| {
        move |eye: DVec3, ray: DVec3| transmittance(&|at| density(value, at), eye + 8.0 * ray, eye + 16.0 * ray, 320)
    };
    for (name, value, scale) in [("linear", &linear as &'static dyn Fn([i32; 3]) -> f32, 0.5), ("rough", &rough, 0.1)] {
        let expected = mean_over_image(|eye, ray| along(value)(eye, ray).powf(scale));
        let own = scene_of(
            &[("density", grid(value))],
            AHEAD,
            "Solid((1, 1, 1))",
            &format!("Medium(density: Grid(path: \"grids.vdb\", scale: {scale}), {black})"),
        );
        is_transmittance(name, &render(&own, &request), expected, most);
    }
    let (scale_height, at) = (0.7, -0.2);
    let expected = mean_over_image(|eye, ray| {
        let ends = [-2.0, 2.0].map(|side| DVec3::splat(side) - eye);
        let slabs = [ends[0] / ray, ends[1] / ray];
        let (enter, leave) = (slabs[0].min(slabs[1]).max_element(), slabs[0].max(slabs[1]).min_element());
        let density = |point: DVec3| 0.05 * (-(point.y - at) / scale_height).exp();
        if enter < leave { transmittance(&density, eye + enter * ray, eye + leave * ray, 200) } else { 1.0 }
    });
    let own = scene_of(
        &[],
        AHEAD,
        "Solid((1, 1, 1))",
        &format!(
            "Medium(boundary: Box(min: (-2, -2, -2), max: (2, 2, 2)),
                density: Height(scale_height: {scale_height}, at: {at}, density: 0.05), {black})"
        ),
    );
    is_transmittance("height", &render(&own, &request), expected, most);
}

/// A white floor whose irradiance is π, beyond the cloud and out of sight of it, has the radiance of the light's transmittance.
fn to_a_floor(samples: u32, most: f64) {
    let camera = "look_from: (0, -6, 0), look_at: (0, -7, 0), up: (0, 0, 1), vertical_fov: 90";
    let floor = "Quad(corner: (-9, -7, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"white\"),
        DirectionalLight(direction: (0, -1, 0), irradiance: (3.141592653589793, 3.141592653589793, 3.141592653589793)),";
    let request = Request::spp(samples).seed(5).sobol().mis().depth(1);
    // The image is the floor from -1 to 1.
    let mean = |of_point: &dyn Fn(f64, f64) -> f64| {
        let at = |i: i32| (f64::from(i) + 0.5) / 64.0 - 1.0;
        (0..128).flat_map(|i| (0..128).map(move |j| (at(i), at(j)))).map(|(x, z)| of_point(x, z)).sum::<f64>() / 16384.0
    };
    let black = "albedo: Rgb(0, 0, 0)";
    for (name, value, scale) in [("linear", &linear as &dyn Fn([i32; 3]) -> f32, 0.5), ("rough", &rough, 0.1)] {
        let expected = mean(&|x, z| {
            let own = |at: DVec3| scale * density(value, at);
            transmittance(&own, DVec3::new(x, -2.1, z), DVec3::new(x, 2.1, z), 336)
        });
        let objects = format!("{floor} Medium(density: Grid(path: \"grids.vdb\", scale: {scale}), {black})");
        let own = scene_of(&[("density", grid(value))], camera, "Solid((0, 0, 0))", &objects);
        let shot = render(&own, &request);
        is_transmittance(name, &shot, expected, most);
        let faults: &[Fault<'_>] = match name {
            "linear" => &[("medium/grid", "let local = position", "let local = select(0.0, 0.5, FAULT) + position")],
            _ => &[
                ("medium/grid", "field.scale * rest", "field.scale * rest * select(1.0, 0.99, FAULT)"),
                ("medium/grid", "1.0 - max(share, 0.0)", "select(1.0, 0.99, FAULT) * (1.0 - max(share, 0.0))"),
            ],
        };
        are_found(name, &own, &shot, &request, faults, 0.0);
    }
    let expected = (-0.2f64 * 0.9 * ((2.0f64 / 0.9).exp() - (-2.0f64 / 0.9).exp())).exp();
    let objects = format!(
        "{floor} Medium(boundary: Box(min: (-2, -2, -2), max: (2, 2, 2)),
            density: Height(scale_height: 0.9, at: 0, density: 0.2), {black})"
    );
    let own = scene_of(&[], camera, "Solid((0, 0, 0))", &objects);
    is_transmittance("height", &render(&own, &request), expected, most);
}

/// Clouds that scatter between a lamp and a floor.
fn lit(seed: u32, grids: &[(&str, TestGrid<'_>)], media: &str) -> Shot {
    let objects = format!(
        "Transformed(by: [Scale(3), Translate((3, 9, 2))], object: Sphere(center: (0, 0, 0), radius: 0.4, material: \"lamp\")),
         Quad(corner: (-9, -3, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"white\"), {media}"
    );
    let scene = scene_of(
        grids,
        "look_from: (0, 4, 12), look_at: (0, 0, 0), vertical_fov: 40",
        "Solid((0.1, 0.1, 0.1))",
        &objects,
    );
    render(&scene, &Request::spp(256).seed(seed).sobol().mis().roulette().size(32, 32))
}

#[test]
fn a_grid_of_one_value_is_a_constant_medium() {
    let one = |_: [i32; 3]| 0.5;
    let more = "albedo: Rgb(0.9, 0.8, 0.5), anisotropy: 0.4";
    let ball = "boundary: Sphere(center: (0, 0, 0), radius: 1.9)";
    let constant = lit(1, &[], &format!("Medium({ball}, density: 0.8, {more})"));
    let within = lit(
        2,
        &[("density", grid(&one))],
        &format!("Medium({ball}, density: Grid(path: \"grids.vdb\", scale: 1.6), {more})"),
    );
    agree("in a ball", &constant, &within, 0.0);
    // Where the grid ends, its background goes on.
    let small = TestGrid { boxes: &[[[-3; 3], [3; 3]]], background: 0.5, ..grid(&one) };
    let around = lit(
        3,
        &[("density", small)],
        &format!("Medium({ball}, density: Grid(path: \"grids.vdb\", scale: 1.6), {more})"),
    );
    agree("around a small grid", &constant, &around, 0.0);
}

#[test]
fn a_grid_may_have_any_boundary_and_transform() {
    let more = "albedo: Rgb(0.9, 0.8, 0.5), anisotropy: 0.4";
    let of_grid = "density: Grid(path: \"grids.vdb\", scale: 3)";
    let bare = lit(4, &[("density", grid(&rough))], &format!("Medium({of_grid}, {more})"));
    let boxed = lit(
        5,
        &[("density", grid(&rough))],
        &format!("Medium(boundary: Box(min: (-4, -2.5, -4), max: (4, 4, 4)), {of_grid}, {more})"),
    );
    agree("in a box", &bare, &boxed, 0.0);
    // The transforms as a map of the file's: turned about y, twice as large, moved.
    let (sin, cos) = (TAU / 12.0).sin_cos();
    let size = 2.0 * VOXEL;
    let map = [
        [size * cos, 0.0, -size * sin, 0.0],
        [0.0, size, 0.0, 0.0],
        [size * sin, 0.0, size * cos, 0.0],
        [0.2, 1.5, -1.0, 1.0],
    ];
    let moved = lit(
        6,
        &[("density", grid(&rough))],
        &format!(
            "Transformed(by: [RotateY(30), Scale(2), Translate((0.2, 1.5, -1))], object: Medium({of_grid}, {more}))"
        ),
    );
    let mapped = lit(7, &[("density", TestGrid { map, ..grid(&rough) })], &format!("Medium({of_grid}, {more})"));
    agree("by the file's map", &moved, &mapped, 0.0);
    // It moves while the shutter is open for no time: as where it is then.
    let at_rest = lit(8, &[("density", grid(&rough))],
        &format!(
            "Moving(keys: [(0, [RotateY(30), Scale(2), Translate((0.2, 1.5, -1))]), (1, [RotateY(90), Scale(2), Translate((0, 0, 0))])],
                object: Medium({of_grid}, {more}))"
        ),
    );
    agree("moving", &moved, &at_rest, 0.0);
    // Its affine inverse is that of the file.
    let there = DAffine3::from_mat3_translation(
        glam::DMat3::from_cols_array(&[size * cos, 0.0, -size * sin, 0.0, size, 0.0, size * sin, 0.0, size * cos]),
        DVec3::new(0.2, 1.5, -1.0),
    );
    assert!((there.inverse() * there).abs_diff_eq(DAffine3::IDENTITY, 1e-12));
}

/// All light that comes in goes out, by rays and by shadow rays.
#[test]
fn clouds_of_albedo_1_keep_their_light() {
    let clouds = "Medium(density: Grid(path: \"grids.vdb\", scale: 1), albedo: Rgb(1, 1, 1), anisotropy: 0.5),
        Medium(boundary: Sphere(center: (1, 0, 0), radius: 1.5), density: Height(scale_height: 0.4, at: 0, density: 0.3), albedo: Rgb(1, 1, 1)),
        Medium(boundary: Box(min: (-1, 0, -2), max: (0, 2, 1)), density: 0.7, albedo: Rgb(1, 1, 1))";
    let lamp = "Sphere(center: (0, 0, 0), radius: 20, material: \"lamp\")";
    let own = scene_of(&[("density", grid(&rough))], AHEAD, "Solid((0, 0, 0))", &format!("{lamp}, {clouds}"));
    for (name, request) in [("rays", Request::spp(16)), ("shadow rays", Request::spp(1024).sobol().mis())] {
        let shot = render(&own, &request.seed(8).depth(2000).size(32, 32));
        let mean = shot.mean_of_all();
        assert!((mean.value[0] - 1.0).abs() < 1e-3, "{name}: {:?}", mean.value);
        mean.is_near([1.0; 3], 2e-3).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Optical depths are those of scenes of usual size, whatever density, voxels and distance are.
#[test]
fn extremes_of_density_size_and_distance() {
    let one = |_: [i32; 3]| 1.0;
    let expected = render_of_size(&one, 1.0, 1.0, 0.0).mean_of_all();
    for (size, density, away) in
        [(1e8, 1e-8, 0.0), (1e-8, 1e8, 0.0), (1e-5, 1e5, 0.0), (1.0, 1.0, 1e8), (1e-5, 1e5, 1e8 * 1e-5)]
    {
        let mean = render_of_size(&one, size, density, away).mean_of_all();
        let (p, z) = mean.difference(&expected, 0, 0.0);
        assert!(p > 1e-6, "voxels of {size} times 0.1, density {density}, {away} away: {z} standard errors");
    }
}

/// A cloud with an optical depth of about 2, `away` from the origin, with the camera.
fn render_of_size(value: &dyn Fn([i32; 3]) -> f32, size: f64, density: f64, away: f64) -> Shot {
    let origin = [away, 0.0, -away];
    let of_grid = TestGrid { boxes: &[[[-9; 3], [9; 3]]], map: scaled(VOXEL * size, origin), ..grid(value) };
    let camera = format!(
        "look_from: ({}, 0, {}), look_at: ({away}, 0, {}), vertical_fov: 12",
        away + 0.1 * size,
        6.0 * size - away,
        -away
    );
    let medium = format!("Medium(density: Grid(path: \"grids.vdb\", scale: {density}), albedo: Rgb(0.8, 0.8, 0.8))");
    let scene = scene_of(&[("density", of_grid)], &camera, "Gradient(bottom: (0, 0, 0), top: (1, 1, 1))", &medium);
    render(&scene, &Request::spp(512).seed(7).sobol().mis().size(32, 32))
}

#[test]
fn grids_without_densities_are_warned_of() {
    let warnings = |value: &dyn Fn([i32; 3]) -> f32| {
        let media = "Medium(density: Grid(path: \"grids.vdb\"), albedo: Rgb(0.5, 0.5, 0.5))";
        scene_of(&[("density", grid(value))], AHEAD, "Solid((1, 1, 1))", media).warnings().join(" ")
    };
    assert!(!warnings(&rough).contains("Grid") && !warnings(&rough).contains("density"));
    assert!(warnings(&|_| 0.0).contains("objects[0].Medium.density: no voxel of the grid"));
    assert!(warnings(&|[x, ..]| x as f32).contains("values below 0, such as -20"));
}

/// One voxel in a box of 512 along each edge takes little memory, and few steps.
#[test]
fn one_voxel_in_a_large_grid() {
    let spot = |voxel: [i32; 3]| if voxel == [0; 3] { 40.0 } else { 0.0 };
    let sparse = |boxes| TestGrid { boxes, ..grid(&spot) };
    let far: &[[[i32; 3]; 2]] = &[[[-256; 3], [-256; 3]], [[0; 3], [0; 3]], [[255; 3], [255; 3]]];
    let near: &[[[i32; 3]; 2]] = &[[[0; 3], [0; 3]]];
    let shots = [far, near].map(|boxes| {
        let camera = "look_from: (0, 0, 60), look_at: (0, 0, 0), vertical_fov: 0.4";
        let medium = "Medium(density: Grid(path: \"grids.vdb\"), albedo: Rgb(0.5, 0.5, 0.5))";
        let scene = scene_of(&[("density", sparse(boxes))], camera, "Solid((1, 1, 1))", medium);
        let flat = gpu_rt::flatten::flatten(&scene, (32, 32), &Request::default().options).expect("it flattens");
        assert!(flat.bricks.len() < 50_000, "{} words", flat.bricks.len());
        render(&scene, &Request::spp(256).seed(boxes.len() as u32).sobol().size(32, 32))
    });
    agree("one voxel", &shots[0], &shots[1], 0.0);
    let mean = shots[0].mean_of_all().value[0];
    assert!(mean < 0.97, "it is not seen: {mean}");
}
