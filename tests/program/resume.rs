//! A render that goes on, or that is joined from parts, is the one that was never interrupted: the same bytes, however its work is split.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use clap::Parser;
use gpu_rt::commands::{self, Cli};
use gpu_rt::error::Error;
use gpu_rt::film::Film;
use gpu_rt::output::exr::{Attribute, ExrImage, State, add_film, read_attributes, read_exr, read_state, write_render};
use tempfile::TempDir;

use crate::common::device::index as software;
use crate::common::exr_header::{field, fields, sealed};
#[cfg(target_os = "linux")]
use crate::common::files::files;
#[cfg(unix)]
use crate::common::program::send;
use crate::common::program::{Ran, command, finish, meanwhile, run, words};
#[cfg(unix)]
use crate::sandbox::attribute;

/// Lights, glass, a texture from a file, and paths of many lengths.
pub const SCENE: &str = "Scene(
    image: (width: 24, height: 16),
    camera: (look_from: (0, 1, 5), look_at: (0, 0.5, 0), up: (0, 1, 0), vertical_fov: 45),
    background: Gradient(bottom: (0.2, 0.2, 0.2), top: (0.1, 0.2, 0.4)),
    materials: {
        \"floor\": Lambertian(albedo: Image(path: \"floor.png\")),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7)),
        \"steel\": Metal(albedo: Rgb(0.8, 0.8, 0.7), fuzz: 0.2),
    },
    objects: [
        Quad(corner: (-4, 0, -4), u: (0, 0, 8), v: (8, 0, 0), material: \"floor\"),
        Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
        Sphere(center: (-0.8, 0.7, 0), radius: 0.7, material: \"glass\"),
        Sphere(center: (0.9, 0.6, 0), radius: 0.6, material: \"steel\"),
    ],
    render: (samples: 64, max_depth: 12),
)
";

/// Writes the texture of the scene.
pub fn save_floor(path: &Path) {
    let texture = image::RgbImage::from_fn(4, 4, |x, y| image::Rgb([200, 40 * x as u8, 60 * y as u8]));
    texture.save(path).expect("the texture is written");
}

/// A folder with the scene and its texture.
pub struct Sandbox {
    folder: TempDir,
}

impl Sandbox {
    pub fn new() -> Sandbox {
        let sandbox = Sandbox { folder: tempfile::tempdir().expect("a temporary folder") };
        sandbox.write("scene.ron", SCENE);
        save_floor(&sandbox.path("floor.png"));
        sandbox
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("the file is written");
    }

    /// Runs a command line without quotes and spaces in its words.
    pub fn says(&self, line: &str) -> Ran {
        run(self.folder.path(), &words(line))
    }

    /// Renders the scene with these arguments.
    pub fn render(&self, more: &str) -> Ran {
        self.says(&format!("render scene.ron --device {} {more}", software()))
    }

    fn command(&self, more: &str) -> Command {
        command(self.folder.path(), &words(&format!("render scene.ron --device {} {more}", software())))
    }

    fn spawn(&self, more: &str) -> Child {
        self.command(more).spawn().expect("the program starts")
    }

    pub fn image(&self, name: &str) -> ExrImage {
        read_exr(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    /// How many samples out.exr holds.
    fn count(&self) -> u64 {
        opened(&self.path("out.exr")).0.samples.count()
    }

    /// Checks that out.exr can be read, and has at least so many samples. The result is how many it has.
    fn holds_at_least(&self, least: u64) -> u64 {
        let count = self.count();
        assert!(count >= least, "{count} samples after {least}");
        assert_eq!(self.holds("out.exr").film.totals.paths, count * 24 * 16);
        count
    }

    /// Checks that out.exr goes on to so many samples of one render.
    fn is_one_render(&self, end: u64) {
        self.render(&format!("--quiet --spp {end} -o out.exr --resume")).exits(0);
        self.render(&format!("--quiet --spp {end} -o full.exr")).exits(0);
        assert_eq!(self.holds("out.exr").difference(&self.holds("full.exr")), [""; 0], "{end} samples");
    }

    /// What a file holds.
    fn holds(&self, name: &str) -> Held {
        Held::read(&self.path(name))
    }

    /// Writes a file anew with another state.
    fn change(&self, name: &str, change: impl Fn(&mut State)) {
        let path = self.path(name);
        let (mut state, film) = opened(&path);
        change(&mut state);
        let attributes = read_attributes(&path).expect("it is read");
        write_render(&path, &film, &attributes, Some(&state), || Ok(())).expect("it is written");
    }
}

/// The state and the film of a file.
fn opened(path: &Path) -> (State, Film) {
    let state = read_state(path).expect("the state is read").expect("there is a state");
    let mut film = state.film().expect("it fits");
    add_film(path, &state, &mut film).expect("the film is read");
    (state, film.film)
}

/// What a file holds of its render, times and names of files aside.
#[derive(Debug, PartialEq)]
pub struct Held {
    rgb: Vec<[f32; 3]>,
    variance: Option<Vec<[f32; 3]>>,
    pub film: Film,
    pub samples: String,
    checks: u32,
    attributes: Vec<(String, Attribute)>,
}

impl Held {
    /// Whether both are the same image, whatever their headers say.
    pub fn has_pixels_of(&self, other: &Held) -> bool {
        self.rgb == other.rgb && self.variance == other.variance && self.film == other.film
    }

    /// What differs in another one, in words.
    pub fn difference(&self, other: &Held) -> Vec<String> {
        let differs = [
            ("rgb", self.rgb != other.rgb),
            ("variance", self.variance != other.variance),
            ("film", self.film != other.film),
            ("samples", self.samples != other.samples),
            ("checks", self.checks != other.checks),
        ];
        let fields = differs.into_iter().filter(|(_, differs)| *differs).map(|(name, _)| name.to_string());
        let only = |a: &Held, b: &Held| -> Vec<String> {
            let only = a.attributes.iter().filter(|attribute| !b.attributes.contains(attribute));
            only.map(|attribute| format!("{attribute:?}")).collect()
        };
        fields.chain(only(self, other)).chain(only(other, self)).collect()
    }

    pub fn read(path: &Path) -> Held {
        let image = read_exr(path).unwrap_or_else(|error| panic!("{error}"));
        let (state, film) = opened(path);
        let mut attributes = read_attributes(path).expect("the header is read");
        attributes.retain(|(name, _)| {
            !name.starts_with("gpu-rt:seconds_") && name != "gpu-rt:scene" && name != "gpu-rt:command"
        });
        attributes.sort_by(|a, b| a.0.cmp(&b.0));
        let State { samples, checks, .. } = state;
        Held { rgb: image.rgb, variance: image.variance, film, samples: samples.to_string(), checks, attributes }
    }
}

/// The table: ways to link, slots, samplers and splits, each resumed and joined.
#[test]
fn split_and_joined_renders_have_the_bytes_of_one() {
    let sandbox = Sandbox::new();
    for sampler in ["sobol", "independent"] {
        sandbox.render(&format!("--quiet --sampler {sampler} --spp 64 -o full.exr")).exits(0);
        let full = sandbox.holds("full.exr");
        assert_eq!(full.samples, "0..64");
        for (ways, first, then) in [
            ("fused, then queues", "--scatter fused --slots 64 --bounces 2", "--scatter queues"),
            ("linked, then fused", "--scatter linked", "--scatter fused --build best --slots 300"),
        ] {
            let ways = format!("{sampler}, {ways}");
            let render = |more: &str| sandbox.render(&format!("--quiet --sampler {sampler} {more}")).exits(0);
            render(&format!("--spp 8 -o out.exr --force {first}"));
            assert!(sandbox.holds("out.exr") != full, "that they can differ at all is seen");
            render(&format!("--spp 40 -o out.exr --resume {then}"));
            render(&format!("--spp 64 -o out.exr --resume=auto {first}"));
            assert_eq!(sandbox.holds("out.exr").difference(&full), [""; 0], "resumed: {ways}");

            render(&format!("--samples 0..16 -o a.exr {first}"));
            render(&format!("--samples 16..24 -o b.exr {then}"));
            render(&format!("--samples 24..48 -o c.exr {then}"));
            render(&format!("--samples 48..64 -o d.exr {first}"));
            for parts in ["d.exr b.exr a.exr c.exr", "a.exr b.exr c.exr d.exr"] {
                sandbox.says(&format!("merge --quiet {parts} -o out.exr")).exits(0);
                assert_eq!(sandbox.holds("out.exr").difference(&full), [""; 0], "joined: {ways}, {parts}");
            }
            // What is joined is a part, also with a gap, which a render fills.
            sandbox.says("merge --quiet --allow-gaps d.exr b.exr -o e.exr").exits(0);
            assert_eq!(sandbox.holds("e.exr").samples, "16..24, 48..64");
            sandbox.says("merge --quiet e.exr c.exr a.exr -o out.exr").exits(0);
            assert_eq!(sandbox.holds("out.exr").difference(&full), [""; 0], "joined in two steps: {ways}");
            render(&format!("--spp 64 -o e.exr --resume {then}"));
            assert_eq!(sandbox.holds("e.exr").difference(&full), [""; 0], "gaps are filled: {ways}");
            for name in ["a", "b", "c", "d", "e"] {
                fs::remove_file(sandbox.path(&format!("{name}.exr"))).expect("it was there");
            }
        }
        fs::remove_file(sandbox.path("full.exr")).expect("it was there");
        fs::remove_file(sandbox.path("out.exr")).expect("it was there");
    }
}

/// Off the ends of runs, the result is the same but for the rounding of f32, and that is said.
#[test]
fn within_a_run_the_image_agrees_to_rounding() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 40 -o full.exr").exits(0);
    sandbox.render("--quiet --spp 13 -o out.exr").exits(0);
    sandbox.render("--spp 40 -o out.exr --resume").exits(0).on_stderr(&["ends within a run of 8 samples"]);
    sandbox.render("--quiet --samples 0..13 -o a.exr").exits(0);
    sandbox.render("--quiet --samples 13..40 -o b.exr").exits(0);
    sandbox.says("merge a.exr b.exr -o joined.exr").exits(0).on_stderr(&["within a run of 8 samples"]);
    let full = sandbox.holds("full.exr");
    for name in ["out.exr", "joined.exr"] {
        let held = sandbox.holds(name);
        assert_eq!((held.samples.as_str(), held.film.totals.paths), ("0..40", full.film.totals.paths));
        // A run of 8 samples is summed in f32: seven roundings of 2^-24 of it, in either.
        for (a, b) in held.rgb.as_flattened().iter().zip(full.rgb.as_flattened()) {
            assert!((a - b).abs() <= 16.0 * f32::EPSILON * b.abs(), "{a} and {b}");
        }
    }
}

/// A render until an error goes on to the same number of samples, with the same checks; one that has reached it is done.
#[test]
fn a_render_until_an_error_goes_on() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --noise 0.04 -o full.exr").exits(0);
    let full = sandbox.holds("full.exr");
    assert!(full.checks > 3, "{} checks", full.checks);
    // As an interrupt leaves it: with the checks at 16, 32, … samples up to there.
    for (end, checks) in [(8, 0), (16, 0), (24, 1), (32, 1), (40, 2)] {
        sandbox.render(&format!("--quiet --spp {end} -o out.exr --force")).exits(0);
        sandbox.change("out.exr", |state| state.checks = checks);
        sandbox.render("--quiet --noise 0.04 -o out.exr --resume").exits(0);
        assert_eq!(sandbox.holds("out.exr").difference(&full), [""; 0], "from {end} samples");
    }
    let before = fs::read(sandbox.path("full.exr")).expect("it is read");
    let ran = sandbox.render("--json --noise 0.04 -o full.exr --resume").exits(0);
    assert_eq!(ran.json()["noise_reached"], true);
    assert!(fs::read(sandbox.path("full.exr")).expect("it is read") == before, "nothing was left to do");
}

/// A finished render is done: exit status 0, the file as it was, and the report of what it holds.
#[test]
fn a_finished_render_is_done() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 16 -o out.exr").exits(0);
    let before = fs::read(sandbox.path("out.exr")).expect("it is read");
    for options in ["--spp 16", "--spp 8"] {
        let ran = sandbox.render(&format!("{options} -o out.exr --resume --json --png out.png")).exits(0);
        let report = ran.json();
        assert_eq!((&report["resumed_from"], &report["samples_per_pixel"]), (&16.into(), &16.into()), "{report}");
        assert!(ran.last_line().contains("16 samples (16 of them resumed)"), "{}", ran.stderr);
        assert!(fs::read(sandbox.path("out.exr")).expect("it is read") == before);
        assert!(sandbox.path("out.png").exists());
    }
    // Without --resume it would be lost.
    sandbox.render("--spp 8 -o out.exr").exits(2).on_stderr(&["holds 16 samples per pixel of this render", "--force"]);
    assert!(fs::read(sandbox.path("out.exr")).expect("it is read") == before);
    // So it would where the number of samples is not known before.
    let ran = sandbox.render("--noise 0.9 --spp 8 -o out.exr --png less.png --json").exits(0);
    let report = ran.on_stderr(&["out.exr stays as it was: it holds 16 samples", "--force"]).json();
    assert_eq!((&report["samples_per_pixel"], &report["output_samples"]), (&8.into(), &16.into()), "{report}");
    assert!(sandbox.path("less.png").exists());
    assert!(fs::read(sandbox.path("out.exr")).expect("it is read") == before);
    for goal in ["--spp 8", "--noise 0.9 --spp 8"] {
        sandbox.render("--quiet --spp 16 -o out.exr").exits(0);
        sandbox.render(&format!("--quiet {goal} -o out.exr --force")).exits(0);
        assert_eq!(sandbox.holds("out.exr").samples, "0..8", "{goal}");
    }
}

/// What does not fit together is refused with exit status 2, and the message names it. The file stays as it was.
#[test]
fn resume_refuses_another_render_and_names_the_difference() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 16 -o out.exr").exits(0);
    sandbox.render("--quiet --samples 16..32 -o part.exr").exits(0);
    let before = fs::read(sandbox.path("out.exr")).expect("it is read");
    let refused = |line: &str, names: &[&str]| {
        sandbox.render(&format!("{line} -o out.exr")).exits(2).on_stderr(names);
        assert!(fs::read(sandbox.path("out.exr")).expect("it is read") == before, "{line}");
    };
    for auto in ["--resume", "--resume=auto"] {
        let other = |line: &str, names: &[&str]| refused(&format!("--spp 32 {auto} {line}"), names);
        other("--seed 1", &["--seed is 1", "and 0 in out.exr"]);
        other("--max-depth 5", &["--max-depth is 5"]);
        other("--size 12x8", &["--size is 12x8"]);
        other("--sampler independent", &["--sampler is independent"]);
        other("--clamp 3", &["--clamp is 3", "off in out.exr"]);
        other("--roulette off", &["--roulette is off"]);
    }
    refused("--samples 16..32 --resume", &["0..16", "not asked for"]);
    refused("--resume --samples 8..64 --noise 0.1", &["cannot be used with"]);

    // The scene: comments, formatting and the paths of files are no part of it.
    sandbox.write("scene.ron", &format!("// A comment.\n{}", SCENE.replace("radius: 0.6", "radius:   0.60")));
    sandbox.render("--quiet --spp 16 -o out.exr --resume").exits(0);
    sandbox.write("scene.ron", &SCENE.replace("radius: 0.6", "radius: 0.61"));
    refused("--spp 32 --resume", &["the scene differs"]);
    fs::create_dir(sandbox.path("textures")).expect("a folder is made");
    fs::copy(sandbox.path("floor.png"), sandbox.path("textures/wood.png")).expect("it is copied");
    sandbox.write("scene.ron", &SCENE.replace("floor.png", "textures/wood.png"));
    sandbox.render("--quiet --spp 16 -o out.exr --resume").exits(0);
    let texture = image::RgbImage::from_fn(4, 4, |x, _| image::Rgb([201, 40 * x as u8, 60]));
    texture.save(sandbox.path("textures/wood.png")).expect("the texture is written");
    refused("--spp 32 --resume", &["textures/wood.png"]);
    sandbox.write("scene.ron", SCENE);

    // There is nothing to resume.
    let said = sandbox.render("--spp 8 -o missing.exr --resume").exits(2).stderr;
    assert!(said.contains("nothing to resume: missing.exr is not there") && said.contains("--resume=auto"), "{said}");
    sandbox.render("--spp 8 -o missing.exr --resume=auto").exits(0).on_stderr(&["nothing to resume", "starts afresh"]);
    sandbox.render("--quiet --spp 8 --no-state -o bare.exr").exits(0);
    sandbox.render("--spp 16 -o bare.exr --resume").exits(2).on_stderr(&["bare.exr has no state"]);

    // Parts.
    let refused = |line: &str, names: &[&str]| {
        sandbox.says(&format!("merge {line} -o joined.exr")).exits(2).on_stderr(names);
        assert!(!sandbox.path("joined.exr").exists(), "{line}");
    };
    refused("out.exr out.exr", &["overlap", "out.exr", "0..16"]);
    sandbox.render("--quiet --samples 12..20 -o middle.exr").exits(0);
    refused("part.exr middle.exr out.exr", &["overlap", "out.exr and middle.exr", "12..16"]);
    sandbox.render("--quiet --samples 40..48 -o late.exr").exits(0);
    refused("late.exr out.exr part.exr", &["gap", "32..40", "part.exr", "--allow-gaps"]);
    sandbox.render("--quiet --samples 16..32 --seed 3 -o seed.exr").exits(0);
    refused("out.exr seed.exr", &["mismatch", "out.exr", "seed.exr", "--seed is 0 in out.exr and 3 in seed.exr"]);
    refused("out.exr bare.exr", &["bare.exr", "no state", "--no-state"]);
    refused("out.exr scene.ron", &["scene.ron", "cannot read"]);
    refused("out.exr missing2.exr", &["missing2.exr", "cannot read"]);
    sandbox.says("merge out.exr part.exr -o out.exr").exits(2);
    assert!(fs::read(sandbox.path("out.exr")).expect("it is read") == before);
}

