//! What the scene loader refuses and accepts: every error at its location, with its field, in the
//! format's own words, and never a panic.

use crate::common::marked::{MARK, fault, unmarked};
use crate::common::mutate::mutated;
use crate::common::stats::Random;
use std::fs;
use std::path::{Path, PathBuf};

use gpu_rt::error::{Error, Location};
use gpu_rt::scene::{Background, Bitmap, DiffuseLight, Material, Metal, Object, Scene, Step, Texture, Transform};

/// A bad scene, marked, with the field and some words of the message.
type Bad = (String, &'static str, &'static [&'static str]);

/// Why an error is not a scene's, at the mark of the text in this file, about this field, in these words.
fn compare(error: &Error, file: &Path, text: &str, field: &str, words: &[&str]) -> Result<(), String> {
    let faults = error.each().iter().map(|error| match error {
        Error::Scene { .. } => fault(error, file, text, field, words),
        _ => Err(format!("not a scene's error: {error}")),
    });
    // Objects without a material get an error, too.
    let faults: Vec<_> = faults.collect();
    faults.iter().find(|fault| fault.is_ok()).or(faults.first()).cloned().unwrap_or(Ok(()))
}

fn parse(text: &str) -> Result<Scene, Error> {
    Scene::parse(text, Path::new(FILE))
}

const FILE: &str = "folder/scene.ron";

/// A scene around one object that uses the material "grey".
fn object(text: &str) -> String {
    format!(
        "Scene(
    image: (width: 4, height: 3),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)),
    materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"été\": Dielectric(ior: 1.5) }},
    objects: [
        {text},
    ],
)
"
    )
}

/// A scene around one material, "it", after another whose name is not ASCII.
fn material(text: &str) -> String {
    format!(
        "(
    image: (width: 4, height: 3),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)),
    materials: {{ \"grün\": Dielectric(ior: 1.5), \"it\": {text} }},
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"it\")],
)
"
    )
}

const IMAGE: &str = "(width: 4, height: 3)";
const CAMERA: &str = "(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40)";
const BACKGROUND: &str = "Solid((1, 1, 1))";

/// A scene of these parts, with CR LF line ends and without objects.
fn scene(image: &str, camera: &str, background: &str, rest: &str) -> String {
    format!(
        "(\r\n  image: {image},\r\n  camera: {camera},\r\n  background: {background},\r\n  objects: [],\r\n  {rest})\r\n"
    )
}

