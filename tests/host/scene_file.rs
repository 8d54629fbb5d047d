//! docs/scene.md follows from the declarations that the program checks scene files by, and these are those that serde reads.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use gpu_rt::scene::format::groups;
use gpu_rt::scene::{
    Background, Camera, CameraKey, Distortion, Heat, ImageSize, Material, Object, Projection, RenderDefaults, Scene,
    Texture, Transform, Varying,
};
use gpu_rt::source::form::{Field, Form, Takes};
use gpu_rt::source::{LARGEST, SMALLEST};
use ron::error::Error as Ron;
use serde::de::DeserializeOwned;

const DOCUMENT: &str = "docs/scene.md";

/// What a section says before its forms.
fn introduction(group: &str) -> &'static str {
    match group {
        "Scene" => "The parts that belong to the file itself.",
        "Projections" => "How directions are laid out on the image: the value of `projection` of the camera.",
        "Distortions" => "What a lens does to the image of a `Calibrated` camera: the value of `distortion`.",
        "Backgrounds" => "What rays that hit nothing see: the value of `background`.",
        "Materials" => {
            "How surfaces scatter and emit light: the values of `materials`. [light-transport.md](light-transport.md#materials) has\n\
             their equations."
        }
        "Textures" => {
            "Colours of materials. A texture is evaluated at a point in the object's own space, before its transforms."
        }
        "Objects" => "Shapes, and what holds them: the elements of `objects`.",
        "Densities" => "How the density of a medium varies: in place of the number.",
        "Emissions" => "How a medium emits, if not the same everywhere.",
        _ => "What `by` of `Transformed` lists. Rotations are right-handed about their axis.",
    }
}

fn document() -> String {
    let mut out = format!(
        "# The scene file\n\n\
         Every part of a scene file, with its fields. [tutorial.md](tutorial.md) builds a scene step by step. This page is made\n\
         from the declarations by which the program checks scenes: `GPU_RT_RENEW=1 cargo test --test host scene_file` writes it.\n\n\
         A scene is a [RON](https://github.com/ron-rs/ron) file. Comments begin with `//`, or stand between `/*` and `*/`. The y axis points\n\
         up, coordinates are right-handed, and colours are linear Rec. 709. Lengths have whatever unit you choose, the scene unit: the\n\
         image does not change if the whole scene is scaled. Paths are relative to the scene file.\n\n\
         A field with a default may be left out. All others must be given. A field that is not listed is an error. Numbers have a\n\
         magnitude of at most {LARGEST:e}; where a field takes a positive number, it is at least {SMALLEST:e}. `gpu-rt check SCENE.ron` names\n\
         the line and column of each error, and [warns](warnings.md) of numbers that are allowed but dangerous.\n"
    );
    for (group, forms) in groups() {
        let _ = write!(out, "\n## {group}\n\n{}\n", introduction(group));
        let mut said = Said::new();
        for form in forms {
            write_form(&mut out, form, &mut said);
        }
    }
    out
}

/// Meanings of fields, with the name of the form whose section has them.
type Said = HashMap<(&'static str, &'static str), &'static str>;
/// A meaning of more words is written once in a group.
const SHORT: usize = 6;

fn write_form(out: &mut String, form: &Form, said: &mut Said) {
    let Form { name, about, fields, in_order, example } = form;
    let _ = write!(out, "\n### {name}\n\n{}\n\n```ron\n{example}\n```\n", wrapped(about));
    let order = if *in_order && fields.len() > 1 { ", in this order" } else { "" };
    let _ = write!(out, "\n| field{order} | takes | default | meaning |\n|---|---|---|---|\n");
    for Field { name, takes, default, about } in *fields {
        let default = match default.contains(' ') && !default.starts_with('(') {
            _ if default.is_empty() => String::new(),
            true => (*default).to_owned(),
            false => format!("`{default}`"),
        };
        let first = *said.entry((*name, *about)).or_insert(form.name);
        let about = match first != form.name && about.split(' ').count() > SHORT {
            true => format!("As of [{first}](#{}).", first.to_lowercase()),
            false => (*about).to_owned(),
        };
        let _ = writeln!(out, "| `{name}` | {} | {default} | {about} |", in_full(takes));
    }
}

/// What a field takes, with its range and unit.
fn in_full(takes: &Takes) -> String {
    let words = match takes {
        Takes::Colour(range) | Takes::Texture(range) if *range == gpu_rt::source::Range::ANY => takes.words(),
        Takes::Colour(range) => format!("(r, g, b), each {range}"),
        Takes::Varying(range) => format!("a number {range}, or a [texture](#textures)"),
        Takes::Texture(range) => format!("a [texture](#textures) {range}"),
        Takes::Number(_, unit) if ["scene units", "per scene unit"].contains(unit) => {
            format!("{}, {}{unit}", takes.words(), if unit.starts_with("per") { "" } else { "in " })
        }
        Takes::Point => "(x, y, z), in scene units".to_owned(),
        _ => takes.words(),
    };
    words.replace('|', "\\|")
}

