//! Writes docs/accuracy.md, the findings of `gpu-rt tradeoff` on scenes of this repository, and docs/accuracy.tsv with all their settings.
//!
//! `cargo bench --bench accuracy [-- --budget 70s]`: the budget is for each scene. Denoising is measured in sweeps of its own, of half that;
//! `--denoising` measures and writes that section alone. GPU_RT_BENCH_DEVICE names the
//! device, if it is not the default one. `make accuracy` runs it.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use gpu_rt::Scene;
use gpu_rt::denoise::{Denoiser, Noisy};
use gpu_rt::tradeoff::judge::FLIP_TARGET;
use gpu_rt::tradeoff::model::samples_to;
use gpu_rt::tradeoff::report::{CAPTION, time_text};
use serde_json::Value;

/// The paths of the scenes, without their endings.
const SCENES: [&str; 6] = [
    "scenes/weekend",
    "scenes/cornell",
    "scenes/cornell-smoke",
    "scenes/next-week",
    "scenes/lights",
    "benches/glass-small-lamp",
];
/// The target whose times are compared over all scenes: its index among the report's targets.
const MIDDLE: usize = 1;
type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A scene's report, the contents of `tradeoff.json`.
struct Report {
    scene: &'static str,
    json: Value,
}

/// One setting in a report.
#[derive(Clone, Copy)]
struct Setting<'a>(&'a Value);

impl Report {
    fn settings(&self) -> impl Iterator<Item = Setting<'_>> {
        self.json["settings"].as_array().into_iter().flatten().map(Setting)
    }

    fn setting(&self, name: &str) -> Option<Setting<'_>> {
        self.settings().find(|setting| setting.name() == name)
    }

    /// The ratio of its time to the middle target to that of the defaults.
    fn ratio(&self, setting: Setting<'_>) -> Option<f64> {
        Some(setting.time(MIDDLE)? / self.setting("defaults")?.time(MIDDLE)?)
    }

    fn text(&self, key: &str) -> &str {
        self.json[key].as_str().unwrap_or_default()
    }

    fn link(&self) -> String {
        format!("[{0}](#{0})", self.scene)
    }
}

impl<'a> Setting<'a> {
    fn name(self) -> &'a str {
        self.0["setting"].as_str().unwrap_or_default()
    }

    fn number(self, key: &str) -> f64 {
        self.0[key].as_f64().unwrap_or(f64::NAN)
    }

    fn is(self, key: &str) -> bool {
        self.0[key] == true
    }

    fn time(self, target: usize) -> Option<f64> {
        self.0["seconds_to"][target]["seconds"].as_f64()
    }

    fn loses_detail(self) -> bool {
        self.0["class"] == "detail"
    }

    /// The bias of the mean in percent, optionally with half its interval.
    fn bias(self, interval: bool) -> String {
        let value = 100.0 * self.number("bias");
        let half = (100.0 * self.0["bias_interval"][1].as_f64().unwrap_or(f64::NAN) - value).abs();
        if value == 0.0 && half == 0.0 {
            return "0".to_string();
        }
        let digits = (1.0 - half.max(1e-9).log10().floor()).clamp(1.0, 8.0) as usize;
        match interval {
            true => format!("{value:+.digits$} ± {half:.digits$} %"),
            false => {
                let digits = (-value.abs().max(1e-9).log10().floor()).clamp(1.0, 8.0) as usize;
                format!("{value:+.digits$} %")
            }
        }
    }
}

