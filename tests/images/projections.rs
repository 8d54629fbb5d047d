//! Cameras that are no flat film at distance 1: one expectation with and without light paths, closed forms, and pixels without a direction.
//! tests/kernels/camera.rs compares their rays with formulas of others.

use gpu_rt::options::{Filter, Scatter};

use crate::common::faults::{agree, changed, differ};
use crate::common::render::{Request, Shot, render, render_planted, scene};

/// A floor, a ball of glass and a lamp, seen by a camera of 16 x 16 pixels.
fn lit(projection: &str) -> String {
    format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 2.5, 2.5), look_at: (0, 0.6, 0), {projection}),
        background: Solid((0, 0, 0)), materials: {{\"floor\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)), \"glass\": Dielectric(ior: 1.5),
            \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7))}},
        objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"),
            Sphere(center: (-0.6, 0.9, 0), radius: 0.8, material: \"glass\"), Sphere(center: (1.2, 2.6, 0.4), radius: 0.7, material: \"lamp\")],
        render: (samples: 384, max_depth: 8))"
    )
}

const PARALLEL: &str = "projection: Orthographic(height: 5)";

/// The light of both kinds of path together is that of camera paths alone, with filters across the seam and the poles of a panorama, too. The
/// densities and the points of the film of all cameras: tests/kernels/camera.rs.
#[test]
fn light_paths_change_no_expectation_of_any_camera() {
    let off = || Request::default().mis().roulette();
    for (camera, filter) in [
        (PARALLEL, Filter::Gauss),
        ("projection: Equirectangular()", Filter::Mitchell),
        ("projection: Fisheye(model: Equidistant, fov: 200)", Filter::Box),
        ("projection: Fisheye(model: Equisolid, fov: 200)", Filter::Box),
        ("projection: Fisheye(model: Stereographic, fov: 200)", Filter::Box),
        ("projection: Fisheye(model: Orthographic, fov: 180), mirror: true", Filter::Box),
        (
            "projection: Calibrated(fx: 8, fy: 9, cx: 7, cy: 9, distortion: Brown(k1: -0.2, p1: 0.02)), aperture: 0.2",
            Filter::Box,
        ),
        ("projection: Calibrated(fx: 6, fy: 7, cx: 7, cy: 9, distortion: KannalaBrandt(k1: -0.03))", Filter::Box),
    ] {
        let room = scene(&lit(camera));
        let by = |request: Request| request.with(|options| options.filter = filter);
        let alone = render(&room, &by(off()).seed(1));
        let both = render(&room, &by(off().light_paths(8)).seed(2));
        assert!(both.film.totals.light_paths[0] > 0, "{camera}: no light path was traced");
        agree(camera, &alone, &both, 1e-4);
        // The planted error: light paths whose light becomes less with the distance from the camera.
        if camera == PARALLEL {
            let fault = ("camera/orthographic_view", "1.0 / area_of_pixel()", "1.0 / (area_of_pixel() * distance)");
            differ(camera, &alone, &render_planted(&room, &by(off().light_paths(8)).seed(2), &changed(&[fault])), 1e-4);
        }
    }
}

/// The share of the light in each pixel's place: its sum, and its middle in pixels from the left upper corner.
fn middle_of_light(shot: &Shot, width: usize) -> (f64, [f64; 2]) {
    let (mut sum, mut at) = (0.0, [0.0; 2]);
    for (i, rgb) in shot.picture.rgb.iter().enumerate() {
        let light = f64::from(rgb[1]);
        sum += light;
        at[0] += light * ((i % width) as f64 + 0.5);
        at[1] += light * ((i / width) as f64 + 0.5);
    }
    (sum, at.map(|x| x / sum))
}

