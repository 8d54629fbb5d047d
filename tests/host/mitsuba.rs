//! Scenes of Mitsuba: what elements become, where errors are, and that no text makes the reader panic.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;
use gpu_rt::error::Error;
use gpu_rt::scene::{Assets, Background, GltfOptions, Material, Object, Scene, Texture};
use std::io::Write;
use tempfile::TempDir;

use crate::common::stats::Random;

const VIEW: &str = r#"<integrator type="volpath"><integer name="max_depth" value="5"/></integrator>
<sensor type="perspective"><float name="fov" value="90"/><string name="fov_axis" value="y"/>
<film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="20"/><rfilter type="box"/></film>
<sampler type="independent"><integer name="sample_count" value="16"/></sampler></sensor>
"#;
const VIEW_IN_RON: &str = "image: (width: 40, height: 20),
    camera: (look_from: (0, 0, 0), look_at: (0, 0, 1), up: (0, 1, 0), vertical_fov: 90), render: (samples: 16, max_depth: 4),";

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// A scene with a view, whose elements begin in line 5.
fn xml(elements: &str) -> String {
    format!("<scene version=\"3.0.0\">{VIEW}{elements}</scene>")
}

fn load(path: &Path, options: &GltfOptions) -> Result<Scene, Error> {
    Scene::load_as(path, options, &mut |_, _, _| {}, &mut Assets::default())
}

fn read(text: &str, options: &GltfOptions) -> Result<Scene, Error> {
    let folder = folder(&[("a.xml", text)]);
    load(&folder.path().join("a.xml"), options)
}

fn defines(given: &[(&str, &str)]) -> GltfOptions {
    let defines = given.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    GltfOptions { defines, ..GltfOptions::default() }
}

/// Errors without the folder of their file.
fn error(text: &str, options: &GltfOptions) -> String {
    let folder = folder(&[("a.xml", text)]);
    let error = load(&folder.path().join("a.xml"), options).expect_err(text).to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}

#[test]
fn a_scene_is_that_of_the_scene_file() {
    for (elements, told, ron) in [
        (
            r##"<default name="red" value="0.2"/>
            <bsdf type="twosided" id="a"><bsdf type="diffuse"><rgb name="reflectance" value="$red, 0.3 0.4"/></bsdf></bsdf>
            <alias id="a" as="b"/>
            <shape type="sphere" id="ball"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/><ref id="b"/></shape>
            <shape type="rectangle"><transform name="to_world"><scale x="2" y="3"/><translate z="4"/></transform>
              <emitter type="area"><rgb name="radiance" value="#ff0000"/></emitter></shape>
            <emitter type="constant"><spectrum name="radiance" value="0.5"/></emitter>"##,
            vec![],
            r#"background: Solid((0.5, 0.5, 0.5)),
            materials: {
                "a": Lambertian(albedo: Rgb(0.2, 0.3, 0.4)),
                "rectangle": DiffuseLight(emit: Rgb(1, 0, 0), two_sided: false),
            },
            objects: [
                Named(name: "ball", object: Sphere(center: (1, 2, 3), radius: 2, material: "a")),
                Quad(corner: (-2, -3, 4), u: (4, 0, 0), v: (0, 6, 0), material: "rectangle"),
            ],"#,
        ),
        (
            r#"<bsdf type="dielectric" id="g"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
            <bsdf type="twosided" id="m"><bsdf type="roughconductor"><string name="distribution" value="ggx"/>
              <float name="alpha" value="0.25"/><rgb name="eta" value="0.2 0.9 1"/><rgb name="k" value="3.9 2.4 2"/></bsdf></bsdf>
            <shape type="cube"><transform name="to_world"><scale x="1" y="2" z="3"/></transform><ref id="g"/></shape>
            <shape type="disk"><transform name="to_world"><scale value="2"/></transform><ref id="m"/></shape>
            <shape type="sphere"><bsdf type="null"/><medium name="interior" type="homogeneous"><float name="sigma_t" value="2"/>
              <float name="albedo" value="0.5"/><phase type="hg"><float name="g" value="0.25"/></phase></medium></shape>
            <shape type="sphere"><bsdf type="thindielectric" id="t"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf></shape>
            <shape type="sphere"><bsdf type="conductor" id="c"><rgb name="specular_reflectance" value="0.9"/></bsdf></shape><shape type="sphere" id="plain"/>
            <emitter type="point"><point name="position" value="1 2 3"/><rgb name="intensity" value="1"/></emitter>"#,
            vec!["correlated by height here, unlike in Mitsuba", "inside of a medium that it does not name"],
            r#"background: Solid((0, 0, 0)),
            materials: { "g": Dielectric(ior: 1.5), "m": Conductor(eta: (0.2, 0.9, 1), k: (3.9, 2.4, 2), roughness: 0.5),
                "t": ThinDielectric(ior: 1.5, inner_reflections: true), "c": Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0, one_sided: true),
                "plain": Lambertian(albedo: Rgb(0.5, 0.5, 0.5), one_sided: true) },
            objects: [
                Box(min: (-1, -2, -3), max: (1, 2, 3), material: "g"),
                Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 2, material: "m"),
                Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 2, albedo: Rgb(0.5, 0.5, 0.5), anisotropy: 0.25),
                Sphere(center: (0, 0, 0), radius: 1, material: "t"),
                Sphere(center: (0, 0, 0), radius: 1, material: "c"),
                Named(name: "plain", object: Sphere(center: (0, 0, 0), radius: 1, material: "plain")),
                PointLight(at: (1, 2, 3), intensity: (1, 1, 1)),
            ],"#,
        ),
    ] {
        let found = read(&xml(elements), &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let expected = Scene::parse(&format!("Scene({VIEW_IN_RON} {ron})"), Path::new("a.ron")).expect(ron);
        // 90 degrees are 2 atan(1) but for the last bit.
        let text = found.text().replace("89.99999999999999", "90.0");
        assert_eq!(text, expected.text());
        // A planted fault is found.
        let planted = read(&xml(&elements.replacen("value=\"0.", "value=\"0.1", 1)), &GltfOptions::default());
        assert_ne!(planted.expect("it is valid").text(), expected.text());
        let warnings = found.warnings();
        assert!(
            warnings.len() == told.len() && warnings.iter().zip(told).all(|(own, told)| own.contains(told)),
            "{warnings:?}"
        );
    }
}

