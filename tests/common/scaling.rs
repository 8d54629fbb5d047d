//! The model of docs/scaling.md: the time of a render over many nodes, from what was measured of its parts.

use std::fmt::Write as _;

use gpu_rt::output::plot::{Curve, Plot, Width, svg};
use gpu_rt::tradeoff::report::time_text;

pub const DOCUMENT: &str = "docs/scaling.md";
pub const PLOT: &str = "docs/plots/scaling.svg";
/// What stands below this line of the document is measured, up to the next one.
pub const MEASURED: &str = "## What was measured\n";
/// What stands below this line is computed from it.
pub const COMPUTED: &str = "## Time against nodes\n";

/// The requested samples of a pixel.
const SAMPLES: f64 = 1e5;
/// Parts are cut at multiples of it.
const RUN: f64 = 8.0;
/// Seconds between two checkpoints.
const CHECKPOINT: f64 = 60.0;
/// What is assumed of Slurm: the seconds until the first task starts, the tasks that it starts in a second, and the seconds until the job
/// that merges starts after the last task.
const FIRST_TASK: f64 = 30.0;
const TASKS_PER_SECOND: f64 = 100.0;
const LAST_TASK: f64 = 30.0;
/// Seconds until a task whose node has failed starts again: the defaults of SlurmdTimeout, and of the delay after a requeue.
const REQUEUE: f64 = 300.0 + 120.0;

const NODES: [u32; 10] = [1, 4, 16, 64, 128, 256, 512, 1000, 4000, 10_000];
/// How many times as fast as here a node renders.
const FASTER: [f64; 3] = [1.0, 10.0, 100.0];
/// Failures of a node in an hour.
const RATES: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];

/// What was measured of a scene, in seconds but for the bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    pub scene: String,
    pub pixels: f64,
    /// From the start of the process to the first pass.
    pub start: f64,
    /// One sample of every pixel, on this machine.
    pub sample: f64,
    /// Writing the image and its state: at the end, and at each checkpoint.
    pub write: f64,
    pub bytes: f64,
    /// Joining one part.
    pub merge: f64,
}

/// The position of an input.
type Field = fn(&mut Inputs) -> &mut f64;

/// The rows of the table of inputs.
const ROWS: [(&str, Field); 6] = [
    ("pixels", |inputs| &mut inputs.pixels),
    ("start *s*: seconds from the start of a process to its first pass", |inputs| &mut inputs.start),
    ("pace *g*: seconds for one sample of every pixel", |inputs| &mut inputs.sample),
    ("write *w*: seconds for the image with its state", |inputs| &mut inputs.write),
    ("bytes of a part", |inputs| &mut inputs.bytes),
    ("merge *m*: seconds a part", |inputs| &mut inputs.merge),
];

/// A number with three digits.
pub fn short(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

/// The inputs as a table.
pub fn table_of_inputs(scenes: &[Inputs]) -> String {
    let mut text = "| |".to_string();
    scenes.iter().for_each(|inputs| _ = write!(text, " {} |", inputs.scene));
    let _ = writeln!(text, "\n|---|{}", "---:|".repeat(scenes.len()));
    for (name, field) in ROWS {
        let _ = write!(text, "| {name} |");
        scenes.iter().for_each(|inputs| _ = write!(text, " {} |", short(*field(&mut inputs.clone()))));
        text.push('\n');
    }
    text
}

/// The inputs that the document has.
pub fn inputs_of(document: &str) -> Vec<Inputs> {
    let measured = document.split_once(MEASURED).map_or("", |(_, rest)| rest);
    let mut cells = measured
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect::<Vec<_>>());
    let names = cells.next().unwrap_or_default();
    let mut scenes: Vec<Inputs> =
        names.into_iter().skip(1).map(|scene| Inputs { scene, ..Inputs::default() }).collect();
    for row in cells.skip(1) {
        let Some((_, field)) = ROWS.iter().find(|(name, _)| *name == row[0]) else { continue };
        for (inputs, cell) in scenes.iter_mut().zip(&row[1..]) {
            *field(inputs) = cell.parse().unwrap_or(f64::NAN);
        }
    }
    scenes
}

/// A render in parts of so many samples, over so many nodes, each so many times as fast as here.
#[derive(Clone, Copy)]
struct Split<'a> {
    inputs: &'a Inputs,
    nodes: f64,
    faster: f64,
    samples: f64,
}

impl<'a> Split<'a> {
    fn parts(&self) -> f64 {
        (SAMPLES / self.samples).ceil()
    }

    /// Seconds of one part.
    fn part(&self) -> f64 {
        let Inputs { start, sample, write, .. } = self.inputs;
        let render = self.samples * sample / self.faster;
        start + render + ((render / CHECKPOINT).floor() + 1.0) * write
    }

    fn merge(&self) -> f64 {
        self.parts() * self.inputs.merge + self.inputs.write
    }

    /// The time to merge if groups of parts are joined first, at the same time.
    fn merge_in_groups(&self) -> f64 {
        2.0 * (self.parts().sqrt().ceil() * self.inputs.merge + self.inputs.write) + LAST_TASK
    }

    fn tasks(&self) -> f64 {
        let rounds = (self.parts() / self.nodes).ceil();
        FIRST_TASK + self.parts() / TASKS_PER_SECOND + rounds * self.part() + LAST_TASK
    }

    /// Seconds of all.
    fn seconds(&self) -> f64 {
        self.tasks() + self.merge()
    }