/// Another driver may round otherwise: it is refused, unless it is allowed; then the header lists both.
#[test]
fn drivers_are_mixed_only_on_request() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --samples 0..8 -o a.exr").exits(0);
    sandbox.render("--quiet --samples 8..16 -o b.exr").exits(0);
    // As if another driver had rendered it.
    sandbox.change("a.exr", |state| state.devices = vec![("Some GPU".to_string(), "driver 1.0".to_string())]);
    sandbox.render("--spp 16 -o a.exr --resume").exits(2).on_stderr(&["Some GPU (driver 1.0)", "--mixed-drivers"]);
    sandbox.says("merge a.exr b.exr -o joined.exr").exits(2).on_stderr(&["mismatch", "Some GPU (driver 1.0)"]);
    sandbox.says("merge --quiet --mixed-drivers a.exr b.exr -o joined.exr").exits(0);
    sandbox.render("--quiet --spp 16 -o a.exr --resume --mixed-drivers").exits(0);
    for name in ["joined.exr", "a.exr"] {
        let attributes = read_attributes(&sandbox.path(name)).expect("it is read");
        let driver = attributes.iter().find(|(name, _)| name == "gpu-rt:driver").expect("it is there");
        assert!(matches!(&driver.1, Attribute::Text(text) if text.starts_with("driver 1.0; ")), "{name}: {driver:?}");
    }
}

