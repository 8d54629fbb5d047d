//! Writes docs/accuracy.md: the findings of `gpu-rt tradeoff` on scenes of this repository.
//!
//! `cargo bench --bench accuracy [-- --budget 70s]`: the budget is for each scene. GPU_RT_BENCH_DEVICE names the
//! device, if it is not the default one. `make accuracy` runs it.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

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
/// A smaller ratio is no difference between settings (`tradeoff::model`).
const NO_DIFFERENCE: f64 = 1.15;

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

    fn declared_unbiased(self) -> bool {
        self.0["class"] == "exact" || self.0["class"] == "noise"
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

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
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

fn document(reports: &[Report], budget: &str) -> String {
    let first = &reports[0];
    let mut text = format!(
        "# Accuracy\n\nWhat the settings of `gpu-rt render` trade: seconds against noise and bias, measured by `gpu-rt tradeoff` on {} scenes.\n\
         Written by `make accuracy`; do not edit. [comparing.md](comparing.md#the-trade-measured) says what the numbers mean.\n\n\
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
    let lists = [
        ("Faster than the defaults to a relMSE of 1e-2, without bias", unbiased as fn(&Report) -> Vec<String>),
        ("Faster, with a bias", biased),
        ("Faster, with less detail", coarser),
        ("Slower by half or more, without bias", later),
        ("Unreliable, because of rare bright paths or too few rounds", unreliable),
    ];
    for (heading, list) in lists {
        let found: Vec<String> = reports.iter().flat_map(list).collect();
        let found = if found.is_empty() { "nothing".to_string() } else { found.join("; ") };
        let _ = writeln!(text, "- {heading}: {found}.");
    }
    text += "\nThe table has the ratio of the seconds to a relMSE of 1e-2 to those of the defaults, and the bias of the mean if one was found. Less than \
             15 % is no difference. *Italic*: unreliable. never: the bias may be larger than the target. –: the setting does not affect the scene. \
             Empty: not measured.\n\n";
    text += &overview(reports);
    for report in reports {
        text += &section(report);
    }
    text
}

/// The settings of a report that satisfy a condition on them and their ratio, after a link to the scene.
fn list(
    report: &Report,
    condition: impl Fn(Setting<'_>, f64) -> bool,
    words: impl Fn(Setting<'_>, f64) -> String,
) -> Vec<String> {
    let known = report.settings().filter(|setting| setting.is("measured") && setting.name() != "defaults");
    let rated = known.filter_map(|setting| Some((setting, report.ratio(setting)?)));
    let found: Vec<String> =
        rated.filter(|(s, ratio)| condition(*s, *ratio)).map(|(s, ratio)| words(s, ratio)).collect();
    if found.is_empty() { Vec::new() } else { vec![format!("{} {}", report.link(), found.join(", "))] }
}

fn times(setting: Setting<'_>, ratio: f64) -> String {
    format!("`{}` × {ratio:.2}", setting.name())
}

fn unbiased(report: &Report) -> Vec<String> {
    let sooner = |s: Setting<'_>, ratio: f64| {
        s.is("reliable") && s.declared_unbiased() && !s.is("biased") && ratio * NO_DIFFERENCE < 1.0
    };
    list(report, sooner, times)
}

fn biased(report: &Report) -> Vec<String> {
    let sooner = |s: Setting<'_>, ratio: f64| {
        s.is("reliable") && !s.declared_unbiased() && !s.loses_detail() && ratio * NO_DIFFERENCE < 1.0
    };
    list(report, sooner, |s, ratio| format!("{} ({} of the light)", times(s, ratio), s.bias(false)))
}

fn coarser(report: &Report) -> Vec<String> {
    let sooner = |s: Setting<'_>, ratio: f64| s.is("reliable") && s.loses_detail() && ratio * NO_DIFFERENCE < 1.0;
    list(report, sooner, |s, ratio| {
        format!("{} (a relMSE of {:.0e} remains)", times(s, ratio), s.number("squared_bias"))
    })
}

fn later(report: &Report) -> Vec<String> {
    let later = |s: Setting<'_>, ratio: f64| s.is("reliable") && s.declared_unbiased() && ratio > 1.5;
    list(report, later, times)
}

fn unreliable(report: &Report) -> Vec<String> {
    let measured: Vec<Setting<'_>> = report.settings().filter(|setting| setting.is("measured")).collect();
    let found: Vec<String> = measured.iter().filter(|s| !s.is("reliable")).map(|s| format!("`{}`", s.name())).collect();
    match found.len() {
        0 => Vec::new(),
        n if n * 2 > measured.len() => vec![format!("{} {n} of {} settings", report.link(), measured.len())],
        _ => vec![format!("{} {}", report.link(), found.join(", "))],
    }
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
            let doubtful = setting.is("measured") && !setting.is("reliable");
            let words = if doubtful { format!("*{words}{bias}*") } else { format!("{words}{bias}") };
            let _ = write!(text, " {words} |");
        }
        text.push('\n');
    }
    text
}

fn section(report: &Report) -> String {
    let mut text = format!("\n## {}\n\n", report.scene);
    let words = |value: &Value| value.as_str().unwrap_or_default().to_string();
    for advice in report.json["recommendations"].as_array().into_iter().flatten() {
        let _ = writeln!(text, "- **{}**", words(&advice["words"]));
    }
    // The document states above what all biases are relative to.
    let bases = report.json["basis"].as_array().into_iter().flatten();
    for basis in bases.filter(|basis| !words(basis).starts_with("biases are differences from the defaults")) {
        let _ = writeln!(text, "- {}", words(basis));
    }
    let _ = writeln!(text, "\n![Error against seconds](plots/{})\n", plot(report.scene));
    for left_out in report.json["left_out"].as_array().into_iter().flatten() {
        let _ = writeln!(text, "{}\n", words(left_out));
    }
    text += "| setting | to 1e-1 | to 1e-2 | to 1e-3 | bias of the mean | s / sample | noise | verdict |\n|---|---:|---:|---:|---:|---:|---:|---|\n";
    for setting in report.settings() {
        let verdict = cell(&words(&setting.0["verdict"]));
        if !setting.is("measured") {
            let _ = writeln!(text, "| `{}` | | | | | | | {verdict} |", setting.name());
            continue;
        }
        let [a, b, c] = [0, 1, 2].map(|target| time_text(setting.time(target)));
        let _ = writeln!(
            text,
            "| `{}` | {a} | {b} | {c} | {} | {} | {} | {verdict} |",
            setting.name(),
            setting.bias(true),
            short(setting.number("seconds_per_sample")),
            short(setting.number("variance_1spp")),
        );
    }
    text
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let budget = match &words[..] {
        [] => "70s",
        [option, budget] if option == "--budget" => budget,
        _ => return Err("expected nothing or --budget TIME".into()),
    };
    let folder = tempfile::tempdir()?;
    let mut reports = Vec::new();
    for path in SCENES {
        eprintln!("{path}");
        reports.push(measure(path, budget, folder.path())?);
    }
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy.md");
    fs::write(path, document(&reports, budget))?;
    Ok(())
}
