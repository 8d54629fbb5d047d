//! Cameras at their extremes, against closed forms integrated over pixels in f64.

use std::f64::consts::PI;

use glam::DVec3;

use crate::common::kernel::{Fault, MODULE, Overlay};
use crate::common::render::{Request, render, render_planted, scene};
use crate::common::scenes::triple;
use crate::common::trace::SPHERE_BY_THE_BOOK;
use crate::common::vectors::U;
use crate::positions::chance_limit;
use crate::table::{Cell, TEXTBOOK_SPHERE};

/// Samples of a pixel.
pub const SAMPLES: u32 = 256;
/// How much above its expectation a root mean square of hundreds of pixels' errors may be by chance: a chi-square of
/// 100 degrees is above 1.8 times its mean once in a million.
const CHANCE: f64 = 1.35;

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

/// The mean of a function over each pixel of an image of `size`, by 32 x 32 points: of the direction (x, y, -1) in the
/// camera's space.
fn integrated((width, height): (u32, u32), vertical_fov: f64, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    const GRID: u32 = 32;
    let pixel = 2.0 * (0.5 * vertical_fov).to_radians().tan() / f64::from(height);
    let of_pixel = |column: u32, row: u32| {
        let mut sum = 0.0;
        for ray in 0..GRID * GRID {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
            let x = (f64::from(column) + at(ray % GRID) - 0.5 * f64::from(width)) * pixel;
            let y = (0.5 * f64::from(height) - f64::from(row) - at(ray / GRID)) * pixel;
            sum += f(DVec3::new(x, y, -1.0));
        }
        sum / f64::from(GRID * GRID)
    };
    (0..height).flat_map(|row| (0..width).map(move |column| (column, row))).map(|(x, y)| of_pixel(x, y)).collect()
}

