//! Everything to be measured on a machine with a GPU, in one run: `make gpu`. It runs the tests of kernels and images on the device, renders the
//! scenes in every way of linking, sweeps slots and workgroups, and times the stages. docs/gpu-NAME.md and a JSON beside it have the
//! figures, and say which defaults another value would beat.
//!
//! `gpu --program PATH [--tests PATH]... [--device SPEC] [--seconds N] [--out DIR]`, in the root of the repository. It needs no compiler and no
//! network: `make gpu-kit` packs what it runs.

#[path = "common/names.rs"]
mod names;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use gpu_rt::output::exr::read_exr;
use names::file_name;
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SCENES: [&str; 7] = ["weekend", "cornell", "mesh", "next-week", "instances", "lights", "glass"];
const WAYS: [&str; 3] = ["fused", "linked", "queues"];
/// Scenes whose slots and workgroups are swept.
const SWEPT: [&str; 2] = ["weekend", "mesh"];
const SLOTS: [u32; 6] = [4_096, 16_384, 65_536, 262_144, 1_048_576, 2_097_152];
const WORKGROUPS: [u32; 4] = [32, 64, 128, 256];
/// Shares of the time: tests, and each render. What is left is for compiling.
const SHARE_OF_TESTS: f64 = 0.4;
const SHARE_OF_RENDERS: f64 = 0.35;
/// Of the time of a render: the part without timestamps.
const SHARE_OF_TIMED: f64 = 0.7;
/// Another value of a setting is advised where it renders this much faster, by the geometric mean over the scenes.
const WORTH_IT: f64 = 1.1;
/// Renders that take less than this are mostly their start, of which nothing follows for longer ones: an NVIDIA H200 renders half a second faster
/// fused, and two seconds faster linked.
const LEAST_SECONDS: f64 = 1.5;
/// Between looks at a test that runs.
const PAUSE: Duration = Duration::from_millis(50);

/// What the command line says.
struct Arguments {
    program: PathBuf,
    tests: Vec<PathBuf>,
    device: String,
    seconds: f64,
    out: PathBuf,
}

/// A run under way: its arguments, the image's size, and when it must end.
struct Run {
    arguments: Arguments,
    size: &'static str,
    is_software: bool,
    end: Instant,
}

/// A render that was measured.
struct Rendered {
    scene: &'static str,
    setting: String,
    /// Its report, or why there is none.
    report: std::result::Result<Value, String>,
}

fn main() -> Result<()> {
    let arguments = arguments()?;
    let begin = Instant::now();
    let devices: Value =
        serde_json::from_slice(&output(Command::new(&arguments.program).args(["devices", "--json"]))?)?;
    let device = chosen(&devices, &arguments.device)?.clone();
    let is_software = device["software"] == true;
    let end = begin + Duration::from_secs_f64(arguments.seconds);
    let run = Run { arguments, size: if is_software { "64x36" } else { "640x360" }, is_software, end };
    let tests: Vec<Value> = run.arguments.tests.iter().map(|binary| run.test(binary, &device["index"])).collect();
    let same = run.ways_that_agree()?;
    let renders = run.renders();
    let seconds = run.seconds_of_render() * SHARE_OF_TIMED;
    let report = json!({
        "device": device,
        "seconds": begin.elapsed().as_secs_f64(),
        "size": run.size,
        "tests": tests,
        "same_bytes": same,
        "renders": renders.iter().map(Rendered::as_json).collect::<Vec<_>>(),
        "advice": if seconds < LEAST_SECONDS { Vec::new() } else { advice(&renders, is_software) },
        "seconds_of_render": seconds,
    });
    let name = file_name(device["name"].as_str().unwrap_or("device"));
    fs::create_dir_all(&run.arguments.out)?;
    let path = run.arguments.out.join(format!("gpu-{name}"));
    fs::write(path.with_extension("json"), serde_json::to_string_pretty(&report)?)?;
    let text = document(&report, &renders);
    fs::write(path.with_extension("md"), &text)?;
    println!("{text}\n{} has this.", path.with_extension("md").display());
    Ok(())
}