/// Several devices render one film: the bytes are those of one device, also after an interrupt.
#[cfg(unix)]
#[test]
fn several_devices_have_the_bytes_of_one() {
    let sandbox = Sandbox::new();
    let several = |devices: usize| vec![software(); devices].join(",");
    let render = |devices: usize, more: &str| {
        sandbox.says(&format!("render scene.ron --quiet --device {} --spp 520 {more}", several(devices))).exits(0)
    };
    render(1, "-o one.exr");
    for devices in [2, 3] {
        render(devices, "-o several.exr --checkpoint 0.05s");
        assert_eq!(sandbox.holds("several.exr").difference(&sandbox.holds("one.exr")), [""; 0], "{devices} devices");
    }
    // What several devices leave when they are stopped may have gaps.
    let line =
        format!("render scene.ron --quiet --device {} --spp 100000000 -o out.exr --checkpoint 0.05s", several(3));
    let mut child = command(sandbox.folder.path(), &words(&line)).spawn().expect("it starts");
    meanwhile(&mut child, || sandbox.path("out.exr").exists());
    send(&child, libc::SIGTERM);
    finish(child).exits(143);
    sandbox.is_one_render(u64::from(opened(&sandbox.path("out.exr")).0.samples.range().end) + 8);
    // Also a render until an error goes on with gaps.
    let gaps = "merge --quiet --allow-gaps a.exr b.exr -o gaps.exr";
    sandbox.render("--quiet --samples 0..8 -o a.exr").exits(0);
    sandbox.render("--quiet --samples 32..40 -o b.exr").exits(0);
    for (goal, image) in [("--spp 64 --noise 0.0001", "noise.exr"), ("--spp 64 --time 1h", "time.exr")] {
        sandbox.says(gaps).exits(0);
        sandbox.render(&format!("--quiet {goal} -o gaps.exr --resume")).exits(0);
        sandbox.render(&format!("--quiet {goal} -o {image}")).exits(0);
        let (mut resumed, full) = (sandbox.holds("gaps.exr"), sandbox.holds(image));
        assert!(resumed.film.totals.paths > 40 * 24 * 16);
        // The checks are those of the part that has been joined, and later ones.
        resumed.checks = full.checks;
        resumed.attributes.clone_from(&full.attributes);
        assert_eq!(resumed.difference(&full), [""; 0], "{goal}");
    }
}