#[test]
fn old_names_and_views_are_read() {
    let text = r#"<scene version="0.6.0"><integrator type="volpath"><integer name="maxDepth" value="-1"/></integrator>
        <sensor type="thinlens"><float name="fov" value="90"/><string name="fovAxis" value="larger"/><float name="apertureRadius" value="0.25"/>
        <float name="focusDistance" value="3"/>
        <transform name="toWorld"><scale x="-1"/><lookAt origin="1, 0, 0" target="1, 0, -5" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="40"/>
        <integer name="cropOffsetX" value="3"/><integer name="cropWidth" value="10"/></film></sensor></scene>"#;
    let scene = read(text, &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let camera = &scene.camera;
    assert_eq!(scene.render.max_depth, 1_000_000);
    assert_eq!((scene.image.width, scene.image.height), (10, 40));
    assert!(camera.mirror && camera.aperture == 0.5 && camera.focus_distance == Some(3.0));
    assert_eq!((camera.look_from, camera.look_at), (DVec3::X, DVec3::new(1.0, 0.0, -1.0)));
    // 40 pixels show 90 degrees: the focal length is 20 pixels. The axis is at 10 of 20 pixels, 7 of those that are left; 3 from the other side.
    let shown = format!("{:?}", camera.projection);
    assert!(shown.contains("cx: 3.0, cy: 20.0"), "{shown}");
    // Another principal point moves the axis by a share of the film: to 8 of 20 pixels, 5 of those that are left.
    let moved = text.replacen("<film", "<float name=\"principal_point_offset_x\" value=\"0.1\"/><film", 1);
    let moved = read(&moved, &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let found = format!("{:?}", moved.camera.projection);
    assert!(found.contains("cx: 5.0, cy: 20.0"), "{found}");
    assert!(
        shown.contains("fx: 20.00000000000") || shown.contains("fx: 19.99999999999") || shown.contains("fx: 20.0,")
    );
}

#[test]
fn errors_have_places() {
    let none = GltfOptions::default();
    for (elements, expected) in [
        ("\n<shape type=\"hair\"/>", "a.xml:6:8: shape hair.type: this plugin is not read: expected one of obj, "),
        (
            "<bsdf type=\"measured\" id=\"x\"/><shape type=\"sphere\"><ref id=\"x\"/></shape>",
            "a.xml:5:7: bsdf measured.type: ",
        ),
        ("<shape type=\"sphere\"><ref id=\"x\"/></shape>", "a.xml:5:27: ref x.id: there is no element of the id \"x\""),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"-\"/></shape>",
            "a.xml:5:43: float radius.value: expected a number, found \"-\"",
        ),
        (
            "<shape type=\"sphere\"><float name=\"size\" value=\"1\"/></shape>",
            "a.xml:5:22: float size: this property of shape sphere is not read",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>",
            "a.xml:5:43: float radius.value: $r has no value: give one by -D r=VALUE",
        ),
        (
            "<shape type=\"obj\"><string name=\"filename\" value=\"no.obj\"/></shape>",
            "a.xml:5:43: string filename.value: no.obj: there is no such file",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"null\"/><medium name=\"interior\" type=\"homogeneous\">\
             <rgb name=\"sigma_t\" value=\"1 2 3\"/></medium></shape>",
            "a.xml:5:84: rgb sigma_t: expected one number for all channels, or an albedo of 0, found [1.0, 2.0, 3.0]",
        ),
        (
            "<bsdf type=\"twosided\" id=\"x\"><ref id=\"x\"/></bsdf><shape type=\"sphere\"><ref id=\"x\"/></shape>",
            "a.xml:5:1: bsdf twosided: expected a bsdf that is not inside itself",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"blendbsdf\"><bsdf type=\"diffuse\"/></bsdf></shape>",
            "a.xml:5:22: bsdf blendbsdf: expected 2 bsdfs in it, found 1",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"blendbsdf\"><bsdf type=\"diffuse\"/><bsdf type=\"null\"/></bsdf></shape>",
            "a.xml:5:67: bsdf null: null cannot be mixed here: write a mask",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"blendbsdf\"><bsdf type=\"diffuse\"/><bsdf type=\"thindielectric\"/></bsdf></shape>",
            "a.xml:5:67: bsdf thindielectric: it cannot be mixed here, because it is a ThinDielectric",
        ),
        (
            "<bsdf type=\"conductor\" id=\"x\"><string name=\"material\" value=\"Xx\"/></bsdf><shape type=\"sphere\"><ref id=\"x\"/></shape>",
            "a.xml:5:55: string material.value: the metal \"Xx\" is not known here",
        ),
        (
            "<emitter type=\"constant\"><spectrum name=\"radiance\" value=\"400:1, 300:1\"/></emitter>",
            "a.xml:5:52: spectrum radiance.value: expected WAVELENGTH:VALUE, .. with wavelengths that rise",
        ),
        (
            "<emitter type=\"point\"><rgb name=\"intensity\" value=\"-1\"/></emitter>",
            "a.xml:5:1: objects[0].PointLight.intensity",
        ),
        ("<include filename=\"a.xml\"/>", "a.xml:5:10: include.filename: a.xml includes itself: expected no circle"),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/></shape>",
            "a.xml:5:54: float radius: this property is there already",
        ),
        (
            "<texture type=\"checkerboard\" id=\"t\"/><shape type=\"sphere\"><ref id=\"t\"/></shape>",
            "a.xml:5:59: ref t: texture checkerboard has no place here",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"/></bsdf>\
             <emitter type=\"area\"><texture type=\"checkerboard\" name=\"radiance\"><transform name=\"to_uv\"><scale value=\"2\"/>\
             </transform></texture></emitter></shape>",
            "expected one to_uv in all textures of a surface, found another",
        ),
        (
            "<shape type=\"sphere\"><bsdf type=\"null\"/><medium name=\"interior\" type=\"homogeneous\">\
             <rgb name=\"sigma_t\" value=\"1 2 3\"/><rgb name=\"albedo\" value=\"0\"/></medium></shape>",
            "expected one number for the sigma_t of its medium: it is not in glass",
        ),
        (
            "<bsdf type=\"diffuse\" id=\"a\"><texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"a.png\"/>\
             <string name=\"wrap_mode\" value=\"border\"/></texture></bsdf><shape type=\"sphere\"><ref id=\"a\"/></shape>",
            "texture bitmap: expected a wrap_mode of repeat, mirror or clamp",
        ),
        (
            "<bsdf type=\"null\" id=\"a\"/><bsdf type=\"null\" id=\"a\"/>",
            "a.xml:5:45: bsdf null.id: another element has this id",
        ),
    ] {
        let found = error(&xml(elements), &none);
        assert!(found.contains(expected), "{found}\nexpected {expected}");
    }
    assert!(error("<scene><a></scene>", &none).starts_with("a.xml:1:"));
    assert!(error("<!DOCTYPE a [<!ENTITY b \"c\">]><scene version=\"3.0.0\"/>", &none).contains("DTD"));
    assert!(error("<scene version=\"3.0.0\"/>", &none).contains("expected a <sensor>"));
}

