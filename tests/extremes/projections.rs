//! Cameras of all projections: in scenes of other sizes and places, and fisheye lenses from the narrowest view to the widest.

use std::f64::consts::PI;

use glam::DVec3;

use crate::common::everything::same;
use crate::common::render::{Request, Shot, render, scene};
use crate::common::scenes::triple;
use crate::table::Cell;
use crate::views::{EDGE, EDGE_BECAUSE, SAMPLES, edge_limit, rms};

const PROJECTIONS: [&str; 8] = [
    "Orthographic(height: 4)",
    "Equirectangular()",
    "Fisheye(model: Equidistant, fov: 360)",
    "Fisheye(model: Equisolid, fov: 360)",
    "Fisheye(model: Stereographic, fov: 250)",
    "Fisheye(model: Orthographic, fov: 180)",
    "Calibrated(fx: 30, fy: 33, cx: 22, cy: 17, distortion: Brown(k1: -0.2, k2: 0.05, p1: 0.002, p2: -0.003))",
    "Calibrated(fx: 12, fy: 13, cx: 22, cy: 17, distortion: KannalaBrandt(k1: -0.02, k2: 0.003))",
];

/// Lamps before a sky that tells directions: all lengths so many times as long, all moved, and the camera moved aside.
fn seen_by(projection: &str, scale: f64, shift: DVec3, aside: f64) -> Shot {
    let point = |x: f64, y: f64, z: f64| triple(scale * DVec3::new(x, y, z) + shift);
    let text = format!(
        "Scene(image: (width: 40, height: 30), camera: (look_from: {}, look_at: {}, up: (0.1, 1, 0), projection: {}),
         background: Gradient(bottom: (0.1, 0.2, 0.3), top: (0.9, 0.7, 0.5)),
         materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: {:?}, material: \"lamp\"), Sphere(center: {}, radius: {:?}, material: \"lamp\")])",
        point(0.3 + aside, 0.4, 5.0),
        point(aside, 0.2, 0.0),
        projection.replace("height: 4", &format!("height: {:?}", 4.0 * scale)),
        point(0.5, 0.4, 0.0),
        0.8 * scale,
        point(-0.9, -0.3, -1.0),
        0.7 * scale,
    );
    render(&scene(&text), &Request::spp(SAMPLES))
}

pub fn powers_of_two() -> Vec<Cell> {
    let of = |projection: &'static str| {
        let usual = seen_by(projection, 1.0, DVec3::ZERO, 0.0);
        let differs = |scale: f64, aside: f64| {
            f64::from(u8::from(!same(&usual, &seen_by(projection, scale, DVec3::ZERO, aside))))
        };
        [-40, 40].map(|exponent| {
            let scale = 2f64.powi(exponent);
            Cell::new(
                format!("2^{exponent}, {projection}"),
                "Whether any bit of the image differs, for lamps before a sky",
                0.0,
                "none, because the host scales the scene to an extent of 1 by a power of two, in f64: kernels read the same numbers.",
            )
            .achieved(differs(scale, 0.0))
            .planted("camera moved by a hundredth of its distance", differs(scale, 0.05))
        })
    };
    PROJECTIONS.into_iter().flat_map(of).collect()
}

pub fn positions() -> Vec<Cell> {
    let far = DVec3::new(-1e8 / 3.0, 1e8, -0.7e8);
    let of = |projection: &'static str| {
        let usual = seen_by(projection, 1.0, DVec3::ZERO, 0.0);
        let off = |aside: f64| {
            let other = seen_by(projection, 1.0, far, aside);
            let values =
                |shot: &Shot| shot.picture.rgb.clone().into_iter().flatten().map(f64::from).collect::<Vec<_>>();
            values(&usual).iter().zip(values(&other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        Cell::new(
            format!("({:.1e}, {:.1e}, {:.1e}), {projection}", far.x, far.y, far.z),
            "Largest difference of a pixel from that at the origin, for lamps before a sky",
            1.0 / f64::from(SAMPLES),
            "one of 256 samples that passes a lamp: at 1e8 the scene is stored to 1e-7 of a pixel, so that no two of 3e5 do so.",
        )
        .achieved(off(0.0))
        .planted("camera moved by a fiftieth of its distance", off(0.1))
    };
    PROJECTIONS.into_iter().map(of).collect()
}

/// The angle of a fisheye's r.
type Angle = fn(f64) -> f64;

/// A lamp around a direction beside the axis, 0.05 of the view away from it: half as wide as the view, or 160 degrees. What is rendered has
/// a view so many times as wide.
fn edge_error(model: &str, angle: Angle, radius: fn(f64) -> f64, fov: f64, wider: f64) -> f64 {
    const SIZE: u32 = 48;
    const GRID: u32 = 32;
    let half = (0.5 * fov).to_radians();
    let (beside, wide) = (0.1 * half, (0.5 * half).min(PI * 4.0 / 9.0));
    let axis = DVec3::new(beside.sin(), 0.0, -beside.cos());
    let text = format!(
        "Scene(image: (width: {SIZE}, height: {SIZE}),
         camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), projection: Fisheye(model: {model}, fov: {:?})),
         background: Solid((0, 0, 0)), materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: {:?}, material: \"lamp\")])",
        wider * fov,
        triple(axis),
        wide.sin(),
    );
    let shot = render(&scene(&text), &Request::spp(SAMPLES));
    let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
    let step = 2.0 * radius(half) / f64::from(SIZE);
    let covers = |x: f64, y: f64| {
        let r = step * x.hypot(y);
        let t = angle(r);
        let across = t.sin() / x.hypot(y);
        // By the chord between the directions: their product says nothing of small angles.
        let chord = (DVec3::new(x * across, -y * across, -t.cos()) - axis).length();
        f64::from(u8::from(t.is_finite() && chord <= 2.0 * (0.5 * wide).sin()))
    };
    let of_pixel = |pixel: u32| {
        let at = |i: u32, ray: u32| f64::from(i) + (f64::from(ray) + 0.5) / f64::from(GRID) - 0.5 * f64::from(SIZE);
        let rays = (0..GRID * GRID).map(|ray| covers(at(pixel % SIZE, ray % GRID), at(pixel / SIZE, ray / GRID)));
        rays.sum::<f64>() / f64::from(GRID * GRID)
    };
    let covered: Vec<f64> = (0..SIZE * SIZE).map(of_pixel).collect();
    rms(&found, &covered, |c| c > 0.0 && c < 1.0)
}

/// A model's name, its angle at a radius, its radius at an angle, and the widest of its lenses here, in degrees.
type Model = (&'static str, Angle, fn(f64) -> f64, f64);

pub fn fisheyes() -> Vec<Cell> {
    let models: [Model; 4] = [
        ("Equidistant", |r| r, |t| t, 360.0),
        ("Equisolid", |r| 2.0 * (0.5 * r).asin(), |t| 2.0 * (0.5 * t).sin(), 360.0),
        ("Stereographic", |r| 2.0 * (0.5 * r).atan(), |t| 2.0 * (0.5 * t).tan(), 200.0),
        ("Orthographic", f64::asin, f64::sin, 180.0),
    ];
    let of = |(model, angle, radius, most): Model| {
        [1e-3, most].map(|fov| {
            Cell::new(format!("fisheye, {model}, {fov} degrees"), EDGE, edge_limit(), EDGE_BECAUSE)
                .achieved(edge_error(model, angle, radius, fov, 1.0))
                .planted("view a tenth narrower", edge_error(model, angle, radius, fov, 0.9))
        })
    };
    models.into_iter().flat_map(of).collect()
}