/// Broken into lines as the other documents are.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is a line");
        if !line.is_empty() && line.chars().count() + word.chars().count() >= 128 {
            lines.push(word.to_owned());
        } else {
            *line += if line.is_empty() { "" } else { " " };
            *line += word;
        }
    }
    lines.join("\n")
}

#[test]
fn the_document_follows_from_the_declarations() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(DOCUMENT);
    let made = document();
    if crate::common::renew() {
        std::fs::write(&path, &made).expect("the document can be written");
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    let other = there.lines().zip(made.lines()).find(|(there, made)| there != made);
    assert!(
        there == made,
        "{DOCUMENT} is not what the declarations say, first at {other:?}: GPU_RT_RENEW=1 writes it anew"
    );
}

fn read<T: DeserializeOwned>(text: &str) -> Result<T, Ron> {
    let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|error| error.code)
}

/// A value that a field reads.
fn sample(takes: &Takes) -> &'static str {
    match takes {
        Takes::Number(..) | Takes::Integer(..) | Takes::Varying(_) => "7",
        Takes::Point | Takes::Vector | Takes::Colour(_) => "(7, 8, 9)",
        Takes::Texture(_) => "Rgb(7, 8, 9)",
        Takes::Other("true or false") => "true",
        Takes::Other("R, G, B, A or Rgb") => "G",
        Takes::Other("Auto or Pane") => "Pane",
        Takes::Other("Ggx or Beckmann") => "Beckmann",
        Takes::Other("Repeat, Clamp or Mirror") => "Mirror",
        Takes::Other("LatitudeLongitude or Octahedral") => "Octahedral",
        Takes::Other("Gltf, Linear or Smooth") => "Linear",
        Takes::Other("two numbers of seconds: (open, close)") => "(7, 8)",
        Takes::Other("an image: Image(path: ..)") => "Image(path: \"name\")",
        Takes::Other(words) if words.starts_with("a number, Height") => "7",
        Takes::Other(words) if words.starts_with("a colour (r, g, b)") => "(7, 8, 9)",
        Takes::Other(words) if words.starts_with("two angles") => "(7, 8)",
        Takes::Other(words) if words.starts_with("Perspective") => "Orthographic(height: 7)",
        Takes::Other(words) if words.starts_with("Equidistant") => "Equisolid",
        Takes::Other(words) if words.starts_with("Brown") => "Brown(k1: 7)",
        Takes::Other(words) if words.starts_with("a list") => "[]",
        Takes::Other(words) if words.starts_with("an object") => "Group([])",
        Takes::Other(_) => "\"name\"",
    }
}

/// Compares forms with the type that serde reads: the fields and their defaults; that there are all variants where it is an enum.
fn compare<T: DeserializeOwned + PartialEq + std::fmt::Debug>(forms: &[Form]) {
    let is_struct = forms.len() == 1 && forms[0].name.starts_with(char::is_lowercase);
    if !is_struct {
        let Err(Ron::NoSuchEnumVariant { expected, .. }) = read::<T>("Nothing(1)") else { panic!("no enum") };
        assert_eq!(expected, forms.iter().map(|form| form.name).collect::<Vec<_>>());
    }
    for form in forms {
        let name = if is_struct { "" } else { form.name };
        if form.in_order {
            let values: Vec<_> = form.fields.iter().map(|field| sample(&field.takes)).collect();
            read::<T>(&format!("{name}({})", values.join(", "))).unwrap_or_else(|error| panic!("{name}: {error}"));
            let one_more = format!("{name}({}, 1)", values.join(", "));
            assert!(read::<T>(&one_more).is_err(), "{one_more}");
            continue;
        }
        let Err(Ron::NoSuchStructField { expected, .. }) = read::<T>(&format!("{name}(nothing: 1)")) else {
            panic!("{}: no struct", form.name)
        };
        assert_eq!(expected, form.fields.iter().map(|field| field.name).collect::<Vec<_>>(), "{}", form.name);
        let with = |last: &Field, value: Option<&str>| {
            let others = form.fields.iter().filter(|field| field.name != last.name);
            let others = others.map(|field| format!("{}: {}, ", field.name, sample(&field.takes)));
            let own = value.map_or(String::new(), |value| format!("{}: {value}", last.name));
            read::<T>(&format!("{name}({}{own})", others.collect::<String>()))
        };
        for field in form.fields {
            with(field, Some(sample(&field.takes))).unwrap_or_else(|e| panic!("{}.{}: {e}", form.name, field.name));
            let without = with(field, None);
            assert_eq!(without.is_ok(), !field.default.is_empty(), "{}.{}: {without:?}", form.name, field.name);
            // A default that is no value is described in words.
            if let (Ok(without), Ok(with)) = (&without, with(field, Some(field.default))) {
                assert_eq!(*without, with, "{}.{}", form.name, field.name);
            } else {
                assert!(field.default.is_empty() || field.default.contains(' '), "{}.{}", form.name, field.name);
            }
        }
    }
}