/// Root mean square of the differences, over the pixels for which `counts` holds.
pub fn rms(found: &[f64], expected: &[f64], counts: impl Fn(f64) -> bool) -> f64 {
    let squares: Vec<f64> =
        found.iter().zip(expected).filter(|(_, e)| counts(**e)).map(|(f, e)| (f - e) * (f - e)).collect();
    assert!(squares.len() > 60, "{} pixels count", squares.len());
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// A shining sphere, seen by an oblique camera a little beside its middle: the error of its coverage of the pixels on
/// its edge. What is rendered has a view so many times as wide, and kernels with replaced modules.
fn edge_error_of(distance: f64, radius: f64, vertical_fov: f64, wider: f64, replaced: &[Fault<'_>]) -> f64 {
    let camera = Oblique::new();
    let beside = DVec3::new(0.13 * radius, -0.07 * radius, -distance);
    let rendered_fov = 2.0 * (wider * (0.5 * vertical_fov).to_radians().tan()).atan().to_degrees();
    let text = format!(
        "Scene(image: (width: 48, height: 48), {}, background: Solid((0, 0, 0)),
         materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: {radius:?}, material: \"lamp\")])",
        camera.text(distance, rendered_fov),
        triple(camera.point(beside)),
    );
    let shot = render_planted(&scene(&text), &Request::spp(SAMPLES), &Overlay::new(replaced));
    let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
    // Inside where the line passes the centre within a radius.
    let covered = integrated((48, 48), vertical_fov, |d| {
        f64::from(u8::from(d.cross(beside).length() <= radius * d.length() && d.dot(beside) > 0.0))
    });
    rms(&found, &covered, |c| c > 0.0 && c < 1.0)
}

fn edge_error(distance: f64, radius: f64, vertical_fov: f64) -> f64 {
    edge_error_of(distance, radius, vertical_fov, 1.0, &[])
}

/// Half a pixel on the edge.
const WIDER: f64 = 1.05;
const WIDER_NAME: &str = "view a twentieth wider";

pub const EDGE: &str = "Root mean square error of the share of edge pixels that a sphere covers";
pub const EDGE_BECAUSE: &str =
    "the standard error of a pixel's 256 samples is at most 1/32 of it; chance does not reach 1.35 times that.";

pub fn edge_limit() -> f64 {
    CHANCE * 0.5 / f64::from(SAMPLES).sqrt()
}

/// The sphere's image is half as high as the picture, however narrow or wide the view.
pub fn fields_of_view() -> Vec<Cell> {
    [1e-3, 1e-2, 0.1, 1.0, 10.0, 90.0, 150.0, 179.0]
        .map(|fov: f64| {
            let radius = (0.5 * (0.5 * fov).to_radians().tan()).atan().sin();
            Cell::new(format!("{fov} degrees"), EDGE, edge_limit(), EDGE_BECAUSE)
                .achieved(edge_error(1.0, radius, fov))
                .planted(WIDER_NAME, edge_error_of(1.0, radius, fov, WIDER, &[]))
        })
        .into()
}

/// Far spheres through telescopes: their edges, and their normals by how bright a sky makes them.
pub fn telescopes() -> Vec<Cell> {
    let mut all = Vec::new();
    for exponent in 1..=7 {
        let distance = 10f64.powi(exponent);
        let fov = 4.0 * (1.0 / distance).atan().to_degrees();
        let range = format!("D/r = 1e{exponent}, through a telescope");
        let cell = Cell::new(range.clone(), EDGE, edge_limit(), EDGE_BECAUSE)
            .achieved(edge_error(distance, 1.0, fov))
            .planted(WIDER_NAME, edge_error_of(distance, 1.0, fov, WIDER, &[]));
        all.push(match exponent >= 4 {
            true => cell.planted(TEXTBOOK_SPHERE, edge_error_of(distance, 1.0, fov, 1.0, &SPHERE_BY_THE_BOOK)),
            false => cell,
        });
        all.push(
            Cell::new(
                range,
                "Root mean square error of the radiance in the middle of far Lambertian spheres under a gradient sky",
                // E[y] under the cosine is 2/3 n.y, its variance at most 1/4: a sample's standard deviation is 1/4 at most.
                CHANCE * 0.25 / f64::from(16 * SAMPLES).sqrt(),
                "a sample has a standard deviation of at most 1/4, and a pixel has 4096 samples: 1/256, times 1.35 for chance.",
            )
            .achieved(shading_error(distance, fov, 1.0))
            .planted("sky dimmer by a twentieth at its top", shading_error(distance, fov, 0.95)),
        );
    }
    all
}

/// Light from 0 below to 1 above, on a white sphere: 0.5 (1 + 2/3 n.y) at a normal n. What is rendered has this radiance above.
fn shading_error(distance: f64, vertical_fov: f64, top: f64) -> f64 {
    let camera = Oblique::new();
    let center = DVec3::new(0.13, -0.07, -distance);
    let text = format!(
        "Scene(image: (width: 24, height: 24), {}, background: Gradient(bottom: (0, 0, 0), top: ({top:?}, {top:?}, {top:?})),
         materials: {{\"white\": Lambertian(albedo: Rgb(1, 1, 1))}},
         objects: [Sphere(center: {}, radius: 1, material: \"white\")])",
        camera.text(distance, vertical_fov),
        triple(camera.point(center)),
    );
    let shot = render(&scene(&text), &Request::spp(16 * SAMPLES));
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

/// The half plane x < 0 of a plane at distance 5 shines, through a lens: a point o of the lens sees o (1 - 5/f) + 5 x
/// of it. The picture is as wide as twice what the lens spreads the edge by, up to 40 degrees: its blur is a quarter of
/// it or more.
/// An aperture and a focus.
type Lens = (f64, f64);

/// Images through lenses, and through others in their place.
fn lenses(lenses: &[(String, Lens, Option<Lens>)]) -> Vec<Cell> {
    const FIGURE: &str = "Root mean square error of the pixels in an image of a half plane at distance 5 through a lens, with an \
                          image as wide as the blur";
    const BECAUSE: &str = "1/32, times 1.35 for chance, as for edge pixels.";
    const NO_LENS: &[Fault<'_>] = &[("camera/thin_lens", MODULE, "camera/pinhole")];
    let reach_of = |aperture: f64, focus: f64| 0.5 * aperture * (1.0 - 5.0 / focus);
    // The error of what is rendered with one lens against what another one shows.
    let error = |(aperture, focus): (f64, f64), rendered: (f64, f64), replaced: &[Fault<'_>]| {
        let reach: f64 = reach_of(aperture, focus);
        let half = match reach {
            0.0 => 5.0 * 20f64.to_radians().tan(),
            _ => (2.0 * reach.abs()).min(5.0 * 20f64.to_radians().tan()),
        };
        let fov = 2.0 * (half / 5.0).atan().to_degrees();
        // No larger than the lenses can see: its edges are as sharp as its size allows.
        let size = 2.0 * half + 4.0 * reach.abs().max(reach_of(rendered.0, rendered.1).abs());
        let height = 2.0 * size;
        let text = format!(
            "Scene(image: (width: 16, height: 16), background: Solid((0, 0, 0)),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: {fov:?}, aperture: {:?}, focus_distance: {:?}),
             materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
             objects: [Quad(corner: (-{size:?}, -{size:?}, -5), u: ({size:?}, 0, 0), v: (0, {height:?}, 0), material: \"lamp\")])",
            rendered.0, rendered.1
        );
        let shot = render_planted(&scene(&text), &Request::spp(SAMPLES), &Overlay::new(replaced));
        let found: Vec<f64> = shot.picture.rgb.iter().map(|rgb| f64::from(rgb[0])).collect();
        let expected = integrated((16, 16), fov, |d| match reach {
            0.0 => f64::from(u8::from(d.x < 0.0)),
            _ => {
                let q = (5.0 * d.x / reach.abs()).clamp(-1.0, 1.0);
                (q.acos() - q * (1.0 - q * q).sqrt()) / PI
            }
        });
        rms(&found, &expected, |_| true)
    };
    let cell = |(range, lens, other): &(String, Lens, Option<Lens>)| {
        let lens = *lens;
        let cell = Cell::new(range, FIGURE, edge_limit(), BECAUSE).achieved(error(lens, lens, &[]));
        let cell = match lens.0 {
            0.0 => cell.planted("aperture of 1", error(lens, (1.0, lens.1), &[])),
            _ => cell.planted("no lens", error(lens, lens, NO_LENS)),
        };
        match *other {
            Some(other) => cell.planted("focus at 10, or at half of its distance", error(lens, other, &[])),
            None => cell,
        }
    };
    lenses.iter().map(cell).collect()
}

pub fn apertures() -> Vec<Cell> {
    // A quad's edge is known to some u of its distance, 1e-6 here. What is in focus near the eye spreads it by more than that.
    lenses(
        &[(0.0, 10.0), (1e-6, 1e-2), (1e-3, 10.0), (1.0, 10.0), (1e3, 10.0)]
            .map(|lens| (format!("{:e}, focus at {}", lens.0, lens.1), lens, None)),
    )
}

pub fn focuses() -> Vec<Cell> {
    // So small where the focus is near that the picture is not all blur.
    let apertures = [(1e-4, 1e-5), (1e-2, 1e-3), (1.0, 0.1), (1e2, 0.1), (1e4, 0.1), (1e8, 0.1)];
    lenses(&apertures.map(|(focus, aperture)| {
        // From 100 on what is at 5 is blurred as if the focus were at infinity; what is nearer than 1, twice as much at half of it.
        let other = if focus > 5.0 { 10.0 } else { 0.5 * focus };
        (format!("{focus:e}, aperture {aperture:e}"), (aperture, focus), Some((aperture, other)))
    }))
}

/// A gradient sky: in a picture of many pixels each must show its own direction, in one pixel the mean of all.
pub fn sizes() -> Vec<Cell> {
    let render_sky = |width: u32, height: u32, fov: f64, samples: u32| {
        let text = format!(
            "Scene(image: (width: {width}, height: {height}), background: Gradient(bottom: (0, 0, 0), top: (1, 1, 1)),
             camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), up: (1, 0, 0), vertical_fov: {fov:?}), materials: {{}}, objects: [])"
        );
        render(&scene(&text), &Request::spp(samples))
    };
    // Up is to the right of the scene's x: y falls or rises along the picture's width alone.
    let radiance = |x: f64, y: f64| 0.5 * (1.0 - x / (1.0 + x * x + y * y).sqrt());
    let mut all = Vec::new();
    let (width, fov) = (16384u32, 1e-2f64);
    let pixel = 2.0 * (0.5 * fov).to_radians().tan() / 2.0;
    let shot = render_sky(width, 2, fov, 16);
    let worst = |aside: f64| {
        let mut worst = 0.0f64;
        for (i, rgb) in shot.picture.rgb.iter().enumerate() {
            let x = ((i as u32 % width) as f64 + aside + 0.5 - 0.5 * f64::from(width)) * pixel;
            let slope = 0.5 * pixel / (1.0 + x * x).powf(1.5);
            worst = worst.max((f64::from(rgb[0]) - radiance(x, 0.0)).abs() / slope);
        }
        worst
    };
    all.push(
        Cell::new(
            "16384 x 2",
            "Distance, in pixels, of a pixel's mean position from its middle, by the gradient of a sky that brightens along the image",
            // Half a pixel; a picture this wide changes by 1/4 over its half, 1e-5 a pixel at its ends.
            0.5 + 8.0 * U / (0.5 * pixel / (1.0 + (8192.0 * pixel).powi(2)).powf(1.5)),
            "half a pixel, because samples lie in their pixel, plus eight roundings of a radiance of 1, divided by its change from \
             pixel to pixel.",
        )
        .achieved(worst(0.0))
        .planted("a pixel aside", worst(1.0)),
    );
    for (fov, samples) in [(40.0, 4096), (179.0, 4096)] {
        // The left one of two is the same picture, half a pixel aside.
        let [one, aside] = [1, 2].map(|width| f64::from(render_sky(width, 1, fov, samples).picture.rgb[0][0]));
        let half = (0.5 * fov).to_radians().tan();
        let expected = integrated((1, 1), fov, |d| radiance(d.x, d.y))[0];
        let deviation = half.min(1.0) / 2.0;
        all.push(
            Cell::new(
                format!("1 x 1, {fov} degrees"),
                "Error of the one pixel's mean, in standard errors",
                chance_limit(1),
                "a normal variate exceeds it once in 1e6.",
            )
            .achieved((one - expected).abs() / (deviation / f64::from(samples).sqrt()))
            .planted("half a pixel aside", (aside - expected).abs() / (deviation / f64::from(samples).sqrt())),
        );
    }
    all
}
