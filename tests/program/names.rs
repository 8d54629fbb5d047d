//! What names of files mean: endings say formats, and `-` is standard input and output.

use std::fs;
use std::io::Write;
use std::process::{Output, Stdio};

use gpu_rt::output::exr::read_exr;

use crate::common::device::index as software;
use crate::common::program::run;
use crate::sandbox::{SPHERE, Sandbox, make_pipe};

/// Runs the program with a text on its standard input.
fn fed(sandbox: &Sandbox, arguments: &[&str], text: &str) -> Output {
    let mut command = sandbox.command(arguments);
    let mut child = command.stdin(Stdio::piped()).spawn().expect("the program starts");
    child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("the program reads");
    child.wait_with_output().expect("its output can be read")
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_ending_of_a_name_says_the_format() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["-o", "a.png", "--checkpoint", "1ms"]).exits(0);
    assert_eq!(sandbox.files(), ["a.png"]);
    assert!(ran.last_line().starts_with("a.png: 16 samples, relative error "), "{}", ran.stderr);
    assert!(ran.stderr.contains("no EXR is written"), "{}", ran.stderr);
    sandbox.render(&["-o", "b.EXR", "--png", "b.PNG"]).exits(0);
    assert_eq!(sandbox.files(), ["a.png", "b.EXR", "b.PNG"]);
    let of = |name: &str| fs::read(sandbox.at(name)).unwrap();
    assert!(of("a.png").starts_with(b"\x89PNG") && of("a.png") == of("b.PNG"));
    assert_eq!(sandbox.exr("b.EXR").width, 20);
}

#[test]
fn names_that_say_no_format_are_refused_before_rendering() {
    let sandbox = Sandbox::new();
    for (more, says) in [
        (["-o", "a.jpg"], "error: a.jpg: .jpg is not written, only an EXR or a PNG: give a.exr or a.png with -o"),
        (["-o", "a"], "error: a: a name without an ending says no format: give a.exr or a.png with -o"),
        (["--png", "a.jpg"], "error: a.jpg: .jpg is not written, only a PNG: give a.png with --png"),
        (["--png", "a.exr"], "error: a.exr: this is a PNG: give a.png with --png"),
    ] {
        sandbox.refuses(&more).says_last(says);
    }
    for name in ["a.jpg", "a.png", "-"] {
        sandbox.run(&["merge", "part.exr", "-o", name]).exits(2).on_stderr(&["an EXR: give "]);
    }
    for name in ["a.jpg", "a.exr", "a", "-"] {
        let ran = sandbox.run(&["compare", "a.exr", "b.exr", "--heatmap", name]).exits(2);
        assert!(ran.last_line().ends_with("with --heatmap; nothing has been compared"), "{}", ran.stderr);
    }
    assert_eq!(sandbox.files(), Vec::<String>::new());
}

/// A picture has no state.
#[test]
fn a_png_with_channels_or_resume_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.render(&["-o", "a.png"]).exits(0);
    for resume in ["--resume", "--resume=auto"] {
        let ran = sandbox.refuses(&["-o", "a.png", resume]);
        let says = "error: a.png: a PNG cannot be resumed, and --resume goes on from an EXR: give -o a.exr --png a.png";
        assert!(ran.last_line().starts_with(says), "{}", ran.stderr);
    }
    sandbox
        .refuses(&["-o", "a.png", "--png", "b.png"])
        .says_last("error: a.png: -o and --png are both a PNG: give -o a.exr");
    sandbox.run(&["merge", "a.png", "-o", "b.exr"]).exits(2);
}

#[test]
fn a_pipe_may_have_any_name() {
    let sandbox = Sandbox::new();
    for (name, is_png) in [("pipe", false), ("pipe.png", true), ("pipe.txt", false)] {
        let pipe = sandbox.at(name);
        make_pipe(&pipe);
        let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
        sandbox.render(&["-o", name]).exits(0);
        assert_eq!(reader.join().unwrap().starts_with(b"\x89PNG"), is_png, "{name}");
    }
}

