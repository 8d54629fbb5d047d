//! Names and excerpts that would control a terminal reach it escaped.

use std::fs;
use std::path::Path;

use crate::common::device::index as software;
use crate::common::program::{Ran, run};

/// Clears the screen, starts a new line, turns the direction of text, and is a C1 control.
const EVIL: &str = "\u{1b}[2J\n\r\t\u{7f}\u{9b}31m\u{202e}\u{2066}";

/// The characters that reach the terminal raw, but for newlines.
fn raw(text: &str) -> Vec<char> {
    let turns = |c: char| {
        "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}".contains(c)
    };
    text.chars().filter(|&c| c != '\n' && (c.is_control() || turns(c))).collect()
}

#[track_caller]
fn assert_nothing_raw(ran: &Ran) {
    assert_eq!((raw(&ran.stdout), raw(&ran.stderr)), (vec![], vec![]), "{ran:?}");
}

/// Runs the program; nothing raw is printed, and something evil is.
#[track_caller]
fn printed(folder: &Path, arguments: &[&str], code: i32) -> Ran {
    let ran = run(folder, arguments).exits(code);
    assert_nothing_raw(&ran);
    let all = format!("{}{}", ran.stdout, ran.stderr);
    assert!(all.contains("\\u001b[2J") || all.contains("\\u{1b}[2J"), "{ran:?}");
    ran
}

fn scene(material: &str, object: &str) -> String {
    format!(
        "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)), materials: {{{material}: Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}}, objects: [{object}])"
    )
}

#[test]
fn names_and_excerpts_do_not_control_the_terminal() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let file = format!("scene{EVIL}.ron");
    let write = |text: &str| fs::write(folder.join(&file), text).expect("the scene is written");
    // RON strings hold every character as it is.
    let (name, other) = (format!("\"{EVIL}\""), format!("\"{EVIL}.ply\""));
    let sphere =
        |radius: &str, material: &str| format!("Sphere(center: (0, 0, 0), radius: {radius}, material: {material})");

    let bad = [
        sphere("1", &format!("\"other {EVIL}\"")),
        sphere(EVIL, &name),
        format!("Sphere{EVIL}(radius: 1)"),
        format!("Mesh(path: {other}, material: {name})"),
    ];
    for object in bad {
        write(&scene(&name, &object));
        let ran = printed(folder, &["check", &file], 2);
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
        printed(folder, &["check", &file, "--json"], 2);
    }
    fs::write(folder.join(format!("{EVIL}.ply")), EVIL).expect("the mesh is written");
    printed(folder, &["check", &file], 2);
    fs::write(folder.join(format!("{EVIL}.ply")), format!("ply\n{EVIL}\n")).expect("the mesh is written");
    printed(folder, &["check", &file], 2);

    // A material that nothing uses is warned about.
    write(&scene(&format!("\"used\": Metal(albedo: Rgb(0.5, 0.5, 0.5)), {name}"), &sphere("1", "\"used\"")));
    let ran = printed(folder, &["check", &file], 0);
    assert!(ran.stdout.contains("no object uses this material"), "{}", ran.stdout);
    printed(folder, &["plan", &file], 0);
    printed(folder, &["check", &file, "--json"], 0).json();
    let picture = format!("{EVIL}.exr");
    printed(folder, &["render", &file, "--spp", "8", "--device", software(), "-o", &picture], 0);
    let ran = printed(folder, &["render", &file, "--spp", "8", "--device", software(), "-o", &picture, "--json"], 0);
    assert!(ran.json().is_object());

    // Layers of an EXR; devices; arguments.
    let layered = format!("layers{EVIL}.exr");
    let pixels = exr::prelude::SpecificChannels::build()
        .with_channel::<f32>(exr::prelude::Text::from_slice_unchecked(EVIL.as_bytes()))
        .with_pixel_fn(|_| (0.5f32,));
    let image = exr::prelude::Image::from_channels((2, 2), pixels);
    exr::prelude::WritableImage::write(&image).to_file(folder.join(&layered)).expect("the image is written");
    printed(folder, &["compare", &layered, &layered], 2);
    write(&scene(&name, &sphere("1", &name)));
    printed(folder, &["render", &file, "--device", EVIL], 2);
    // The parser of arguments leaves out escape sequences by itself, and nothing else.
    assert_nothing_raw(&run(folder, &["render", &file, &format!("--{EVIL}")]).exits(2));
    printed(folder, &["check", &format!("missing{EVIL}")], 2);
}