/// A number with three digits.
fn short(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

fn measure(path: &'static str, budget: &str, folder: &Path) -> Result<Report> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scene = path.rsplit('/').next().unwrap_or(path);
    let out = folder.join(scene);
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.arg("tradeoff").arg(root.join(format!("{path}.ron"))).args(["--budget", budget, "--json", "-o"]);
    command.arg(&out);
    if let Ok(device) = std::env::var("GPU_RT_BENCH_DEVICE") {
        command.args(["--device", &device]);
    }
    let output = command.stderr(std::process::Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(format!("{scene}: {}", output.status).into());
    }
    fs::copy(out.join("plot.svg"), root.join("docs/plots").join(plot(scene)))?;
    Ok(Report { scene, json: serde_json::from_slice(&output.stdout)? })
}

fn plot(scene: &str) -> String {
    format!("accuracy-{scene}.svg")
}

/// The number of processors and their name.
fn machine() -> String {
    let about = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{count} x {}", name.map_or("an unnamed processor", |(_, name)| name))
}

fn document(reports: &[Report], denoising: &str, budget: &str) -> String {
    let first = &reports[0];
    let mut text = format!(
        "# Accuracy\n\nWhat the settings of `gpu-rt render` trade: seconds against noise and bias, measured by `gpu-rt tradeoff` on {} scenes.\n\
         Written by `make accuracy`; do not edit. [accuracy.tsv](accuracy.tsv) has all settings of each scene. [comparing.md](comparing.md#the-trade-measured) says what the numbers mean.\n\n\
         Measured on {} ({}), {}, {budget} per scene. On another device the advice may differ.\n\n{CAPTION} \
         A bias is that of the mean radiance, relative to the defaults with the same random numbers.\n\n",
        reports.len(),
        first.text("device"),
        first.text("driver"),
        machine(),
    );
    text += "## The defaults\n\n";
    text += "| scene | pixels | s / sample | noise, 1 sample | falls as | to 1e-1 | to 1e-2 | to 1e-3 |\n|---|---|---:|---:|---|---:|---:|---:|\n";
    for report in reports {
        let Some(defaults) = report.setting("defaults") else { continue };
        let [a, b, c] = [0, 1, 2].map(|target| time_text(defaults.time(target)));
        let _ = writeln!(
            text,
            "| {} | {}x{} | {} | {} | N^-{:.2} | {a} | {b} | {c} |",
            report.link(),
            report.json["whole_width"],
            report.json["whole_height"],
            short(defaults.number("seconds_per_sample")),
            short(defaults.number("variance_1spp")),
            defaults.number("exponent"),
        );
    }
    text += "\n## All settings\n\n";
    text += "The table has the ratio of the seconds to a relative MSE of 1e-2 to those of the defaults, and the bias of the mean if one was found. Less than \
             15 % is no difference. *Italic*: unreliable. never: the bias may be larger than the target. –: the setting does not affect the scene. \
             Empty: not measured.\n\n";
    text += &overview(reports);
    text += denoising;
    for report in reports {
        text += &section(report);
    }
    text
}

/// A row for each setting, a column for each scene.
fn overview(reports: &[Report]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for setting in reports.iter().flat_map(Report::settings) {
        if setting.name() != "defaults" && !names.contains(&setting.name()) {
            names.push(setting.name());
        }
    }
    names.sort_unstable();
    let mut text = "| setting | gives up |".to_string();
    reports.iter().for_each(|report| text += &format!(" {} |", report.link()));
    text += &format!("\n|---|---|{}\n", "---:|".repeat(reports.len()));
    for name in names {
        let class = reports.iter().find_map(|report| report.setting(name)?.0["class"].as_str()).unwrap_or_default();
        let _ = write!(text, "| `{name}` | {class} |");
        for report in reports {
            let Some(setting) = report.setting(name) else { continue };
            let words = match report.ratio(setting) {
                _ if setting.0["verdict"] == "not measured: does nothing to this scene" => "–".to_string(),
                _ if !setting.is("measured") => String::new(),
                None => "never".to_string(),
                Some(ratio) => format!("{ratio:.2}"),
            };
            let bias = match setting.is("biased") {
                true if setting.loses_detail() => format!(", bias² {:.0e}", setting.number("squared_bias")),
                true => format!(", {}", setting.bias(false)),
                false => String::new(),
            };
            let unreliable = setting.is("measured") && !setting.is("reliable");
            let words = if unreliable { format!("*{words}{bias}*") } else { format!("{words}{bias}") };
            let _ = write!(text, " {words} |");
        }
        text.push('\n');
    }
    text
}

const DENOISING: &str = "\n## Denoising\n";
/// Denoising is measured in the middle of the image: this part of its width and height. Its pixels are as small as those of the full image,
/// because a denoiser loses more of the detail in larger ones.
const MIDDLE_OF: u32 = 8;
/// How often denoising the full image is timed. The least counts.
const TIMED: u32 = 3;

/// A sweep of denoising over the middle of a scene.
struct Denoised {
    report: Report,
    full: (u32, u32),
    /// The seconds of denoising the full image.
    seconds: f64,
}

/// The text of a scene of which the image is the middle, and the size of the full image.
fn middle_of(path: &Path) -> Result<(String, (u32, u32))> {
    let text = fs::read_to_string(path)?;
    let scene = Scene::parse(&text, path)?;
    let (width, height, fov) = (scene.image.width, scene.image.height, scene.camera.vertical_fov.unwrap_or_default());
    // Parts of even sides stand in the middle of images of even sides; half a row does not matter.
    let (w, h) = (width / MIDDLE_OF / 4 * 4, height / MIDDLE_OF / 4 * 4);
    let narrow = 2.0 * ((0.5 * fov).to_radians().tan() * f64::from(h) / f64::from(height)).atan().to_degrees();
    let mut middle = text.clone();
    for (old, new) in [
        (format!("image: (width: {width}, height: {height})"), format!("image: (width: {w}, height: {h})")),
        (format!("vertical_fov: {fov}"), format!("vertical_fov: {narrow}")),
    ] {
        if middle.matches(&old).count() != 1 {
            return Err(format!("{}: expected `{old}` once", path.display()).into());
        }
        middle = middle.replace(&old, &new);
    }
    Ok((middle, (width, height)))
}

fn measure_denoised(path: &'static str, budget: &str, denoiser: &Denoiser, folder: &Path) -> Result<Denoised> {
    let scene = path.rsplit('/').next().unwrap_or(path);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("{path}.ron"));
    let (text, full) = middle_of(&file)?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.args(["tradeoff", "-", "--knobs", "denoise", "--budget", budget, "--json", "-o"]).arg(folder.join(scene));
    if let Ok(device) = std::env::var("GPU_RT_BENCH_DEVICE") {
        command.args(["--device", &device]);
    }
    // Paths in a scene on standard input are relative to the current folder.
    command.current_dir(file.parent().unwrap_or(Path::new(".")));
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
    child.stdin.take().ok_or("no standard input")?.write_all(text.as_bytes())?;
    let output = child.wait_with_output()?;
    if !output.status.success() {
        return Err(format!("{scene}: {}", output.status).into());
    }
    let layer = vec![[0.5; 3]; full.0 as usize * full.1 as usize];
    let noisy = Noisy { size: full, rgb: layer.clone(), albedo: Some(layer.clone()), normal: Some(layer) };
    let mut seconds = f64::INFINITY;
    for _ in 0..TIMED {
        let begin = Instant::now();
        denoiser.denoise(&noisy)?;
        seconds = seconds.min(begin.elapsed().as_secs_f64());
    }
    Ok(Denoised { report: Report { scene, json: serde_json::from_slice(&output.stdout)? }, full, seconds })
}