/// A render that --time ends consists of complete runs, also if the time is over before it begins: it goes on to the bytes of one render.
#[test]
fn a_render_that_time_ends_goes_on() {
    let sandbox = Sandbox::new();
    let mut before = 0;
    for (time, more) in [("0.7s", ""), ("1ms", "--resume"), ("0.7s", "--resume")] {
        let ran = sandbox.render(&format!("--time {time} -o out.exr {more}")).exits(0);
        let is_late = ran.stderr.contains("warning: --time 0.001 s is over before rendering begins: ");
        assert_eq!(is_late, time == "1ms", "{}", ran.stderr);
        let held = sandbox.count();
        assert!(held > before && held.is_multiple_of(8), "{held} after {before}");
        before = held;
    }
    sandbox.is_one_render(before + 16);
    // Within a run the last bits would differ.
    sandbox.render("--quiet --spp 13 -o out.exr --force").exits(0);
    sandbox.render("--quiet --spp 24 -o out.exr --resume").exits(0);
    sandbox.render("--quiet --spp 24 -o full.exr --force").exits(0);
    assert!(sandbox.holds("out.exr").film != sandbox.holds("full.exr").film);
}

/// A render that is stopped says what it has, and goes on from there.
#[cfg(unix)]
#[test]
fn an_interrupted_render_goes_on() {
    let sandbox = Sandbox::new();
    let mut child = sandbox.spawn("--spp 100000 --quiet --checkpoint 0.05s -o out.exr");
    meanwhile(&mut child, || sandbox.path("out.exr").exists());
    send(&child, libc::SIGINT);
    let ran = finish(child);
    assert!(ran.stderr.contains("out.exr holds") && ran.stderr.contains("--resume"), "{}", ran.stderr);
    let held = sandbox.count();
    let says = format!("holds {held} samples per pixel");
    assert!(ran.stderr.contains(&says) && held.is_multiple_of(8), "{}", ran.stderr);
    sandbox.is_one_render(held + 16);
}

