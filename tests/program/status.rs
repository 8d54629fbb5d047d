//! `gpu-rt status`: its report about a folder of parts, whatever their state.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use gpu_rt::cluster::Folder;
use gpu_rt::output::exr::{StateFile, add_film, write_render};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::common::device::index as software;
use crate::common::exr_header::sealed;
use crate::common::program::{Ran, command, meanwhile, run, words};

/// A lamp over a floor, and a part of the sky.
const SCENE: &str = "Scene(
    image: (width: 16, height: 9),
    camera: (look_from: (0, 1, 5), look_at: (0, 0.5, 0), vertical_fov: 45),
    background: Gradient(bottom: (0.2, 0.2, 0.2), top: (0.1, 0.2, 0.4)),
    materials: { \"floor\": Lambertian(albedo: Rgb(0.5, 0.6, 0.7)), \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7)) },
    objects: [
        Quad(corner: (-4, 0, -4), u: (0, 0, 8), v: (8, 0, 0), material: \"floor\"),
        Sphere(center: (0, 2, 0), radius: 0.5, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 12),
)
";

/// A folder above that of the job, which holds what `submit` writes, but for the scripts.
struct Sandbox {
    above: TempDir,
    folder: Folder,
}

impl Sandbox {
    /// A job of parts of so many samples each.
    fn new(parts: u32, each: u32) -> Sandbox {
        let above = tempfile::tempdir().expect("a temporary folder");
        let path = above.path().join("job");
        let job = json!({
            "format": 1,
            "version": env!("CARGO_PKG_VERSION"),
            "scene": "scene/scene.ron",
            "output": "scene.exr",
            "samples": [0, parts * each],
            "noise": null,
            "most": null,
            "parts": (0..parts).map(|part| [part * each, (part + 1) * each]).collect::<Vec<_>>(),
            "width": 16,
            "height": 9,
            "options": [],
            "sbatch": [],
        });
        fs::create_dir_all(path.join("scene")).expect("a folder is made");
        fs::create_dir_all(path.join("parts")).expect("a folder is made");
        fs::write(path.join("scene/scene.ron"), SCENE).expect("the scene is written");
        fs::write(path.join("job.json"), job.to_string()).expect("job.json is written");
        let folder = Folder::read(&path).expect("it is read");
        Sandbox { above, folder }
    }

    fn part(&self, number: u32) -> PathBuf {
        let [start, end] = self.folder.request.parts[number as usize];
        self.folder.part_path(&(start..end))
    }

    fn says(&self, line: &str) -> Ran {
        run(self.above.path(), &words(line))
    }

    /// Renders so many samples from the start of a part on.
    fn render(&self, number: u32, samples: u32, more: &str) -> Ran {
        let start = self.folder.request.parts[number as usize][0];
        let (end, part) = (start + samples, self.part(number));
        let line = format!("render job/scene/scene.ron --quiet --device {} --samples {start}..{end}", software());
        self.says(&format!("{line} -o {} {more}", part.display())).exits(0)
    }

    /// Makes a part look as if it had been written so long ago.
    fn age(&self, number: u32, seconds: u64) {
        let file = fs::File::options().write(true).open(self.part(number)).expect("it is there");
        let then = SystemTime::now().checked_sub(Duration::from_secs(seconds)).expect("it is a time");
        file.set_modified(then).expect("it can be aged");
    }

    fn status(&self, more: &str) -> Value {
        self.says(&format!("status job --json {more}")).exits(0).json()
    }

    /// How many parts are done, under way, stopped, not begun and not usable.
    fn counts(&self) -> [u64; 5] {
        let states = &self.status("")["parts_by_state"];
        ["done", "under_way", "stopped", "not_begun", "not_usable"]
            .map(|state| states[state].as_u64().unwrap_or_else(|| panic!("{state}: {states}")))
    }

    /// The paths and contents of all files of the job.
    fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let folders = ["", "parts", "scene"].map(|name| self.folder.path.join(name));
        let entries = folders.iter().flat_map(|folder| fs::read_dir(folder).expect("it is listed"));
        let paths = entries.map(|entry| entry.expect("it is listed").path()).filter(|path| path.is_file());
        let mut files: Vec<_> = paths.map(|path| (path.clone(), fs::read(path).expect("it is read"))).collect();
        files.sort();
        files
    }
}

/// From an empty folder to the joined image, each state of a part, and the JSON of each.
#[test]
fn parts_are_counted_by_their_states() {
    let sandbox = Sandbox::new(4, 16);
    assert_eq!(sandbox.counts(), [0, 0, 0, 4, 0]);
    let report = sandbox.status("");
    for (key, value) in [("samples_asked", 64), ("samples_done", 0), ("parts", 4), ("width", 16), ("height", 9)] {
        assert_eq!(report[key], value, "{key}: {report}");
    }
    assert_eq!((&report["image"], &report["seconds_left"]), (&"absent".into(), &Value::Null), "{report}");

    sandbox.render(0, 16, "");
    sandbox.render(1, 8, "");
    sandbox.render(2, 8, "");
    sandbox.age(2, 3600);
    assert_eq!(sandbox.counts(), [1, 1, 1, 1, 0]);
    let before = sandbox.files();
    let said = sandbox.says("status job").exits(0).stdout;
    for line in
        ["samples: 32 of 64 (50.0 %)", "parts: 4: 1 done, 1 under way, 1 stopped, 1 not begun", "is not there yet"]
    {
        assert!(said.contains(line), "{said}");
    }
    assert!(said.contains("time left: ") && said.contains("with one part at a time"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    assert!(sandbox.files() == before, "it has changed a file");

    // What is under way is a matter of the interval of the checkpoints: of 60 s unless it is given.
    sandbox.age(1, 120);
    assert_eq!(sandbox.counts(), [1, 1, 1, 1, 0]);
    sandbox.age(1, 190);
    assert_eq!(sandbox.counts(), [1, 0, 2, 1, 0]);
    let mut folder = sandbox.folder.clone();
    for options in [&["--checkpoint", "2m"][..], &["--checkpoint=2m"]] {
        folder.request.options = options.iter().map(ToString::to_string).collect();
        folder.write().expect("job.json is written");
        assert_eq!(sandbox.counts(), [1, 1, 1, 1, 0]);
    }
    // A clock that is ahead.
    let file = fs::File::options().write(true).open(sandbox.part(1)).expect("it is there");
    file.set_modified(SystemTime::now() + Duration::from_secs(3600)).expect("it can be aged");
    assert_eq!(sandbox.counts(), [1, 1, 1, 1, 0]);

    (1..4).for_each(|part| _ = sandbox.render(part, 16, "--resume=auto"));
    assert_eq!(sandbox.counts(), [4, 0, 0, 0, 0]);
    let parts: Vec<String> = (0..4).map(|part| sandbox.part(part).display().to_string()).collect();
    sandbox.says(&format!("merge --quiet {} -o job/scene.exr", parts[..2].join(" "))).exits(0);
    assert_eq!(sandbox.status("")["image"], "incomplete");
    sandbox.says("status job").exits(0).on_stdout(&["has 32 of 64 samples", "time left: none"]);
    sandbox.says(&format!("merge --quiet {} -o job/scene.exr", parts.join(" "))).exits(0);
    let report = sandbox.status("");
    assert_eq!((&report["image"], report["seconds_left"].as_f64()), (&"complete".into(), Some(0.0)), "{report}");
}

/// In rounds, the image is complete when the error is reached, also with fewer samples than requested.
#[test]
fn a_render_in_rounds_is_complete_when_its_error_is_reached() {
    let mut sandbox = Sandbox::new(4, 16);
    (sandbox.folder.request.noise, sandbox.folder.request.most) = (Some(0.3), Some(1024));
    sandbox.folder.write().expect("job.json is written");
    (0..4).for_each(|part| _ = sandbox.render(part, 16, ""));
    let join = |noise: &str| {
        sandbox.says(&format!("merge --quiet job/parts --noise {noise} -o job/scene.exr")).exits(0);
        sandbox.status("")["image"].clone()
    };
    assert_eq!(join("0.0001"), "incomplete");
    let said = sandbox.says("status job").exits(0).stdout;
    assert!(said.contains("--noise 0.3 is not reached; 64 samples are asked for so far, of 1024 at most"), "{said}");
    assert_eq!(join("0.3"), "complete");
    sandbox.says("status job").exits(0).on_stdout(&["--noise 0.3 is reached", "time left: none"]);
}

/// The time left follows from the pace of the processes, also of one that goes on with an earlier one's samples, and from the number of parts
/// under way.
#[test]
fn the_time_left_follows_from_the_pace() {
    let sandbox = Sandbox::new(4, 16);
    // The pace of a process does not count what it has found.
    sandbox.render(0, 8, "");
    let seconds = &sandbox.render(0, 16, "--resume --json").json()["seconds"];
    let [pace, all] = ["per_sample", "render"].map(|name| seconds[name].as_f64().expect("it is known"));
    assert!(pace > 0.0 && (8.0 * pace - all).abs() < 1e-9, "{pace} of {all}");
    assert_eq!(sandbox.status("")["seconds_per_sample"], pace);

    let left = || {
        let report = sandbox.status("");
        report["seconds_left"].as_f64().unwrap_or_else(|| panic!("{report}"))
            / report["seconds_per_sample"].as_f64().expect("it is known")
    };
    assert!((left() - 48.0).abs() < 1e-6, "one part at a time: {}", left());
    sandbox.render(1, 8, "");
    sandbox.render(2, 8, "");
    // 32 samples are missing, and two parts are under way.
    assert!((left() - 16.0).abs() < 1e-6, "{}", left());
    // One part cannot be shared.
    sandbox.render(3, 8, "");
    sandbox.render(1, 16, "--resume");
    sandbox.render(2, 15, "--resume");
    assert!((left() - 8.0).abs() < 1e-6, "{}", left());

    // A file without a pace.
    let path = sandbox.part(0);
    let file = StateFile::open(&path).expect("it is read").expect("there is a state");
    let (mut film, state) = (file.state.film().expect("it fits"), file.state.clone());
    file.add_to(&mut film).expect("it is read");
    write_render(&path, &film.film, &[], Some(&state), || Ok(())).expect("it is written");
    (1..4).for_each(|part| fs::remove_file(sandbox.part(part)).expect("it was there"));
    assert_eq!(sandbox.status("")["seconds_left"], Value::Null);
    sandbox.says("status job").exits(0).on_stdout(&["time left: unknown"]);
}

/// A checkpoint has the pace, and a part that is replaced all the time is never an error.
#[test]
fn a_render_that_goes_on_is_under_way() {
    let sandbox = Sandbox::new(2, 100_000_000);
    let part = sandbox.part(0).display().to_string();
    let line = format!(
        "render job/scene/scene.ron --quiet --device {} --samples 0..100000000 --checkpoint 1ms -o {part}",
        software()
    );
    let mut child = command(sandbox.above.path(), &words(&line)).spawn().expect("it starts");
    meanwhile(&mut child, || sandbox.part(0).exists());
    for _ in 0..10 {
        let report = sandbox.status("--error --png now.png");
        assert_eq!(report["parts_by_state"]["under_way"], 1, "{report}");
        assert!(report["seconds_left"].as_f64().is_some_and(|left| left > 0.0), "{report}");
        assert!(report["samples_done"].as_u64().is_some_and(|done| done >= 8), "{report}");
        assert_eq!(report["samples_done"].as_u64(), report["end_sample"].as_u64(), "{report}");
    }
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
}

/// The contents of an open file are consistent, even if it has been replaced since.
#[test]
fn an_open_part_stays_as_it_was() {
    let sandbox = Sandbox::new(1, 16);
    sandbox.render(0, 8, "");
    let open = || StateFile::open(&sandbox.part(0)).expect("it is read").expect("there is a state");
    let (file, other) = (open(), open());
    sandbox.render(0, 16, "--resume");
    let mut film = file.state.film().expect("it fits");
    file.add_to(&mut film).expect("its pixels are those of its state");
    assert_eq!(film.film.totals.paths, 8 * 16 * 9);
    // The file that is there now does not fit the state that was.
    assert!(add_film(&sandbox.part(0), &other.state, &mut film).is_err());
}

/// What is damaged, of another render, or of other samples is named with the reason, and the rest is counted.
#[test]
fn parts_that_cannot_be_used_are_named() {
    let sandbox = Sandbox::new(8, 16);
    for part in [2, 6, 7] {
        sandbox.render(part, 16, "");
    }
    sandbox.render(0, 16, "--seed 3");
    sandbox.render(1, 16, "--size 8x8");
    sandbox.render(3, 16, "--no-state");
    fs::copy(sandbox.part(2), sandbox.part(4)).expect("it is copied");
    let bytes = fs::read(sandbox.part(2)).expect("it is read");
    fs::write(sandbox.part(5), &bytes[..300]).expect("it is written");
    let reasons = [
        (0, "--seed is 3 in it and 0 in"),
        (1, "it has 8x8 pixels instead of 16x9"),
        (3, "no state"),
        (4, "it holds the samples 32..48, and those of this part are 64..80"),
        (5, ""),
    ];
    let report = sandbox.status("");
    assert_eq!(sandbox.counts(), [3, 0, 0, 0, 5], "{report}");
    assert_eq!(report["samples_done"], 48, "{report}");
    let said = sandbox.says("status job").exits(0).stdout;
    for (number, (part, words)) in reasons.into_iter().enumerate() {
        let not_usable = &report["not_usable"][number];
        let (path, reason) = (&not_usable["path"], not_usable["reason"].as_str().unwrap_or_default());
        let name = sandbox.part(part).file_name().expect("it has a name").to_string_lossy().into_owned();
        assert!(path.as_str().is_some_and(|path| path.ends_with(&name)), "{part}: {report}");
        assert!(!reason.is_empty() && reason.contains(words), "{part}: {report}");
        assert!(said.contains(&format!("{name}: {reason}")), "{said}");
    }
    // Only the others are joined.
    let report = sandbox.status("--error");
    assert_eq!((&report["samples_done"], &report["samples"]), (&48.into(), &"32..48, 96..128".into()), "{report}");

    // Damage of the pixels shows where they are read.
    let mut broken = bytes.clone();
    let end = broken.len();
    broken[end - 400..end - 200].fill(0x5a);
    fs::write(sandbox.part(2), broken).expect("it is written");
    assert_eq!(sandbox.counts(), [3, 0, 0, 0, 5]);
    sandbox.says("status job --error").exits(2).on_stderr(&["032-048.exr: cannot read"]);

    // The joined image may be damaged, or that of another render.
    fs::copy(sandbox.part(5), sandbox.folder.output()).expect("it is copied");
    assert_eq!(sandbox.status("")["image"], "not usable");
    fs::copy(sandbox.part(0), sandbox.folder.output()).expect("it is copied");
    sandbox.says("status job").exits(0).on_stdout(&["it is of another render than the parts: --seed is 3"]);
}

/// The joined error is that of `merge`, and the picture that of one render.
#[test]
fn the_error_and_the_picture_are_those_of_the_joined_parts() {
    let sandbox = Sandbox::new(4, 16);
    let said = sandbox.says("status job --error --png early.png").exits(0);
    assert!(said.stdout.contains("error unknown: there are no samples"), "{said:?}");
    assert!(said.stderr.contains("early.png has not been written") && !sandbox.above.path().join("early.png").exists());
    assert_eq!(sandbox.status("--error")["relative_error"], Value::Null);

    sandbox.render(0, 16, "");
    sandbox.render(2, 8, "");
    sandbox.render(3, 16, "");
    let join = |parts: &[u32]| {
        let parts: Vec<String> = parts.iter().map(|part| sandbox.part(*part).display().to_string()).collect();
        sandbox.says(&format!("merge --allow-gaps --json {} -o joined.exr", parts.join(" "))).exits(0).json()
    };
    let same = |report: &Value, joined: &Value| {
        let keys = "relative_error relative_error_bound relative_error_confidence relative_error_excludes reliable samples complete paths rays";
        for key in keys.split(' ') {
            assert!(report.get(key).is_some(), "{key}: {report}");
            assert_eq!(report[key], joined[key], "{key}");
        }
    };
    same(&sandbox.status("--error"), &join(&[0, 2, 3]));
    let report = sandbox.status("--error");
    let said = sandbox.says("status job --error").exits(0).stdout;
    let percent = |key: &str| format!("{:.2} %", 100.0 * report[key].as_f64().expect("it is known"));
    let line = format!(
        "relative error {} (95 % sure: below {}), of 40 samples",
        percent("relative_error"),
        percent("relative_error_bound")
    );
    assert!(said.contains(&line), "{said}");

    sandbox.render(1, 16, "");
    sandbox.render(2, 16, "--resume");
    same(&sandbox.status("--error"), &join(&[0, 1, 2, 3]));
    let full = format!("render job/scene/scene.ron --quiet --device {} --spp 64", software());
    for exposure in ["", "--exposure 1.5"] {
        sandbox.says(&format!("{full} -o full.exr --png full.png {exposure}")).exits(0);
        sandbox.says(&format!("status job --png now.png {exposure}")).exits(0);
        let read = |name: &str| fs::read(sandbox.above.path().join(name)).expect("it is read");
        assert!(read("now.png") == read("full.png"), "{exposure}");
        fs::remove_file(sandbox.above.path().join("full.exr")).expect("it was there");
    }
    // What it reads is never overwritten.
    let before = sandbox.files();
    for name in ["job/parts/00-16.exr", "job/scene/scene.ron", "job/job.json", "job/scene.exr"] {
        fs::write(sandbox.folder.output(), "").expect("it is written");
        sandbox.says(&format!("status job --png {name}")).exits(2).on_stderr(&["would overwrite the input", "--png"]);
        fs::remove_file(sandbox.folder.output()).expect("it was there");
    }
    assert!(sandbox.files() == before);
    sandbox.says("status job --png job/now.png").exits(0);
}

#[test]
fn status_refuses_a_folder_without_a_job() {
    let sandbox = Sandbox::new(2, 8);
    for folder in ["job/parts", "missing", "job/job.json"] {
        sandbox.says(&format!("status {folder}")).exits(2).on_stderr(&["job.json: cannot read", "gpu-rt submit"]);
    }
    fs::write(sandbox.folder.path.join("job.json"), "{}").expect("it is written");
    sandbox.says("status job").exits(2).on_stderr(&["job.json", "format"]);
    sandbox.says("status").exits(2);
}

/// A thousand parts within 5 seconds, of which this takes 0.13 on two cores. The files have a megabyte each, of which only the first 64 KiB are
/// there: whatever reads more than headers meets an error.
#[test]
fn a_thousand_parts_take_seconds() {
    const PARTS: u32 = 1000;
    let mut sandbox = Sandbox::new(PARTS, 8);
    (sandbox.folder.request.width, sandbox.folder.request.height) = (320, 180);
    sandbox.folder.request.samples = [10_000_000, 10_000_000 + 8 * PARTS];
    sandbox.folder.request.parts.iter_mut().flatten().for_each(|at| *at += 10_000_000);
    sandbox.folder.write().expect("job.json is written");
    sandbox.render(0, 8, "--size 320x180");
    let bytes = fs::read(sandbox.part(0)).expect("it is read");
    let said = |part: u32| format!("[[{},{}]]", 10_000_000 + 8 * part, 10_000_008 + 8 * part);
    let range = said(0);
    let at =
        bytes.windows(range.len()).position(|window| window == range.as_bytes()).expect("the state says its range");
    assert!(bytes.len() > 1 << 20, "{} bytes", bytes.len());
    for part in 0..PARTS {
        // All but the range is the same.
        let mut header = bytes[..64 << 10].to_vec();
        header[at..at + range.len()].copy_from_slice(said(part).as_bytes());
        fs::write(sandbox.part(part), sealed(header)).expect("it is written");
    }
    let start = Instant::now();
    let report = sandbox.status("");
    let took = start.elapsed();
    assert_eq!(
        (&report["parts_by_state"]["done"], &report["samples_done"]),
        (&PARTS.into(), &(8 * PARTS).into()),
        "{report}"
    );
    println!("{PARTS} parts: {took:?}");
    assert!(took < Duration::from_secs(5), "{took:?}");
}