/// What denoising changes: a row for each scene.
fn denoising(all: &[Denoised], budget: &str) -> String {
    let mut text = format!(
        "{DENOISING}\n[`--denoise`](denoising.md) beside the defaults, in sweeps of {budget} over the middle of each image, with pixels as small as those of the full image unless the second \
         column says otherwise. Each pair is the defaults → `--denoise`, in seconds for the full image: compare them within a row. FLIP is that of an image with 4, 16 and 64 samples \
         against the mean of all rounds, whose own noise (third column) makes all FLIPs larger. Bias and bias² are those with 16 samples. –: not reached with 64 times the samples.\n\n\
         | scene | measured at | noise of the mean | FLIP with 4 samples | 16 | 64 | to FLIP 0.05 | to relative MSE 1e-2 | s / sample | denoising takes | bias of the \
         mean | bias² |\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for Denoised { report, full, seconds } in all {
        let (Some(raw), Some(denoised)) = (report.setting("defaults"), report.setting("--denoise")) else { continue };
        let number = |key: &str| report.json[key].as_f64().unwrap_or(f64::NAN);
        let parts = f64::from(full.0) * f64::from(full.1) / (number("whole_width") * number("whole_height"));
        let flips = |setting: Setting<'_>| -> Vec<(u32, f64)> {
            let all = setting.0["flip"].as_array().into_iter().flatten();
            all.filter_map(|flip| Some((flip["samples"].as_u64()? as u32, flip["flip"].as_f64()?))).collect()
        };
        let fixed = |setting: Setting<'_>| if setting.name() == "--denoise" { *seconds } else { 0.0 };
        let per_sample = |setting: Setting<'_>| parts * setting.number("seconds_per_sample");
        let to_flip = |setting: Setting<'_>| {
            let samples = samples_to(&flips(setting), FLIP_TARGET);
            samples.map_or("–".to_string(), |n| time_text(Some(fixed(setting) + n * per_sample(setting))))
        };
        let to_error = |setting: Setting<'_>| {
            let of_samples = setting.time(MIDDLE).map(|time| time - setting.number("seconds_beside"));
            time_text(of_samples.map(|time| fixed(setting) + parts * time))
        };
        let both = |of: &dyn Fn(Setting<'_>) -> String| format!("{} → {}", of(raw), of(denoised));
        let flip = |at: usize| both(&|setting| flips(setting).get(at).map_or(String::new(), |(_, flip)| short(*flip)));
        let _ = writeln!(
            text,
            "| {} | {}x{} of {}x{} | {:.0e} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0e} |",
            report.link(),
            report.json["width"],
            report.json["height"],
            report.json["whole_width"],
            report.json["whole_height"],
            number("relative_mse_of_reference"),
            flip(0),
            flip(1),
            flip(2),
            both(&to_flip),
            both(&to_error),
            both(&|setting| short(per_sample(setting))),
            time_text(Some(*seconds)),
            denoised.bias(true),
            denoised.number("squared_bias"),
        );
    }
    text
}

