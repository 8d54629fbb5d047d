//! Caustics with closed forms, which only light paths find: of a ball lens, of a spherical mirror, of lamps that shrink to a point. And a furnace.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::common::kernel::Overlay;
use crate::common::oracles::fresnel;
use crate::common::render::{Mean, Request, render, render_planted, scene};

const ALBEDO: f64 = 1e-4;
const INDEX: f64 = 1.5;
const REFLECTANCE: f64 = 0.8;
const INTENSITY: f64 = 100.0;

/// A ball of radius 1 around the origin, a floor of hardly any albedo; a light on the axis; the eye beside the axis, towards its foot.
struct Bench {
    material: &'static str,
    light: f64,
    floor: f64,
    eye: DVec3,
    /// Half the height of the image, one unit from the eye.
    half_field: f64,
}

/// The floor is nearer than the focus.
const LENS: Bench =
    Bench { material: "glass", light: 3.0, floor: -1.8, eye: DVec3::new(1.5, -1.0, 0.0), half_field: 0.08 };
/// All within the mirror, which makes parallel what the light sends up.
const MIRROR: Bench =
    Bench { material: "mirror", light: 0.5, floor: -0.4, eye: DVec3::new(0.5, 0.1, 0.0), half_field: 0.3 };

fn traced() -> Request {
    Request::default().mis().roulette().light_paths(8)
}