#[test]
fn a_dash_reads_standard_input_and_writes_standard_output() {
    let sandbox = Sandbox::new();
    let render = ["render", "-", "--device", software()];
    sandbox.render(&["-o", "a.png", "--quiet"]).exits(0);
    let png = fs::read(sandbox.at("a.png")).unwrap();
    for more in [&["-o", "-"][..], &["--png", "-"]] {
        let ran = fed(&sandbox, &[&render[..], more].concat(), SPHERE);
        assert!(ran.status.success(), "{}", words(&ran.stderr));
        assert!(ran.stdout == png, "{more:?}: {}", words(&ran.stderr));
    }
    // By default the names begin with `stdin`.
    assert_eq!(sandbox.files(), ["a.png", "stdin.exr"]);
    read_exr(&sandbox.at("stdin.exr")).unwrap();
    for more in [["-o", "-"], ["--png", "-"]] {
        let ran = sandbox.refuses(&[&more[..], &["--json"]].concat());
        assert!(ran.last_line().contains("-: standard output has the report of --json"), "{}", ran.stderr);
    }
    // A file of this name.
    sandbox.render(&["-o", "./-.exr"]).exits(0);
    fs::copy(sandbox.folder.path().join("scenes/sphere.ron"), sandbox.at("-")).unwrap();
    sandbox.run(&["check", "./-"]).exits(0);
}

#[test]
fn scenes_on_standard_input_have_their_paths_here_and_their_errors_named() {
    let sandbox = Sandbox::new();
    image::RgbImage::new(1, 1).save(sandbox.at("black.png")).unwrap();
    let scene = |path: &str| SPHERE.replace("Rgb(0.5, 0.4, 0.3)", &format!("Image(path: \"{path}\")"));
    let ran = fed(&sandbox, &["check", "-"], &scene("black.png"));
    assert!(ran.status.success(), "{}", words(&ran.stderr));
    let says = "-: valid, 1 primitive, no warnings\n";
    assert_eq!(words(&ran.stdout), says);
    for (text, says) in [
        (
            scene("gone.png"),
            "error: <stdin>:5:57: materials[\"grey\"].Lambertian.albedo.Image.path: gone.png: cannot read",
        ),
        (SPHERE.replace("radius: 1", "radius: -1"), "error: <stdin>:6:49: objects[0].Sphere.radius: expected"),
        (String::new(), "error: <stdin>:1:1: Scene: the scene file is empty"),
    ] {
        for command in ["check", "plan", "render"] {
            let ran = fed(&sandbox, &[command, "-"], &text);
            assert_eq!(ran.status.code(), Some(2));
            assert!(words(&ran.stderr).starts_with(says), "{}", words(&ran.stderr));
        }
    }
}

#[test]
fn a_dash_is_refused_where_a_name_is_needed() {
    let sandbox = Sandbox::new();
    for line in [
        "merge - -o a.exr",
        "compare - b.exr",
        "compare a.exr -",
        "converge ../scenes/sphere.ron --reference -",
        "converge ../scenes/sphere.ron --reference a.exr -o -",
        "tradeoff ../scenes/sphere.ron --reference -",
        "tradeoff ../scenes/sphere.ron -o -",
        "plan ../scenes/sphere.ron --wgsl -",
        "submit slurm - --spp 8 --parts 1 --dry-run",
        "submit slurm ../scenes/sphere.ron --spp 8 --parts 1 --dry-run -o -",
        "status -",
    ] {
        sandbox.says(line).exits(2).says_last("error: -: expected the name of a");
    }
    assert_eq!(sandbox.files(), Vec::<String>::new());
}

/// A newcomer copies it into a file of his own.
#[test]
fn the_example_of_the_readme_renders_wherever_it_is_saved() {
    let readme = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
    let example = readme.split("```ron\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.ron"), example).unwrap();
    run(folder.path(), &["check", "scene.ron"]).exits(0).on_stdout(&["no warnings"]);
    let small = ["--size", "16x9", "--spp", "1", "--device", software()];
    run(folder.path(), &[&["render", "scene.ron"], &small[..]].concat()).exits(0);
}
