//! Scenes of pbrt-v4: what directives become, where errors are, and that no text makes the reader panic.

use std::fs;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use gpu_rt::bitmap::Channel;
use gpu_rt::data::luminance;
use gpu_rt::error::Error;
use gpu_rt::scene::{
    Assets, Background, Colour, GltfOptions, Lambertian, Material, Object, Projection, Scene, SkyLayout, Texture,
    Transform,
};
use tempfile::TempDir;

use crate::common::stats::Random;
use crate::mitsuba::mutate;

pub const VIEW: &str = r#"Scale -1 1 1 LookAt 0 0 0 0 0 1 0 1 0 Camera "perspective" "float fov" 90
Film "rgb" "integer xresolution" 40 "integer yresolution" 20 Sampler "halton" "integer pixelsamples" 16 PixelFilter "box"
Integrator "volpath" "integer maxdepth" 4 WorldBegin
"#;
const VIEW_IN_RON: &str = "image: (width: 40, height: 20),
    camera: (look_from: (0, 0, 0), look_at: (0, 0, 1), up: (0, 1, 0), vertical_fov: 90), render: (samples: 16, max_depth: 4),";

pub fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

pub fn load(path: &Path, lossless: bool) -> Result<Scene, Error> {
    let options = GltfOptions { lossless, ..GltfOptions::default() };
    Scene::load_as(path, &options, &mut |_, _, _| {}, &mut Assets::default())
}

pub fn read(text: &str) -> Result<Scene, Error> {
    let folder = folder(&[("a.pbrt", text.as_bytes())]);
    load(&folder.path().join("a.pbrt"), false)
}

/// Errors without the folder of their file.
pub fn error(files: &[(&str, &[u8])]) -> String {
    let folder = folder(files);
    let error = load(&folder.path().join("a.pbrt"), false).expect_err("it is wrong").to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}

/// A scene, and the same in our own form with what is told of it.
type Same = (&'static str, &'static str, &'static [&'static str]);

