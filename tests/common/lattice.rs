//! Scenes that span what a scene can require: each thing beside the least of the others, what works on each other in pairs, and all of it.

use gpu_rt::scene::Scene;
use image::{Rgb, RgbImage};

use super::everything::{Everything, World};
use super::render::scene_in;
use super::vdb::{TestGrid, scaled, vdb};

/// What a scene of the lattice has instead of the minimum.
#[derive(Clone, Copy)]
struct Point {
    name: &'static str,
    camera: &'static str,
    background: &'static str,
    /// Materials beside `grey`.
    materials: &'static str,
    /// Objects beside the ground and a ball.
    objects: &'static str,
    /// Whether there is a lamp above them, of the material `more`.
    has_lamp: bool,
}

const CAMERA: &str = "look_from: (0, 1, 4), look_at: (0, 0.5, 0), vertical_fov: 40";
const LENS: &str = "look_from: (0, 1, 4), look_at: (0, 0.5, 0), vertical_fov: 40, aperture: 0.3";
const MOVING: &str = "look_from: (0, 1, 4), look_at: (0, 0.5, 0), vertical_fov: 40, aperture: 0.1, shutter: (0, 1), \
                      moving: [(0, (look_from: (0, 1, 4), look_at: (0, 0.5, 0))), (1, (look_from: (0.2, 1, 4), look_at: (0, 0.5, 0)))]";