/// A render that is killed at any moment leaves a file that can be read, and that a later one goes on from.
#[cfg(unix)]
#[test]
fn a_killed_render_goes_on() {
    killed_at_moments(10);
}

#[cfg(unix)]
#[test]
#[ignore = "minutes: make test-long"]
fn a_render_killed_at_200_moments_goes_on() {
    killed_at_moments(200);
}

#[cfg(unix)]
fn killed_at_moments(moments: u64) {
    let sandbox = Sandbox::new();
    let mut held = 0;
    for moment in 0..moments {
        let mut child = sandbox.spawn("--spp 1000000 --quiet --checkpoint 0.02s --resume=auto -o out.exr");
        if moment == 0 {
            meanwhile(&mut child, || sandbox.path("out.exr").exists());
        }
        // Some starting, some rendering, some writing.
        std::thread::sleep(Duration::from_millis(moment * 977 % 400));
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        held = sandbox.holds_at_least(held);
    }
    assert_eq!(attribute(&sandbox.image("out.exr"), "gpu-rt:complete"), "0");
    sandbox.is_one_render(held + 8);
}

/// A render is killed at each call of the system on files, from the first of a checkpoint to the last: the old file is there, or the new one.
#[cfg(target_os = "linux")]
#[test]
fn a_render_killed_within_a_checkpoint_goes_on() {
    killed_at_calls(11);
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "minutes: make test-long"]
fn a_render_killed_at_each_call_of_a_checkpoint_goes_on() {
    killed_at_calls(1);
}

