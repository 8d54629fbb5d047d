//! Cameras at their extremes, against closed forms integrated over pixels in f64.

use std::f64::consts::PI;

use glam::DVec3;

use crate::places::chance_limit;
use crate::render::{Ask, render, scene};
use crate::scenes::triple;
use crate::table::{Cell, Row};
use crate::vectors::U;

/// Samples of a pixel.
const SAMPLES: u32 = 256;
/// How much above its expectation a root mean square of hundreds of pixels' errors may be by chance: a chi-square of 100 degrees is above
/// 1.8 times its mean once in a million.
const CHANCE: f64 = 1.35;

/// The table's cells of cameras.
pub fn cells() -> Vec<Cell> {
    let mut all = fields_of_view();
    all.extend(telescopes());
    all.extend(lenses());
    all.extend(sizes());
    all
}

/// A camera with no axis of its own along one of the world's.
struct Oblique {
    from: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Oblique {
    fn new() -> Oblique {
        let forward = DVec3::new(0.3, -0.5, 0.81).normalize();
        let right = forward.cross(DVec3::new(0.1, 1.0, 0.2)).normalize();
        Oblique { from: DVec3::new(1.3, -0.7, 2.1), forward, right, up: right.cross(forward) }
    }

    fn text(&self, distance: f64, vertical_fov: f64) -> String {
        let at = self.from + distance * self.forward;
        format!(
            "camera: (look_from: {}, look_at: {}, up: {}, vertical_fov: {vertical_fov:?})",
            triple(self.from),
            triple(at),
            triple(self.up)
        )
    }

    fn point(&self, p: DVec3) -> DVec3 {
        self.from + p.x * self.right + p.y * self.up - p.z * self.forward
    }
}

/// The mean of a function over each pixel of an image of `size`, by 32 x 32 places: of the direction (x, y, -1) in the camera's space.
fn integrated((width, height): (u32, u32), vertical_fov: f64, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    const PLACES: u32 = 32;
    let pixel = 2.0 * (0.5 * vertical_fov).to_radians().tan() / f64::from(height);
    let of_pixel = |column: u32, row: u32| {
        let mut sum = 0.0;
        for place in 0..PLACES * PLACES {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(PLACES);
            let x = (f64::from(column) + at(place % PLACES) - 0.5 * f64::from(width)) * pixel;
            let y = (0.5 * f64::from(height) - f64::from(row) - at(place / PLACES)) * pixel;
            sum += f(DVec3::new(x, y, -1.0));
        }
        sum / f64::from(PLACES * PLACES)
    };
    (0..height).flat_map(|row| (0..width).map(move |column| (column, row))).map(|(x, y)| of_pixel(x, y)).collect()
}

/// Root mean square of the differences, over the pixels for which `counts` holds.
fn rms(found: &[f64], expected: &[f64], counts: impl Fn(f64) -> bool) -> f64 {
    let squares: Vec<f64> =
        found.iter().zip(expected).filter(|(_, e)| counts(**e)).map(|(f, e)| (f - e) * (f - e)).collect();
    assert!(squares.len() > 60, "{} pixels count", squares.len());
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// A shining sphere, seen by an oblique camera a little beside its middle: the error of its coverage of the pixels on its edge.
fn edge_error(distance: f64, radius: f64, vertical_fov: f64) -> f64 {
    let camera = Oblique::new();
    let beside = DVec3::new(0.13 * radius, -0.07 * radius, -distance);
    let text = format!(
        "Scene(image: (width: 48, height: 48), {}, background: Solid((0, 0, 0)),
         materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: {radius:?}, material: \"lamp\")])",
        camera.text(distance, vertical_fov),
        triple(camera.point(beside)),
    );
    let shot = render(&scene(&text), &Ask::spp(SAMPLES));
    let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
    // Inside where the line passes the centre within a radius.
    let covered = integrated((48, 48), vertical_fov, |d| {
        f64::from(u8::from(d.cross(beside).length() <= radius * d.length() && d.dot(beside) > 0.0))
    });
    rms(&found, &covered, |c| c > 0.0 && c < 1.0)
}

const EDGE: &str = "Error of the share of edge pixels that a sphere covers, root mean square";
const EDGE_BECAUSE: &str =
    "A pixel's 256 samples are off by 1/32 of it at most on average; 1.35 times that is not reached by chance.";

fn edge_limit() -> f64 {
    CHANCE * 0.5 / f64::from(SAMPLES).sqrt()
}

/// The sphere's image is half as high as the picture, however narrow or wide the view.
fn fields_of_view() -> Vec<Cell> {
    [1e-3, 1e-2, 0.1, 1.0, 10.0, 90.0, 150.0, 179.0]
        .map(|fov: f64| {
            let radius = (0.5 * (0.5 * fov).to_radians().tan()).atan().sin();
            Cell::new(Row::FieldOfView, format!("{fov} degrees"), EDGE, edge_limit(), EDGE_BECAUSE)
                .achieved(edge_error(1.0, radius, fov))
        })
        .into()
}

/// Far spheres through telescopes: their edges, and their normals by how bright a sky makes them.
fn telescopes() -> Vec<Cell> {
    let mut all = Vec::new();
    for exponent in 1..=7 {
        let distance = 10f64.powi(exponent);
        let fov = 4.0 * (1.0 / distance).atan().to_degrees();
        let range = format!("D/r = 1e{exponent}, through a telescope");
        all.push(
            Cell::new(Row::Distance, range.clone(), EDGE, edge_limit(), EDGE_BECAUSE)
                .achieved(edge_error(distance, 1.0, fov)),
        );
        all.push(
            Cell::new(
                Row::Distance,
                range,
                "Error of the light that far Lambertian spheres show of a gradient sky, root mean square over their middles",
                // E[y] under the cosine is 2/3 n.y, its variance at most 1/4: a sample's standard deviation is 1/4 at most.
                CHANCE * 0.25 / f64::from(16 * SAMPLES).sqrt(),
                "A sample has a standard deviation of 1/4 at most and a pixel has 4096: 1/256, and 1.35 for chance.",
            )
            .achieved(shading_error(distance, fov)),
        );
    }
    all
}

/// Light from 0 below to 1 above, on a white sphere: 0.5 (1 + 2/3 n.y) at a normal n.
fn shading_error(distance: f64, vertical_fov: f64) -> f64 {
    let camera = Oblique::new();
    let center = DVec3::new(0.13, -0.07, -distance);
    let text = format!(
        "Scene(image: (width: 24, height: 24), {}, background: Gradient(bottom: (0, 0, 0), top: (1, 1, 1)),
         materials: {{\"white\": Lambertian(albedo: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: 1, material: \"white\")])",
        camera.text(distance, vertical_fov),
        triple(camera.point(center)),
    );
    let shot = render(&scene(&text), &Ask::spp(16 * SAMPLES));
    let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
    let expected = integrated((24, 24), vertical_fov, |d| {
        let d = d.normalize();
        // From the foot of the perpendicular, half a chord back.
        let foot = center.dot(d) * d - center;
        let across = foot.length_squared();
        if across > 1.0 {
            // A pixel that holds the edge does not count.
            return f64::NAN;
        }
        let normal = foot - (1.0 - across).sqrt() * d;
        let world = normal.x * camera.right + normal.y * camera.up - normal.z * camera.forward;
        0.5 * (1.0 + 2.0 / 3.0 * world.y)
    });
    rms(&found, &expected, |e| !e.is_nan())
}

/// The half plane x < 0 of a plane at distance 5 shines, through a lens: a point o of the lens sees o (1 - 5/f) + 5 x of it.
fn lenses() -> Vec<Cell> {
    const FIGURE: &str = "Error of what a lens sees of a half plane at distance 5, root mean square over all pixels";
    const BECAUSE: &str = "As of edge pixels: 1/32, and 1.35 for chance.";
    let cell = |row, range: String, aperture: f64, focus: f64| {
        let reach = 0.5 * aperture * (1.0 - 5.0 / focus);
        // No larger than the lens can see: its edges are as sharp as its size allows.
        let size = 4.0 * reach.abs() + 10.0;
        let height = 2.0 * size;
        let text = format!(
            "Scene(image: (width: 16, height: 16), background: Solid((0, 0, 0)),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40, aperture: {aperture:?}, focus_distance: {focus:?}),
             materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
             objects: [Quad(corner: (-{size:?}, -{size:?}, -5), u: ({size:?}, 0, 0), v: (0, {height:?}, 0), material: \"lamp\")])"
        );
        let shot = render(&scene(&text), &Ask::spp(SAMPLES));
        let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
        let expected = integrated((16, 16), 40.0, |d| match reach {
            0.0 => f64::from(u8::from(d.x < 0.0)),
            _ => {
                let q = (5.0 * d.x / reach.abs()).clamp(-1.0, 1.0);
                (q.acos() - q * (1.0 - q * q).sqrt()) / PI
            }
        });
        Cell::new(row, range, FIGURE, edge_limit(), BECAUSE).achieved(rms(&found, &expected, |_| true))
    };
    let apertures = [0.0, 1e-6, 1e-3, 1.0, 1e3];
    let focuses = [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e8];
    let mut all: Vec<Cell> = apertures.map(|a| cell(Row::Aperture, format!("{a:e}, focus at 10"), a, 10.0)).into();
    all.extend(focuses.map(|f| cell(Row::Focus, format!("{f:e}, aperture 0.1"), 0.1, f)));
    all
}

/// A gradient sky: in a picture of many pixels each must show its own place, in one pixel the mean of all.
fn sizes() -> Vec<Cell> {
    let render_sky = |width: u32, height: u32, fov: f64, samples: u32| {
        let text = format!(
            "Scene(image: (width: {width}, height: {height}), background: Gradient(bottom: (0, 0, 0), top: (1, 1, 1)),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), up: (1, 0, 0), vertical_fov: {fov:?}), materials: {{}}, objects: [])"
        );
        render(&scene(&text), &Ask::spp(samples))
    };
    // Up is to the right of the scene's x: y falls or rises along the picture's width alone.
    let radiance = |x: f64, y: f64| 0.5 * (1.0 - x / (1.0 + x * x + y * y).sqrt());
    let mut all = Vec::new();
    let (width, fov) = (16384u32, 1e-2f64);
    let pixel = 2.0 * (0.5 * fov).to_radians().tan() / 2.0;
    let shot = render_sky(width, 2, fov, 16);
    let mut worst = 0.0f64;
    for (i, rgb) in shot.picture.rgb.iter().enumerate() {
        let x = ((i as u32 % width) as f64 + 0.5 - 0.5 * f64::from(width)) * pixel;
        let slope = 0.5 * pixel / (1.0 + x * x).powf(1.5);
        worst = worst.max((f64::from(rgb[0]) - radiance(x, 0.0)).abs() / slope);
    }
    all.push(
        Cell::new(
            Row::ImageSize,
            "16384 x 2",
            "How far from its middle, in pixels, a pixel's mean is of a sky that brightens along the picture",
            // Half a pixel; a picture this wide changes by 1/4 over its half, 1e-5 a pixel at its ends.
            0.5 + 8.0 * U / (0.5 * pixel / (1.0 + (8192.0 * pixel).powi(2)).powf(1.5)),
            "Samples lie in their pixel: half a pixel, and eight roundings of a radiance of 1 over what it changes by from pixel to pixel.",
        )
        .achieved(worst),
    );
    for (fov, samples) in [(40.0, 4096), (179.0, 4096)] {
        let shot = render_sky(1, 1, fov, samples);
        let half = (0.5 * fov).to_radians().tan();
        let expected = integrated((1, 1), fov, |d| radiance(d.x, d.y))[0];
        let spread = half.min(1.0) / 2.0;
        all.push(
            Cell::new(
                Row::ImageSize,
                format!("1 x 1, {fov} degrees"),
                "Error of the one pixel's mean, in standard errors at most",
                chance_limit(1),
                "A normal variate is above it once in 1e6.",
            )
            .achieved((f64::from(shot.picture.rgb[0][0]) - expected).abs() / (spread / f64::from(samples).sqrt())),
        );
    }
    all
}
