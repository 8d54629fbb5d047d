//! The channels of `--aov` that are of sample 0: each against a closed form at the point where that sample is, and motions against the projections of
//! the points before and after.

use glam::{DMat3, DVec2, DVec3};
use gpu_rt::aov::{Aovs, ChannelNames};
use gpu_rt::film::Film;
use gpu_rt::options::{Integrator, Scatter};
use gpu_rt::scene::{AnimationFrame, Assets, GltfOptions, Scene};

use crate::common::gltf::{glb, moving};
use crate::common::render::{Request, render, scene, scene_with};

const ALL: &str = "motion,depth0,distance0,position0,normal0,uv0,face0,offset0,object";
const FPS: f64 = 24.0;

/// What a film has of sample 0 of a pixel.
#[derive(Clone, Copy, Debug)]
struct Truth {
    /// Where the sample is, in pixels from the image's left upper corner.
    at: DVec2,
    motion: DVec2,
    depth: f64,
    distance: f64,
    point: DVec3,
    normal: DVec3,
    uv: DVec2,
    face: u32,
    object: u32,
}

fn truths(scene: &Scene, scatter: Scatter) -> (Film, Vec<Truth>) {
    let aovs = Aovs::parse(ALL).expect("they are names");
    let request = Request::spp(8).scatter(scatter).with(|options| {
        options.aov.set(aovs);
        options.integrator = Integrator::Mis;
    });
    let film = render(scene, &request).film;
    let channels = film.aovs().channels();
    let value = |index: usize, name: &str| {
        let channel = channels.iter().find(|channel| channel.name == name).expect("the film has it");
        f64::from(film.channel(index, channel))
    };
    let truth = |index: usize| {
        let two = |x: &str, y: &str| DVec2::new(value(index, x), value(index, y));
        let three =
            |name: &str| two(&format!("{name}.X"), &format!("{name}.Y")).extend(value(index, &format!("{name}.Z")));
        let corner = DVec2::new((index as u32 % film.width()).into(), (index as u32 / film.width()).into());
        let offset = two("offset0.X", "offset0.Y");
        assert!(offset.min_element() >= 0.0 && offset.max_element() < 1.0, "{offset}");
        Truth {
            at: corner + offset,
            motion: two("motion.X", "motion.Y"),
            depth: value(index, "depth0.Z"),
            distance: value(index, "distance0.Z"),
            point: three("position0"),
            normal: three("normal0"),
            uv: two("uv0.U", "uv0.V"),
            face: value(index, "face0.Y") as u32,
            object: value(index, "object.Y") as u32,
        }
    };
    let truths = (0..(film.width() * film.height()) as usize).map(truth).collect();
    (film, truths)
}

const SIZE: DVec2 = DVec2::new(48.0, 32.0);

/// A camera in the words of a scene and of this test.
#[derive(Clone, Copy)]
struct View {
    from: DVec3,
    at: DVec3,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Perspective,
    Orthographic,
    Panorama,
    Fisheye,
}

impl View {
    fn axes(&self) -> DMat3 {
        let forward = (self.at - self.from).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        DMat3::from_cols(right, forward.cross(right), forward)
    }

    /// Where on the image a point is, and its distances along the axis and from the eye.
    fn see(&self, p: DVec3) -> (DVec2, f64, f64) {
        let DVec3 { x, y, z } = self.axes().transpose() * (p - self.from);
        let (middle, distance) = (0.5 * SIZE, (p - self.from).length());
        let at = match self.kind {
            // 60 degrees from the lower to the upper edge.
            Kind::Perspective => DVec2::new(x, y) / z * (0.5 * SIZE.y / 30f64.to_radians().tan()),
            // A height of 4.
            Kind::Orthographic => DVec2::new(x, y) * (SIZE.y / 4.0),
            // Turns of 360 degrees along the width, and of 180 along the height.
            Kind::Panorama => DVec2::new(
                x.atan2(z).to_degrees() / 360.0 * SIZE.x,
                (y / distance).asin().to_degrees() / 180.0 * SIZE.y,
            ),
            Kind::Fisheye => DVec2::new(x, y).normalize() * x.hypot(y).atan2(z).to_degrees() / 180.0 * SIZE.y,
        };
        (middle + at, z, if self.kind == Kind::Orthographic { z } else { distance })
    }

