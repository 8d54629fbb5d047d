//! A scene with everything in it, at any scale, position and brightness, and the comparison of two of its renders.

use glam::DVec3;
use gpu_rt::film::Totals;
use gpu_rt::scene::Scene;
use image::{Rgb, RgbImage};
use tempfile::TempDir;

use super::instances::ball_file;
use super::render::{Shot, scene_in};

/// A scene's numbers that the tests vary.
#[derive(Clone, Copy)]
pub struct World {
    /// Of all lengths, the camera's included.
    pub scale: f64,
    /// Of everything, the camera included.
    pub shift: [f64; 3],
    /// Of all radiance.
    pub brightness: f64,
    /// Of the camera alone, along x.
    pub camera_shift: f64,
    /// Of the lamp alone.
    pub lamp: f64,
}

impl Default for World {
    fn default() -> World {
        World { scale: 1.0, shift: [0.0; 3], brightness: 1.0, camera_shift: 0.0, lamp: 1.0 }
    }
}

/// The image file of the scene lives as long as this.
pub struct Everything(TempDir);

impl Everything {
    pub fn new() -> Everything {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let image = RgbImage::from_fn(8, 8, |x, y| Rgb([(x * 30) as u8, (y * 30) as u8, 200]));
        image.save(folder.path().join("image.png")).expect("the image is written");
        for (name, text) in [("octahedron.obj", octahedron()), ("flat.obj", ball_file(0, DVec3::ONE))] {
            std::fs::write(folder.path().join(name), text).expect("the mesh is written");
        }
        Everything(folder)
    }

    /// Every primitive, among them a sphere that is huge against its distance, every material, every texture, a lens, and a sky;
    /// panes, flat and round; objects inside others; two of them coincident; media in every kind of boundary, overlapping, textured, and one that fills a
    /// glass sphere.
    pub fn scene(&self, world: World) -> Scene {
        scene_in(self.0.path(), &self.text(world))
    }

    /// The folder of the files that its scenes name.
    pub fn folder(&self) -> &std::path::Path {
        self.0.path()
    }

    /// Its file, beside the files that it names.
    pub fn file(&self, world: World) -> std::path::PathBuf {
        let path = self.0.path().join("everything.ron");
        std::fs::write(&path, self.text(world)).expect("the scene is written");
        path
    }