impl Bench {
    fn lit_by(&self, light: &str, emitted: f64) -> String {
        let Bench { material, floor, eye, .. } = self;
        format!(
            "Scene(image: (width: 16, height: 16), camera: (look_from: ({}, {}, {}), look_at: (0, {floor}, 0), vertical_fov: {}),
            background: Solid((0, 0, 0)), materials: {{\"floor\": Lambertian(albedo: Rgb({ALBEDO}, {ALBEDO}, {ALBEDO})),
                \"glass\": Dielectric(ior: {INDEX}), \"mirror\": Metal(albedo: Rgb({REFLECTANCE}, {REFLECTANCE}, {REFLECTANCE}), fuzz: 0),
                \"lamp\": DiffuseLight(emit: Rgb({emitted}, {emitted}, {emitted}))}},
            objects: [Quad(corner: (-9, {floor}, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"floor\"),
                Sphere(center: (0, 0, 0), radius: 1, material: \"{material}\"), {light}], render: (samples: 4096, max_depth: 20))",
            eye.x,
            eye.y,
            eye.z,
            2.0 * self.half_field.atan().to_degrees(),
        )
    }

    /// With a light without size.
    fn with_point(&self) -> String {
        let light =
            format!("PointLight(at: (0, {}, 0), intensity: ({INTENSITY}, {INTENSITY}, {INTENSITY}))", self.light);
        self.lit_by(&light, 0.0)
    }

    /// With a ball of the same power.
    fn with_bulb(&self, radius: f64) -> String {
        let light = format!("Sphere(center: (0, {}, 0), radius: {radius}, material: \"lamp\")", self.light);
        self.lit_by(&light, INTENSITY / (PI * radius * radius))
    }

    /// The share of the image, over its area, that a point of the floor has; 0 outside the image.
    fn image_share(&self, point: DVec3) -> f64 {
        let forward = (DVec3::new(0.0, self.floor, 0.0) - self.eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let view = point - self.eye;
        let depth = view.dot(forward);
        let half = depth * self.half_field;
        if depth <= 0.0 || view.dot(right).abs() > half || view.dot(right.cross(forward)).abs() > half {
            return 0.0;
        }
        let distance = view.length();
        let (at_floor, at_eye) = ((view.y / distance).abs(), depth / distance);
        at_floor / (distance * distance * at_eye.powi(3)) / (2.0 * self.half_field).powi(2)
    }

    /// What a ray sends to the image: its share of light by where it meets the floor.
    fn landed(&self, origin: DVec3, direction: DVec3, share: f64) -> f64 {
        let t = (self.floor - origin.y) / direction.y;
        if t > 0.0 { share * self.image_share(origin + t * direction) } else { 0.0 }
    }

    /// The mean radiance of the image under the point light: the floor's radiance is its irradiance times albedo over pi. A sum over the
    /// directions that the light sends, each with what the ball makes of it.
    fn expected(&self) -> f64 {
        const ANGLES: i32 = 20_000;
        const TURNS: i32 = 200;
        let origin = DVec3::new(0.0, self.light, 0.0);
        let mut sum = 0.0;
        for angle in (0..ANGLES).map(|i| (f64::from(i) + 0.5) * PI / f64::from(ANGLES)) {
            let solid_angle = angle.sin() * PI / f64::from(ANGLES) * TAU / f64::from(TURNS);
            for turn in (0..TURNS).map(|i| (f64::from(i) + 0.5) * TAU / f64::from(TURNS)) {
                let outwards = DVec3::new(turn.cos(), 0.0, turn.sin());
                sum += solid_angle * self.sent(origin, angle.cos() * DVec3::Y + angle.sin() * outwards);
            }
        }
        INTENSITY * ALBEDO / PI * sum
    }

    /// What the light's ray sends to the image, by the ball.
    fn sent(&self, origin: DVec3, direction: DVec3) -> f64 {
        if self.material == "mirror" {
            return self.sent_within(origin, direction, 1.0);
        }
        let closest = -origin.dot(direction);
        let discriminant = 1.0 - origin.length_squared() + closest * closest;
        if closest < 0.0 || discriminant < 0.0 {
            return self.landed(origin, direction, 1.0);
        }
        let point = origin + (closest - discriminant.sqrt()) * direction;
        let normal = point.normalize();
        let reflected = direction - 2.0 * direction.dot(normal) * normal;
        let cosine = -direction.dot(normal);
        let (share, cos_inside) = fresnel(cosine, INDEX);
        let mut sum = self.landed(point, reflected, share);
        let mut inside = direction / INDEX + (cosine / INDEX - cos_inside) * normal;
        let (mut point, mut left) = (point, 1.0 - share);
        for _ in 0..8 {
            point -= 2.0 * point.dot(inside) * inside;
            let outside = INDEX * inside + (cosine - INDEX * cos_inside) * point;
            sum += self.landed(point, outside, left * (1.0 - share));
            inside -= 2.0 * inside.dot(point) * point;
            left *= share;
        }
        sum
    }

    /// What a ray within the mirror sends to the image.
    fn sent_within(&self, mut point: DVec3, mut direction: DVec3, mut share: f64) -> f64 {
        for _ in 0..40 {
            let along = point.dot(direction);
            let to_mirror = (along * along + 1.0 - point.length_squared()).sqrt() - along;
            let to_floor = (self.floor - point.y) / direction.y;
            if to_floor > 0.0 && to_floor < to_mirror {
                return self.landed(point, direction, share);
            }
            point += to_mirror * direction;
            direction -= 2.0 * direction.dot(point) * point;
            share *= REFLECTANCE;
        }
        0.0
    }
}

/// Around the axial point of a ball lens, and of a spherical mirror. 3 % less light is found.
#[test]
fn a_ball_lens_and_a_spherical_mirror_focus_a_point_light() {
    for bench in [LENS, MIRROR] {
        let expected = [bench.expected(); 3];
        let room = scene(&bench.with_point());
        let found = render(&room, &traced()).mean_of_all();
        found.is_near(expected, 0.015).unwrap_or_else(|error| panic!("{}: {error}", bench.material));
        let planted = Overlay::new(&[])
            .rewritten("light_path/lens_connection", |own| own.replace("* pixels)", "* pixels * 1.03)"));
        let planted = render_planted(&room, &traced(), &planted).mean_of_all();
        assert!(planted.is_near(expected, 0.015).is_err(), "{}: 3 % less light is not found", bench.material);
    }
}

/// Lamps of one power and the radii R, R/2, R/4 approach a light without size by the square of the radius: what is left of the last two by
/// Richardson's rule is of its fourth power.
#[test]
fn lamps_that_shrink_approach_a_light_without_size() {
    let point = LENS.expected();
    let [large, middle, small] =
        [0.2, 0.1, 0.05].map(|radius| render(&scene(&LENS.with_bulb(radius)), &traced()).mean_of_all());
    let off = |mean: &Mean| 1.0 - mean.value[0] / point;
    assert!(off(&large) > 0.1 && off(&large) > 2.0 * off(&middle), "{large:?}, {middle:?}, {point}");
    let limit = Mean {
        value: [0, 1, 2].map(|c| (4.0 * small.value[c] - middle.value[c]) / 3.0),
        variance: [0, 1, 2].map(|c| (16.0 * small.variance[c] + middle.variance[c]) / 9.0),
        degrees: small.degrees,
    };
    limit.is_near([point; 3], 0.04).unwrap_or_else(|error| panic!("{error}"));
}

/// Within walls that emit 1, all radiance is 1: glass, a mirror and a white ball cannot be seen. A squared ratio in one of the weights is found.
#[test]
fn nothing_can_be_seen_in_a_furnace() {
    let room = scene(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 1.9), look_at: (0, 0, 0), vertical_fov: 70),
        background: Solid((0, 0, 0)), materials: {
            \"wall\": DiffuseLight(emit: Rgb(1, 1, 1)), \"white\": Lambertian(albedo: Rgb(1, 1, 1)),
            \"glass\": Dielectric(ior: 1.5), \"mirror\": Metal(albedo: Rgb(1, 1, 1), fuzz: 0)},
        objects: [Quad(corner: (-2, -2, -2), u: (4, 0, 0), v: (0, 4, 0), material: \"wall\"), Quad(corner: (-2, -2, 2), u: (4, 0, 0), v: (0, 4, 0), material: \"wall\"),
            Quad(corner: (-2, -2, -2), u: (0, 0, 4), v: (0, 4, 0), material: \"wall\"), Quad(corner: (2, -2, -2), u: (0, 0, 4), v: (0, 4, 0), material: \"wall\"),
            Quad(corner: (-2, -2, -2), u: (0, 0, 4), v: (4, 0, 0), material: \"wall\"), Quad(corner: (-2, 2, -2), u: (0, 0, 4), v: (4, 0, 0), material: \"wall\"),
            Sphere(center: (-0.6, 0.2, 0.4), radius: 0.6, material: \"glass\"),
            Box(min: (0.2, -0.6, 0), max: (0.9, 0.3, 0.6), material: \"glass\"), Sphere(center: (0.2, 0.9, -0.2), radius: 0.5, material: \"mirror\"),
            Sphere(center: (-0.4, -0.9, 0), radius: 0.5, material: \"white\"), Quad(corner: (-1, -1, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"white\")],
        render: (samples: 1024, max_depth: 60))",
    );
    let found = render(&room, &traced()).mean_of_all();
    found.is_near([1.0; 3], 5e-3).unwrap_or_else(|error| panic!("{error}"));
    let squared = Overlay::new(&[]).rewritten("light_path/density_ratio", |own| {
        own.replace("exp2((*path).log_ratio + log2(emission))", "exp2(2.0 * ((*path).log_ratio + log2(emission)))")
    });
    let planted = render_planted(&room, &traced(), &squared).mean_of_all();
    assert!(planted.is_near([1.0; 3], 5e-3).is_err(), "a squared ratio in one of the weights is not found");
}