const SAME: &[Same] = &[
    (
        r#"LightSource "infinite" "rgb L" [0.5 0.25 1]
        MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [0.2 0.3 0.4]
        AttributeBegin NamedMaterial "red" Translate 1 2 3 Shape "sphere" "float radius" 2 AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [1 0 0] "float scale" 2 "bool twosided" true
          Material "diffuse" "rgb reflectance" [0 0 0] Shape "disk" "float radius" 0.5 "float height" 4 AttributeEnd
        LightSource "point" "point3 from" [1 2 3] "rgb I" [1 1 1]
        LightSource "distant" "point3 from" [0 1 0] "point3 to" [0 0 0] "blackbody L" 6500 "float scale" 0"#,
        r#"background: Solid((0.5, 0.25, 1)),
        materials: { "red": Lambertian(albedo: Rgb(0.2, 0.3, 0.4)), "diffuse": DiffuseLight(emit: Rgb(2, 0, 0)) },
        objects: [
            Sphere(center: (1, 2, 3), radius: 2, material: "red"),
            Disk(center: (0, 0, 4), normal: (0, 0, 1), radius: 0.5, material: "diffuse"),
            PointLight(at: (1, 2, 3), intensity: (1, 1, 1)), DirectionalLight(direction: (0, -1, 0), irradiance: (0, 0, 0)),
        ],"#,
        &[],
    ),
    (
        r#"MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [1 1 1] "rgb sigma_s" [1 1 1] "float scale" 2 "float g" 0.25
        MakeNamedMedium "wine" "string type" "homogeneous" "rgb sigma_a" [1 2 3] "rgb sigma_s" [0 0 0]
        AttributeBegin MediumInterface "fog" "" Material "interface" Shape "sphere" AttributeEnd
        AttributeBegin MediumInterface "wine" "" Material "dielectric" "float eta" 1.3 Shape "sphere" AttributeEnd
        Material "conductor" "spectrum eta" "metal-Al-eta" "spectrum k" "metal-Al-k" "float roughness" 0.0625 Shape "disk"
        Material "dielectric" "float roughness" 0.25 "bool remaproughness" false Shape "disk"
        Material "coateddiffuse" "rgb reflectance" [0.2 0.3 0.4] "float thickness" 0 "integer maxdepth" 1000 Shape "disk"
        Material "thindielectric" Shape "disk"
        MakeNamedMaterial "a" "string type" "diffuse" MakeNamedMaterial "b" "string type" "conductor"
        Material "mix" "string materials" ["a" "b"] "float amount" 0.25 Shape "disk""#,
        r#"materials: {
            "dielectric": Dielectric(ior: 1.3, absorption: (1, 2, 3)),
            "conductor": Conductor(eta: (1.6575, 0.8804, 0.52124), k: (9.22381, 6.2695, 4.837), roughness: 0.5),
            "dielectric 2": RoughDielectric(ior: 1.5, roughness: 0.5),
            "coateddiffuse": Plastic(diffuse: Rgb(0.2, 0.3, 0.4), nonlinear: true),
            "thindielectric": ThinDielectric(ior: 1.5, inner_reflections: true),
            "a": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
            "b": Conductor(eta: (0.20101, 0.92375, 1.10222), k: (3.91326, 2.45305, 2.14209)),
            "mix": Mix(a: "a", b: "b", share: 0.25),
        },
        objects: [
            Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 4, albedo: Rgb(0.5, 0.5, 0.5), anisotropy: 0.25),
            Sphere(center: (0, 0, 0), radius: 1, material: "dielectric"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "conductor"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "dielectric 2"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "coateddiffuse"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "thindielectric"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "mix"),
        ],"#,
        &[
            "Material coateddiffuse: its random walk is a closed form here",
            "Camera perspective: it seems to be inside of a medium that it does not name",
        ],
    ),
    (
        r#"LightSource "point" "rgb I" [1 0.25 1] "float power" 12.566370614359172
        LightSource "spot" "float coneangle" 90 "float conedeltaangle" 90 "float power" 3.141592653589793
        LightSource "distant" "point3 from" [0 1 0] "point3 to" [0 0 0] "float illuminance" 3
        LightSource "infinite" "float illuminance" 3.141592653589793
        Texture "m" "spectrum" "mix" "rgb tex1" [1 0 0.5] "rgb tex2" [0 1 0.5] "float amount" 0.25
        Material "diffuse" "texture reflectance" "m" Shape "disk" "float innerradius" 0
        ObjectBegin "o" AreaLightSource "diffuse" Translate 1 0 0 Shape "sphere" ObjectEnd
        AttributeBegin AreaLightSource "diffuse" "float power" 19.739208802178716
          Material "diffuse" "rgb reflectance" [0 0 0] Shape "disk" AttributeEnd
        Translate 0 1 0 Scale 2 2 2 ObjectInstance "o""#,
        r#"background: Solid((1, 1, 1)), materials: {
            "diffuse": Lambertian(albedo: Rgb(0.75, 0.25, 0.5)),
            "diffuse 2": DiffuseLight(emit: Rgb(2, 2, 2), two_sided: false),
        },
        objects: [
            PointLight(at: (0, 0, 0), intensity: (1, 0.25, 1)),
            SpotLight(at: (0, 0, 0), towards: (0, 0, 1), intensity: (1, 1, 1), inner: 0, outer: 90, falloff: Smooth),
            DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3)),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "diffuse"),
            Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: "diffuse 2"),
            Transformed(by: [Scale(2), Translate((0, 1, 0))], object: Group([Sphere(center: (1, 0, 0), radius: 1, material: "diffuse")])),
        ],"#,
        &["Shape sphere: it emits nothing: pbrt has no area lights in objects"],
    ),
];

#[test]
fn a_scene_is_that_of_the_scene_file() {
    for (directives, ron, told) in SAME {
        let found = read(&(VIEW.to_owned() + directives)).unwrap_or_else(|error| panic!("{error}"));
        let background = if ron.contains("background") { "" } else { "background: Solid((0, 0, 0))," };
        let expected = Scene::parse(&format!("Scene({VIEW_IN_RON} {background} {ron})"), Path::new("a.ron"));
        let expected = expected.unwrap_or_else(|error| panic!("{error}"));
        let text = found.text().replace("89.99999999999999", "90.0").replace("1.0000000000000002", "1.0");
        assert!(text == expected.text(), "{text}\n{}", expected.text());
        // A planted fault is found.
        let planted = read(&(VIEW.to_owned() + &directives.replacen("0.25", "0.26", 1)));
        assert_ne!(planted.expect("it is valid").text(), expected.text());
        let warnings = found.warnings();
        let is_told = |own: &String| told.iter().any(|told| own.contains(told));
        assert!(warnings.len() == told.len() && warnings.iter().all(is_told), "{warnings:?}");
    }
}