/// At every so many calls of a checkpoint.
#[cfg(target_os = "linux")]
fn killed_at_calls(step: usize) {
    use crate::common::kills::kill_before;
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --size 24x16 --spp 8 -o out.exr").exits(0);
    let mut held = 8;
    let killed = |call: usize| {
        let command = sandbox.command("--spp 100000000 --quiet --checkpoint 1ns --resume -o out.exr");
        assert!(kill_before(command, call), "the render has ended by itself");
    };
    // The end of a checkpoint.
    let mut calls = 1;
    let last = loop {
        killed(calls);
        let now = sandbox.holds_at_least(held);
        if now > held {
            break calls;
        }
        calls += if step == 1 { 1 } else { 5 };
        assert!(calls < 10_000, "no checkpoint is ever written");
    };
    for call in (1..=last + 3).step_by(step) {
        killed(call);
        held = sandbox.holds_at_least(held);
    }
    // Only the last one may have left a temporary file, which the next start removes.
    sandbox.is_one_render(held + 8);
    assert_eq!(files(sandbox.folder.path(), ".part", false), Vec::<PathBuf>::new());
}

/// A checkpoint never replaces one of the same render that holds more: another process may be ahead.
#[test]
fn a_checkpoint_of_more_samples_stays() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 4096 -o out.exr").exits(0);
    let before = fs::read(sandbox.path("out.exr")).expect("it is read");
    let mut child = sandbox.spawn("--spp 100000000 --checkpoint 0.02s -o out.exr");
    let mut seen = false;
    for _ in 0..40 {
        std::thread::sleep(Duration::from_millis(10));
        sandbox.holds_at_least(4096);
        seen |= fs::read(sandbox.path("out.exr")).expect("it is read") == before;
    }
    assert!(seen);
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
}