fn arguments() -> Result<Arguments> {
    let mut found = Arguments {
        program: "target/release/gpu-rt".into(),
        tests: Vec::new(),
        device: String::new(),
        seconds: 540.0,
        out: "docs".into(),
    };
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let value = words.next().ok_or(format!("{word}: a value is missing"))?;
        match word.as_str() {
            "--program" => found.program = value.into(),
            "--tests" => found.tests.push(value.into()),
            "--device" => found.device = value,
            "--seconds" => found.seconds = value.parse()?,
            "--out" => found.out = value.into(),
            _ => return Err(format!("{word}: expected --program, --tests, --device, --seconds or --out").into()),
        }
    }
    found.program = fs::canonicalize(&found.program)?;
    Ok(found)
}

/// The device of this index or name, or the default one.
fn chosen<'a>(devices: &'a Value, spec: &str) -> Result<&'a Value> {
    let all = devices["devices"].as_array().ok_or("no devices")?;
    let fits = |device: &&Value| match spec {
        "" => device["default"] == true,
        _ => {
            let name = device["name"].as_str().unwrap_or_default().to_lowercase();
            device["index"].as_u64().is_some_and(|index| spec.parse() == Ok(index))
                || name.contains(&spec.to_lowercase())
        }
    };
    all.iter().find(fits).ok_or_else(|| format!("no device is named {spec}").into())
}

/// What a command prints on stdout.
fn output(command: &mut Command) -> Result<Vec<u8>> {
    let done = command.stdin(Stdio::null()).output()?;
    match done.status.success() {
        true => Ok(done.stdout),
        false => {
            let said = String::from_utf8_lossy(&done.stderr).into_owned();
            Err(said.lines().last().unwrap_or("it failed").to_string().into())
        }
    }
}