fn bad(text: impl Into<String>, field: &'static str, words: &'static [&'static str]) -> Bad {
    (text.into(), field, words)
}

/// Bad scenes.
#[rustfmt::skip]
fn all_bad() -> Vec<Bad> {
    let image = |text: &str| scene(text, CAMERA, BACKGROUND, "");
    let camera = |text: &str| scene(IMAGE, text, BACKGROUND, "");
    let background = |text: &str| scene(IMAGE, CAMERA, text, "");
    let texture = &["a texture: Rgb(r, g, b), Checker(..), Image(..), Noise(..) or Marble(..)"];
    let sphere = |rest: &str| object(&format!("Sphere(center: (0, 0, 0), {rest})"));
    let moving = |keys: &str| object(&format!("Moving(keys: {keys}, object: Sphere(center: (0, 0, 0), radius: 1, material: \"grey\"))"));
    let lens = |more: &str| scene(IMAGE, &format!("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40, {more})"), BACKGROUND, "");
    let boundary = |text: &str| object(&format!("Medium(boundary: {text}, density: 1, albedo: Rgb(1, 1, 1))"));
    let medium = |text: &str| object(&format!("Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), {text})"));
    let wanted = &["a boundary: a Sphere, a Box or a closed Mesh, Transformed, Moving or not, without a material"];
    let rest = |text: &str| scene(IMAGE, CAMERA, BACKGROUND, text);
    vec![
        // The image.
        bad(image("(width: §0, height: 3)"), "image.width", &["width", "from 1 to 65536", "found 0"]),
        bad(image("(width: 4, height: §65537)"), "image.height", &["height", "found 65537"]),
        bad(image("§(width: 65536, height: 65536)"), "image", &["width times height", "4294967296"]),
        bad(image("(width: §-4, height: 3)"), "image.width", &["a whole number from 1 to 65536", "found -4"]),
        bad(image("(width: §4.5, height: 3)"), "image.width", &["a whole number", "found 4.5"]),
        bad(image("(width: §5000000000, height: 3)"), "image.width", &["a whole number", "5000000000"]),
        bad(image("(width: 4, height: §\"3\")"), "image.height", &["a whole number", "found \"3\""]),
        bad(image("(width: 4, §heigth: 3)"), "image.heigth", &["unknown field heigth", "width, height", "did you mean height?"]),
        bad(image("§(width: 4)"), "image.height", &["height is missing", "a whole number"]),
        bad(image("§7"), "image", &["(width: .., height: ..)", "found 7"]),
        // The camera.
        bad(camera("(look_from: (1, 2, 3), look_at: §(1, 2, 3), vertical_fov: 40)"), "camera.look_at", &["look_at", "same point"]),
        bad(camera("(look_from: (0, 0, 0), look_at: §(0, 0, 1e-200), vertical_fov: 40)"), "camera.look_at", &["look_at", "1e-100"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), up: §(0, 0, 0), vertical_fov: 40)"), "camera.up", &["up", "no length"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), up: §(0, 0, 2), vertical_fov: 40)"), "camera.up", &["parallel to the view"]),
        bad(camera("§(look_from: (0, 5, 0), look_at: (0, 0, 0), vertical_fov: 40)"), "camera.up", &["parallel", "up: (0, 0, 1)"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: §0)"), "camera.vertical_fov", &["vertical_fov", "between 0 and 180", "found 0"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: §180.0)"), "camera.vertical_fov", &["found 180.0"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: §NaN)"), "camera.vertical_fov", &["found NaN"]),
        bad(camera("(look_from: (0, 0, §inf), look_at: (0, 0, 0), vertical_fov: 40)"), "camera.look_from[2]", &["finite", "found inf"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (§-2e100, 0, 0), vertical_fov: 40)"), "camera.look_at[0]", &["1e100", "found -2e100"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40, aperture: §-0.1)"), "camera.aperture", &["aperture", "found -0.1"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40, focus_distance: §0)"), "camera.focus_distance", &["greater than 0"]),
        bad(camera("§(look_from: (0, 0, 5), look_at: (0, 0, 0))"), "camera.vertical_fov", &["vertical_fov is missing", "degrees"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: §40, projection: Orthographic(height: 2))"), "camera.vertical_fov", &["short for a projection"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Orthographic(height: §0))"), "camera.projection.Orthographic.height", &["height", "greater than 0"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Fisheye(model: Stereographic, fov: §360))"), "camera.projection.Fisheye.fov", &["between 0 and 360, both excluded", "found 360"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Fisheye(model: Orthographic, fov: §181))"), "camera.projection.Fisheye.fov", &["from 0 to 180"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Equirectangular(horizontal: §(90, -90)))"), "camera.projection.Equirectangular.horizontal", &["above the first one"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Equirectangular(vertical: (-90, §91)))"), "camera.projection.Equirectangular.vertical[1]", &["from -90 to 90", "found 91"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Calibrated(fx: §-3, fy: 3, cx: 1, cy: 1))"), "camera.projection.Calibrated.fx", &["fx", "greater than 0"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Calibrated(fx: 3, fy: 3, cx: 1, cy: 1, distortion: Brown(k1: §inf)))"), "camera.projection.Calibrated.distortion.Brown.k1", &["-1e9 to 1e9", "found inf"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Calibrated(fx: 3, fy: 3, cx: 1, cy: 1, distortion: KannalaBrandt(k4: §1e60)))"), "camera.projection.Calibrated.distortion.KannalaBrandt.k4", &["-1e9 to 1e9", "found 1e60"]),
        bad(camera("(look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Orthographic(height: 2), aperture: §0.1)"), "camera.aperture", &["Orthographic", "no lens"]),
        bad(camera("(§lookfrom: (0, 0, 5), look_at: (0, 0, 0))"), "camera.lookfrom", &["unknown field lookfrom", "did you mean look_from?"]),
        bad(camera("(§look-from: (0, 0, 5), look_at: (0, 0, 0))"), "camera", &["a field's name", "found look-from"]),
        bad(camera("(look_from: §(0, 5), look_at: (0, 0, 0), vertical_fov: 40)"), "camera.look_from", &["a point: (x, y, z)", "found (0, 5)"]),
        // The background.
        bad(background("Solid((1, §-1, 1))"), "background.Solid[1]", &["radiance", "found -1"]),
        bad(background("Solid((1, 1, §1e-31))"), "background.Solid[2]", &["1e-30", "found 1e-31"]),
        bad(background("Gradient(bottom: (1, 1, 1), top: (§2e30, 1, 1))"), "background.Gradient.top[0]", &["1e30"]),
        bad(background("§Gradient(bottom: (1, 1, 1))"), "background.Gradient.top", &["top is missing", "a colour: (r, g, b)"]),
        bad(background("Solid(§1, 1, 1)"), "background.Solid[0]", &["Solid((r, g, b))"]),
        bad(background("§(1, 1, 1)"), "background", &["a background: Solid((r, g, b)), Gradient(bottom: .., top: ..) or Image(path: ..)", "did you mean Solid((1, 1, 1))?"]),
        bad(background("§Sold((1, 1, 1))"), "background", &["found Sold((1, 1, 1))", "did you mean Solid?"]),
        bad(background("Image(path: §\"missing.exr\")"), "background.Image.path", &["folder/missing.exr", "cannot read the image"]),
        // Materials.
        bad(material("Metal(albedo: §\"steel\")"), "materials[\"it\"].Metal.albedo", texture),
        bad(material("DiffuseLight(emit: §5)"), "materials[\"it\"].DiffuseLight.emit", texture),
        bad(material("Lambertian(albedo: §Rbg(1, 1, 1))"), "materials[\"it\"].Lambertian.albedo", &["did you mean Rgb?", "found Rbg(1, 1, 1)"]),
        bad(material("Lambertian(albedo: §Rgb(1, 1))"), "materials[\"it\"].Lambertian.albedo.Rgb", &["expected Rgb(r, g, b)", "found Rgb(1, 1)"]),
        bad(material("Lambertian(albedo: §Rgb(1, 1, 1, 1))"), "materials[\"it\"].Lambertian.albedo.Rgb", &["expected Rgb(r, g, b)"]),
        bad(material("Lambertian(albedo: Rgb(1, 1, §red))"), "materials[\"it\"].Lambertian.albedo.Rgb[2]", &["a number", "found red"]),
        bad(material("Lambertian(albedo: Rgb(0.5, §1.01, 0.5))"), "materials[\"it\"].Lambertian.albedo.Rgb[1]", &["albedo", "from 0 to 1", "1.01"]),
        bad(material("Lambertian(albedo: Rgb(0, 0, 0), alpha: §1.5)"), "materials[\"it\"].Lambertian.alpha", &["alpha", "from 0 to 1", "1.5"]),
        bad(material("Pbr(alpha: §-0.1)"), "materials[\"it\"].Pbr.alpha", &["alpha", "-0.1"]),
        bad(material("Pbr(alpha: 0.5, alpha_cutoff: §-1)"), "materials[\"it\"].Pbr.alpha_cutoff", &["alpha_cutoff", "-1"]),
        bad(material("Pbr(alpha: §\"none\")"), "materials[\"it\"].Pbr.alpha", &["a number"]),
        bad(material("Metal(albedo: Rgb(§-0.1, 0.5, 0.5))"), "materials[\"it\"].Metal.albedo.Rgb[0]", &["albedo", "-0.1"]),
        bad(material("Lambertian(albedo: Checker(scale: 1, even: (0, 0, 0), odd: (0, 0, §2)))"), "materials[\"it\"].Lambertian.albedo.Checker.odd[2]", &["albedo"]),
        bad(material("Lambertian(albedo: Checker(scale: §0, even: (0, 0, 0), odd: (0, 0, 0)))"), "materials[\"it\"].Lambertian.albedo.Checker.scale", &["scale", "greater than 0"]),
        bad(material("Lambertian(albedo: Checker(scale: 1, even: §Rgb(0, 0, 0), odd: (0, 0, 0)))"), "materials[\"it\"].Lambertian.albedo.Checker.even", &["a colour: (r, g, b)"]),
        bad(material("Lambertian(albedo: Noise(scale: §-1))"), "materials[\"it\"].Lambertian.albedo.Noise.scale", &["scale"]),
        bad(material("Lambertian(albedo: Marble(scale: §1e101))"), "materials[\"it\"].Lambertian.albedo.Marble.scale", &["1e100"]),
        bad(material("Lambertian(albedo: Image(path: §\"none.png\"))"), "materials[\"it\"].Lambertian.albedo.Image.path", &["folder/none.png"]),
        bad(material("Metal(albedo: Rgb(1, 1, 1), fuzz: §1.5)"), "materials[\"it\"].Metal.fuzz", &["fuzz", "from 0 to 1"]),
        bad(material("Metal(albedo: Rgb(1, 1, 1), fuzz: §NaN)"), "materials[\"it\"].Metal.fuzz", &["fuzz"]),
        bad(material("Dielectric(ior: §0)"), "materials[\"it\"].Dielectric.ior", &["ior", "greater than 0"]),
        bad(material("§Dielectric()"), "materials[\"it\"].Dielectric.ior", &["ior is missing", "a positive number"]),
        bad(material("DiffuseLight(emit: Rgb(§-1, 0, 0))"), "materials[\"it\"].DiffuseLight.emit.Rgb[0]", &["radiance"]),
        bad(material("DiffuseLight(emit: Rgb(1, 1, 1), two_sided: §1)"), "materials[\"it\"].DiffuseLight.two_sided", &["true or false", "found 1"]),
        bad(material("§Conductor(roughness: 0.5)"), "materials[\"it\"].Conductor", &["either an albedo, or both eta and k"]),
        bad(material("§Conductor(albedo: Rgb(1, 1, 1), eta: (1, 1, 1), k: (0, 0, 0))"), "materials[\"it\"].Conductor", &["either an albedo"]),
        bad(material("§Conductor(eta: (1, 1, 1))"), "materials[\"it\"].Conductor", &["either an albedo, or both eta and k"]),
        bad(material("Conductor(eta: (1, §0, 1), k: (1, 1, 1))"), "materials[\"it\"].Conductor.eta[1]", &["eta", "from 0.001 to 1000"]),
        bad(material("Conductor(albedo: Rgb(1, 1, §1.1))"), "materials[\"it\"].Conductor.albedo.Rgb[2]", &["albedo", "1.1"]),
        bad(material("Conductor(albedo: Rgb(1, 1, 1), roughness: §1.5)"), "materials[\"it\"].Conductor.roughness", &["roughness", "from 0 to 1"]),
        bad(material("RoughDielectric(ior: 1.5, roughness: §-0.5)"), "materials[\"it\"].RoughDielectric.roughness", &["roughness", "from 0 to 1"]),
        bad(material("RoughDielectric(ior: §0)"), "materials[\"it\"].RoughDielectric.ior", &["ior", "greater than 0"]),
        bad(material("Pbr(metallic: §2)"), "materials[\"it\"].Pbr.metallic", &["metallic", "from 0 to 1"]),
        bad(material("Pbr(roughness: §\"rough\")"), "materials[\"it\"].Pbr.roughness", &["a number from 0 to 1, or a texture", "found \"rough\""]),
        bad(material("Pbr(metallic: §true)"), "materials[\"it\"].Pbr.metallic", &["a number from 0 to 1, or a texture"]),
        bad(material("Pbr(metallic: §, ior: 1.5)"), "materials[\"it\"].Pbr.metallic", &["a number from 0 to 1, or a texture"]),
        bad(material("Pbr(roughness: §Image(path: \"a.png\", chanel: G))"), "materials[\"it\"].Pbr.roughness", &["or a texture", "chanel"]),
        bad(material("Pbr(roughness: §Picture(path: \"a.png\"))"), "materials[\"it\"].Pbr.roughness", &["or a texture", "found Picture"]),
        bad(material("Pbr(roughness: Image(path: \"a.png\", tint: (§2, 1, 1)))"), "materials[\"it\"].Pbr.roughness.Image.tint[0]", &["from 0 to 1"]),
        bad(material("Pbr(roughness: Checker(scale: 1, even: (§-1, 0, 0), odd: (1, 1, 1)))"), "materials[\"it\"].Pbr.roughness.Checker.even[0]", &["from 0 to 1"]),
        bad(material("Pbr(base_color: Image(path: \"a.png\", channel: §G))"), "materials[\"it\"].Pbr.base_color.Image.channel", &["expected none, or Rgb if its codes are linear"]),
        bad(material("Pbr(transmission: §-0.5)"), "materials[\"it\"].Pbr.transmission", &["transmission", "from 0 to 1"]),
        bad(material("§Pbr(transmission: 0.5, absorption: (1, 0, 0))"), "materials[\"it\"].Pbr", &["`solid: true`", "absorption"]),
        bad(material("Pbr(specular: §2)"), "materials[\"it\"].Pbr.specular", &["specular", "from 0 to 1"]),
        bad(material("Pbr(coat: §1.5)"), "materials[\"it\"].Pbr.coat", &["coat", "from 0 to 1"]),
        bad(material("Pbr(coat: 1, coat_roughness: §-1)"), "materials[\"it\"].Pbr.coat_roughness", &["from 0 to 1"]),
        bad(material("Pbr(coat: 1, coat_ior: §0.5)"), "materials[\"it\"].Pbr.coat_ior", &["from 1 to 1000"]),
        bad(material("Pbr(coat: 1, coat_normal: §Rgb(0, 0, 1))"), "materials[\"it\"].Pbr.coat_normal.Rgb", &["a normal map"]),
        bad(material("Pbr(sheen: Rgb(§2, 0, 0))"), "materials[\"it\"].Pbr.sheen.Rgb[0]", &["albedo", "found 2"]),
        bad(material("Pbr(sheen: Rgb(1, 1, 1), sheen_roughness: §7)"), "materials[\"it\"].Pbr.sheen_roughness", &["from 0 to 1"]),
        bad(material("Pbr(iridescence: §-1)"), "materials[\"it\"].Pbr.iridescence", &["from 0 to 1"]),
        bad(material("Pbr(iridescence: 1, iridescence_ior: §0.5)"), "materials[\"it\"].Pbr.iridescence_ior", &["from 1 to 1000"]),
        bad(material("Pbr(iridescence: 1, iridescence_thickness: §-1)"), "materials[\"it\"].Pbr.iridescence_thickness", &["from 0 to 1e6"]),
        bad(material("Pbr(iridescence: 1, iridescence_thickness_min: §NaN)"), "materials[\"it\"].Pbr.iridescence_thickness_min", &["found NaN"]),
        bad(material("Pbr(diffuse_transmission: §2)"), "materials[\"it\"].Pbr.diffuse_transmission", &["from 0 to 1"]),
        bad(material("Pbr(diffuse_transmission: 1, diffuse_transmission_color: Rgb(0, §2, 0))"), "materials[\"it\"].Pbr.diffuse_transmission_color.Rgb[1]", &["albedo"]),
        bad(material("§Pbr(transmission: 1, dispersion: 0.5)"), "materials[\"it\"].Pbr", &["`solid: true`", "dispersion"]),
        bad(material("Dielectric(ior: 1.5, dispersion: §21)"), "materials[\"it\"].Dielectric.dispersion", &["from 0 to 20"]),
        bad(material("§Dielectric(ior: 0.7, dispersion: 1)"), "materials[\"it\"].Dielectric", &["an ior below 1"]),
        bad(material("RoughDielectric(ior: 1.5, dispersion: §-1)"), "materials[\"it\"].RoughDielectric.dispersion", &["from 0 to 20"]),
        bad(material("Pbr(anisotropy: §1.5)"), "materials[\"it\"].Pbr.anisotropy", &["from 0 to 1"]),
        bad(material("Conductor(albedo: Rgb(1, 1, 1), anisotropy: 1, anisotropy_rotation: §NaN)"), "materials[\"it\"].Conductor.anisotropy_rotation", &["found NaN"]),
        bad(material("RoughDielectric(ior: 1.5, anisotropy: 1, anisotropy_texture: §Noise(scale: 1))"), "materials[\"it\"].RoughDielectric.anisotropy_texture.Noise", &["an image of directions"]),
        bad(material("Pbr(ior: §0.9)"), "materials[\"it\"].Pbr.ior", &["ior", "from 1 to 1000"]),
        bad(material("Pbr(base_color: Rgb(1, §-1, 1))"), "materials[\"it\"].Pbr.base_color.Rgb[1]", &["albedo", "-1"]),
        bad(material("§Glass(ior: 1.5)"), "materials[\"it\"]", &["a material: Lambertian(..), Metal(..)", "found Glass(ior: 1.5)", "did you mean Dielectric(ior: 1.5)?"]),
        bad(material("§\"glass\""), "materials[\"it\"]", &["a material"]),
        bad(material("Dielectric(ior: 1), §\"it\": Dielectric(ior: 2)"), "materials[\"it\"]", &["\"it\" is defined twice"]),
        bad(material("Dielectric(ior: 1), §other: Dielectric(ior: 2)"), "materials", &["a material's name in quotes", "found other"]),
        bad(material("Dielectric(ior: 1), \"b\" §Dielectric(ior: 2)"), "materials", &["a colon"]),
        // Objects.
        bad(sphere("radius: §0, material: \"grey\""), "objects[0].Sphere.radius", &["radius", "greater than 0", "found 0"]),
        bad(sphere("radius: §-1, material: \"grey\""), "objects[0].Sphere.radius", &["radius", "found -1"]),
        bad(sphere("radius: §1e-101, material: \"grey\""), "objects[0].Sphere.radius", &["from 1e-100 to 1e100"]),
        bad(sphere("radius: §1e400, material: \"grey\""), "objects[0].Sphere.radius", &["found 1e400"]),
        bad(sphere("radius: §, material: \"grey\""), "objects[0].Sphere.radius", &["a positive number", "found ,"]),
        bad(sphere("radius: §5px, material: \"grey\""), "objects[0].Sphere.radius", &["a positive number", "found 5px"]),
        bad(sphere("radius: §\"one\", material: \"grey\""), "objects[0].Sphere.radius", &["a positive number", "found \"one\""]),
        bad(sphere("radius §= 5, material: \"grey\""), "objects[0].Sphere", &["a colon after the name", "found ="]),
        bad(sphere("radius: 1 §material: \"grey\""), "objects[0].Sphere", &["a comma or a closing bracket", "found material"]),
        bad(sphere("radius: 1, §radius: 2"), "objects[0].Sphere.radius", &["given twice"]),
        bad(sphere("§raduis: 1"), "objects[0].Sphere.raduis", &["center, radius, material", "did you mean radius?"]),
        bad(sphere("§\"radius\": 1"), "objects[0].Sphere", &["a field's name, without quotes"]),
        bad(sphere("radius: 1, material: §\"gray\""), "objects[0].Sphere.material", &["\"gray\"", "\"grey\", \"été\"", "did you mean \"grey\"?"]),
        bad(sphere("radius: 1, material: §\"\""), "objects[0].Sphere.material", &["there is no material \"\""]),
        bad(sphere("radius: 1, material: §grey"), "objects[0].Sphere.material", &["a material's name in quotes", "found grey"]),
        bad(sphere("radius: 1, material: §None"), "objects[0].Sphere.material", &["material is missing"]),
        bad(sphere("radius: 1, material: §\"grey"), "objects[0].Sphere.material", &["string is not closed"]),
        bad(sphere("radius: 1, material: \"gr\\q§ey\""), "objects[0].Sphere.material", &["backslash"]),
        bad(sphere("radius: 1, §/* material: \"grey\""), "objects[0].Sphere", &["comment is not closed"]),
        bad(sphere("radius: 1, §/ material: \"grey\""), "objects[0].Sphere", &["comment"]),
        bad(object("§Sphere(center: (0, 0, 0), radius: 1)"), "objects[0].Sphere.material", &["material is missing", "\"grey\", \"été\""]),
        bad(object("/* \"été\" (( */ §Sphere(center: (0, 0, 0))"), "objects[0].Sphere.radius", &["radius is missing"]),
        bad(object("Sphere(center: (0, §NaN, 0), radius: 1)"), "objects[0].Sphere.center[1]", &["finite", "found NaN"]),
        bad(object("Sphere(center: §[0, 0, 0], radius: 1)"), "objects[0].Sphere.center", &["a point: (x, y, z)", "found [0, 0, 0]"]),
        bad(object("Sphere(center: §(0, 0, 0, 0), radius: 1)"), "objects[0].Sphere.center", &["a point", "found (0, 0, 0, 0)"]),
        bad(object("Sphere(center: (0, 0 §0), radius: 1)"), "objects[0].Sphere.center", &["a comma"]),
        bad(object("§Sphere"), "objects[0].Sphere", &["expected Sphere(center: .., radius: .., material: ..)"]),
        bad(object("§Sphere { radius: 1 }"), "objects[0].Sphere", &["expected Sphere(center: .., "]),
        bad(object("Sphere(§(0, 0, 0), 1)"), "objects[0].Sphere[0]", &["fields by name"]),
        bad(object("Group([Group([])§), Group([])"), "objects[0].Group[0]", &["expected ], found )", "is not closed"]),
        bad(object("§Cube(size: 1)"), "objects[0]", &["did you mean Box(min: .., max: ..)?"]),
        bad(object("§Plane(y: 0)"), "objects[0]", &["did you mean Quad("]),
        bad(object("§Triangle(a: 1)"), "objects[0]", &["did you mean Mesh("]),
        bad(material("§Diffuse(albedo: Rgb(1, 1, 1))"), "materials[\"it\"]", &["did you mean Lambertian("]),
        bad(material("Mix(a: \"grün\", b: §\"grin\", share: 0.5)"), "materials[\"it\"].Mix.b", &["there is no material \"grin\"", "did you mean \"grün\"?"]),
        bad(material("Mix(a: §\"it\", b: \"grün\", share: 0.5)"), "materials[\"it\"].Mix.a", &["\"it\" cannot be mixed, because it is a Mix"]),
        bad(material("Mix(a: \"grün\", b: §\"lamp\", share: 0.5), \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1))"), "materials[\"it\"].Mix.b", &["it emits light"]),
        bad(material("Mix(a: \"grün\", b: §\"veil\", share: 0.5), \"veil\": Lambertian(albedo: Rgb(1, 1, 1), alpha: 0.5)"), "materials[\"it\"].Mix.b", &["it has an alpha"]),
        bad(material("Mix(a: \"grün\", b: §\"wine\", share: 0.5), \"wine\": Dielectric(ior: 1.3, absorption: (1, 2, 3))"), "materials[\"it\"].Mix.b", &["it absorbs light inside"]),
        bad(material("Mix(a: \"grün\", b: §\"pane\", share: 0.5), \"pane\": ThinDielectric()"), "materials[\"it\"].Mix.b", &["it is a ThinDielectric"]),
        bad(material("Mix(a: \"grün\", b: \"grün\", share: §2)"), "materials[\"it\"].Mix.share", &["from 0 to 1"]),
        bad(material("§Emissive(emit: Rgb(1, 1, 1))"), "materials[\"it\"]", &["did you mean DiffuseLight("]),
        bad(material("Lambertian(albedo: §(0.7, 0.3, 0.2))"), "materials[\"it\"].Lambertian.albedo", &["a texture: Rgb(r, g, b), Checker(..), Image(..), Noise(..) or Marble(..)", "did you mean Rgb(0.7, 0.3, 0.2)?"]),
        bad(scene(IMAGE, "(look_from: (0, 0, 5), look_at: (0, 0, 0), §fov: 40)", BACKGROUND, ""), "camera.fov", &["did you mean vertical_fov?"]),
        bad(object("Group([]), §Spher(radius: 1)"), "objects[1]", &["an object: Sphere(..), Quad(..)", "did you mean Sphere?"]),
        bad(object("Group([]), Group([Group([]), §3])"), "objects[1].Group[1]", &["an object", "found 3"]),
        bad(object("§Group()"), "objects[0].Group", &["a list of objects", "found Group()"]),
        bad(object("Quad(corner: (0, 0, 0), u: §(0, 0, 0), v: (1, 0, 0), material: \"grey\")"), "objects[0].Quad.u", &["quad", "along u"]),
        bad(object("§Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (-2, 0, 0), material: \"grey\")"), "objects[0].Quad", &["quad", "parallel"]),
        bad(object("§Quad(corner: (0, 0, 0), u: (1e30, 1e30, 0), v: (1e-30, 1e-30, 0), material: \"grey\")"), "objects[0].Quad", &["parallel"]),
        bad(object("§Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (1, 1e-10, 0), material: \"grey\")"), "objects[0].Quad", &["parallel"]),
        bad(object("Disk(center: (0, 0, 0), normal: §(0, 0, 0), radius: 1, material: \"grey\")"), "objects[0].Disk.normal", &["no length"]),
        bad(object("Disk(center: (0, 0, 0), normal: (0, 1, 0), radius: §-1, material: \"grey\")"), "objects[0].Disk.radius", &["radius", "greater than 0"]),
        bad(object("§Disk(center: (0, 0, 0), radius: 1, material: \"grey\")"), "objects[0].Disk.normal", &["normal is missing"]),
        bad(object("Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0), material: §\"wood\")"), "objects[0].Quad.material", &["there is no material \"wood\""]),
        bad(object("§Box(min: (0, 0, 0), max: (1, 1, 0), material: \"grey\")"), "objects[0].Box", &["box", "along z"]),
        bad(object("§Box(min: (0, 2, 0), max: (1, 1, 1), material: \"grey\")"), "objects[0].Box", &["box", "along y", "2.0 and 1.0"]),
        bad(object("Transformed(by: [Scale(§0)], object: Group([]))"), "objects[0].Transformed.by[0].Scale", &["scale", "greater than 0"]),
        bad(object("Transformed(by: [Scale(§-2)], object: Group([]))"), "objects[0].Transformed.by[0].Scale", &["found -2"]),
        bad(object("Transformed(by: [§Scale(1, 2)], object: Group([]))"), "objects[0].Transformed.by[0].Scale", &["a positive number"]),
        bad(object("Transformed(by: [RotateY(1), RotateX(§inf)], object: Group([]))"), "objects[0].Transformed.by[1].RotateX", &["finite"]),
        bad(object("Transformed(by: [Rotate(axis: §(0, 0, 0), degrees: 1)], object: Group([]))"), "objects[0].Transformed.by[0].Rotate.axis", &["no length"]),
        bad(object("Transformed(by: [Translate((1, §NaN, 0))], object: Group([]))"), "objects[0].Transformed.by[0].Translate[1]", &["finite"]),
        bad(object("Transformed(by: [Translate(§1, 2, 3)], object: Group([]))"), "objects[0].Transformed.by[0].Translate[0]", &["Translate((x, y, z))"]),
        bad(object("Transformed(by: [§RotateW(1)], object: Group([]))"), "objects[0].Transformed.by[0]", &["a transform", "did you mean Rotate"]),
        bad(object("Transformed(by: §Scale(2), object: Group([]))"), "objects[0].Transformed.by", &["a list of transforms"]),
        bad(object("§Transformed(by: [])"), "objects[0].Transformed.object", &["object is missing", "an object"]),
        bad(object("Transformed(by: [Scale(1e60)], object: Transformed(by: [§Scale(1e60)], object: Group([])))"), "objects[0].Transformed.object.Transformed.by[0]", &["1e100"]),
        bad(object("Transformed(by: [Scale(1e60)], object: §Sphere(center: (0, 0, 1e60), radius: 1, material: \"grey\"))"), "objects[0].Transformed.object.Sphere", &["1e100"]),
        bad(object("Transformed(by: [Scale(1e-60)], object: Group([§Box(min: (0, 0, 0), max: (1e-60, 1, 1), material: \"grey\")]))"), "objects[0].Transformed.object.Group[0].Box", &["1e-100"]),
        bad(object("Group([Mesh(path: §\"bunny.ply\", material: \"grey\")])"), "objects[0].Group[0].Mesh.path", &["folder/bunny.ply", "cannot read the mesh"]),
        bad(object("Mesh(path: §\"bunny.fbx\", material: \"grey\")"), "objects[0].Mesh.path", &["folder/bunny.fbx", ".obj, .ply, .stl, .gltf or .glb"]),
        bad(object("Mesh(path: §\"\", material: \"grey\")"), "objects[0].Mesh.path", &[".obj, .ply, .stl, .gltf or .glb"]),
        bad(object("§Mesh(path: \"bunny.ply\")"), "objects[0].Mesh.material", &["material is missing", "\"grey\""]),
        bad(object("Mesh(path: \"bunny.ply\", material: §\"gray\")"), "objects[0].Mesh.material", &["did you mean \"grey\"?"]),
        bad(object("§Mesh(material: \"grey\")"), "objects[0].Mesh.path", &["path is missing", "a file's path in quotes"]),
        // Motion.
        bad(moving("§[]"), "objects[0].Moving.keys", &["there is no key", "[(0, [Translate((0, 0, 0))])"]),
        bad(moving("[(1, [Scale(1)]), (§0, [Scale(2)])]"), "objects[0].Moving.keys[1][0]", &["in the order of their times", "found 0 after 1"]),
        bad(moving("[(0, [Scale(1)]), (1, §[RotateX(2)])]"), "objects[0].Moving.keys[1][1]", &["[Scale], found [RotateX]"]),
        bad(moving("[(0, [Scale(1)]), (1, [Scale(§0)])]"), "objects[0].Moving.keys[1][1][0].Scale", &["greater than 0"]),
        bad(moving("[(§1e10, [Scale(1)])]"), "objects[0].Moving.keys[0][0]", &["a time from -1e9 to 1e9"]),
        bad(lens("shutter: §(1, 0)"), "camera.shutter", &["closes at 0, before it opens at 1"]),
        bad(lens("shutter: (0, §1e10)"), "camera.shutter[1]", &["a time from -1e9 to 1e9"]),
        bad(lens("moving: [(0, (look_from: (0, 0, 5), look_at: (0, 0, 0))), (1, §(look_from: (0, 0, -5), look_at: (0, 0, 0)))]"), "camera.moving[1][1]", &["parallel to up", "add a key"]),
        bad(lens("moving: [(0, §(look_from: (0, 0, 5)))]"), "camera.moving[0][1].look_at", &["look_at is missing", "a point: (x, y, z)"]),
        // Media.
        bad(boundary("§Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0))"), "objects[0].Medium.boundary", wanted),
        bad(boundary("§Group([Sphere(center: (0, 0, 0), radius: 1)])"), "objects[0].Medium.boundary", wanted),
        bad(boundary("§Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1))"), "objects[0].Medium.boundary", wanted),
        bad(boundary("Transformed(by: [], object: Transformed(by: [], object: §Group([])))"), "objects[0].Medium.boundary.Transformed.object.Transformed.object", wanted),
        bad(boundary("Transformed(by: [Scale(§0)], object: Sphere(center: (0, 0, 0), radius: 1))"), "objects[0].Medium.boundary.Transformed.by[0].Scale", &["greater than 0"]),
        bad(boundary("Sphere(center: (0, 0, 0), radius: §0)"), "objects[0].Medium.boundary.Sphere.radius", &["radius"]),
        bad(boundary("§Box(min: (0, 0, 0), max: (1, 1, 0))"), "objects[0].Medium.boundary.Box", &["along z"]),
        bad(boundary("Sphere(center: (0, 0, 0), radius: 1, material: §\"grey\")"), "objects[0].Medium.boundary.Sphere.material", &["boundary has no surface", "remove the material"]),
        bad(boundary("Transformed(by: [Scale(2)], object: Box(min: (0, 0, 0), max: (1, 1, 1), material: §\"no such\"))"), "objects[0].Medium.boundary.Transformed.object.Box.material", &["boundary has no surface"]),
        bad(boundary("Transformed(by: [Scale(1e60)], object: §Sphere(center: (0, 0, 1e60), radius: 1))"), "objects[0].Medium.boundary.Transformed.object.Sphere", &["1e100"]),
        bad(boundary("Mesh(path: §\"fog.ply\")"), "objects[0].Medium.boundary.Mesh.path", &["folder/fog.ply", "cannot read the mesh"]),
        bad(boundary("§3"), "objects[0].Medium.boundary", &["a boundary: a Sphere(..), a Box(..) or a closed Mesh(..)", "found 3"]),
        bad(medium("density: §-1, albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["a density of 0 or greater than 0", "found -1"]),
        bad(medium("density: §NaN, albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["density", "found NaN"]),
        bad(medium("density: §inf, albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["1e-100 to 1e100", "found inf"]),
        bad(medium("density: §1e-101, albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["1e-100 to 1e100"]),
        bad(medium("density: 1, albedo: Rgb(1, §1.5, 1)"), "objects[0].Medium.albedo.Rgb[1]", &["an albedo from 0 to 1"]),
        bad(medium("density: 1, albedo: §Image(path: \"none.png\")"), "objects[0].Medium.albedo", &["no texture coordinates inside a medium"]),
        bad(medium("density: 1, albedo: Noise(scale: §0)"), "objects[0].Medium.albedo.Noise.scale", &["scale"]),
        bad(medium("density: 1, albedo: Rgb(1, 1, 1), anisotropy: §1"), "objects[0].Medium.anisotropy", &["between -1 and 1", "found 1"]),
        bad(medium("density: 1, albedo: Rgb(1, 1, 1), anisotropy: §-1.0"), "objects[0].Medium.anisotropy", &["between -1 and 1"]),
        bad(medium("density: 1, albedo: Rgb(1, 1, 1), anisotropy: §NaN"), "objects[0].Medium.anisotropy", &["found NaN"]),
        bad(object("§Medium(density: 1, albedo: Rgb(1, 1, 1))"), "objects[0].Medium.boundary", &["boundary is missing"]),
        bad(object("§Medium(density: Height(scale_height: 1, at: 0, density: 1), albedo: Rgb(1, 1, 1))"), "objects[0].Medium.boundary", &["boundary is missing", "a Grid(..) has a box"]),
        bad(medium("density: Height(scale_height: §0, at: 0, density: 1), albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density.Height.scale_height", &["scale_height", "greater than 0"]),
        bad(medium("density: §\"thick\", albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["a number, Height(..) or Grid(..)", "found \"thick\""]),
        bad(medium("density: §Grid(pth: \"a.vdb\"), albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density", &["a number, Height(..) or Grid(..)"]),
        bad(medium("density: Grid(path: §\"none.vdb\"), albedo: Rgb(1, 1, 1)"), "objects[0].Medium.density.Grid.path", &["folder/none.vdb", "cannot read the grid"]),
        bad(medium("density: 1, albedo: Rgb(1, 1, 1), emission: (1, §-1, 0)"), "objects[0].Medium.emission[1]", &["radiance", "found -1"]),
        bad(medium("density: 1, albedo: Rgb(1, 1, 1), emission: Blackbody(path: \"a.vdb\", at: §100)"), "objects[0].Medium.emission.Blackbody.at", &["from 500 to 40000"]),
        // The file.
        bad(rest("render: (samples: §0)"), "render.samples", &["from 1 to 2147483648"]),
        bad(rest("render: (samples: §2147483649)"), "render.samples", &["found 2147483649"]),
        bad(rest("render: (max_depth: §1000001)"), "render.max_depth", &["from 0 to 1000000"]),
        bad(rest("render: (§spp: 1)"), "render.spp", &["samples, max_depth"]),
        bad(rest("§objetcs: []"), "objetcs", &["image, camera, background, materials, objects, render", "did you mean objects?"]),
        bad(rest("materials: §[]"), "materials", &["a map of materials", "found []"]),
        bad(rest("§objects: []"), "objects", &["given twice"]),
        bad(format!("§Scene(image: {IMAGE}, camera: {CAMERA}, background: {BACKGROUND})"), "objects", &["objects is missing", "a list of objects"]),
        bad(rest(") §x ("), "Scene", &["the end of the file"]),
        bad("§", "Scene", &["empty"]),
        bad("§\n\n  // nothing but a remark\n", "Scene", &["empty"]),
        bad("\n  §[]", "Scene", &["Scene(image: .., camera: ..", "found []"]),
        bad("§Scene", "Scene", &["Scene(image: .."]),
        bad("§scene(image: 1)", "Scene", &["Scene(image: .."]),
        bad("#![enable(§nothing)]\n()", "Scene", &["no extension nothing"]),
        bad("(image: (width: 4,\n height: 3§", "image", &["the file ends", "the ( of line 1, column 9"]),
        bad("(image: (width: 4, height: 3)\n§", "Scene", &["the file ends", "line 1, column 1"]),
        bad("§/* one /* two */ ", "Scene", &["comment is not closed"]),
    ]
}

/// And the comparison rejects another location, field or word.
#[test]
fn every_error_has_its_location_field_and_words() {
    let path = Path::new(FILE);
    let cases = all_bad();
    assert!(cases.len() >= 60);
    for (text, field, words) in cases {
        let Err(error) = parse(&unmarked(&text)) else {
            panic!("accepted: {text}");
        };
        assert_eq!(compare(&error, path, &text, field, words), Ok(()), "{text}");
        for (path, text, field, words) in [
            (Path::new("other.ron"), text.clone(), field.to_owned(), words),
            (path, format!("\n{text}"), field.to_owned(), words),
            (path, text.replace(MARK, " §"), field.to_owned(), words),
            (path, text.clone(), format!("{field}x"), words),
            (path, text.clone(), field.to_owned(), &["no message says this"]),
        ] {
            assert!(
                compare(&error, path, &text, &field, words).is_err(),
                "{text}, {field}, {words:?} passed for {error}"
            );
        }
    }
    assert!(compare(&Error::Usage("unrelated".to_owned()), path, "§", "Scene", &[]).is_err());
}

/// A scene with every feature of the format that can be built, and RON's own freedoms with it.
const GOOD: &str = r##"#![enable(implicit_some)]
// A remark before the scene, with brackets: ((([[[{{{ and a quote: "
Scene(
    image: (width: 64, height: 48,),
    camera: (look_from: (13, 2, 3), look_at: (0, -0.5, +1e-3), up: (0, 1, 0), vertical_fov: 20,
             aperture: 0.1, focus_distance: 1_0.0),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)), /* one /* two */ ) one */
    materials: {
        "ground": Lambertian(albedo: Checker(scale: 0.32, even: (0.2, 0.3, 0.1), odd: (0.9, 0.9, 0.9))),
        "steel":  Metal(albedo: Rgb(0.7, 0.6, 0.5), fuzz: 0.1),
        "mirror": Metal(albedo: Rgb(0, 1, 1)),
        "glass":  Dielectric(ior: 1.5),
        r#"air "in" glass"#: Dielectric(ior: 0.666),
        "lamp é":   DiffuseLight(emit: Rgb(15, 15, 15)),
        "one \"side\"": DiffuseLight(emit: Checker(scale: 1, even: (0, 0, 0), odd: (4, 4, 4)), two_sided: false),
        "cloud": Lambertian(albedo: Noise(scale: 4)),
        "marble": Lambertian(albedo: Marble(scale: 4.5)),
    },
    objects: [
        Sphere(center: (0, -1000, 0), radius: 1000, material: "ground"),
        Quad(corner: (113, 554, 432), u: (0, 0, -305), v: (330, 0, 0), material: Some("lamp é")),
        Box(min: (0, 0, 0), max: (1, 1, 1), material: "steel"),
        Transformed(
            by: [Scale(2), RotateX(1), RotateY(15), RotateZ(-3),
                 Rotate(axis: (1, 2, 3), degrees: 45), Translate((265, 0, 295))],
            object: Group([
                Box(min: (-1, -1, -1), max: (-0.5, 1, 1), material: r#"air "in" glass"#),
                Group([]),
                Transformed(by: [], object: Sphere(center: (1, 1, 1), radius: 0.5, material: "one \"side\"")),
            ]),
        ),
        Group([Sphere(center: (1, 1, 1), radius: 1e-3, material: "glass",),],),
    ],
    render: (samples: 500, max_depth: 0),
)
// the end"##;

/// A group is named so that a layer can be; there are eight beside that of the background.
#[test]
fn light_groups_are_names_of_layers() {
    let lamps = |names: &[&str]| {
        let lamp = |(index, name): (usize, &&str)| {
            format!("\"lamp {index}\": DiffuseLight(emit: Rgb(1, 1, 1), light_group: \"{name}\"),\n")
        };
        GOOD.replace(
            "    materials: {\n",
            &format!("    materials: {{\n{}", names.iter().enumerate().map(lamp).collect::<String>()),
        )
    };
    let eight = ["a", "b", "c c", "d", "e", "f", "g", "é"];
    let parsed = parse(&lamps(&[&eight[..], &["background", "a"]].concat())).unwrap();
    assert_eq!(gpu_rt::scene::light_groups::names(&parsed), ["a", "b", "background", "c c", "d", "e", "f", "g", "é"]);
    for (names, words) in [
        (&[&eight[..], &["h"]].concat()[..], "at most 8 light groups"),
        (&["a.b"], "a name of 1 to 200 bytes"),
        (&["a=1"], "a name of 1 to 200 bytes"),
        (&["rest"], "other than \"rest\""),
        (&[""], "a name of 1 to 200 bytes"),
        (&[&*"x".repeat(201)], "a name of 1 to 200 bytes"),
    ] {
        let message = parse(&lamps(names)).unwrap_err().to_string();
        assert!(message.contains("light_group") && message.contains(words), "{message}");
    }
    let point = GOOD.replace(
        "    objects: [\n",
        "    objects: [\nPointLight(at: (0, 9, 0), intensity: (1, 1, 1), light_group: \"a,b\"),\n",
    );
    let message = parse(&point).unwrap_err().to_string();
    assert!(message.contains("PointLight.light_group") && message.contains("a name of"), "{message}");
}

#[test]
fn every_feature_of_the_format_parses() {
    let scene = parse(GOOD).unwrap();
    assert_eq!((scene.image.width, scene.image.height), (64, 48));
    assert_eq!(scene.camera.look_at.to_array(), [0.0, -0.5, 1e-3]);
    assert_eq!(scene.camera.focus_distance, Some(10.0));
    assert_eq!((scene.render.samples, scene.render.max_depth), (500, 0));
    assert!(matches!(scene.background, Background::Gradient { .. }));
    let names: Vec<&str> = scene.materials.iter().map(|(name, _)| name.as_str()).collect();
    let in_order = "ground|steel|mirror|glass|air \"in\" glass|lamp é|one \"side\"|cloud|marble";
    assert_eq!(names.join("|"), in_order);
    let mirror = Material::Metal(Metal { albedo: Texture::Rgb(0.0, 1.0, 1.0), fuzz: 0.0, one_sided: false });
    assert_eq!(scene.materials[2].1, mirror);
    assert!(matches!(scene.materials[5].1, Material::DiffuseLight(DiffuseLight { two_sided: true, .. })));
    assert!(matches!(scene.materials[6].1, Material::DiffuseLight(DiffuseLight { two_sided: false, .. })));
    let Object::Transformed { by, object } = &scene.objects[3] else {
        panic!("{:?}", scene.objects[3]);
    };
    assert_eq!(by.len(), 6);
    assert_eq!(by[2], Transform::RotateY(15.0));
    assert!(matches!(&**object, Object::Group(objects) if objects.len() == 3));
    assert_locations_hold(&scene, GOOD);
}

/// Every object and material stands where the scene says it does.
fn assert_locations_hold(scene: &Scene, text: &str) {
    let lines: Vec<&str> = text.split('\n').collect();
    let check = |at: Location, name: &str| {
        let rest: String = lines[at.line - 1].chars().skip(at.column - 1).collect();
        assert!(rest.starts_with(name), "no {name} at {at}:\n{text}");
    };
    for (index, object) in scene.objects.iter().enumerate() {
        check(scene.location(&[Step::Field("objects"), Step::Index(index)]), object.name());
    }
    for (name, material) in &scene.materials {
        check(scene.material_location(name), material.name());
    }
}

#[test]
fn locations_inside_objects_are_found() {
    let scene = parse(GOOD).unwrap();
    let steps = [
        Step::Field("objects"),
        Step::Index(3),
        Step::Variant("Transformed"),
        Step::Field("object"),
        Step::Variant("Group"),
        Step::Index(2),
        Step::Variant("Transformed"),
        Step::Field("object"),
        Step::Variant("Sphere"),
        Step::Field("radius"),
    ];
    let at = scene.location(&steps);
    let line = GOOD.lines().nth(at.line - 1).unwrap();
    let rest: String = line.chars().skip(at.column - 1).collect();
    assert!(rest.starts_with("0.5, material"), "{at}");
    let error = scene.error(&steps, "is too small").to_string();
    let field = "objects[3].Transformed.object.Group[2].Transformed.object.Sphere.radius";
    assert_eq!(error, format!("{FILE}:{}:{}: {field}: is too small", at.line, at.column));
    // A missing value has the location of what is around it.
    assert_eq!(scene.location(&[]).line, 3);
    let camera = scene.location(&[Step::Field("camera")]);
    assert_eq!(scene.location(&[Step::Field("camera"), Step::Field("roll")]), camera);
    assert_eq!(scene.location(&[Step::Field("objects"), Step::Index(99)]), scene.location(&[Step::Field("objects")]));
}

#[test]
fn line_ends_byte_order_marks_and_struct_names_do_not_matter() {
    let plain = parse(GOOD).unwrap();
    let windows = GOOD.replace('\n', "\r\n");
    let marked = format!("\u{feff}{GOOD}");
    let named = GOOD
        .replace("image: (", "image: ImageSize(")
        .replace("camera: (", "camera: Camera (")
        .replace("render: (", "render: /* defaults */ RenderDefaults(");
    let nameless = GOOD.replace("Scene(", "(");
    for text in [windows, marked, named, nameless] {
        let scene = parse(&text).unwrap();
        assert_eq!(scene.objects, plain.objects);
        assert_eq!(scene.materials, plain.materials);
        assert_eq!(scene.camera, plain.camera);
        assert_locations_hold(&scene, text.trim_start_matches('\u{feff}'));
    }
    // The byte order mark takes no column, and a struct's name is no part of a field's path.
    let error = parse("\u{feff}(imag: 1)").unwrap_err().to_string();
    assert!(error.starts_with("folder/scene.ron:1:2: imag: "), "{error}");
    let error = parse("Scene(image: ImageSize(width: x))").unwrap_err().to_string();
    assert!(error.contains("folder/scene.ron:1:31: image.width: "), "{error}");
}

#[test]
fn absent_fields_have_their_defaults() {
    let scene = parse(&scene(IMAGE, CAMERA, BACKGROUND, "")).unwrap();
    assert_eq!(scene.camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!((scene.camera.aperture, scene.camera.focus_distance), (0.0, None));
    assert_eq!((scene.render.samples, scene.render.max_depth), (100, 50));
    assert!(scene.materials.is_empty() && scene.objects.is_empty() && scene.bitmaps.is_empty());
}

#[test]
#[rustfmt::skip]
fn numbers_at_the_ends_of_their_ranges_are_accepted() {
    let cases = [
        scene("(width: 65536, height: 16384)", CAMERA, BACKGROUND, ""),
        scene("(width: 1, height: 65536)", CAMERA, BACKGROUND, ""),
        scene(IMAGE, CAMERA, "Solid((0, 1e-30, 1e30))", ""),
        scene(IMAGE, CAMERA, BACKGROUND, "render: (samples: 2147483648, max_depth: 1000000)"),
        scene(IMAGE, "(look_from: (1e8, 0, 5), look_at: (1e8, 0, 0), vertical_fov: 179.9)", BACKGROUND, ""),
        material("Dielectric(ior: 0.01)"),
        material("Metal(albedo: Rgb(0, 0, 0), fuzz: 1)"),
        object("Sphere(center: (1e99, 0, 0), radius: 1e-100, material: \"grey\")"),
        object("Sphere(center: (0, 0, 0), radius: 1e100, material: \"grey\")"),
        object("Quad(corner: (0, 0, 0), u: (1e30, 0, 0), v: (0, 1e-30, 0), material: \"grey\")"),
        object("Quad(corner: (0, 0, 0), u: (1e-30, 0, 0), v: (1e-30, 1e-38, 0), material: \"grey\")"),
        object("Box(min: (-1e-90, 0, 0), max: (0, 1e-90, 1e90), material: \"grey\")"),
        object("Transformed(by: [Scale(1e90), Scale(1e-90)], object: Group([]))"),
        object("Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 0, albedo: Rgb(0, 1, 0), anisotropy: -0.999)"),
        object("Group([Transformed(by: [Scale(2)], object: Medium(boundary: Transformed(by: [RotateX(3)], object: Box(min: (0, 0, 0), max: (1, 1, 1))), density: 1e100, albedo: Marble(scale: 1)))])"),
    ];
    for text in cases {
        if let Err(error) = parse(&text) {
            panic!("{error}\n{text}");
        }
    }
}

#[test]
fn warnings_name_the_location_and_the_number() {
    let warnings = |text: &str| parse(text).unwrap().warnings();
    assert_eq!(warnings(&material("Lambertian(albedo: Rgb(0.5, 0.5, 0.5))")).len(), 1);
    let near = warnings(&material("Dielectric(ior: 1.0000001)"));
    assert_eq!(near.len(), 2, "{near:?}");
    assert!(near[0].starts_with("folder/scene.ron:5:26: materials[\"grün\"]: no object uses"), "{near:?}");
    let ior = "folder/scene.ron:5:70: materials[\"it\"].Dielectric.ior: an ior of 1.0000001";
    assert!(near[1].starts_with(ior), "{near:?}");
    assert_eq!(warnings(&material("Dielectric(ior: 1)")).len(), 1);
    // As near on either side.
    for (ior, count) in [("0.999999", 2), ("1.000001", 2), ("0.9999989", 1), ("1.0000011", 1)] {
        let found = warnings(&material(&format!("Dielectric(ior: {ior})")));
        assert_eq!(found.len(), count, "{found:?}");
    }
    let white = warnings(&material("Metal(albedo: Rgb(0.5, 1, 0.5))"));
    assert!(white[1].contains("Metal.albedo: an albedo of 1"), "{white:?}");
    let medium = |density: &str| {
        let boundary = "Sphere(center: (0, 0, 0), radius: 1)";
        warnings(&object(&format!("Medium(boundary: {boundary}, density: {density}, albedo: Rgb(1, 1, 1))")))
    };
    assert_eq!(medium("0").len(), medium("1").len() + 1);
    let nothing = "folder/scene.ron:7:73: objects[0].Medium.density: a density of 0 means";
    assert!(medium("0.0").iter().any(|warning| warning.starts_with(nothing)), "{:?}", medium("0"));
    let empty = warnings(&scene(IMAGE, CAMERA, BACKGROUND, ""));
    assert!(empty[0].starts_with("folder/scene.ron:5:12: objects: there are 0 objects"), "{empty:?}");
}

#[test]
fn files_that_cannot_be_read_have_a_location() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    for path in [folder.path().join("missing.ron"), folder.path().to_owned()] {
        let error = Scene::load(&path).unwrap_err();
        assert!(
            error.to_string().starts_with(&format!("{}: Scene: cannot read the scene file: ", path.display())),
            "{error}"
        );
        assert_eq!(error.exit_status(), 2);
    }
    let cases = [
        (write("empty.ron", b""), "§", "empty"),
        (write("space.ron", b" \n\t\r\n"), "§", "empty"),
        (write("latin.ron", b"(\n  // caf\xe9"), "(\n  // caf§", "UTF-8"),
        (write("utf16.ron", b"\xff\xfe(\0"), "§", "UTF-8"),
    ];
    for (path, text, word) in cases {
        let error = Scene::load(&path).unwrap_err();
        assert_eq!(compare(&error, &path, text, "Scene", &[word]), Ok(()));
        assert_eq!(error.exit_status(), 2);
    }
    let good = write("good.ron", GOOD.as_bytes());
    assert_eq!(Scene::load(&good).unwrap().objects.len(), 5);
}

/// A scene whose material "it" or background names `file`, at the mark.
fn naming(file: &str, value: &str) -> String {
    let image = format!("Image(path: §{file:?})");
    match value {
        "background" => scene(IMAGE, CAMERA, &image, ""),
        value => material(&value.replace("..", &image)),
    }
}

/// The error, or the decoded image, of that scene.
fn with_image(folder: &Path, file: &str, value: &str) -> Result<Bitmap, Error> {
    let scene = Scene::parse(&unmarked(&naming(file, value)), &folder.join("scene.ron"))?;
    Ok(scene.bitmaps.colours(file).expect("it is loaded").clone())
}

const ALBEDO: &str = "Lambertian(albedo: ..)";
const EMIT: &str = "DiffuseLight(emit: ..)";

#[test]
fn images_become_linear() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // One row of black, middle grey and white, in every way that it may be written.
    let grey8 = image::GrayImage::from_raw(3, 1, vec![0, 188, 255]).unwrap();
    let grey16 = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(3, 1, vec![0, 188 * 257, 65535]);
    let floats = vec![0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0];
    let float = image::Rgb32FImage::from_raw(3, 1, floats).unwrap();
    grey8.save(at("grey8.png")).unwrap();
    image::DynamicImage::from(grey8.clone()).to_rgba8().save(at("rgba8.tga")).unwrap();
    image::DynamicImage::from(grey8).to_rgb8().save(at("rgb8.bmp")).unwrap();
    grey16.unwrap().save(at("grey16.png")).unwrap();
    float.save(at("float.hdr")).unwrap();
    let texel = |x: usize, _: usize| [(0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)][x];
    exr::prelude::write_rgb_file(at("float.exr"), 3, 1, texel).unwrap();
    let coded = 0.502_886_5;
    let cases = [
        ("grey8.png", coded),
        ("rgba8.tga", coded),
        ("rgb8.bmp", coded),
        ("grey16.png", coded),
        ("float.hdr", 0.5),
        ("float.exr", 0.5),
    ];
    for (file, grey) in cases {
        for value in [ALBEDO, EMIT, "background"] {
            let bitmap = with_image(folder.path(), file, value).unwrap();
            assert_eq!((bitmap.width, bitmap.height), (3, 1), "{file}");
            for (texel, light) in bitmap.texels().zip([0.0, grey, 1.0]) {
                assert!(texel.iter().all(|c| (c - light).abs() < 1e-6), "{file}: {texel:?}");
            }
        }
    }
    // Row 0 is on top.
    let rows = |_: usize, y: usize| [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)][y];
    exr::prelude::write_rgb_file(at("rows.exr"), 1, 2, rows).unwrap();
    let bitmap = with_image(folder.path(), "rows.exr", ALBEDO).unwrap();
    assert!(bitmap.texels().eq([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
}

#[test]
fn images_that_cannot_be_used_are_refused_at_their_path() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let texel = |value: f32| move |x: usize, y: usize| (0.5, if (x, y) == (1, 2) { value } else { 0.5 }, 0.5);
    exr::prelude::write_rgb_file(at("negative.exr"), 3, 4, texel(-1.0)).unwrap();
    exr::prelude::write_rgb_file(at("nan.exr"), 3, 4, texel(f32::NAN)).unwrap();
    exr::prelude::write_rgb_file(at("bright.exr"), 3, 4, texel(2.0)).unwrap();
    exr::prelude::write_rgb_file(at("huge.exr"), 3, 4, texel(2e30)).unwrap();
    exr::prelude::write_rgb_file(at("wide.exr"), 16385, 1, |_, _| (0.0f32, 0.0, 0.0)).unwrap();
    image::GrayImage::new(1, 16385).save(at("tall.png")).unwrap();
    let mut cut = fs::read(at("bright.exr")).unwrap();
    cut.truncate(cut.len() - 9);
    fs::write(at("cut.exr"), cut).unwrap();
    fs::write(at("text.png"), "no image").unwrap();
    fs::write(at("text.txt"), "no image").unwrap();
    fs::write(at("empty.jpg"), "").unwrap();
    let of_texel = "at texel (1, 2) from the top left";
    let cases: [(&str, &str, &[&str]); 12] = [
        ("missing.png", ALBEDO, &["missing.png", "cannot read the image"]),
        (".", ALBEDO, &["not a file"]),
        ("", "background", &["not a file"]),
        ("text.png", ALBEDO, &["text.png", "cannot decode the image"]),
        ("text.txt", ALBEDO, &["text.txt", "format is not known"]),
        ("empty.jpg", EMIT, &["empty.jpg", "cannot decode the image"]),
        ("cut.exr", EMIT, &["cut.exr", "cannot decode the image"]),
        ("wide.exr", "background", &["wide.exr", "16384", "16385 by 1"]),
        ("tall.png", ALBEDO, &["tall.png", "16384", "1 by 16385"]),
        ("bright.exr", ALBEDO, &["albedo", "(0.5, 2.0, 0.5)", of_texel]),
        ("bright.exr", "Metal(albedo: ..)", &["albedo", of_texel]),
        ("huge.exr", EMIT, &["1e30", of_texel]),
    ];
    for (file, value, words) in cases {
        let field = match value {
            "background" => "background.Image.path".to_owned(),
            value => format!("materials[\"it\"].{}.Image.path", value.replace('(', ".").replace(": ..)", "")),
        };
        let error = with_image(folder.path(), file, value).unwrap_err();
        assert_eq!(compare(&error, &at("scene.ron"), &naming(file, value), &field, words), Ok(()), "{file} {value}");
    }
    // What is no light counts as 0.
    for (file, value) in [("negative.exr", ALBEDO), ("negative.exr", "background"), ("nan.exr", EMIT)] {
        let bitmap = with_image(folder.path(), file, value).expect("it is read");
        assert_eq!(bitmap.texel(7), [0.5, 0.0, 0.5], "{file} {value}");
        assert!(bitmap.warning.is_some_and(|warning| warning.starts_with("1 of 12 texels")), "{file} {value}");
    }
    // More than 1 is no fault of a light.
    assert!(with_image(folder.path(), "bright.exr", EMIT).is_ok());
}

/// Nested objects, each of them inside the one before.
fn nested(before: &str, after: &str, depth: usize) -> String {
    object(&format!("{}Group([]){}", before.repeat(depth), after.repeat(depth)))
}

#[test]
fn deep_nesting_is_an_error_and_no_crash() {
    let nests = [("Group([", "])"), ("Transformed(by: [], object: ", ")")];
    for (before, after) in nests {
        assert!(parse(&nested(before, after, 50)).is_ok());
        for depth in [100, 1000, 200_000] {
            for after in [after, ""] {
                let error = parse(&nested(before, after, depth)).unwrap_err().to_string();
                assert!(error.starts_with("folder/scene.ron:7:"), "{error}");
                assert!(error.contains(": objects[0]: nested too deeply"), "{error}");
            }
        }
    }
    let pieces = ["(", "[", "{", "/*", "Some(", "((", "a:(", "r#", "\"\\", ")", "]", "#", "[(", "-", "é"];
    for piece in pieces {
        let text = piece.repeat(200_000);
        let texts = [object(&text), material(&text), scene(&text, CAMERA, &text, "")];
        for text in texts.into_iter().chain([text]) {
            assert_inside(&parse(&text).unwrap_err(), &text);
        }
    }
}

/// An error's location is inside the text, or just past the end of its line.
fn assert_inside(error: &Error, text: &str) {
    for error in error.each() {
        let Error::Scene { location, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(location.file, Path::new(FILE));
        let line = text.split('\n').nth(location.line.wrapping_sub(1));
        let columns = 1..=line.map_or(0, |line| line.chars().count() + 1);
        assert!(columns.contains(&location.column), "{error}\n{text}");
    }
}

#[test]
fn no_mutated_scene_panics_or_loses_its_location() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..20_000 {
        let bytes = mutated(GOOD.as_bytes(), GOOD.as_bytes(), 0, &mut random);
        let text = String::from_utf8_lossy(&bytes);
        let unmarked = text.strip_prefix('\u{feff}').unwrap_or(&text);
        match parse(&text) {
            Ok(scene) => {
                assert_locations_hold(&scene, unmarked);
                assert!(scene.warnings().iter().all(|warning| warning.starts_with(FILE)));
                accepted += 1;
            }
            Err(error) => {
                assert_inside(&error, unmarked);
                refused += 1;
            }
        }
    }
    // Both sides of the fence were seen.
    assert!(accepted > 500 && refused > 5_000, "{accepted} accepted, {refused} refused");
}

/// Angles in radians get a warning at their location, and angles in degrees are not.
#[test]
fn angles_that_are_surely_radians_are_warned_of() {
    let turned = |angle: &str| {
        let by = format!("RotateX({angle}), RotateY({angle}), Rotate(axis: (1, 0, 0), degrees: {angle}), RotateZ(30)");
        let sphere = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")";
        let text = object(&format!("Transformed(by: [{by}], object: {sphere})"));
        let text = text
            .replace(", \"été\": Dielectric(ior: 1.5)", "")
            .replace("vertical_fov: 40", &format!("vertical_fov: {angle}"));
        (parse(&unmarked(&text)).unwrap().warnings(), text)
    };
    let (warnings, text) = turned("§0.69813");
    let fields = ["camera.vertical_fov", "by[0].RotateX", "by[1].RotateY", "by[2].Rotate.degrees"];
    assert_eq!(warnings.len(), fields.len(), "{warnings:#?}");
    for ((warning, field), (line, column)) in warnings.iter().zip(fields).zip(marks(&text)) {
        assert!(warning.starts_with(&format!("{FILE}:{line}:{column}: ")) && warning.contains(field), "{warning}");
        assert!(
            warning.ends_with("0.69813 is 40 degrees in radians, and angles are in degrees: write 40"),
            "{warning}"
        );
    }
    for angle in ["40", "0.698", "0.69823", "45.5"] {
        assert_eq!(turned(angle).0, Vec::<String>::new());
    }
}

// All errors of a scene

/// The lines and columns of all marks.
fn marks(text: &str) -> Vec<(usize, usize)> {
    let lines = text.split('\n').enumerate();
    let of_line = |(number, line): (usize, &str)| {
        let starts = line.split(MARK).scan(1, |column, part| {
            *column += part.chars().count();
            Some((number + 1, *column))
        });
        let starts: Vec<_> = starts.collect();
        starts[..starts.len() - 1].to_vec()
    };
    lines.flat_map(of_line).collect()
}

/// The locations of the errors of a text, which are at its marks and nowhere else.
#[track_caller]
fn all_at_marks(text: &str) -> Error {
    let error = parse(&unmarked(text)).expect_err("the scene is bad");
    let location = |error: &Error| match error {
        Error::Scene { location, .. } => (location.line, location.column),
        other => panic!("{other}"),
    };
    assert_eq!(error.each().iter().map(location).collect::<Vec<_>>(), marks(text), "{error}");
    error
}

/// Wrong types, unknown, missing and repeated fields, ranges, references and files, in the file's order, and nothing that only follows from
/// another error.
#[test]
fn all_errors_of_a_scene_are_listed() {
    all_at_marks(
        "(
    image: (width: 4, height: §3.5),
    camera: (look_from: (0, 0, §\"5\"), §lookat: (0, 0, 0), vertical_fov: §fast),
    background: Solid(§(1, 1)),
    render: (samples: §0),
    materials: {
        \"grey\": Lambertian(albedo: Rgb(0.5, §1.5, 0.5)),
        \"blue\": Lambertian(albedo: Rgb(§blue, 0, 0)),
        \"image\": Lambertian(albedo: Image(path: §\"gone.png\")),
        §\"grey\": Dielectric(ior: 1.5),
    },
    objects: [
        Sphere(center: (0, 0, 0), radius: §-1, material: §\"gray\"),
        Sphere(center: (0, 0, 0), §radus: 1, material: \"blue\"),
        §Sphere(center: (0, 0, 0), material: \"blue\"),
        §Ball(radius: 1), /* a comment */
        Group([
            Transformed(by: [RotateX(§up), Scale(2)], object: Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")),
            Mesh(path: §\"gone.ply\", material: \"blue\"),
            Medium(boundary: §Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0)), density: §-1, albedo: Rgb(§2, 1, 1)),
        ]),
    ],
)
",
    );
}

#[test]
fn sections_that_are_missing_are_listed_too() {
    let error = parse("(camera: (look_from: 1, look_at: (0, 0, 0), vertical_fov: 40))").expect_err("it is bad");
    let fields = error.messages().iter().map(|text| text.split(": ").nth(1).unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(fields, ["image", "background", "objects", "camera.look_from"], "{error}");
    // An unknown field may be among them.
    all_at_marks("(§imag: (width: 4, height: 3), objects: [])");
}

/// Nothing is known of what comes behind it.
#[test]
fn an_error_of_the_notation_is_the_last() {
    let error = all_at_marks(
        &object("Sphere(center: 0, radius: 1, material: \"grey\"), Box(min §(0, 0, 0)), Ball()")
            .replace("center: 0", "center: §0"),
    );
    assert!(error.messages()[1].contains("expected a colon after the name"), "{error}");
}

#[test]
fn at_most_twenty_are_listed() {
    let sphere = |radius: &str| format!("Sphere(center: (0, 0, 0), radius: {radius}, material: \"grey\")");
    let spheres = |count: usize, radius: &str| object(&vec![sphere(radius); count].join(",\n"));
    for radius in ["0", "wide"] {
        let Err(Error::Several { errors, more }) = parse(&spheres(30, radius)) else { panic!("it is bad") };
        assert_eq!(errors.len(), 20);
        // ron's own are not looked for beyond.
        assert_eq!(more, if radius == "0" { 10 } else { 0 });
    }
}

#[test]
fn a_section_with_an_unknown_field_is_not_missing() {
    let good = object("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")");
    for (from, to) in [("vertical_fov: 40)", "vertical_fov: 40, §bokeh: 6)"), ("height: 3)", "height: 3, §bokeh: 6)")]
    {
        assert!(good.contains(from));
        let error = all_at_marks(&good.replace(from, to));
        assert!(error.to_string().contains("unknown field bokeh") && error.each().len() == 1, "{error}");
    }
}

#[test]
fn a_hash_is_no_comment() {
    for text in [
        format!("§# a scene\n{}", object("")),
        object("§# an object\n"),
        object("Sphere(center: (0, 0, 0), radius: 1, §# wide\n material: \"grey\")"),
        object("Sphere(center: (0, 0, 0), radius: §# wide\n 1, material: \"grey\")"),
        object("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\") §# grey\n"),
    ] {
        let error = all_at_marks(&text);
        assert!(error.to_string().ends_with("comments begin with //, found #"), "{error}");
    }
    // A raw string has some, and an extension begins with one.
    let raw = object("Sphere(center: (0, 0, 0), radius: 1, material: r#\"grey\"#)");
    assert!(parse(&raw).is_ok());
    assert!(parse(&format!("#![enable(implicit_some)]\n{raw}")).is_ok());
}