/// Options have values without brackets, media have names before the world too, and the faces that Ptex numbers are no others.
#[test]
fn files_of_exporters_are_read() {
    let medium = r#"MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [1 1 1] "rgb sigma_s" [2 2 2]"#;
    let shapes = |numbers: &str| {
        format!(
            r#"MediumInterface "fog" "" Material "interface" Shape "sphere" MediumInterface "" "" Material "diffuse"
            Shape "trianglemesh" "point3 P" [0 0 3 1 0 3 0 1 3] "integer indices" [0 1 2] {numbers}"#
        )
    };
    let before =
        format!(r#"Option "seed" 42 Option "bool wavefront" true Option "msereferenceout" "a.txt" {medium} {VIEW}"#);
    let before = read(&(before + &shapes("\"integer faceIndices\" [7]"))).expect("it is read");
    let after = read(&format!("{VIEW}{medium} {}", shapes(""))).expect("it is read");
    assert_eq!(format!("{:?}", before.objects), format!("{:?}", after.objects));
    assert_eq!((before.objects.len(), before.warnings().len()), (2, after.warnings().len()));
    assert!(error(&[("a.pbrt", b"Option \"seed\"")]).contains("expected its value"));
}

#[test]
fn errors_have_places() {
    for (directives, expected) in [
        ("Shape \"hair\"", "a.pbrt:4:1: Shape hair: this shape is not read: expected one of sphere, "),
        ("Shape \"sphere\" \"float radius\" \"x\"", "a.pbrt:4:16: Shape sphere.radius: expected numbers"),
        ("Shape \"sphere\" \"float size\" 1", "a.pbrt:4:16: Shape sphere.size: this parameter is not read"),
        ("Shape \"sphere\" \"integer radius\" 1", "radius: expected the type float, found integer"),
        ("\n  Shape \"sphere\" \"float radius\" [1 2]", "a.pbrt:5:18: Shape sphere.radius: expected 1 number, found 2"),
        ("Shape \"sphere\" \"float radius\" [1", "Shape sphere.radius: expected ], found the end of the file"),
        ("Sphere", "a.pbrt:4:1: Sphere: this directive is not read"),
        ("Translate 1 2", "Translate: expected 3 numbers, found the end of the file"),
        ("NamedMaterial \"x\"", "a.pbrt:4:1: NamedMaterial: there is no material \"x\" above"),
        ("ObjectInstance \"x\"", "ObjectInstance: there is no object \"x\""),
        (
            "ObjectBegin \"a\" ObjectEnd ObjectBegin \"b\" ObjectInstance \"a\"",
            "expected no instance inside of an object",
        ),
        (
            "MakeNamedMedium \"a\" \"rgb sigma_a\" [-1 1 1] \"rgb sigma_s\" [1 1 1]",
            "expected sigma_a, sigma_s and a scale of 0 or more",
        ),
        ("AttributeEnd", "AttributeEnd: expected AttributeBegin before it"),
        ("AttributeBegin", "a.pbrt:4:1: AttributeBegin: expected its end before that of the file"),
        ("Film \"rgb\"", "Film rgb: expected it before WorldBegin"),
        ("Include \"b.pbrt\"", "a.pbrt:4:1: Include: cannot read the scene file: "),
        ("Include \"a.pbrt\"", "a.pbrt:4:1: Include: a.pbrt includes itself: expected no circle"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "indices of vertices from 0 to below 3, found 3",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1] \"integer indices\" [0 1 2]",
            "expected 3 numbers for each element",
        ),
        (
            "MakeNamedMedium \"a\" \"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [1 1 1] MediumInterface \"a\" \"\" Shape \"sphere\"",
            "a.pbrt:4:1: MakeNamedMedium: expected one number for the extinction of all channels of its medium, found [2.0, 3.0, 4.0]",
        ),
        (
            "LightSource \"infinite\" \"string filename\" \"a.exr\"",
            "background.Image.path: a.exr: cannot read the image",
        ),
        (
            "Scale 1 2 1 LightSource \"infinite\" \"string filename\" \"a.exr\"",
            "expected a transform that turns the sky alone",
        ),
        (
            "LightSource \"infinite\" \"string filename\" \"a.exr\" \"float illuminance\" 1",
            "a.pbrt:4:24: LightSource infinite.filename: a.exr: cannot read the image",
        ),
        (
            "AreaLightSource \"diffuse\" \"float power\" 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0] \
             \"integer indices\" [0 1 2]",
            "a.pbrt:4:43: Shape trianglemesh: expected faces with an area",
        ),
        (
            "MakeNamedMedium \"a\" \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [1 1 1] MediumInterface \"a\" \"\" \
             AreaLightSource \"diffuse\" \"float power\" 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1.1 0] \
             \"integer indices\" [0 1 2 1 3 2]",
            "Shape trianglemesh: expected no power for the faces of different areas around a medium",
        ),
        (
            "LightSource \"point\" \"spectrum I\" \"stdillum-F13\"",
            "LightSource point.I: the spectrum \"stdillum-F13\" is not read",
        ),
        (
            "Material \"diffuse\" \"spectrum reflectance\" \"stdillum-F1\"",
            "Material diffuse.reflectance: the spectrum \"stdillum-F1\" is not read here",
        ),
        (
            "Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"bool invert\" true",
            "a.pbrt:4:1: Texture imagemap: a.png: cannot read the image",
        ),
        (
            "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\"",
            "a.pbrt:4:32: Texture imagemap.filename: a.png: cannot read the image",
        ),
        (
            "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string encoding\" \"gamma 0\"",
            "a.pbrt:4:58: Texture imagemap.encoding: expected sRGB, linear, or gamma and a number above 0",
        ),
        (
            "Texture \"a\" \"float\" \"checkerboard\" \"float uscale\" 3.21 Texture \"b\" \"float\" \"checkerboard\" \"texture tex1\" \"a\"",
            "Texture checkerboard: expected a uscale and a vscale whose ratio to those of its textures is a number such as 8, 1/2",
        ),
        ("ActiveTransform Middle", "ActiveTransform: expected StartTime, EndTime or All"),
        (
            "LightSource \"point\" \"spectrum I\" \"x.spd\"",
            "a.pbrt:4:21: LightSource point.I: cannot read the spectrum: ",
        ),
        ("Shape \"sphere\" \"float zmin\" 0.5 \"float zmax\" 0.5", "expected a zmin below the zmax"),
        ("ReverseOrientation Shape \"sphere\" \"float radius\" 0", "expected a radius and a phimax above 0, found 0"),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 1 0 0 0 1] Shape \"sphere\"", "Transform: expected 0 0 0 1 as its last row"),
    ] {
        let found = error(&[("a.pbrt", (VIEW.to_owned() + directives).as_bytes())]);
        assert!(found.contains(expected), "{found}\nexpected {expected}");
    }
    assert!(error(&[("a.pbrt", b"Film \"rgb\"")]).starts_with("a.pbrt:1:1: scene: expected WorldBegin"));
    let inner =
        error(&[("a.pbrt", (VIEW.to_owned() + "Include \"b.pbrt\"").as_bytes()), ("b.pbrt", b"\nShape \"hair\"")]);
    assert!(inner.starts_with("b.pbrt:2:1: Shape hair"), "{inner}");
}

