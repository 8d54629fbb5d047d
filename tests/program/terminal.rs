//! What terminals get: names and excerpts that would control them are escaped, and nothing is wider than they are.

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

#[cfg(target_os = "linux")]
mod wide {
    use std::process::Stdio;

    use crate::common::device::index as software;
    use crate::common::screen::{on_terminal, rows};
    use crate::sandbox::{SPHERE, Sandbox};

    /// Progress, warnings, summaries, tables, errors and help. A word alone in its row may be wider: a path is never broken.
    #[test]
    fn no_line_is_wider_than_the_terminal() {
        let sandbox = Sandbox::new();
        let white = SPHERE
            .replace("Rgb(0.5, 0.4, 0.3)", "Rgb(1, 1, 1)")
            .replace("\"grey\": ", "\"grey\": Metal(albedo: Noise(scale: 1)), \"white\": ");
        sandbox.scene("white.ron", &white.replace("material: \"grey\"", "material: \"white\""));
        sandbox.scene("bad.ron", &SPHERE.replace("radius: 1", "radius: wide").replace("\"grey\" }", "\"gray\" }"));
        sandbox.render(&["-o", "b.exr"]).exits(0);
        let device = software();
        for columns in [80, 40] {
            for line in [
                format!("render ../scenes/white.ron -o a.exr --verbose --max-depth 2 --device {device}"),
                "check ../scenes/white.ron".to_owned(),
                "check ../scenes/bad.ron".to_owned(),
                "plan ../scenes/white.ron".to_owned(),
                "compare a.exr b.exr".to_owned(),
                "devices".to_owned(),
                "render --what".to_owned(),
                "--help".to_owned(),
                "render --help".to_owned(),
                "merge --help".to_owned(),
                "tradeoff --help".to_owned(),
                "compare --help".to_owned(),
            ] {
                let command = sandbox.command(&line.split(' ').collect::<Vec<_>>());
                let text = on_terminal(command, columns);
                let rows = rows(&text);
                assert!(!rows.is_empty(), "{line}");
                for row in rows {
                    // The library of options breaks no headings, which fit into 80.
                    let is_heading = columns < 80 && line.contains("--help") && !row.starts_with(' ');
                    let may_be_wide = is_heading || !row.trim().contains(' ');
                    assert!(row.chars().count() <= usize::from(columns) || may_be_wide, "{line}, {columns}: {row:?}");
                }
            }
        }
    }

    /// JSON stays JSON, and what a program reads stays in its line.
    #[test]
    fn lines_that_programs_read_are_never_broken() {
        let sandbox = Sandbox::new();
        let text = on_terminal(sandbox.command(&["devices", "--json"]), 20);
        assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok(), "{text}");
        sandbox.scene("white.ron", &SPHERE.replace("Rgb(0.5, 0.4, 0.3)", "Rgb(1, 1, 1)"));
        let ran = sandbox.run(&["check", "../scenes/white.ron"]).exits(0);
        assert_eq!(ran.stdout.lines().count(), 2, "{}", ran.stdout);
        let mut command = sandbox.command(&["check", "../scenes/white.ron"]);
        assert_eq!(command.stdout(Stdio::piped()).output().unwrap().stdout, ran.stdout.as_bytes());
    }
}