    fn words(&self, more: &str) -> String {
        let kind = match self.kind {
            Kind::Perspective => "Perspective(vertical_fov: 60)",
            Kind::Orthographic => "Orthographic(height: 4)",
            Kind::Panorama => "Equirectangular()",
            Kind::Fisheye => "Fisheye(model: Equidistant, fov: 180)",
        };
        let v = |v: DVec3| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
        format!("camera: (look_from: {}, look_at: {}, projection: {kind}{more})", v(self.from), v(self.at))
    }
}

const KINDS: [Kind; 4] = [Kind::Perspective, Kind::Orthographic, Kind::Panorama, Kind::Fisheye];

/// The objects: a ball that shifts, one that rests, a box that turns and grows, and a face of a mesh.
fn text(view: View, more: &str) -> String {
    format!(
        "Scene(image: (width: 48, height: 32), {}, background: Solid((1, 1, 1)),
            materials: {{\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
            objects: [
                Moving(keys: [(0, [Translate((-1, 0, 0))]), (2, [Translate((1, 1, 1))])],
                    object: Sphere(center: (0, 0, 0), radius: 0.7, material: \"grey\")),
                Transformed(by: [RotateY(30)], object: Sphere(center: (0, -1002, 0), radius: 1000, material: \"grey\")),
                Moving(keys: [(0, [RotateZ(0), Scale(1), Translate((1, 0, 0))]), (2, [RotateZ(90), Scale(2), Translate((1, 0, 0))])],
                    object: Box(min: (-0.5, -0.5, -0.5), max: (0.5, 0.5, 0.5), material: \"grey\")),
                Mesh(path: \"faces.obj\", material: \"grey\"),
            ])",
        view.words(more)
    )
}

/// Two faces beside each other, far to the left.
const FACES: &str =
    "v -4 -1 -1\nv -2 -1 -1\nv -2 1 -1\nv -4 1 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

const VIEW: View = View { from: DVec3::new(0.25, 0.5, 4.0), at: DVec3::new(0.0, 0.25, 0.0), kind: Kind::Perspective };

fn at_frame(number: f64, view: View, more: &str) -> Scene {
    scene_with(&[("faces.obj", FACES.to_owned())], &text(view, more))
        .in_frame(Some(AnimationFrame { number, fps: FPS }))
}

/// Where the moving objects take a point of their own space at a time in seconds, and their inverse.
fn moved(object: u32, p: DVec3, seconds: f64) -> DVec3 {
    let share = 0.5 * seconds;
    match object {
        1 => p + DVec3::new(2.0 * share - 1.0, share, share),
        3 => (1.0 + share) * (DMat3::from_rotation_z(90f64.to_radians() * share) * p) + DVec3::X,
        _ => p,
    }
}

fn unmoved(object: u32, p: DVec3, seconds: f64) -> DVec3 {
    let share = 0.5 * seconds;
    match object {
        1 => p - DVec3::new(2.0 * share - 1.0, share, share),
        3 => DMat3::from_rotation_z(-90f64.to_radians() * share) * (p - DVec3::X) / (1.0 + share),
        _ => p,
    }
}

/// A frame of 12 is 0.5 s. Kernels round a ray's origin, direction and distance by a few 2^-24; the scene is some 8 units deep, and a unit has at
/// most 50 pixels: 1e-4 pixel.
#[test]
fn sample_0_sees_what_its_ray_hits() {
    for kind in KINDS {
        let view = View { kind, ..VIEW };
        let (film, truths) = truths(&at_frame(12.0, view, ""), Scatter::Fused);
        let mut objects = [0; 5];
        for truth in truths.iter().filter(|truth| truth.object > 0) {
            objects[truth.object as usize] += 1;
            let (at, depth, distance) = view.see(truth.point);
            // Behind the sphere of a radius of 1000, f32 has fewer digits for what is far.
            let error = 1e-6 * truth.distance;
            assert!((truth.at - at).length() < 1e-3, "{kind:?}: {truth:?} {at}");
            assert!(
                (truth.depth - depth).abs() < 4.0 * error && (truth.distance - distance).abs() < 4.0 * error,
                "{truth:?}"
            );
            let own = unmoved(truth.object, truth.point, 0.5);
            let (normal, uv, face) = match truth.object {
                1 => (own / 0.7, None, 0),
                2 => ((own - DVec3::new(0.0, -1002.0, 0.0)) / 1000.0, None, 0),
                3 => {
                    let axis = own.abs().max_position();
                    let own_normal =
                        DVec3::from_array(std::array::from_fn(|i| if i == axis { own[i].signum() } else { 0.0 }));
                    (DMat3::from_rotation_z(22.5f64.to_radians()) * own_normal, None, 0)
                }
                _ => {
                    let uv = DVec2::new(0.5 * (own.x + 4.0), 0.5 * (own.y + 1.0));
                    (DVec3::Z, Some(uv), if uv.x > uv.y { 1 } else { 2 })
                }
            };
            assert!((truth.normal - normal).length() < 1e-5 * (1.0 + truth.distance), "{truth:?} {normal}");
            assert!(uv.is_none_or(|uv| (uv - truth.uv).length() < 1e-5), "{truth:?}");
            assert_eq!(truth.face, face);
        }
        assert!(objects[1..].iter().all(|count| *count > 3), "{kind:?}: {objects:?}");
        // Where sample 0 hits nothing, there is nothing. The control: in the middle of its pixel it is not.
        let missed = truths.iter().filter(|truth| truth.object == 0);
        assert!(missed.clone().all(|truth| truth.depth > 1e38 && truth.distance > 1e38 && truth.point == DVec3::ZERO));
        let is_in_the_middle = |truth: &Truth| (truth.at.floor() + 0.5 - view.see(truth.point).0).length() < 1e-3;
        assert!(!truths.iter().any(is_in_the_middle) && film.width() == 48);
    }
}

/// Spheres have the coordinates of docs/scene.md in their own space, which is turned with the object, also where nothing has a texture.
#[test]
fn texture_coordinates_are_those_of_the_object() {
    let text = text(VIEW, "")
        .replace("radius: 1000", "radius: 1001")
        .replace("Translate((-1, 0, 0))]), (2, [Translate((1, 1, 1))", "RotateX(40)]), (2, [RotateX(40)");
    let scene = scene_with(&[("faces.obj", FACES.to_owned())], &text);
    let (_, truths) = truths(&scene, Scatter::Fused);
    let mut seen = 0;
    for truth in truths.iter().filter(|truth| truth.object == 1 && truth.distance < 5.0) {
        let own = DMat3::from_rotation_x(-40f64.to_radians()) * truth.point / 0.7;
        let u = ((-own.z).atan2(own.x) + std::f64::consts::PI) / std::f64::consts::TAU;
        let uv = DVec2::new(u, (-own.y).clamp(-1.0, 1.0).acos() / std::f64::consts::PI);
        // Beside the poles a longitude is not sharp in f32.
        assert!((uv - truth.uv).length() * own.x.hypot(own.z) < 1e-5, "{truth:?} {uv}");
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

/// How far a motion is from the difference of two projections, at most over an image, in pixels; `from` and `to` are the cameras of both frames.
fn worst(truths: &[Truth], from: View, to: View, follow: impl Fn(&Truth) -> DVec3) -> (f64, usize) {
    let errors = truths.iter().filter(|truth| truth.object > 0).filter_map(|truth| {
        let (then, depth, _) = to.see(follow(truth));
        let mut way = then - from.see(truth.point).0;
        if from.kind == Kind::Panorama {
            way.x -= (way.x / SIZE.x).round() * SIZE.x;
        }
        let is_seen = depth > 0.0 || [Kind::Panorama, Kind::Fisheye].contains(&from.kind);
        is_seen.then(|| (truth.motion - way).length())
    });
    errors.fold((0.0, 0), |(most, count), error: f64| (most.max(error), count + 1))
}

/// Points move by the motion of their objects and of the camera, in whichever stages kernels are.
#[test]
fn motion_is_the_difference_of_projections() {
    let later = View { from: VIEW.from + DVec3::new(0.5, 0.25, -0.5), at: VIEW.at + DVec3::X, ..VIEW };
    for kind in KINDS {
        let view = |seconds: f64| View {
            from: VIEW.from.lerp(later.from, 0.5 * seconds),
            at: VIEW.at.lerp(later.at, 0.5 * seconds),
            kind,
        };
        let keys = |view: View| format!("(look_from: {}, look_at: {})", v(view.from), v(view.at));
        let more = format!(", moving: [(0, {}), (2, {})]", keys(VIEW), keys(later));
        for (more, scatter, moves) in [("", Scatter::Fused, false), (more.as_str(), Scatter::Linked, true)] {
            let scene = at_frame(12.0, View { kind, ..VIEW }, more);
            let (_, truths) = truths(&scene, scatter);
            let (now, next) = (0.5, 0.5 + 1.0 / FPS);
            let at = |seconds: f64| if moves { view(seconds) } else { View { kind, ..VIEW } };
            let follow = |seconds: f64| {
                move |truth: &Truth| moved(truth.object, unmoved(truth.object, truth.point, now), seconds)
            };
            let (error, count) = worst(&truths, at(now), at(next), follow(next));
            assert!(error < 1e-3 && count > 300, "{kind:?} {moves}: {error} of {count}");
            // The controls: what is off by a thousandth of a second, and what only rests.
            assert!(worst(&truths, at(now), at(next), follow(next + 1e-3)).0 > 1e-3);
            assert!(truths.iter().any(|truth| truth.motion.length() > 0.1 && truth.motion.length() < 1e3));
            // The sky moves with the camera alone; parallel rays see one point of it.
            let sky: Vec<_> = truths.iter().filter(|truth| truth.object == 0 && truth.motion.x < 1e38).collect();
            let turns = kind != Kind::Orthographic && moves;
            assert!(sky.iter().all(|truth| (truth.motion.length() > 1e-3) == turns), "{kind:?} {moves}");
        }
    }
}

fn v(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

/// While the shutter is open each sample has a time of its own, from which its motion counts: what shifts evenly has one motion for each point.
#[test]
fn motion_counts_from_the_time_of_the_sample() {
    let (_, truths) = truths(&at_frame(12.0, VIEW, ", shutter: (0, 0.25)"), Scatter::Queues);
    let ball: Vec<Truth> = truths.into_iter().filter(|truth| truth.object == 1).collect();
    let shift = DVec3::new(1.0, 0.5, 0.5) / FPS;
    let (error, count) = worst(&ball, VIEW, VIEW, |truth| truth.point + shift);
    assert!(error < 1e-3 && count > 20, "{error} of {count}");
    assert!(worst(&ball, VIEW, VIEW, |truth| truth.point + 1.02 * shift).0 > 1e-3);
    // The box turns, so that its motion is another one at each time. Its samples lie on it at the times that they have.
    let (_, at_rest) = self::truths(&at_frame(12.0, VIEW, ""), Scatter::Fused);
    assert!(at_rest.iter().zip(&ball).any(|(a, b)| a.motion != b.motion));
}

/// Skins and morph targets move the faces that a sample hits.
#[test]
fn faces_move_with_skins_and_morphs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("moving.glb");
    let (json, binary) = moving();
    std::fs::write(&path, glb(&json, &binary)).expect("the file is written");
    let mut assets = Assets::default();
    let mut load = |number: f64| {
        let options = GltfOptions { frame: Some(AnimationFrame { number, fps: FPS }), ..GltfOptions::default() };
        Scene::load_as(&path, &options, &mut |_, _, _| {}, &mut assets).expect("it is a scene")
    };
    let mut scene = load(6.0);
    scene.neighbours = Some(Box::new([load(5.0), load(7.0)]));
    (scene.image.width, scene.image.height) = (48, 32);
    let (_, truths) = truths(&scene, Scatter::Fused);
    // The camera rises by 1 in a second and looks along -z from a height of 1; 45 degrees from the lower to the upper edge.
    let see = |p: DVec3, seconds: f64| {
        let from = DVec3::new(0.0, 1.0 + seconds, 8.0);
        DVec2::new(p.x, from.y - p.y) / (from.z - p.z) * (16.0 / 22.5f64.to_radians().tan())
    };
    let turned = |seconds: f64| DMat3::from_rotation_z(90f64.to_radians() * seconds);
    // A vertex of the strip: its lower end rests, its upper end turns about (0, 1, 0), and its middle is between both.
    let vertex = |p: DVec3, seconds: f64| {
        let (weight, upper) = (0.5 * p.y, turned(seconds) * (p - DVec3::Y) + DVec3::Y);
        p.lerp(upper, weight)
    };
    let strip = |truth: &Truth, seconds: [f64; 2]| {
        let faces = [[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]];
        let corner =
            |number: usize| DVec3::new(if number.is_multiple_of(2) { -0.5 } else { 0.5 }, (number / 2) as f64, 0.0);
        let corners = |seconds: f64| faces[truth.face as usize - 1].map(|number| vertex(corner(number), seconds));
        let ([a, b, c], [a_then, b_then, c_then]) = (corners(seconds[0]), corners(seconds[1]));
        // By areas: all of it lies in the plane z = 0.
        let cross = |u: DVec3, v: DVec3| u.x * v.y - u.y * v.x;
        let (s, t) =
            (cross(truth.point - a, c - a) / cross(b - a, c - a), cross(b - a, truth.point - a) / cross(b - a, c - a));
        a_then + s * (b_then - a_then) + t * (c_then - a_then)
    };
    let (now, next) = (6.0 / FPS, 7.0 / FPS);
    let grown = |seconds: f64| (1.0 + seconds) * turned(seconds);
    let mut counts = [0; 4];
    for truth in truths.iter().filter(|truth| truth.object > 0) {
        let then = |next: f64| match truth.object {
            1 => strip(truth, [now, next]),
            2 => grown(next) * (grown(now).inverse() * (truth.point - DVec3::X * 2.0 * now)) + DVec3::X * 2.0 * next,
            _ => truth.point + DVec3::Z * (next - now),
        };
        let error = |next: f64, camera: f64| (see(then(next), camera) - see(truth.point, now) - truth.motion).length();
        counts[truth.object as usize] += 1;
        assert!(error(next, next) < 1e-3, "{truth:?}: {}", error(next, next));
        // The control: without the motion of the object.
        assert!(error(now, next) > 1e-3 || truth.object == 1, "{truth:?}");
    }
    assert!(counts[1..].iter().all(|count| *count > 5), "{counts:?}");
}

/// Blender's passes count rows upwards. Their first two numbers are where the surface was in the frame before minus where it is; the last two are where
/// it is minus where it will be (Cycles, primitive_motion_vector).
#[test]
fn blender_has_its_signs() {
    let scene = at_frame(12.0, VIEW, "");
    let (_, truths) = truths(&scene, Scatter::Fused);
    let aovs = Aovs::parse("motion").expect("it is a name");
    let request = Request::spp(8).with(|options| {
        options.aov.set(aovs);
        options.aov.names = ChannelNames::Blender;
    });
    let film = render(&scene, &request).film;
    let channels = film.aovs().channels();
    let value = |index: usize, name: &str| {
        let channel = channels.iter().find(|channel| channel.name == name).expect("the film has it");
        f64::from(film.channel(index, channel))
    };
    let now = 0.5;
    for (index, truth) in truths.iter().enumerate().filter(|(_, truth)| truth.object > 0) {
        let own = unmoved(truth.object, truth.point, now);
        let at = |seconds: f64| VIEW.see(moved(truth.object, own, seconds)).0 * DVec2::new(1.0, -1.0);
        let (before, after) = (at(now - 1.0 / FPS) - at(now), at(now) - at(now + 1.0 / FPS));
        let vector = ["X", "Y", "Z", "W"].map(|name| value(index, &format!("Vector.{name}")));
        let expected = [before.x, before.y, after.x, after.y];
        assert!(
            vector.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-3),
            "{vector:?} {expected:?}"
        );
    }
}

/// What the next camera does not see has no motion.
#[test]
fn what_leaves_the_view_has_no_motion() {
    let text = "Scene(image: (width: 48, height: 32),
        camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vertical_fov: 60, moving: [(0, (look_from: (0, 0, 1), look_at: (0, 0, 0))),
            (1, (look_from: (0, 0, -47), look_at: (0, 0, -48)))]),
        background: Solid((1, 1, 1)), materials: {\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))},
        objects: [Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0), material: \"grey\")])";
    // In a frame the camera goes 2 units ahead, through the wall.
    let (_, truths) = truths(&scene(text).in_frame(Some(AnimationFrame { number: 0.0, fps: FPS })), Scatter::Fused);
    assert!(truths.iter().all(|truth| truth.object == 1 && truth.motion == DVec2::splat(f64::from(f32::MAX))));
}