#[test]
fn what_pbrt_shows_otherwise_is_told_and_can_be_refused() {
    for (directives, told) in [
        ("Shape \"curve\"", "Shape curve: it is left out"),
        (
            "Material \"coatedconductor\" \"float conductor.roughness\" 0.1 \"float thickness\" 1 Shape \"disk\"",
            "its coat is left out",
        ),
        ("Material \"hair\" \"float beta_m\" 0.1 Shape \"disk\"", "Material hair: it becomes a matt surface"),
        (
            "LightSource \"goniometric\" \"string filename\" \"g.exr\"",
            "its image is not used: it becomes a point light",
        ),
        ("ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Shape \"disk\"", "what moves is at rest"),
        (
            "Material \"dielectric\" \"spectrum eta\" \"glass-BK7\" Shape \"disk\"",
            "its index is 1.5168 for all colours",
        ),
        ("Material \"diffuse\" \"string normalmap\" \"n.png\" Shape \"disk\"", "its normalmap is left out"),
        (
            "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 \
             MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"texture reflectance\" \"t\" \
             MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \
             Material \"mix\" \"string materials\" [\"b\" \"a\"] Shape \"sphere\"",
            "it becomes a mesh with 128 edges around",
        ),
        ("Shape \"cylinder\"", "it becomes a mesh with 128 edges around"),
        ("Scale 1 2 3 Shape \"sphere\"", "it becomes a mesh with 128 edges around"),
        (
            "Material \"coateddiffuse\" \"float thickness\" 1 Shape \"disk\"",
            "its layer is as dark in all directions here",
        ),
        (
            "AttributeBegin Material \"dielectric\" Shape \"sphere\" AttributeEnd \
             AreaLightSource \"diffuse\" Shape \"disk\" \"float radius\" 0.5",
            "Shape disk: it seems to be inside of glass, where pbrt scales its light",
        ),
        (
            "MakeNamedMedium \"a\" \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [1 1 1] MediumInterface \"a\" \"\" Material \"interface\" \
             Translate 0 0 9 Shape \"sphere\" Shape \"sphere\" \"float radius\" 0.5",
            "its medium seems to be inside of another: here their densities add",
        ),
    ] {
        let files = folder(&[("a.pbrt", (VIEW.to_owned() + directives + " LightSource \"infinite\"").as_bytes())]);
        let path = files.path().join("a.pbrt");
        let warnings = load(&path, false).unwrap_or_else(|error| panic!("{error}")).warnings();
        assert!(warnings.iter().any(|own| own.contains("a.pbrt:4:") && own.contains(told)), "{told}: {warnings:?}");
        let refused = load(&path, true).expect_err("it loses something").to_string();
        assert!(refused.contains(told) && refused.contains("(--lossless)"), "{refused}");
    }
    let fog = |outside: &str, z: f64| {
        let medium = r#"MakeNamedMedium "a" "rgb sigma_a" [1 1 1] "rgb sigma_s" [1 1 1]"#;
        let view = VIEW.replace("Camera", &format!("MediumInterface \"\" \"{outside}\" Camera"));
        let ball = format!(r#"Translate 0 0 {z} MediumInterface "a" "" Material "interface" Shape "sphere""#);
        read(&format!("{view} {medium} {ball}")).expect("it is valid").warnings().join(" ")
    };
    assert!(fog("", 0.5).contains("Camera perspective: it seems to be inside of a medium that it does not name"));
    assert!(!fog("a", 0.5).contains("inside of a medium") && !fog("", 1.5).contains("inside of a medium"));
    // A lamp beside glass.
    let beside = r#"AttributeBegin Material "dielectric" Shape "sphere" AttributeEnd
        AreaLightSource "diffuse" Shape "disk" "float radius" 0.5 "float height" 2"#;
    let warnings = read(&(VIEW.to_owned() + beside)).expect("it is valid").warnings();
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// Each face of a mesh has all of a power: what it sends from its sides is π times its area times its radiance.
#[test]
fn faces_have_the_power_of_their_lamp() {
    let radiance = |shape: &str, before: &str| {
        let lamp = format!(
            "AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" 6.283185307179586 {before} Shape {shape}"
        );
        let black = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]";
        let text = format!("{VIEW}{black} {lamp}");
        let files = folder(&[("a.pbrt", text.as_bytes()), ("a.ply", PLY.as_bytes())]);
        let scene = load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
        let Material::DiffuseLight(lamp) = &scene.materials[0].1 else { panic!("{:?}", scene.materials) };
        lamp.emit.plain().expect("it is plain").x
    };
    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                       element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 2 0\n0 2 0\n4 0 1 2 3\n";
    let points = "\"point3 P\" [0 0 0 1 0 0 0 2 0 1 2 0]";
    let triangles = format!("\"trianglemesh\" {points} \"integer indices\" [0 1 2 1 3 2]");
    for (shape, before, area) in [
        (triangles.as_str(), "", 1.0),
        (triangles.as_str(), "Scale 2 3 1", 6.0),
        (&format!("\"bilinearmesh\" {points}"), "", 2.0),
        ("\"plymesh\" \"string filename\" \"a.ply\"", "Scale 3 3 3", 18.0),
    ] {
        let found = radiance(shape, before);
        assert!((found * area - 1.0).abs() < 1e-9, "{shape}: {found}");
    }
}

/// Faces of different areas have a radiance each: that of one is the power over π times its area.
#[test]
fn faces_of_different_areas_are_lamps_of_their_own() {
    const PI: f64 = std::f64::consts::PI;
    let lamps = |shape: &str| {
        let text = format!(
            "{VIEW}Material \"diffuse\" \"rgb reflectance\" [0 0 0] Scale 2 2 2 AreaLightSource \"diffuse\" \"float power\" 8 Shape {shape}"
        );
        let scene = read(&text).unwrap_or_else(|error| panic!("{error}"));
        let materials: std::collections::HashMap<_, _> = scene.materials.iter().cloned().collect();
        let lamp = |object: &Object| {
            let Object::Mesh { path, material: Some(material) } = object else { panic!("{object:?}") };
            let Material::DiffuseLight(lamp) = &materials[material] else { panic!("{:?}", materials[material]) };
            let mesh = &scene.meshes[path];
            let area = mesh.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
                0.5 * (b - a).cross(c - a).length()
            });
            assert!(mesh.uvs.is_empty() || mesh.uvs.len() == mesh.positions.len());
            (area.sum::<f64>(), mesh.triangles.len(), lamp.emit.plain().expect("it is plain").x)
        };
        scene.objects.iter().map(lamp).collect::<Vec<_>>()
    };
    // Two triangles of an area of 2 after the transform, and one of 6.
    let points = "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 4 0 0]";
    let triangles = format!("\"trianglemesh\" {points} \"integer indices\" [0 1 2 1 3 2 1 4 3]");
    for (shape, expected) in [
        (triangles.as_str(), [(6.0, 1, 6.0), (4.0, 2, 2.0)]),
        (
            "\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 3 0 0 3 1 0] \"integer indices\" [0 1 2 3 1 4 3 5]",
            [(8.0, 2, 8.0), (4.0, 2, 4.0)],
        ),
    ] {
        let found = lamps(shape);
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for ((area, count, radiance), (expected_area, faces, area_of_lamp)) in found.into_iter().zip(expected) {
            assert!((area - expected_area).abs() < 1e-9 && count == faces, "{shape}: {area} {count}");
            assert!((radiance * PI * area_of_lamp - 8.0).abs() < 1e-9, "{shape}: {radiance}");
        }
    }
    let many: String =
        (0..4097).map(|number| format!("0 0 {number} 1 0 {number} 0 {} {number} ", 1 + number)).collect();
    let indices: String = (0..3 * 4097).map(|corner| format!("{corner} ")).collect();
    let text = format!(
        "{VIEW}AreaLightSource \"diffuse\" \"float power\" 8 Shape \"trianglemesh\" \"point3 P\" [{many}] \"integer indices\" [{indices}]"
    );
    let refused = error(&[("a.pbrt", text.as_bytes())]);
    assert!(
        refused.contains("a.pbrt:4:43: Shape trianglemesh: expected at most 4096 faces of different areas"),
        "{refused}"
    );
}