/// A file that is damaged anywhere is refused, or is what it was; nothing panics, and no wrong total is taken.
#[test]
fn damaged_states_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 8 --size 6x5 -o out.exr").exits(0);
    let full = sandbox.holds("out.exr");
    let bytes = fs::read(sandbox.path("out.exr")).expect("it is read");
    let path = sandbox.path("broken.exr");
    let read = |bytes: &[u8]| -> Option<Film> {
        fs::write(&path, bytes).expect("it is written");
        let state = read_state(&path).ok()??;
        let mut film = state.film().ok()?;
        add_film(&path, &state, &mut film).ok()?;
        Some(film.film)
    };
    assert!(read(&bytes).expect("it is whole") == full.film);
    let mut refused = 0;
    for position in (0..bytes.len()).step_by(3) {
        let mut broken = bytes.clone();
        broken[position] ^= 1 << (position % 8);
        match read(&broken) {
            // The bit was in the picture, or in an attribute that nothing goes on from.
            Some(film) => assert!((0..30).all(|pixel| film.words(pixel) == full.film.words(pixel)), "byte {position}"),
            None => refused += 1,
        }
        assert!(read(&bytes[..position]).is_none_or(|film| film == full.film), "{position} bytes");
    }
    assert!(refused > 0);
}

/// A bit of the name, the type, the size and the value of each attribute of the header is flipped in turn. Where gpu-rt goes on from an
/// attribute, `merge` refuses the file; elsewhere it writes the bytes that it writes of the good one.
#[test]
fn damaged_headers_are_refused_or_change_nothing() {
    let sandbox = Sandbox::new();
    let render = |more: &str| sandbox.render(&format!("--size 6x5 --aov material {more}"));
    render("--quiet --spp 8 -o good.exr").exits(0);
    render("--quiet --samples 8..16 -o b.exr").exits(0);
    let good = fs::read(sandbox.path("good.exr")).expect("it is read");
    let text = |name: &str| sandbox.path(name).display().to_string();
    let joined = |bytes: &[u8]| -> Result<Vec<u8>, Error> {
        fs::write(sandbox.path("a.exr"), bytes).expect("it is written");
        let words = ["gpu-rt", "merge", &text("a.exr"), &text("b.exr"), "--quiet", "-o", &text("out.exr")];
        commands::run(&Cli::try_parse_from(words).expect("a command"), Instant::now())?;
        Ok(fs::read(sandbox.path("out.exr")).expect("it is read"))
    };
    let expected = joined(&good).expect("it is whole");
    let (mut refused, mut unchanged) = (0, 0);
    for field in fields(&good) {
        let name = field.name_in(&good);
        let steps = [0, 1, 2, 3, 4].map(|share| field.value.start + field.value.len() * share / 5);
        let value = steps.into_iter().filter(|at| field.value.contains(at));
        let mut offsets: Vec<usize> =
            [field.name.end - 1, field.kind.start, field.size.start].into_iter().chain(value).collect();
        offsets.dedup();
        for at in offsets {
            let mut broken = good.clone();
            broken[at] ^= 1 << (at % 7);
            match joined(&broken) {
                Err(error) => {
                    assert_eq!(error.exit_status(), 2, "{name}, byte {at}: {error}");
                    refused += 1;
                }
                Ok(bytes) => {
                    assert!(!name.starts_with("gpu-rt:"), "part {}, {name}, byte {at}", field.part);
                    assert!(bytes == expected, "part {}, {name}, byte {at}", field.part);
                    unchanged += 1;
                }
            }
        }
    }
    println!("{refused} refused, {unchanged} unchanged");
    assert!(refused > 200 && unchanged > 5, "{refused} refused, {unchanged} unchanged");

    // The checksum alone refuses a header that can be read, and merge hands on what it says.
    let hash = field(&good, 0, "gpu-rt:scene_hash").value;
    let mut broken = good.clone();
    broken[hash.clone()].fill(b'9');
    let error = joined(&broken).expect_err("another hash").to_string();
    assert!(error.contains("a.exr: cannot read: its header is damaged"), "{error}");
    let bytes = joined(&sealed(broken.clone())).expect("its checksum is right");
    assert_eq!(&bytes[field(&bytes, 0, "gpu-rt:scene_hash").value], "9".repeat(hash.len()).as_bytes());
    // A render does not go on from it, nor replace it.
    for resume in ["--resume", "--resume=auto"] {
        fs::write(sandbox.path("a.exr"), &broken).expect("it is written");
        render(&format!("--spp 16 -o a.exr {resume}")).exits(2).on_stderr(&["its header is damaged"]);
        assert!(fs::read(sandbox.path("a.exr")).expect("it is there") == broken);
    }
    // Attributes of other programs may be there; merge does not hand them on.
    let start = field(&good, 0, "gpu-rt:version").name.start;
    let more = moved(&good, start, b"owner\0string\0\x02\0\0\0me");
    assert!(joined(&more).expect("an attribute more") == expected);
}