#[test]
fn the_declarations_are_those_that_are_read() {
    for (group, forms) in groups() {
        match group {
            "Scene" => {
                compare::<ImageSize>(&forms[1..2]);
                compare::<Camera>(&forms[2..3]);
                compare::<RenderDefaults>(&forms[3..4]);
                compare::<CameraKey>(&forms[4..5]);
                let error = Scene::parse("Scene(nothing: 1)", Path::new("a.ron")).expect_err("no field").to_string();
                let names: Vec<_> = forms[0].fields.iter().map(|field| field.name).collect();
                assert!(error.ends_with(&format!("expected one of {}", names.join(", "))), "{error}");
            }
            "Projections" => compare::<Projection>(forms),
            "Distortions" => compare::<Distortion>(forms),
            "Backgrounds" => compare::<Background>(forms),
            "Materials" => compare::<Material>(forms),
            "Textures" => compare::<Texture>(forms),
            "Objects" => compare::<Object>(forms),
            "Densities" => compare::<Varying>(forms),
            "Emissions" => compare::<Heat>(forms),
            "Transforms" => compare::<Transform>(forms),
            _ => panic!("{group} is compared with nothing"),
        }
    }
}

/// A scene around an example of a form.
fn around(group: &str, form: &Form) -> String {
    let [mut image, mut camera, mut render] = [
        "(width: 32, height: 18)",
        "(look_from: (0, 1, 8), look_at: (0, 1, 0), vertical_fov: 30, shutter: (0, 1))",
        "()",
    ];
    let [mut background, mut material, mut object] =
        ["Solid((1, 1, 1))", "Lambertian(albedo: Rgb(0.5, 0.5, 0.5))", ""].map(str::to_owned);
    let own_camera;
    let example = form.example;
    match (group, form.name) {
        (_, "Scene") => return example.to_owned(),
        (_, "image") => image = example,
        (_, "camera") => camera = example,
        (_, "camera_key") => {
            let key = format!(
                "(look_from: (0, 1, 8), look_at: (0, 1, 0), vertical_fov: 30, shutter: (0, 1), moving: [(0, {example})])"
            );
            own_camera = key;
            camera = &own_camera;
        }
        ("Projections" | "Distortions", _) => {
            let projection = match group {
                "Projections" => example.to_owned(),
                _ => format!("Calibrated(fx: 9, fy: 9, cx: 16, cy: 9, distortion: {example})"),
            };
            own_camera =
                format!("(look_from: (0, 1, 8), look_at: (0, 1, 0), projection: {projection}, shutter: (0, 1))");
            camera = &own_camera;
        }
        (_, "render") => render = example,
        ("Backgrounds", _) => background = example.to_owned(),
        ("Materials", _) => {
            let part = |name| format!(", \"{name}\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))");
            let parts = ["paint", "rust"].into_iter().filter(|name| example.contains(name)).map(part);
            material = example.to_owned() + &parts.collect::<String>();
        }
        ("Textures", _) => material = format!("Lambertian(albedo: {example})"),
        ("Objects", _) => object = example.to_owned(),
        ("Densities" | "Emissions", _) => {
            let fields = match group {
                "Densities" => format!("density: {example}"),
                _ => format!("density: 1, emission: {example}"),
            };
            object = format!("Medium(boundary: Box(min: (0, 0, 0), max: (1, 1, 1)), albedo: Rgb(0, 0, 0), {fields})");
        }
        _ => {
            object =
                format!("Transformed(by: [{example}], object: Box(min: (0, 0, 0), max: (1, 1, 1), material: \"matt\"))")
        }
    }
    format!(
        "Scene(image: {image}, camera: {camera}, render: {render}, background: {background}, materials: {{ \"matt\": {material} }},\n\
         objects: [Sphere(center: (0, 1, 0), radius: 1, material: \"matt\"), {object}])"
    )
}

#[test]
fn every_example_of_the_document_is_a_scene() {
    // The files that examples name lie here.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for (group, forms) in groups() {
        for form in forms {
            let text = around(group, form);
            // The sky of a user has any name.
            let text = text.replace("sky.exr", "textures/sky.hdr");
            let scene =
                Scene::parse(&text, &folder.join("example.ron")).unwrap_or_else(|error| panic!("{error}\n{text}"));
            assert_eq!(scene.warnings(), Vec::<String>::new(), "{text}");
        }
    }
}