/// The illuminants of pbrt have a luminance of 1 and the colours that the observer sees of their spectra.
#[test]
fn illuminants_have_names() {
    let names = (1..=12).map(|number| format!("stdillum-F{number}"));
    let names =
        ["stdillum-A", "stdillum-D50", "stdillum-D65", "illum-acesD60"].map(str::to_owned).into_iter().chain(names);
    let point = |kind: &str, value: &str| {
        let scene = read(&format!("{VIEW} LightSource \"point\" \"{kind} I\" [{value}] \"float scale\" 2"))
            .expect("it is valid");
        let Object::PointLight { intensity, .. } = scene.objects[0] else { panic!("{:?}", scene.objects) };
        intensity
    };
    let mut all = Vec::new();
    for name in names {
        let found = point("spectrum", &format!("\"{name}\""));
        assert!((luminance(found.to_array()) - 2.0).abs() < 2e-4, "{name}: {found}");
        all.push(found);
    }
    // Illuminant A is a black body of 2855.5 K; those of F are none.
    let black = point("blackbody", "2855.5");
    let off = |found: Colour| ((found - black) / black).abs().max_element();
    assert!(off(all[0]) < 2e-3 && all[1..].iter().all(|other| off(*other) > 1e-2), "{all:?} {black}");
}