    fn seconds_in_groups(&self) -> f64 {
        self.tasks() + self.merge_in_groups()
    }

    /// The one that takes the least time, over all sizes of parts.
    fn best(inputs: &'a Inputs, nodes: u32, faster: f64, seconds: fn(&Split<'a>) -> f64) -> Split<'a> {
        let nodes = f64::from(nodes);
        let all = (1..=(SAMPLES / RUN) as u32).rev().map(|runs| Split {
            inputs,
            nodes,
            faster,
            samples: RUN * f64::from(runs),
        });
        let least = |a: Split<'a>, b: Split<'a>| if seconds(&b) < seconds(&a) { b } else { a };
        all.reduce(least).unwrap_or(Split { inputs, nodes, faster, samples: SAMPLES })
    }
}

/// What a failure of a node costs the part that it renders.
fn loss(inputs: &Inputs) -> f64 {
    CHECKPOINT / 2.0 + inputs.start + REQUEUE
}

/// The mean of the most failures that one of so many parts meets, if each meets so many on average (Poisson's law).
fn most_failures(parts: f64, mean: f64) -> f64 {
    let (mut sum, mut term, mut below) = (0.0, (-mean).exp(), 0.0f64);
    for count in 0..1000 {
        below += term;
        let more = 1.0 - below.min(1.0).powf(parts);
        sum += more;
        term *= mean / f64::from(count + 1);
        if more < 1e-12 {
            break;
        }
    }
    sum
}

/// All that follows from the inputs.
pub fn tables(scenes: &[Inputs]) -> String {
    let mut text = String::new();
    for inputs in scenes {
        let _ = write!(
            text,
            "\n### {}\n\n| nodes | parts | samples a part | time | speed-up | of it merging | disk | merged in groups | nodes 10 times as fast | 100 times |\n\
             |---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
            inputs.scene
        );
        let one = Split::best(inputs, 1, 1.0, Split::seconds).seconds();
        for nodes in NODES {
            let [best, ten, hundred] = FASTER.map(|faster| Split::best(inputs, nodes, faster, Split::seconds));
            let groups = Split::best(inputs, nodes, 1.0, Split::seconds_in_groups);
            let cell = |split: &Split<'_>| {
                let used =
                    if split.parts() < f64::from(nodes) { format!(" ({})", split.parts()) } else { String::new() };
                format!("{}{used}", time_text(Some(split.seconds())))
            };
            let _ = writeln!(
                text,
                "| {nodes} | {} | {} | {} | {} | {:.0} % | {:.1} GB | {} | {} | {} |",
                best.parts(),
                best.samples,
                time_text(Some(best.seconds())),
                short(one / best.seconds()),
                100.0 * best.merge() / best.seconds(),
                best.parts() * inputs.bytes / 1e9,
                time_text(Some(groups.seconds_in_groups())),
                cell(&ten),
                cell(&hundred),
            );
        }
    }
    text += "\n## Failures\n\n| failures of a node in an hour |";
    let sizes = [16, 256];
    for inputs in scenes {
        sizes.iter().for_each(|nodes| _ = write!(text, " {}, {nodes} nodes |", inputs.scene));
    }
    let _ = writeln!(text, "\n|---:|{}", "---:|".repeat(sizes.len() * scenes.len()));
    for rate in RATES {
        let _ = write!(text, "| {rate:e} |");
        for inputs in scenes {
            for nodes in sizes {
                let split = Split::best(inputs, nodes, 1.0, Split::seconds);
                let mean = rate / 3600.0 * split.part() * (split.parts() / split.nodes).ceil();
                let delay = loss(inputs) * most_failures(split.nodes, mean);
                let _ = write!(
                    text,
                    " {} failures, {} later, {:.2} % |",
                    short(mean * split.nodes),
                    time_text(Some(delay)),
                    100.0 * delay / split.seconds()
                );
            }
        }
        text.push('\n');
    }
    text
}

/// Time against nodes.
pub fn plot(scenes: &[Inputs]) -> String {
    let nodes: Vec<u32> = (0..=40).map(|step| 10f64.powf(f64::from(step) / 10.0).round() as u32).collect();
    let mut curves = Vec::new();
    for inputs in scenes {
        for faster in FASTER {
            let seconds =
                |nodes: &u32| (f64::from(*nodes), Split::best(inputs, *nodes, faster, Split::seconds).seconds());
            let name =
                if faster == 1.0 { inputs.scene.clone() } else { format!("{}, {faster} times as fast", inputs.scene) };
            curves.push(Curve { name, points: nodes.iter().map(seconds).collect(), marks: Vec::new() });
        }
    }
    let plot = Plot { title: "", x: "nodes", y: "seconds", curves, guide: false, width: Width::Wide };
    svg(&plot).unwrap_or_default()
}

/// The document with these measurements instead of its own.
pub fn with_measurements(document: &str, measured: &str) -> Option<String> {
    let (before, rest) = document.split_once(MEASURED)?;
    let (_, computed) = rest.split_once(COMPUTED)?;
    Some(format!("{before}{MEASURED}\n{measured}\n{COMPUTED}{computed}"))
}

/// The document with what follows from its measurements.
pub fn with_tables(document: &str) -> Option<String> {
    let (before, _) = document.split_once(COMPUTED)?;
    Some(format!("{before}{COMPUTED}\n![Seconds against nodes](plots/scaling.svg)\n{}", tables(&inputs_of(document))))
}