#[test]
fn included_files_have_their_own_places() {
    let inner = "<scene version=\"3.0.0\">\n\n <shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/><bsdf type=\"roughconductor\"><rgb name=\"eta\" value=\"1\"/><rgb name=\"k\" value=\"2\"/></bsdf></shape></scene>";
    let files = folder(&[("a.xml", &xml("<include filename=\"in/b.xml\"/>")), ("in/b.xml", inner), ("b.xml", inner)]);
    // A file outside of the folder is told.
    fs::write(files.path().join("in/c.xml"), xml("<include filename=\"../b.xml\"/>")).unwrap();
    let told = load(&files.path().join("in/c.xml"), &defines(&[("r", "2")])).expect("it is valid").warnings();
    assert!(
        told.iter().any(|told| told.contains("c.xml:5:") && told.contains("outside of the scene's folder: ../b.xml")),
        "{told:?}"
    );
    let path = files.path().join("a.xml");
    let scene = load(&path, &defines(&[("r", "2")])).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(scene.objects[..], [Object::Sphere { radius: 2.0, .. }]));
    assert!(scene.inputs().contains(&files.path().join("in/b.xml")), "{:?}", scene.inputs());
    let [warning] = &scene.warnings()[..] else { panic!("{:?}", scene.warnings()) };
    assert!(
        warning.contains("in/b.xml:3:56: bsdf roughconductor: its masking and shadowing are correlated by height here"),
        "{warning}"
    );
    for (options, expected) in [
        (defines(&[("r", "x")]), "in/b.xml:3:44: float radius.value: expected a number, found \"x\""),
        (defines(&[("r", "-2")]), "in/b.xml:3:2: shape sphere: expected a radius above 0"),
        (defines(&[("r", "2"), ("unused", "1")]), "-D unused: "),
        (GltfOptions { lossless: true, ..defines(&[("r", "2")]) }, "in/b.xml:3:56: bsdf roughconductor: its masking"),
    ] {
        let found = load(&path, &options).expect_err(expected).to_string();
        assert!(found.contains(expected), "{found}");
    }
}