/// A view without `Scale -1 1 1` shows the mirror image. Packed and included files are read; a part of the film is a part of the image.
#[test]
fn views_and_files_are_those_of_pbrt() {
    let mirrored = read(&VIEW.replacen("Scale -1 1 1", "", 1)).expect("it is valid");
    assert!(mirrored.camera.mirror && !read(VIEW).expect("it is valid").camera.mirror);
    let tall = VIEW.replace("\"integer yresolution\" 20", "\"integer yresolution\" 80");
    let fov = read(&tall).expect("it is valid").camera.vertical_fov.expect("it is plain");
    assert!((fov - 2.0 * 2f64.atan().to_degrees()).abs() < 1e-9, "{fov}");
    let part = VIEW.replace("Film \"rgb\"", "Film \"rgb\" \"float cropwindow\" [0.25 0.5 0 1]");
    let part = read(&part).expect("it is valid");
    assert_eq!((part.image.width, part.image.height), (10, 20));
    let text = format!("{:?}", part.camera.projection);
    assert!(text.contains("fx: 10.0") && text.contains("cx: 10.0"), "{text}");
    // In a mirrored view it is the same part of the film, whose axis is as far from the other edge.
    let part =
        VIEW.replacen("Scale -1 1 1", "", 1).replace("Film \"rgb\"", "Film \"rgb\" \"float cropwindow\" [0 0.25 0 1]");
    let text = format!("{:?}", read(&part).expect("it is valid").camera.projection);
    assert!(text.contains("cx: -10.0"), "{text}");

    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(b"Shape \"sphere\"").unwrap();
    let packed = packed.finish().unwrap();
    let including = VIEW.to_owned() + "Include \"b.pbrt.gz\" Include \"b.pbrt.gz\"";
    let files = folder(&[("a.pbrt", including.as_bytes()), ("b.pbrt.gz", &packed)]);
    assert_eq!(load(&files.path().join("a.pbrt"), false).expect("it is valid").objects.len(), 2);
}