impl Run {
    /// A software driver takes long to compile, and is here to test this program: it renders two scenes.
    fn scenes(&self) -> &'static [&'static str] {
        if self.is_software { &SCENES[..2] } else { &SCENES }
    }

    fn left(&self) -> f64 {
        self.end.saturating_duration_since(Instant::now()).as_secs_f64()
    }

    /// Runs a binary of tests on the device, for its share of the time: how many passed, and which failed.
    fn test(&self, binary: &Path, index: &Value) -> Value {
        let name = binary.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let share = self.arguments.seconds * SHARE_OF_TESTS / self.arguments.tests.len() as f64;
        eprintln!("{name}: for {share:.0} s at most");
        let log = std::env::temp_dir().join(format!("{name}.log"));
        let run = || -> Result<bool> {
            let mut child = Command::new(binary)
                .env("GPU_RT_TEST_DEVICE", index.to_string())
                .stdin(Stdio::null())
                .stdout(fs::File::create(&log)?)
                .stderr(Stdio::null())
                .spawn()?;
            let end = Instant::now() + Duration::from_secs_f64(share);
            while child.try_wait()?.is_none() {
                if Instant::now() > end {
                    child.kill()?;
                    child.wait()?;
                    return Ok(false);
                }
                std::thread::sleep(PAUSE);
            }
            Ok(true)
        };
        let ended = run().map_err(|error| error.to_string());
        let said = fs::read_to_string(&log).unwrap_or_default();
        let of = |end: &str| -> Vec<&str> {
            let lines = said.lines().filter(|line| line.starts_with("test ") && line.contains(end));
            lines.filter_map(|line| line.split_whitespace().nth(1)).collect()
        };
        let failures: Vec<&str> = said.lines().filter(|line| line.contains("panicked at")).collect();
        json!({
            "tests": name,
            "passed": of("... ok").len(),
            "failed": of("... FAILED"),
            "panics": failures,
            "complete": ended.as_ref().is_ok_and(|ended| *ended),
            "error": ended.err(),
        })
    }

    /// The report of a render.
    fn render(&self, scene: &str, size: &str, out: &Path, more: &[&str]) -> Result<Value> {
        let scene = format!("scenes/{scene}.ron");
        let mut command = Command::new(&self.arguments.program);
        command.args(["render", &scene, "--size", size, "--force", "--json", "--quiet", "-o"]).arg(out);
        if !self.arguments.device.is_empty() {
            command.args(["--device", &self.arguments.device]);
        }
        Ok(serde_json::from_slice(&output(command.args(more))?)?)
    }

    /// For each scene, whether all ways of linking make the same bytes.
    fn ways_that_agree(&self) -> Result<Vec<Value>> {
        let folder = tempfile::tempdir()?;
        let mut found = Vec::new();
        for scene in self.scenes() {
            eprintln!("{scene}: the same bytes");
            let image = |way: &str| -> Result<Vec<[f32; 3]>> {
                let out = folder.path().join("a.exr");
                self.render(scene, "64x36", &out, &["--spp", "8", "--scatter", way])?;
                Ok(read_exr(&out)?.rgb)
            };
            let images = WAYS.map(image);
            let same = match &images {
                [Ok(fused), Ok(linked), Ok(queues)] => json!(fused == linked && fused == queues),
                others => json!(
                    others.iter().filter_map(|image| image.as_ref().err()).map(ToString::to_string).collect::<Vec<_>>()
                ),
            };
            found.push(json!({"scene": scene, "same": same}));
        }
        Ok(found)
    }

    /// The scenes and settings of the renders that are measured.
    fn wanted(&self) -> Vec<(&'static str, String)> {
        let scenes = self.scenes();
        let of_scene = |scene: &'static str| WAYS.map(|way| (scene, format!("--scatter {way}")));
        let mut wanted: Vec<(&'static str, String)> = scenes.iter().copied().flat_map(of_scene).collect();
        for scene in SWEPT.into_iter().filter(|scene| scenes.contains(scene)) {
            wanted.push((scene, String::new()));
            wanted.extend(SLOTS.map(|slots| (scene, format!("--slots {slots}"))));
            wanted.extend(WORKGROUPS.map(|size| (scene, format!("--workgroup {size}"))));
        }
        wanted
    }

    fn seconds_of_render(&self) -> f64 {
        self.arguments.seconds * SHARE_OF_RENDERS / self.wanted().len() as f64
    }

    /// All renders that are measured, as far as the time allows.
    fn renders(&self) -> Vec<Rendered> {
        let (wanted, seconds) = (self.wanted(), self.seconds_of_render());
        let folder = tempfile::tempdir();
        let measure = |(scene, setting): (&'static str, String)| {
            eprintln!("{scene} {setting}");
            let report = match (&folder, self.left() > 2.0 * seconds) {
                (Err(error), _) => Err(error.to_string()),
                (_, false) => Err("no time was left".to_string()),
                (Ok(folder), true) => {
                    self.measure(scene, &setting, seconds, &folder.path().join("a.exr")).map_err(|e| e.to_string())
                }
            };
            Rendered { scene, setting, report }
        };
        wanted.into_iter().map(measure).collect()
    }

    /// Paths per second by a render of so many seconds, and the seconds of its stages by another one, which is shorter.
    fn measure(&self, scene: &str, setting: &str, seconds: f64, out: &Path) -> Result<Value> {
        let setting: Vec<&str> = setting.split_whitespace().collect();
        let render = |more: &[&str]| self.render(scene, self.size, out, &[&setting, more].concat());
        let time = |share: f64| format!("{:.2}s", share * seconds);
        // Kernels are compiled before the time that is measured.
        let first = render(&["--spp", "1"])?;
        let timed = render(&["--spp", "1000000", "--time", &time(SHARE_OF_TIMED)])?;
        let profiled = render(&["--spp", "1000000", "--time", &time(1.0 - SHARE_OF_TIMED), "--profile"])?;
        Ok(json!({
            "compile": first["seconds"]["compile"],
            "paths_per_second": timed["paths_per_second"],
            "host_share": timed["host_seconds"].as_f64().unwrap_or(0.0) / timed["seconds"]["render"].as_f64().unwrap_or(1.0),
            "idle": profiled["device_idle"],
            "stages": profiled["stage_seconds"],
        }))
    }
}

impl Rendered {
    fn as_json(&self) -> Value {
        let (report, error) = (self.report.as_ref().ok(), self.report.as_ref().err());
        json!({"scene": self.scene, "setting": self.setting, "report": report, "error": error})
    }

    fn pace(&self) -> Option<f64> {
        self.report.as_ref().ok()?["paths_per_second"].as_f64().filter(|pace| *pace > 0.0)
    }
}