const MOVING_OBJECTS: &str = "Moving(keys: [(0, [RotateY(0), Translate((0, 0, 0))]), (1, [RotateY(20), Translate((0.1, 0.1, 0))])], object: Group([
        Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"more\"),
        Disk(center: (1, 1, 0), normal: (0, 0, 1), radius: 0.2, material: \"grey\"),
        Box(min: (-1, 0, 0.2), max: (-0.5, 0.6, 0.5), material: \"grey\"),
        Transformed(by: [Scale(0.3), Translate((0.2, 1.2, 0.5))], object: Mesh(path: \"octahedron.obj\", material: \"grey\")),
        Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"grey\"),
        PointLight(at: (1, 2, 1), intensity: (2, 2, 2)),
        Medium(boundary: Box(min: (-2, 0, -1), max: (2, 1.5, 1)), density: 0.4, albedo: Checker(scale: 0.3, even: (0.9, 0.9, 0.9), odd: (0.2, 0.5, 0.2))),
    ])),";
const GRADIENT: &str = "Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))";
const DARK: &str = "Solid((0.01, 0.02, 0.03))";
const SKY: &str = "Image(path: \"sky.png\")";
/// In front of the camera, beside the ball.
const BALL: &str = "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"more\"),";
const QUAD: &str = "Quad(corner: (-1.5, 0.1, -0.5), u: (1, 0, 0.3), v: (0, 1.2, 0), material: \"more\"),";
const CUBOID: &str = "Transformed(by: [RotateY(25), Translate((-1, 0, 0.5))], object: Box(min: (0, 0, 0), max: (0.6, 0.8, 0.5), material: \"more\")),";
const SMOOTH: &str = "Transformed(by: [Scale(0.5), Translate((-0.9, 0.6, 0.5))], object: Mesh(path: \"octahedron.obj\", material: \"more\")),";
const FLAT: &str =
    "Transformed(by: [Scale(0.5), Translate((-0.9, 0.6, 0.5))], object: Mesh(path: \"flat.obj\", material: \"more\")),";
const GREY: &str = "\"more\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2)),";
const GLASS: &str = "\"more\": Dielectric(ior: 1.5),";
const STEEL: &str = "\"more\": Metal(albedo: Rgb(0.8, 0.7, 0.6), fuzz: 0.2),";
const LAMP: &str = "\"more\": DiffuseLight(emit: Rgb(4, 3, 2)),";
const CHECKER: &str = "\"more\": Lambertian(albedo: Checker(scale: 0.3, even: (0.1, 0.2, 0.3), odd: (0.9, 0.8, 0.7))),";
const IMAGE: &str = "\"more\": Lambertian(albedo: Image(path: \"image.png\")),";
const NOISE: &str = "\"more\": Lambertian(albedo: Noise(scale: 3)),";
const MARBLE: &str = "\"more\": Lambertian(albedo: Marble(scale: 4)),";

/// The least but for these.
const fn point(name: &'static str, background: &'static str, materials: &'static str, objects: &'static str) -> Point {
    Point { name, camera: CAMERA, background, materials, objects, has_lamp: false }
}

const fn under_a_lamp(name: &'static str, materials: &'static str, objects: &'static str) -> Point {
    Point { has_lamp: true, ..point(name, DARK, materials, objects) }
}

const POINTS: &[Point] = &[
    point("spheres", GRADIENT, GREY, BALL),
    point("a solid background", DARK, GREY, BALL),
    point("an image for a background", SKY, GREY, BALL),
    point("quads", GRADIENT, GREY, QUAD),
    point("boxes", GRADIENT, GREY, CUBOID),
    point("a flat mesh", GRADIENT, GREY, FLAT),
    point("a smooth mesh", GRADIENT, GREY, SMOOTH),
    point("metal", GRADIENT, STEEL, BALL),
    point("glass", GRADIENT, GLASS, BALL),
    point("a lamp", DARK, LAMP, BALL),
    point("a rectangular lamp", DARK, LAMP, QUAD),
    point("a mesh as a lamp", DARK, LAMP, FLAT),
    point("a checker", GRADIENT, CHECKER, BALL),
    point("an image on a box", GRADIENT, IMAGE, CUBOID),
    point("noise", GRADIENT, NOISE, BALL),
    point("marble on a mesh", GRADIENT, MARBLE, FLAT),
    Point { camera: LENS, ..point("a lens", GRADIENT, GREY, BALL) },
    Point { camera: MOVING, ..point("what moves", DARK, LAMP, MOVING_OBJECTS) },
    Point {
        camera: "look_from: (0, 0.5, 4), look_at: (0, 0.5, 0), vertical_fov: 0.001",
        ..point("a narrow view", SKY, GREY, BALL)
    },
    point(
        "a medium",
        GRADIENT,
        GREY,
        "Medium(boundary: Sphere(center: (0.9, 0.5, 0.4), radius: 0.4), density: 2, albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.5),",
    ),
    under_a_lamp(
        "a textured medium in a box, under a lamp",
        "",
        "Medium(boundary: Box(min: (-2, 0, -1), max: (2, 1.5, 1)), density: 0.4, albedo: Checker(scale: 0.3, even: (0.9, 0.9, 0.9), odd: (0.2, 0.5, 0.2))),",
    ),
    point(
        "a medium in a mesh",
        GRADIENT,
        GREY,
        "Medium(boundary: Transformed(by: [Scale(0.8), Translate((0.5, 0.8, 0.5))], object: Mesh(path: \"flat.obj\")), density: 2, albedo: Rgb(0.9, 0.8, 0.7)),",
    ),
    under_a_lamp(
        "a cloud under a lamp",
        "",
        "Medium(density: Grid(path: \"cloud.vdb\", scale: 6), albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.5),",
    ),
    point(
        "haze that glows",
        DARK,
        GREY,
        "Medium(boundary: Box(min: (-2, 0, -1), max: (2, 1.5, 1)), density: Height(scale_height: 0.3, at: 0, density: 1), albedo: Rgb(0.5, 0.5, 0.5),
            emission: (0.5, 1, 2)),",
    ),
    Point {
        camera: MOVING,
        ..under_a_lamp(
            "fire in a mesh that moves",
            "",
            "Moving(keys: [(0, [RotateY(0), Translate((0.5, 0.8, 0.5))]), (1, [RotateY(20), Translate((0.6, 0.9, 0.5))])], object: Medium(
                boundary: Transformed(by: [Scale(0.8)], object: Mesh(path: \"flat.obj\")), density: Grid(path: \"cloud.vdb\", scale: 6),
                albedo: Rgb(0.2, 0.2, 0.2), emission: Blackbody(path: \"cloud.vdb\", name: \"density\", scale: 2500))),",
        )
    },
    point(
        "four lamps, a sky and glass",
        SKY,
        "\"more\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false), \"glass\": Dielectric(ior: 1.5),",
        "Sphere(center: (1.5, 1, 0), radius: 0.1, material: \"more\"), Sphere(center: (-1.5, 1, 0), radius: 0.1, material: \"more\"),
         Quad(corner: (-1, 2, -1), u: (0.3, 0, 0), v: (0, 0, 0.3), material: \"more\"), Box(min: (0, 2, 0), max: (0.1, 2.1, 0.1), material: \"more\"),
         Sphere(center: (0.9, 0.5, 0.6), radius: 0.4, material: \"glass\"),",
    ),
    point("a surface that emits and scatters", DARK, EMISSIVE, BALL),
    point("numbers that vary, under a lamp", DARK, VARYING, VARYING_OBJECTS),
    point("a surface that emits and scatters, a lamp and glass", DARK, EMISSIVE_AND_GLASS, EMISSIVE_OBJECTS),
    point("a transparent quad", GRADIENT, "\"more\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: 0, alpha: Image(path: \"image.png\", channel: G)),", QUAD),
    point("a ball and a box with holes", DARK, "\"more\": DiffuseLight(emit: Rgb(4, 3, 2)),
        \"holes\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: 0, alpha: Image(path: \"image.png\", channel: G)), \"glow\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2), emission: Rgb(0.5, 1, 2), alpha: 0.4),",
        "Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"more\"), Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"glow\"),
         Box(min: (-1.2, 0.1, 0), max: (-0.5, 0.8, 0.6), material: \"holes\"),"),
    point("a transparent mesh that emits", DARK, "\"more\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2), emission: Rgb(0.5, 1, 2), alpha: 0.4),", FLAT),
    point("a light without size", DARK, GREY, POINT_LIGHT),
    point("lights without size in fog", DARK, GREY, LIGHTS_IN_FOG),
    point(
        "a lamp, a sky, lights without size and glass",
        SKY,
        "\"more\": DiffuseLight(emit: Rgb(4, 3, 2)), \"glass\": Dielectric(ior: 1.5),",
        "Sphere(center: (1.5, 1, 0), radius: 0.1, material: \"more\"), Sphere(center: (0.9, 0.5, 0.6), radius: 0.4, material: \"glass\"),
         PointLight(at: (-1, 1.5, 1), intensity: (2, 2, 1)), DirectionalLight(direction: (1, -2, -1), irradiance: (1, 1, 1)),",
    ),
    under_a_lamp(
        "rough metals under a lamp",
        "\"brushed\": Conductor(albedo: Image(path: \"image.png\"), roughness: 0.4),
         \"gold\": Conductor(eta: (0.14, 0.37, 1.44), k: (3.98, 2.39, 1.6)),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"brushed\"), Sphere(center: (-0.9, 0.5, 0.4), radius: 0.4, material: \"gold\"),",
    ),
    under_a_lamp(
        "frosted glass, flat and smooth, under a lamp",
        "\"frosted\": RoughDielectric(ior: 1.5, roughness: 0.3), \"clear\": RoughDielectric(ior: 1.3),",
        "Transformed(by: [Scale(0.5), Translate((-0.9, 0.6, 0.5))], object: Mesh(path: \"octahedron.obj\", material: \"frosted\")),
         Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"frosted\"), Sphere(center: (0.9, 1.5, 0.4), radius: 0.4, material: \"clear\"),",
    ),
    under_a_lamp(
        "the material of glTF under a lamp",
        "\"plastic\": Pbr(base_color: Image(path: \"image.png\"), metallic: 0, roughness: 0.3),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"plastic\"),",
    ),
    under_a_lamp(
        "coats under a lamp",
        "\"varnish\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: 0, coat: Image(path: \"image.png\", channel: R),
            coat_roughness: Image(path: \"image.png\", channel: G), coat_normal: Image(path: \"image.png\")),
         \"glow\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: 0, coat: 0.5, emission: Rgb(0.5, 1, 2)),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"varnish\"), Sphere(center: (-0.9, 0.5, 0.4), radius: 0.4, material: \"glow\"),",
    ),
    under_a_lamp(
        "plastics and worn metal under a lamp",
        "\"satin\": Plastic(diffuse: Rgb(0.7, 0.3, 0.2), roughness: 0.3, distribution: Beckmann, emission: Rgb(0.1, 0.2, 0.3), alpha: 0.8),
         \"gloss\": Plastic(diffuse: Checker(scale: 0.2, even: (0.9, 0.8, 0.7), odd: (0.1, 0.2, 0.3)), nonlinear: true, one_sided: true),
         \"worn\": Conductor(albedo: Rgb(0.9, 0.8, 0.7), roughness: 0.3, distribution: Beckmann),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"satin\"), Sphere(center: (-0.9, 1.5, 0.4), radius: 0.3, material: \"gloss\"),
         Sphere(center: (-0.9, 0.5, 0.4), radius: 0.3, material: \"worn\"),",
    ),
    under_a_lamp(
        "mixes under a lamp",
        "\"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7)), \"gloss\": Plastic(diffuse: Checker(scale: 0.2, even: (0.9, 0.8, 0.7), odd: (0.1, 0.2, 0.3))),
         \"clear\": Dielectric(ior: 1.5), \"worn\": Mix(a: \"gloss\", b: \"mirror\", share: Checker(scale: 0.1, even: (0.2, 0, 0), odd: (0.9, 0, 0)), alpha: 0.8),
         \"milky\": Mix(a: \"clear\", b: \"gloss\", share: 0.3),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"worn\"), Sphere(center: (-0.9, 0.5, 0.4), radius: 0.3, material: \"milky\"),",
    ),
    under_a_lamp(
        "velvet under a lamp",
        "\"velvet\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: 0, sheen: Rgb(0.9, 0.5, 0.3), sheen_roughness: 0.4),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"velvet\"),",
    ),
    under_a_lamp(
        "brushed metal, a ball that is half glass and a smooth mesh that is a pane, under a lamp",
        "\"brushed\": Conductor(albedo: Rgb(0.9, 0.8, 0.7), roughness: 0.3, anisotropy: 0.8),
         \"half\": Pbr(base_color: Rgb(0.7, 0.8, 0.9), metallic: 0, roughness: 0.3, transmission: 0.5, solid: true, absorption: (0.1, 0.2, 0.3)),
         \"pane\": Pbr(base_color: Rgb(0.7, 0.8, 0.9), metallic: 0, roughness: 0.3, transmission: Image(path: \"image.png\", channel: R),
            specular: Image(path: \"image.png\", channel: G)),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"half\"), Sphere(center: (-0.9, 1.5, 0.4), radius: 0.3, material: \"brushed\"),
         Transformed(by: [Scale(0.5), Translate((-0.9, 0.6, 0.5))], object: Mesh(path: \"octahedron.obj\", material: \"pane\")),",
    ),
    under_a_lamp(
        "glass with dispersion, a soap bubble and a leaf, under a lamp",
        "\"flint\": Dielectric(ior: 1.6, dispersion: 0.8, absorption: (0.1, 0.2, 0.3)),
         \"frosted\": RoughDielectric(ior: 1.6, roughness: 0.3, dispersion: 2, transmittance: Rgb(0.9, 0.8, 0.7)),
         \"soap\": Pbr(metallic: 0, roughness: 0, transmission: 1, iridescence: 1, iridescence_thickness_texture: Image(path: \"image.png\", channel: G)),
         \"leaf\": Pbr(base_color: Rgb(0.2, 0.6, 0.1), metallic: 0, diffuse_transmission: Image(path: \"image.png\", channel: R),
            diffuse_transmission_color: Rgb(0.5, 0.8, 0.1)),",
        "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"flint\"), Sphere(center: (-0.9, 1.5, 0.4), radius: 0.3, material: \"soap\"),
         Sphere(center: (0.9, 1.5, 0.4), radius: 0.3, material: \"frosted\"),
         Transformed(by: [Scale(0.5), Translate((-0.9, 0.6, 0.5))], object: Mesh(path: \"octahedron.obj\", material: \"leaf\")),",
    ),
    Point {
        camera: LENS,
        ..point(
            "glass and textured metal behind a lens",
            GRADIENT,
            "\"more\": Metal(albedo: Image(path: \"image.png\"), fuzz: 0), \"glass\": Dielectric(ior: 1.5),",
            "Sphere(center: (0.9, 0.5, 0.6), radius: 0.4, material: \"glass\"),
             Quad(corner: (-1.5, 0.1, -0.5), u: (1, 0, 0.3), v: (0, 1.2, 0), material: \"more\"),",
        )
    },
];

const VARYING: &str = "\"more\": Pbr(base_color: Rgb(0.7, 0.3, 0.2), metallic: Image(path: \"image.png\", channel: B), roughness: Noise(scale: 4)),
    \"glass\": RoughDielectric(ior: 1.5, roughness: Checker(scale: 0.2, even: (0, 0, 0), odd: (0.3, 0, 0))),
    \"steel\": Conductor(albedo: Rgb(0.7, 0.7, 0.8), roughness: Image(path: \"image.png\", channel: G)),
    \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false),";
const VARYING_OBJECTS: &str = "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"glass\"),
    Quad(corner: (-1.5, 0.1, -0.5), u: (1, 0, 0.3), v: (0, 1.2, 0), material: \"more\"),
    Box(min: (-0.3, 0, 0), max: (0.3, 0.5, 0.4), material: \"steel\"),
    Quad(corner: (-1, 2, -1), u: (0.3, 0, 0), v: (0, 0, 0.3), material: \"lamp\"),";
const EMISSIVE: &str = "\"more\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2), emission: Rgb(0.5, 1, 2)),";
const EMISSIVE_AND_GLASS: &str =
    "\"more\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2), emission: Rgb(0.5, 1, 2)), \"glass\": Dielectric(ior: 1.5),
    \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false),";
const EMISSIVE_OBJECTS: &str = "Sphere(center: (0.9, 0.5, 0.4), radius: 0.4, material: \"glass\"),
    Quad(corner: (-1.5, 0.1, -0.5), u: (1, 0, 0.3), v: (0, 1.2, 0), material: \"more\"),
    Quad(corner: (-1, 2, -1), u: (0.3, 0, 0), v: (0, 0, 0.3), material: \"lamp\"),";
const POINT_LIGHT: &str = "PointLight(at: (1, 2, 1), intensity: (3, 2, 1)),";
const LIGHTS_IN_FOG: &str = "SpotLight(at: (1, 2, 1), towards: (0, 0.5, 0), intensity: (9, 8, 7), inner: 10, outer: 25),
    DirectionalLight(direction: (1, -2, -1), irradiance: (1, 1, 1)),
    Medium(boundary: Sphere(center: (0, 0.5, 0), radius: 1.5), density: 0.4, albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.3),";

/// Scenes that lack what the others have, by name: background, materials and objects.
const SPARSE: &[(&str, &str, &str, &str)] = &[
    ("nothing", GRADIENT, "", ""),
    ("nothing before an image", SKY, "", ""),
    ("fog alone", GRADIENT, "", FOG),
    ("fog before an image", SKY, "", FOG),
    ("a lamp alone", DARK, LAMP, CUBOID),
    ("a lamp, glass and a mirror", DARK, SHINY, SHINY_OBJECTS),
];
const FOG: &str = "Medium(boundary: Sphere(center: (0, 0.5, 0), radius: 1), density: 1, albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.5),";
const SHINY: &str = "\"more\": DiffuseLight(emit: Rgb(4, 3, 2)), \"glass\": Dielectric(ior: 1.5), \"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7)),";
const SHINY_OBJECTS: &str = "Sphere(center: (0, 2, 0), radius: 0.5, material: \"more\"), Sphere(center: (0.9, 0.5, 0.4), radius: 0.6, material: \"glass\"),
    Sphere(center: (-0.9, 0.5, 0.4), radius: 0.6, material: \"mirror\"),";

/// The images and meshes live as long as this.
pub struct Lattice {
    everything: Everything,
}

impl Lattice {
    pub fn new() -> Lattice {
        let everything = Everything::new();
        let sky = RgbImage::from_fn(8, 4, |x, y| Rgb([(x * 30) as u8, 40 + (y * 50) as u8, 250 - (y * 60) as u8]));
        sky.save(everything.folder().join("sky.png")).expect("the image is written");
        let rough = |[x, y, z]: [i32; 3]| ((x * x + 3 * y * z + 5 * z).rem_euclid(7)) as f32 / 7.0;
        let boxes = &[[[-6; 3], [6; 3]]];
        let cloud = TestGrid { boxes, background: 0.0, map: scaled(0.1, [0.9, 0.5, 0.4]), value: &rough };
        std::fs::write(everything.folder().join("cloud.vdb"), vdb(&[("density", cloud)])).expect("the file is written");
        Lattice { everything }
    }

    /// The scenes by name, everything last.
    pub fn scenes(&self) -> Vec<(&'static str, Scene)> {
        let folder = self.everything.folder();
        let of_sparse = SPARSE.iter().map(|(name, background, materials, objects)| {
            (*name, scene_in(folder, &text_of(CAMERA, background, materials, objects)))
        });
        let of_points = POINTS.iter().map(|point| (point.name, scene_in(folder, &text(point))));
        of_points.chain(of_sparse).chain([("everything", self.everything.scene(World::default()))]).collect()
    }
}

fn text(point: &Point) -> String {
    let Point { camera, background, materials, objects, has_lamp, .. } = point;
    let quad = "Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"more\"),";
    let [lamp, quad] = if *has_lamp { [LAMP, quad] } else { [""; 2] };
    let materials = format!("\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), {lamp} {materials}");
    let objects = format!(
        "Sphere(center: (0, -100, 0), radius: 100, material: \"grey\"),
        Sphere(center: (0, 0.5, 0), radius: 0.5, material: \"grey\"),
        {quad} {objects}"
    );
    text_of(camera, background, &materials, &objects)
}

fn text_of(camera: &str, background: &str, materials: &str, objects: &str) -> String {
    format!(
        "Scene(image: (width: 12, height: 9), camera: ({camera}), background: {background},
        materials: {{ {materials} }}, objects: [{objects}],
        render: (samples: 16, max_depth: 8))"
    )
}