/// Spherical cameras, skies of images and spectra of files.
#[test]
fn skies_and_spectra_are_read_from_files() {
    let view = VIEW.replace("\"perspective\" \"float fov\" 90", "\"spherical\" \"string mapping\" \"equirectangular\"");
    let camera = read(&view).expect("it is valid").camera;
    // The left of a viewer who looks at +z, with +y above, is +x.
    assert!((camera.look_at - DVec3::X).length() < 1e-12 && camera.mirror, "{camera:?}");
    assert!(matches!(camera.projection, Some(Projection::Equirectangular { .. })));

    let mut sky = std::io::Cursor::new(Vec::new());
    let texels = image::RgbImage::from_fn(8, 8, |x, _| image::Rgb([if x < 4 { 255 } else { 0 }; 3]));
    texels.write_to(&mut sky, image::ImageFormat::Png).unwrap();
    let directives = r#"Texture "t" "spectrum" "imagemap" "string filename" "sky.png" "string encoding" "linear" "float scale" 0.5
        AttributeBegin Material "diffuse" "texture reflectance" "t" Shape "sphere" AttributeEnd
        AttributeBegin Rotate 90 1 0 0 Translate 1 2 3 LightSource "infinite" "string filename" "sky.png" "float scale" 2 AttributeEnd
        LightSource "point" "spectrum I" "grey.spd" "float scale" 3
        Material "diffuse" "spectrum reflectance" "grey.spd" Shape "disk""#;
    let spectrum = b"# nm\n300 0.5\n  900\t0.5 # end\n";
    let text = VIEW.to_owned() + directives;
    let files = folder(&[("a.pbrt", text.as_bytes()), ("sky.png", sky.get_ref()), ("grey.spd", spectrum)]);
    let scene = load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
    let Background::Image { by, tint, layout, .. } = &scene.background else { panic!("{:?}", scene.background) };
    assert_eq!((*tint, *layout), (Colour::splat(2.0), SkyLayout::Octahedral));
    assert!(
        matches!(by[..], [Transform::Rotate { axis, degrees }] if axis == DVec3::X && (degrees - 90.0).abs() < 1e-9)
    );
    assert_eq!(scene.bitmaps.colours("sky.png").expect("it is loaded").width, 8);
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let Object::PointLight { intensity, .. } = &scene.objects[1] else { panic!("{:?}", scene.objects) };
    // An even spectrum is a little red beside D65, with the luminance that the scale says.
    assert!((luminance(intensity.to_array()) - 3.0).abs() < 1e-9 && intensity.x > intensity.z, "{intensity}");
    let Material::Lambertian(Lambertian { albedo: Texture::Image { channel, tint, .. }, .. }) = &scene.materials[0].1
    else {
        panic!("{:?}", scene.materials)
    };
    assert_eq!((*channel, *tint), (Some(Channel::Rgb), Colour::splat(0.5)));
    let Material::Lambertian(matt) = &scene.materials[1].1 else { panic!("{:?}", scene.materials) };
    let albedo = matt.albedo.plain().expect("it is plain");
    assert!((albedo - Colour::splat(0.5)).abs().max_element() < 2e-3, "{albedo}");
}

/// An uneven instance has the shapes of its object in its vertices, each where the even one has it.
#[test]
fn instances_may_be_uneven() {
    let scene = |by: &str| {
        let object = "ObjectBegin \"o\" Translate 1 0 0 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \
                      \"integer indices\" [0 1 2] Translate 1 0 0 Shape \"sphere\" ObjectEnd";
        read(&format!("{VIEW}{object} {by} ObjectInstance \"o\"")).unwrap_or_else(|error| panic!("{error}"))
    };
    let even = scene("Translate 0 0 5");
    assert_eq!((even.meshes.len(), even.objects.len()), (1, 1));
    let uneven = scene("Translate 0 0 5 Scale 1 2 -3");
    // That of the object is there too, for even instances.
    assert_eq!((uneven.meshes.len(), uneven.objects.len()), (3, 2));
    let names: Vec<_> = uneven.objects.iter().map(|object| format!("{object:?}")).collect();
    let mesh = names
        .iter()
        .find_map(|name| uneven.meshes.iter().find(|(path, own)| own.positions.len() == 3 && name.contains(*path)));
    let (_, mesh) = mesh.expect("it is used");
    assert_eq!(mesh.positions, [DVec3::new(1.0, 0.0, 5.0), DVec3::new(2.0, 0.0, 5.0), DVec3::new(1.0, 2.0, 5.0)]);
    let sphere = uneven.meshes.values().find(|mesh| mesh.positions.len() > 3).expect("it is there");
    let bounds = sphere.bounds();
    assert!(
        (bounds.min - DVec3::new(1.0, -2.0, 2.0)).length() < 2e-3
            && (bounds.max - DVec3::new(3.0, 2.0, 8.0)).length() < 2e-3
    );
}