/// The settings of a kind that render faster than the usual one by [`WORTH_IT`].
fn advice(renders: &[Rendered], is_software: bool) -> Vec<String> {
    let pace = |scene: &str, setting: &str| renders.iter().find(|r| r.scene == scene && r.setting == setting)?.pace();
    let mut settings: Vec<&str> = renders.iter().map(|render| render.setting.as_str()).collect();
    settings.sort_unstable();
    settings.dedup();
    let mut all = Vec::new();
    for setting in settings.into_iter().filter(|setting| !setting.is_empty()) {
        // What the program takes by itself (src/plan/tuning.rs).
        let usual = match setting.starts_with("--scatter") {
            true if is_software => "--scatter fused",
            true => "--scatter linked",
            false => "",
        };
        let ratios: Vec<f64> =
            SCENES.iter().filter_map(|scene| Some(pace(scene, setting)? / pace(scene, usual)?)).collect();
        if ratios.is_empty() {
            continue;
        }
        let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
        if mean > WORTH_IT {
            let than = if usual.is_empty() { "the default" } else { usual };
            all.push(format!("`{setting}` renders {mean:.2} times as fast as {than}, over {} scenes", ratios.len()));
        }
    }
    all
}

fn document(report: &Value, renders: &[Rendered]) -> String {
    let device = &report["device"];
    let text_of = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let mut text = format!(
        "# {}\n\nDriver: {}, {}. Images of {} pixels. Written by `make gpu` in {:.0} s.\n",
        text_of(&device["name"]),
        text_of(&device["driver"]),
        text_of(&device["backend"]),
        text_of(&report["size"]),
        report["seconds"].as_f64().unwrap_or(0.0),
    );
    text += "\n## What to change\n\n";
    let advice = report["advice"].as_array().cloned().unwrap_or_default();
    if report["seconds_of_render"].as_f64().is_some_and(|seconds| seconds < LEAST_SECONDS) {
        text += "The renders were too short to tell: most of each was its start. Give the run more seconds.\n";
    } else if advice.is_empty() {
        let _ = writeln!(text, "No other setting renders {WORTH_IT} times as fast as the defaults.");
    }
    advice.iter().for_each(|line| text += &format!("- {}\n", text_of(line)));
    text += "\n## Tests\n\n| tests | passed | failed | to their end |\n|---|--:|---|---|\n";
    for tests in report["tests"].as_array().into_iter().flatten() {
        let failed: Vec<String> = tests["failed"].as_array().into_iter().flatten().map(text_of).collect();
        let end = if tests["complete"] == true { "yes" } else { "no" };
        let _ =
            writeln!(text, "| {} | {} | {} | {end} |", text_of(&tests["tests"]), tests["passed"], failed.join(", "));
    }
    text += "\nThe same bytes by all ways of linking: ";
    let same = report["same_bytes"].as_array().cloned().unwrap_or_default();
    let same: Vec<String> = same.iter().map(|row| format!("{} {}", text_of(&row["scene"]), row["same"])).collect();
    let _ = writeln!(text, "{}.", same.join(", "));
    text += "\n## Renders\n\nStages are shares of the time of all of them.\n\n";
    text +=
        "| scene | setting | compile, s | million paths/s | host | idle | stages |\n|---|---|--:|--:|--:|--:|---|\n";
    for render in renders {
        let setting = if render.setting.is_empty() { "defaults" } else { &render.setting };
        let _ = match &render.report {
            Err(error) => writeln!(text, "| {} | `{setting}` | | {error} | | | |", render.scene),
            Ok(found) => {
                let percent =
                    |value: &Value| value.as_f64().map_or("–".to_string(), |share| format!("{:.0} %", 100.0 * share));
                let stages = found["stages"].as_object().cloned().unwrap_or_default();
                let all: f64 = stages.values().filter_map(Value::as_f64).sum();
                let mut shares: Vec<(f64, &String)> = stages
                    .iter()
                    .filter_map(|(name, seconds)| Some((seconds.as_f64()? / all.max(1e-12), name)))
                    .collect();
                shares.sort_by(|a, b| b.0.total_cmp(&a.0));
                let shares: Vec<String> = shares
                    .iter()
                    .filter(|(share, _)| *share >= 0.01)
                    .map(|(share, name)| format!("{name} {:.0} %", 100.0 * share))
                    .collect();
                writeln!(
                    text,
                    "| {} | `{setting}` | {:.2} | {:.2} | {} | {} | {} |",
                    render.scene,
                    found["compile"].as_f64().unwrap_or(0.0),
                    found["paths_per_second"].as_f64().unwrap_or(0.0) / 1e6,
                    percent(&found["host_share"]),
                    percent(&found["idle"]),
                    shares.join(", "),
                )
            }
        };
    }
    text
}