/// The document with another section of denoising.
fn with_denoising(document: &str, section: &str) -> Result<String> {
    const NEXT: &str = "\n## ";
    let first = format!("{NEXT}{}\n", SCENES[0].rsplit('/').next().unwrap_or_default());
    let (before, after) = match document.split_once(DENOISING) {
        Some((before, rest)) => (before, &rest[rest.find(NEXT).unwrap_or(rest.len())..]),
        None => document.split_at(document.find(&first).ok_or("the document has no section of a scene")?),
    };
    Ok(format!("{before}{section}{after}"))
}

fn section(report: &Report) -> String {
    let mut text = format!("\n## {}\n\n", report.scene);
    let words = |value: &Value| value.as_str().unwrap_or_default().to_string();
    // What is advised follows from the tables, and how much was measured is in the file of all settings.
    let bases = report.json["basis"].as_array().into_iter().flatten();
    for basis in bases.filter(|basis| words(basis).contains("unreliable")) {
        let _ = writeln!(text, "- {}", words(basis));
    }
    let _ = writeln!(text, "\n![Error against seconds](plots/{})", plot(report.scene));
    text
}

/// A line for each setting of each scene, with tabs between the columns.
fn all_settings(reports: &[Report]) -> String {
    let mut text =
        "scene\tsetting\tto 1e-1\tto 1e-2\tto 1e-3\tbias of the mean\ts / sample\tnoise\tverdict\n".to_string();
    for report in reports {
        for setting in report.settings() {
            let (scene, name) = (report.scene, setting.name());
            let verdict = setting.0["verdict"].as_str().unwrap_or_default().replace('`', "");
            if !setting.is("measured") {
                let _ = writeln!(text, "{scene}\t{name}\t\t\t\t\t\t\t{verdict}");
                continue;
            }
            let [a, b, c] = [0, 1, 2].map(|target| time_text(setting.time(target)));
            let (bias, seconds) = (setting.bias(true), short(setting.number("seconds_per_sample")));
            let noise = short(setting.number("variance_1spp"));
            let _ = writeln!(text, "{scene}\t{name}\t{a}\t{b}\t{c}\t{bias}\t{seconds}\t{noise}\t{verdict}");
        }
    }
    text
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let denoising_alone = words.iter().any(|word| word == "--denoising");
    let words: Vec<&str> = words.iter().map(String::as_str).filter(|word| *word != "--denoising").collect();
    let budget = match words[..] {
        [] => "70s",
        ["--budget", budget] => budget,
        _ => return Err("expected --budget TIME, --denoising, both or nothing".into()),
    };
    let half = format!("{}s", gpu_rt::cli::duration(budget)?.as_secs().div_ceil(2));
    let folder = tempfile::tempdir()?;
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md");
    let denoiser = Denoiser::open(None)?;
    let (mut denoised, mut reports) = (Vec::new(), Vec::new());
    for path in SCENES {
        eprintln!("{path}");
        denoised.push(measure_denoised(path, &half, &denoiser, folder.path())?);
        if !denoising_alone {
            reports.push(measure(path, budget, folder.path())?);
        }
    }
    let section = denoising(&denoised, &half);
    if !denoising_alone {
        fs::write(path.with_extension("tsv"), all_settings(&reports))?;
    }
    let document = match denoising_alone {
        true => with_denoising(&fs::read_to_string(&path)?, &section)?,
        false => document(&reports, &section, budget),
    };
    fs::write(path, document)?;
    Ok(())
}