/// A mirror image of a sphere is inside out, but not that of an instance, nor its mirror image in that.
#[test]
fn mirrored_instances_have_the_fronts_of_their_shapes() {
    let outward = |own: &str, of_instance: &str| {
        let object = format!("ObjectBegin \"o\" {own} Shape \"sphere\" \"float phimax\" 300 ObjectEnd");
        let text = format!("{VIEW}{object} {of_instance} ObjectInstance \"o\"");
        let scene = read(&text).unwrap_or_else(|error| panic!("{error}"));
        let mesh = scene.meshes.values().next_back().expect("it is a mesh");
        mesh.normals[300].as_dvec3().dot(mesh.positions[300]) > 0.0
    };
    assert!(outward("", "Scale 1 2 1") && outward("", "Scale 1 1 -1"));
    assert!(!outward("Scale 1 1 -1", "Scale 1 2 1") && !outward("Scale 1 1 -1", "Scale 1 1 -2"));
    assert!(
        outward("ReverseOrientation Scale 1 1 -1", "Scale 1 1 -1") && !outward("ReverseOrientation", "Scale 1 1 -1")
    );
}

/// Parts of spheres, disks and cylinders end where pbrt has their ends.
#[test]
fn parts_of_shapes_are_meshes() {
    let bounds = |shape: &str| {
        let scene = read(&format!("{VIEW} Shape {shape}")).unwrap_or_else(|error| panic!("{error}"));
        let mesh = scene.meshes.values().next().expect("it is a mesh").clone();
        (mesh.bounds(), mesh)
    };
    for (shape, min, max) in [
        ("\"sphere\" \"float zmin\" 0 \"float radius\" 2", [-2.0, -2.0, 0.0], [2.0, 2.0, 2.0]),
        ("\"sphere\" \"float phimax\" 90", [0.0, 0.0, -1.0], [1.0, 1.0, 1.0]),
        ("\"disk\" \"float phimax\" 180 \"float height\" 3", [-1.0, 0.0, 3.0], [1.0, 1.0, 3.0]),
        ("\"cylinder\" \"float phimax\" 180", [-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]),
    ] {
        let (found, _) = bounds(shape);
        let differs = (found.min - DVec3::from_array(min)).length() + (found.max - DVec3::from_array(max)).length();
        assert!(differs < 2e-3, "{shape}: {found:?}");
    }
    let (_, ring) = bounds("\"disk\" \"float innerradius\" 0.5");
    let radii = ring.positions.iter().map(|p| p.length());
    assert!(radii.clone().fold(f64::MAX, f64::min) > 0.499 && radii.fold(0.0, f64::max) < 1.001);
}

/// Shapes that are turned inside out, by a mirror image or by themselves, have the front that pbrt gives them.
#[test]
fn fronts_are_those_of_pbrt() {
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]";
    let normal = |before: &str, more: &str| {
        let scene = read(&format!("{VIEW}{before} {mesh} {more}")).unwrap_or_else(|error| panic!("{error}"));
        let mesh = &scene.meshes["a.pbrt#meshes/0"];
        let [a, b, c] = mesh.triangles[0].map(|corner| mesh.positions[corner as usize]);
        (b - a).cross(c - a).z
    };
    assert!(normal("", "") > 0.0);
    assert!(normal("Scale -1 1 1", "") > 0.0);
    assert!(normal("ReverseOrientation", "") < 0.0);
    assert!(normal("ReverseOrientation Scale -1 1 1", "") < 0.0);
    assert!(normal("Scale -1 1 1", "\"normal N\" [0 0 1 0 0 1 0 0 1]") > 0.0);
    assert!(normal("ReverseOrientation", "\"normal N\" [0 0 1 0 0 1 0 0 1]") < 0.0);
}

/// Random edits: each scene is read or refused, without a panic.
#[test]
fn mutants_do_not_panic() {
    let scenes: Vec<Vec<u8>> =
        SAME.iter().map(|(directives, ..)| (VIEW.to_owned() + directives).into_bytes()).collect();
    let files = folder(&[]);
    let path = files.path().join("mutant.pbrt");
    let mut random = Random(69);
    let (mut good, mut bad) = (0, 0);
    for number in 0..2000 {
        let mut text = scenes[number % scenes.len()].clone();
        mutate(&mut text, b"[]\"\n-9. e#ab0", &mut random);
        fs::write(&path, &text).unwrap();
        match load(&path, false) {
            Ok(_) => good += 1,
            Err(_) => bad += 1,
        }
    }
    println!("{good} are read, {bad} refused");
    assert!(good > 20 && bad > 1000, "{good} are read, {bad} refused");
}