/// What Mitsuba would show otherwise without an error is told.
#[test]
fn what_mitsuba_shows_otherwise_is_told() {
    let ball = |radius: f64, inside: &str| {
        format!(
            "<shape type=\"sphere\"><point name=\"center\" value=\"0 0 9\"/><float name=\"radius\" value=\"{radius}\"/>{inside}</shape>"
        )
    };
    let lamp = "<emitter type=\"area\"/>";
    let fog = "<bsdf type=\"null\"/><medium name=\"interior\" type=\"homogeneous\"/>";
    for (elements, told) in [
        (ball(2.0, "<bsdf type=\"dielectric\"/>") + &ball(1.0, lamp), "inside of glass"),
        (ball(2.0, fog) + &ball(1.0, fog), "inside of another: here their densities add"),
        (ball(9.5, fog), "inside of a medium that it does not name"),
        ("<shape type=\"rectangle\"><bsdf type=\"dielectric\"/></shape>".to_owned(), "its glass has no inside"),
        (
            ball(1.0, "<bsdf type=\"blendbsdf\"><bsdf type=\"conductor\"/><bsdf type=\"diffuse\"/></bsdf>"),
            "its mirror image is brighter here",
        ),
        (
            "<emitter type=\"sunsky\"><float name=\"turbidity\" value=\"3\"/></emitter>".to_owned(),
            "it becomes a white and blue sky",
        ),
        ("<path value=\"..\"/>".to_owned() + &ball(1.0, lamp), "outside of the scene's folder: .."),
    ] {
        let scene = read(&xml(&elements), &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let warnings = scene.warnings();
        assert!(warnings.iter().any(|own| own.contains("a.xml:") && own.contains(told)), "{told}: {warnings:?}");
    }
    // One beside the other: nothing is told.
    let beside = ball(2.0, "<bsdf type=\"dielectric\"/>")
        + "<shape type=\"sphere\"><point name=\"center\" value=\"3 0 9\"/><emitter type=\"area\"/></shape>";
    assert_eq!(read(&xml(&beside), &GltfOptions::default()).expect("it is valid").warnings(), Vec::<String>::new());
}

/// Files are found where Mitsuba finds them: an include beside its own file or the scene, a mesh in the folders of `path`, the last one first.
#[test]
fn files_are_found_in_the_order_of_mitsuba() {
    let triangle = |x: f64| format!("v {x} 0 5\nv 1 0 5\nv 0 1 5\nf 1 2 3\n");
    let (a, b, c) = (triangle(2.0), triangle(3.0), triangle(4.0));
    let mesh = "<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/></shape>";
    let within = |inner: &str| format!("<scene version=\"3.0.0\">{inner}</scene>");
    for (text, x) in [
        (xml("<include filename=\"sub/b.xml\"/>"), 2.0),
        (xml(&format!("<path value=\"p\"/>{mesh}")), 3.0),
        (xml(&format!("<path value=\"p\"/><path value=\"q\"/>{mesh}")), 4.0),
    ] {
        let files = folder(&[
            ("a.xml", &text),
            ("sub/b.xml", &within("<include filename=\"c.xml\"/>")),
            ("c.xml", &within(mesh)),
            ("m.obj", &a),
            ("p/m.obj", &b),
            ("q/m.obj", &c),
        ]);
        let scene =
            load(&files.path().join("a.xml"), &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let [mesh] = scene.meshes.values().collect::<Vec<_>>()[..] else { panic!("{:?}", scene.meshes.keys()) };
        assert_eq!(mesh.positions[0], DVec3::new(x, 0.0, 5.0));
    }
}

/// Many shapes in one line are read in seconds, and instances share the meshes that are made for them.
#[test]
fn many_shapes_are_read_in_seconds() {
    let start = Instant::now();
    for shape in ["<shape type=\"sphere\"/>", "<shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>"] {
        let scene = read(&xml(&shape.repeat(40_000)), &GltfOptions::default()).expect("it is valid");
        assert_eq!((scene.objects.len(), scene.materials.len()), (40_000, 1));
    }
    let instance = "<shape type=\"instance\"><ref id=\"g\"/></shape>";
    let group = "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cylinder\"/></shape>";
    let scene =
        read(&xml(&(group.to_owned() + &instance.repeat(5_000))), &GltfOptions::default()).expect("it is valid");
    assert_eq!((scene.objects.len(), scene.meshes.len()), (5_000, 1));
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}

#[test]
fn names_are_for_scenes_of_mitsuba_alone() {
    let files = folder(&[("a.ron", ""), ("a.obj", "")]);
    for name in ["a.ron", "a.obj"] {
        let found = load(&files.path().join(name), &defines(&[("r", "2")])).expect_err(name).to_string();
        assert!(found.starts_with("-D is for scenes of Mitsuba, which are .xml: "), "{found}");
    }
}

/// Names that double each other, and files that include each other twice, end at a limit.
#[test]
fn what_grows_without_end_is_refused() {
    let doubling: String =
        (1..40).map(|i| format!("<default name=\"n{i}x\" value=\"$n{j}x$n{j}x$n{j}x$n{j}x\"/>", j = i - 1)).collect();
    let found = error(&xml(&format!("<default name=\"n0x\" value=\"abcd\"/>{doubling}")), &GltfOptions::default());
    assert!(found.contains("at most 65536 bytes"), "{found}");
    let twice =
        |i: usize| format!("<scene version=\"3.0.0\">{0}{0}</scene>", format!("<include filename=\"{}.xml\"/>", i + 1));
    let texts: Vec<(String, String)> = (0..20).map(|i| (format!("{i}.xml"), twice(i))).collect();
    let mut all: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    all.push(("20.xml", "<scene version=\"3.0.0\"></scene>"));
    let files = folder(&all);
    let found = load(&files.path().join("0.xml"), &GltfOptions::default()).expect_err("too many files").to_string();
    assert!(found.contains("at most 1000 included files"), "{found}");
}

#[test]
fn deep_and_circular_files_are_refused() {
    for levels in [101, 10_000] {
        let text = xml(&format!("{}{}", "<bsdf type=\"twosided\">".repeat(levels), "</bsdf>".repeat(levels)));
        let found = error(&text, &GltfOptions::default());
        assert!(found.contains("expected at most 100 elements within each other"), "{found}");
    }
    let files = folder(&[
        ("a.xml", &xml("<include filename=\"b.xml\"/>")),
        ("b.xml", "<scene version=\"3.0.0\">\n<include filename=\"a.xml\"/></scene>"),
    ]);
    let found = load(&files.path().join("a.xml"), &GltfOptions::default()).expect_err("a circle").to_string();
    assert!(found.contains("b.xml:2:10: include.filename: ") && found.contains("includes itself"), "{found}");
}

/// Two meshes: a square, then a triangle with normals.
fn serialized() -> Vec<u8> {
    let mesh = |flags: u32, numbers: &[f32], count: u64, triangles: &[u32]| {
        let mut all = Vec::from((flags | 0x1000).to_le_bytes());
        all.extend(b"name\0");
        all.extend(count.to_le_bytes());
        all.extend((triangles.len() as u64 / 3).to_le_bytes());
        all.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        all.extend(triangles.iter().flat_map(|corner| corner.to_le_bytes()));
        let mut packed = ZlibEncoder::new(Vec::from([0x1c, 0x04, 4, 0]), Compression::default());
        packed.write_all(&all).unwrap();
        packed.finish().unwrap()
    };
    let mut file = mesh(0, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0], 4, &[0, 1, 2, 0, 2, 3]);
    let second = file.len() as u64;
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let normals = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    file.extend(mesh(1, &[corners, normals].concat(), 3, &[0, 1, 2]));
    file.extend([0u64.to_le_bytes(), second.to_le_bytes()].concat());
    file.extend(2u32.to_le_bytes());
    file
}

#[test]
fn meshes_are_read_and_converted() {
    let elements = "<shape type=\"serialized\"><string name=\"filename\" value=\"m.serialized\"/><integer name=\"shape_index\" value=\"N\"/>\
                    <transform name=\"to_world\"><scale x=\"2\" y=\"-1\"/></transform></shape>";
    for (number, triangles) in [(0, 2), (1, 1)] {
        let files = folder(&[("a.xml", &xml(&elements.replace('N', &number.to_string())))]);
        fs::write(files.path().join("m.serialized"), serialized()).unwrap();
        let path = files.path().join("a.xml");
        let scene = load(&path, &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let mesh = &scene.meshes["a.xml#meshes/0"];
        assert_eq!(mesh.triangles.len(), triangles);
        // A mirror image whose normals say what is outside.
        let [a, b, c] = mesh.triangles[0].map(|corner| mesh.positions[corner as usize]);
        assert!((b - a).cross(c - a).z * f64::from(mesh.normals[0].z) > 0.0);
        assert!(scene.inputs().contains(&files.path().join("m.serialized")));

        let to = files.path().join("b.ron");
        let made = Scene::of_model(&path, &to, &GltfOptions::default(), &mut Assets::default()).unwrap();
        for (name, mesh) in made.made_meshes() {
            gpu_rt::scene::write_ply(mesh, &mut fs::File::create(files.path().join(name)).unwrap()).unwrap();
        }
        fs::write(&to, made.text()).unwrap();
        let again = Scene::load(&to).unwrap_or_else(|error| panic!("{error}"));
        let written = &again.meshes["b-0.ply"];
        assert_eq!((&written.positions, &written.triangles), (&mesh.positions, &mesh.triangles));
        assert_eq!((&written.normals, &written.uvs), (&mesh.normals, &mesh.uvs));
    }
    let files = folder(&[("a.xml", &xml(&elements.replace('N', "2")))]);
    fs::write(files.path().join("m.serialized"), serialized()).unwrap();
    let found = load(&files.path().join("a.xml"), &GltfOptions::default()).expect_err("there are two").to_string();
    assert!(found.contains("there is no mesh 2: the file has 2"), "{found}");
}

/// Up to four random edits, some of which put one of `letters` somewhere.
pub fn mutate(text: &mut Vec<u8>, letters: &[u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        if text.is_empty() {
            return;
        }
        let at = random.below(text.len());
        match random.below(4) {
            0 => text[at] = letters[random.below(letters.len())],
            1 => _ = text.remove(at),
            2 => text.truncate(at.max(1)),
            _ => {
                let part = text[at..(at + random.below(40)).min(text.len())].to_vec();
                let to = random.below(text.len());
                text.splice(to..to, part);
            }
        }
    }
}

/// The scenes of tests/references/mitsuba with random edits: each is read or refused, without a panic.
#[test]
fn mutants_do_not_panic() {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references/mitsuba");
    let files = tempfile::tempdir().unwrap();
    let mut scenes = Vec::new();
    for entry in fs::read_dir(&from).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        fs::copy(&path, files.path().join(&name)).unwrap();
        if name.ends_with(".xml") && name != "parts.xml" {
            scenes.push(fs::read(&path).unwrap());
        }
    }
    assert!(scenes.len() >= 8);
    let mut random = Random(68);
    let path = files.path().join("mutant.xml");
    let (mut good, mut bad) = (0, 0);
    for number in 0..2000 {
        let mut text = scenes[number % scenes.len()].clone();
        mutate(&mut text, b"<>/\"=0-9. e$#:az", &mut random);
        fs::write(&path, &text).unwrap();
        match load(&path, &GltfOptions::default()) {
            Ok(_) => good += 1,
            Err(_) => bad += 1,
        }
    }
    println!("{good} are read, {bad} refused");
    assert!(good > 20 && bad > 1000, "{good} are read, {bad} refused");
}

/// What the variant scalar_rgb of Mitsuba 3.9 has of these, by `traverse`.
#[test]
fn spectra_and_metals_are_those_of_mitsuba() {
    let pairs = "400:0.1, 500:0.2, 600:0.6, 700:0.3";
    let files = folder(&[
        (
            "a.xml",
            &xml(&format!(
                "<bsdf type=\"diffuse\" id=\"a\"><spectrum name=\"reflectance\" value=\"{pairs}\"/></bsdf>
                <bsdf type=\"conductor\" id=\"b\"><string name=\"material\" value=\"Au\"/></bsdf>
                <shape type=\"sphere\"><ref id=\"a\"/></shape><shape type=\"sphere\"><ref id=\"b\"/></shape>
                <emitter type=\"constant\"><spectrum name=\"radiance\" filename=\"b.spd\"/></emitter>"
            )),
        ),
        ("b.spd", "# a lamp\n400 0.1\n500 0.2\n600 0.6\n700 0.3\n"),
    ]);
    let scene = load(&files.path().join("a.xml"), &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
    };
    let Material::Lambertian(matt) = &scene.materials[0].1 else { panic!("{:?}", scene.materials) };
    let Texture::Rgb(r, g, b) = matt.albedo else { panic!("{matt:?}") };
    near([r, g, b], [0.62763923, 0.37130532, 0.12045722]);
    let Background::Solid(light) = scene.background else { panic!("{:?}", scene.background) };
    near(light.to_array(), [0.7233114, 0.3574196, 0.10408046]);
    let Material::Conductor(gold) = &scene.materials[1].1 else { panic!("{:?}", scene.materials) };
    near(gold.eta.unwrap().to_array(), [0.14304, 0.37531, 1.44205]);
    assert!(scene.inputs().contains(&files.path().join("b.spd")));
    // A black body of 2856 kelvins has the chromaticity of illuminant A, (0.44757, 0.40745): in linear Rec. 709, red over green and blue over green.
    let lamp = xml(
        "<emitter type=\"constant\"><spectrum name=\"radiance\" type=\"blackbody\"><float name=\"temperature\" value=\"2856\"/></spectrum></emitter>",
    );
    let scene = read(&lamp, &GltfOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let Background::Solid(light) = scene.background else { panic!("{:?}", scene.background) };
    let (x, y) = (0.44757, 0.40745);
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    let rows = [[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]];
    let [r, g, b] = rows.map(|row: [f64; 3]| row.iter().zip(xyz).map(|(a, b)| a * b).sum::<f64>());
    assert!(
        (light.x / light.y - r / g).abs() < 2e-3 && (light.z / light.y - b / g).abs() < 2e-3,
        "{light:?} {r} {g} {b}"
    );
}