    fn text(&self, world: World) -> String {
        let World { scale, shift: [x, y, z], brightness, camera_shift, lamp } = world;
        let length = |l: f64| format!("{:e}", l * scale);
        let point = |p: [f64; 3]| {
            let [a, b, c] = [0, 1, 2].map(|i| p[i] * scale + world.shift[i]);
            format!("({a:e}, {b:e}, {c:e})")
        };
        let colour = |c: [f64; 3]| c.map(|v| format!("{:e}", v * brightness)).join(", ");
        format!(
            "Scene(
    image: (width: 12, height: 9),
    camera: (look_from: {from}, look_at: {at}, up: (0.1, 1, 0), vertical_fov: 35, aperture: {aperture}, focus_distance: {focus}),
    background: Gradient(bottom: ({bottom}), top: ({top})),
    materials: {{
        \"checker\": Lambertian(albedo: Checker(scale: 0.4, even: (0.8, 0.7, 0.2), odd: (0.1, 0.2, 0.6))),
        \"image\": Lambertian(albedo: Image(path: \"image.png\")),
        \"noise\": Metal(albedo: Noise(scale: 3), fuzz: 0.3),
        \"marble\": Lambertian(albedo: Marble(scale: 5)),
        \"plain\": Lambertian(albedo: Rgb(0.5, 0.6, 0.7)),
        \"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0),
        \"glass\": Dielectric(ior: 1.5),
        \"pane\": ThinDielectric(transmittance: Rgb(0.7, 0.9, 0.8)),
        \"lamp\": DiffuseLight(emit: Rgb({lamp}), two_sided: false),
        \"screen\": DiffuseLight(emit: Checker(scale: 0.3, even: ({even}), odd: ({odd}))),
    }},
    objects: [Transformed(by: [Scale({scale:e}), Translate(({x:e}, {y:e}, {z:e}))], object: Group([
        Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"checker\"),
        Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
        Quad(corner: (-3, 0.3, -2.5), u: (1.5, 0, -0.4), v: (0, 1.5, 0), material: \"screen\"),
        Disk(center: (1.8, 0.5, -2), normal: (-0.3, 0.1, 1), radius: 0.5, material: \"screen\"),
        Sphere(center: (0, -100000.2, 0), radius: 100000, material: \"marble\"),
        Sphere(center: (-1.1, 0.7, 0), radius: 0.7, material: \"image\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.6, material: \"glass\"),
        Sphere(center: (-0.3, 1.3, 1.2), radius: 0.3, material: \"pane\"),
        Quad(corner: (-1.5, 0.2, 1.6), u: (1, 0, 0.2), v: (0, 0.8, 0.1), material: \"pane\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.25, material: \"plain\"),
        Sphere(center: (0.4, 0.6, 0.6), radius: 0.25, material: \"mirror\"),
        Transformed(by: [RotateY(30), Translate((1.3, 0, -0.7))], object: Box(min: (0, 0, 0), max: (0.8, 1.4, 0.9), material: \"marble\")),
        Transformed(by: [Scale(0.5), RotateX(20), RotateZ(10), Translate((-0.2, 0.4, -1.4))], object: Group([
            Box(min: (-1, -0.4, -1), max: (1, 1.3, 1), material: \"noise\"),
            Transformed(by: [Rotate(axis: (1, 2, 3), degrees: 50)], object: Sphere(center: (2.5, 0.5, 0), radius: 0.9, material: \"mirror\")),
        ])),
        Transformed(by: [Scale(0.5), RotateY(20), Translate((-0.4, 1.6, 0.3))], object: Mesh(path: \"octahedron.obj\", material: \"image\")),
        Transformed(by: [Scale(0.4), RotateX(10), Translate((0.9, 1.9, 0))], object: Mesh(path: \"octahedron.obj\", material: \"mirror\")),
        Transformed(by: [Scale(0.3), Translate((-1.4, 2, -0.5))], object: Mesh(path: \"flat.obj\", material: \"marble\")),
        Medium(boundary: Sphere(center: (0.4, 0.6, 0.6), radius: 0.6), density: {dense}, albedo: Rgb(0.2, 0.4, 0.9), anisotropy: 0.4),
        Medium(boundary: Box(min: (-2, 0.1, -1), max: (2, 1.5, 1.5)), density: {thin}, albedo: Checker(scale: 0.3, even: (0.9, 0.9, 0.9), odd: (0.2, 0.5, 0.2))),
        Medium(boundary: Transformed(by: [Scale(0.7), RotateZ(15), Translate((1.2, 0.8, 1))], object: Mesh(path: \"flat.obj\")), density: {thin}, albedo: Rgb(0.8, 0.8, 0.8), anisotropy: -0.3),
    ]))],
    render: (samples: 16, max_depth: 12),
)",
            from = point([0.5 + camera_shift, 1.7, 5.0]),
            at = point([0.0 + camera_shift, 0.7, 0.0]),
            dense = format_args!("{:e}", 4.0 / scale),
            thin = format_args!("{:e}", 0.5 / scale),
            aperture = length(0.3),
            focus = length(4.5),
            bottom = colour([0.1, 0.2, 0.3]),
            top = colour([0.6, 0.5, 0.9]),
            lamp = colour([5.0 * lamp, 4.0 * lamp, 3.0 * lamp]),
            even = colour([1.0, 0.0, 0.5]),
            odd = colour([0.0, 2.0, 0.5]),
        )
    }
}

/// An octahedron with the normals of a sphere and texture coordinates.
fn octahedron() -> String {
    let mut text = String::new();
    for (x, y, z) in [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)] {
        text +=
            &format!("v {x} {y} {z}\nvn {x} {y} {z}\nvt {} {}\n", 0.3 + 0.4 * f64::from(x), 0.5 + 0.9 * f64::from(y));
    }
    for [a, b, c] in [[5, 1, 3], [1, 6, 3], [6, 2, 3], [2, 5, 3], [1, 5, 4], [6, 1, 4], [2, 6, 4], [5, 2, 4]] {
        text += &format!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n");
    }
    text
}

/// Compares all of the film, except the count of hidden light, and the picture bit by bit: as numbers, zeros of both signs would be equal.
pub fn same(a: &Shot, b: &Shot) -> bool {
    let bits = |shot: &Shot| {
        let floats = shot.picture.rgb.iter().chain(&shot.picture.variance).flatten();
        floats.map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let totals = |shot: &Shot| Totals { light: Totals::default().light, ..shot.film.totals };
    let words = |shot: &Shot| (0..shot.picture.rgb.len()).map(|pixel| shot.film.words(pixel)).collect::<Vec<_>>();
    totals(a) == totals(b) && words(a) == words(b) && bits(a) == bits(b) && a.picture.samples == b.picture.samples
}