/// A ball of radius 0.5 at (0.7, 0.4) beside the axis covers pi / 4 of scene units² whatever its distance is, each with (24 / 3)² pixels. Samples in
/// pixels of its edge alone are uncertain: some 60 pixels, each with a variance of 1 / 12 / 256. Six times that is 0.84 pixels of 50.
#[test]
fn an_orthographic_image_has_the_size_of_things() {
    for (distance, mirror) in [(2.0, false), (2000.0, false), (2.0, true)] {
        let room = scene(&format!(
            "Scene(image: (width: 32, height: 24), camera: (look_from: (0, 0, {distance}), look_at: (0, 0, 0),
                projection: Orthographic(height: 3), mirror: {mirror}), background: Solid((0, 0, 0)),
            materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
            objects: [Sphere(center: (0.7, 0.4, -1), radius: 0.5, material: \"lamp\"),
                Sphere(center: (0, 0, {}), radius: 0.5, material: \"lamp\")])",
            distance + 1.0
        ));
        let shot = render(&room, &Request::spp(256));
        let (sum, [x, y]) = middle_of_light(&shot, 32);
        let expected = std::f64::consts::PI * (0.5 * 8.0f64).powi(2);
        assert!((sum - expected).abs() < 0.84, "{distance}: {sum} pixels, expected {expected}");
        let at = 16.0 + if mirror { -5.6 } else { 5.6 };
        assert!((x - at).abs() < 0.05 && (y - (12.0 - 3.2)).abs() < 0.05, "{distance} {mirror}: ({x}, {y})");
    }
}

/// Pixels beyond the lens are black and not rejected, in smoke, too; the bytes are the same in kernels of one stage each.
#[test]
fn pixels_without_a_direction_are_black() {
    for (camera, black) in [
        ("projection: Fisheye(model: Orthographic, fov: 180)", 6.0),
        ("projection: Fisheye(model: Equidistant, fov: 360)", 6.0),
        // 1 - 3 r² / 4 is 0 at r² = 4/3, where r (1 - r² / 4) is 0.77: 4.6 pixels of the middle.
        ("projection: Calibrated(fx: 6, fy: 6, cx: 6, cy: 6, distortion: Brown(k1: -0.25))", 4.62),
    ] {
        let room = scene(&format!(
            "Scene(image: (width: 12, height: 12), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), {camera}),
            background: Solid((1, 1, 1)), materials: {{\"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
            objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"m\"),
                Medium(boundary: Sphere(center: (0, 0, 3), radius: 50), density: 0.01, albedo: Rgb(1, 1, 1))])"
        ));
        let request = Request::spp(8).mis();
        let shot = render(&room, &request);
        assert_eq!(shot.film.totals.rejected.total(), 0, "{camera}");
        for (i, rgb) in shot.picture.rgb.iter().enumerate() {
            // From the middle of the image to the nearest and to the farthest point of the pixel.
            let from_middle = |x: usize| (x as f64 + 0.5 - 6.0).abs();
            let (x, y) = (from_middle(i % 12), from_middle(i / 12));
            let (near, far) = ((x - 0.5).hypot(y - 0.5), (x + 0.5).hypot(y + 0.5));
            assert!(near < black || *rgb == [0.0; 3], "{camera}: pixel {i} is {rgb:?}");
            assert!(far > black || rgb.iter().all(|value| *value > 0.3), "{camera}: pixel {i} is {rgb:?}");
        }
        for scatter in [Scatter::Linked, Scatter::Queues] {
            let other = render(&room, &request.clone().with(|options| options.scatter = Some(scatter)));
            assert_eq!(other.picture.rgb, shot.picture.rgb, "{camera} {scatter:?}");
        }
    }
}

/// A camera that moves past a lamp sees it, mirrored, on the other side.
#[test]
fn a_mirrored_camera_that_moves_is_mirrored() {
    let middle = |mirror: bool, projection: &str| {
        let room = scene(&format!(
            "Scene(image: (width: 32, height: 24), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), {projection}, mirror: {mirror}, shutter: (0, 1),
                moving: [(0, (look_from: (0, 0, 4), look_at: (0, 0, 0))), (1, (look_from: (0.5, 0, 4), look_at: (0.5, 0, 0)))]),
            background: Solid((0, 0, 0)), materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))}},
            objects: [Sphere(center: (1, 0.5, 0), radius: 0.4, material: \"lamp\")])"
        ));
        middle_of_light(&render(&room, &Request::spp(256)), 32).1
    };
    for projection in
        ["vertical_fov: 50", "projection: Orthographic(height: 4)", "projection: Fisheye(model: Equisolid, fov: 60)"]
    {
        let ([x, y], [mirrored, same]) = (middle(false, projection), middle(true, projection));
        assert!(x > 19.0 && (mirrored - (32.0 - x)).abs() < 0.1, "{projection}: {x} {mirrored}");
        assert!(y < 10.0 && (y - same).abs() < 0.1, "{projection}: {y} {same}");
    }
}