/// The file with these bytes more in its header, so that its tables of offsets tell where its blocks are now.
fn moved(bytes: &[u8], at: usize, more: &[u8]) -> Vec<u8> {
    let tables = fields(bytes).last().expect("attributes").value.end + 2;
    let first = u64::from_le_bytes(bytes[tables..tables + 8].try_into().expect("eight bytes")) as usize;
    let mut moved = bytes.to_vec();
    for offset in moved[tables..first].as_chunks_mut::<8>().0 {
        *offset = (u64::from_le_bytes(*offset) + more.len() as u64).to_le_bytes();
    }
    moved.splice(at..at, more.iter().copied());
    moved
}

/// A file of an earlier format says so, and is refused: what wrote it goes on with it.
#[test]
fn an_earlier_format_is_named() {
    let sandbox = Sandbox::new();
    sandbox.render("--quiet --spp 8 --size 6x5 -o out.exr").exits(0);
    let mut bytes = fs::read(sandbox.path("out.exr")).expect("it is read");
    let state = field(&bytes, 1, "gpu-rt:state").value;
    let said = b"\"format\":2";
    let at = bytes[state.clone()].windows(said.len()).position(|window| window == said).expect("it says its format");
    bytes[state.start + at + said.len() - 1] = b'1';
    fs::write(sandbox.path("out.exr"), bytes).expect("it is written");
    for line in ["--spp 16 --resume", "--spp 16 --resume=auto"] {
        let words = "out.exr: cannot read: its state has the format 1, and this version of gpu-rt reads 2";
        sandbox.render(&format!("--size 6x5 -o out.exr {line}")).exits(2).on_stderr(&[words]);
    }
}

/// Ten thousand parts take no more memory than two, and one command.
#[test]
fn ten_thousand_parts_are_joined() {
    const PARTS: u32 = 10_000;
    let sandbox = Sandbox::new();
    let ends = |part: u32| (10_000_000 + 8 * part, 10_000_008 + 8 * part);
    let (start, end) = ends(0);
    sandbox.render(&format!("--quiet --size 3x2 --samples {start}..{end} -o part.exr")).exits(0);
    let bytes = fs::read(sandbox.path("part.exr")).expect("it is read");
    let said = format!("[[{start},{end}]]");
    let at = bytes.windows(said.len()).position(|window| window == said.as_bytes()).expect("the state says its range");
    let mut names = Vec::new();
    // Not in their order.
    for part in (0..PARTS).map(|number| number * 7 % PARTS) {
        let (start, end) = ends(part);
        let mut bytes = bytes.clone();
        bytes[at..at + said.len()].copy_from_slice(format!("[[{start},{end}]]").as_bytes());
        let name = format!("{part}.exr");
        fs::write(sandbox.path(&name), sealed(bytes)).expect("it is written");
        names.push(name);
    }
    let mut arguments = vec!["merge", "--json", "-o", "joined.exr"];
    arguments.extend(names.iter().map(String::as_str));
    let report = run(sandbox.folder.path(), &arguments).exits(0).json();
    assert_eq!((&report["parts"], &report["samples_per_pixel"]), (&PARTS.into(), &(8 * PARTS).into()));
    let held = sandbox.holds("joined.exr");
    assert_eq!(
        (held.samples, held.film.totals.paths),
        (format!("{start}..{}", ends(PARTS - 1).1), 6 * 8 * u64::from(PARTS))
    );
    // All parts have the pixels of the first one, and so has their mean.
    let first = read_exr(&sandbox.path("part.exr")).expect("it is read");
    assert_eq!(held.rgb, first.rgb);
}
