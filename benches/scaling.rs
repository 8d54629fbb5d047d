//! Measures the parts that docs/scaling.md computes from, and writes them there with the tables. `make scaling` runs it.
//!
//! `cargo bench --bench scaling [-- --program PATH]`: the program to measure, if it is not the one that cargo builds.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

// The tests use more of it.
#[allow(dead_code)]
#[path = "../tests/common/exr_header.rs"]
mod exr_header;
#[path = "../tests/common/scaling.rs"]
mod scaling;
#[path = "../tests/common/took.rs"]
mod took;

use exr_header::sealed;
use scaling::{DOCUMENT, Inputs, PLOT, inputs_of, plot, short, table_of_inputs, with_measurements, with_tables};
use took::{Took, median, of_children};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SCENES: [&str; 2] = ["weekend", "next-week"];
/// Every time is the median of so many.
const TIMES: usize = 5;
/// Samples of short renders, of longer ones, and of the one that is cut into parts.
const FEW: u32 = 8;
const MORE: u32 = 40;
const CUT: u32 = 64;
/// The first sample of a part that is copied: its range has the same number of digits everywhere.
const FIRST: u32 = 10_000_000;

struct Bench {
    program: PathBuf,
    folder: tempfile::TempDir,
}

impl Bench {
    /// Runs the program; the JSON is its report.
    fn run(&self, line: &str) -> Result<(Value, Took)> {
        let (start, before) = (Instant::now(), of_children());
        let mut command = Command::new(&self.program);
        command.current_dir(self.folder.path()).args(line.split_whitespace()).args(["--quiet", "--json"]);
        let output = command.stderr(Stdio::inherit()).output()?;
        let took = Took { wall: start.elapsed().as_secs_f64(), processor: of_children() - before };
        if !output.status.success() {
            return Err(format!("{line}: {}", output.status).into());
        }
        Ok((serde_json::from_slice(&output.stdout)?, took))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn render(&self, scene: &str, more: &str) -> Result<(Value, Took)> {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{scene}.ron"));
        self.run(&format!("render {} {more}", scene.display()))
    }

    /// Copies a part as those of the samples after it: `part-0.exr`, `part-1.exr`, …
    fn copy_parts(&self, each: u32, count: u32) -> Result<()> {
        let bytes = fs::read(self.path("part.exr"))?;
        let range = |part: u32| format!("[[{},{}]]", FIRST + each * part, FIRST + each * (part + 1));
        let known = range(0);
        let at = bytes.windows(known.len()).position(|window| window == known.as_bytes()).ok_or("no range")?;
        for part in 0..count {
            let mut bytes = bytes.clone();
            bytes[at..at + known.len()].copy_from_slice(range(part).as_bytes());
            fs::write(self.path(&format!("part-{part}.exr")), sealed(bytes))?;
        }
        Ok(())
    }

    /// The median time of joining the first parts.
    fn merge(&self, count: u32) -> Result<Took> {
        let names: Vec<String> = (0..count).map(|part| format!("part-{part}.exr")).collect();
        let line = format!("merge {} -o joined.exr", names.join(" "));
        let times = (0..TIMES).map(|_| Ok(self.run(&line)?.1)).collect::<Result<Vec<_>>>()?;
        Ok(middle(&times))
    }

    fn inputs(&self, scene: &str) -> Result<(Inputs, String)> {
        let (mut start, mut write, mut few, mut more) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut report = Value::Null;
        for _ in 0..TIMES {
            eprintln!("{scene}: renders");
            let took;
            (report, took) = self.render(scene, &format!("--samples {FIRST}..{} -o part.exr --force", FIRST + FEW))?;
            let seconds = |name: &str| report["seconds"][name].as_f64().unwrap_or(f64::NAN);
            start.push(seconds("total") - seconds("write") - seconds("render") + seconds("first_pass"));
            write.push(seconds("write"));
            few.push(took.processor);
            more.push(self.render(scene, &format!("--spp {MORE} -o other.exr --force"))?.1.processor);
        }
        self.render(scene, &format!("--samples {FIRST}..{} -o part.exr --force", FIRST + CUT))?;
        eprintln!("{scene}: merges");
        let (fewer, all) = (4, 12);
        self.copy_parts(CUT, all)?;
        let merge = (self.merge(all)?.processor - self.merge(fewer)?.processor) / f64::from(all - fewer);
        let cores = std::thread::available_parallelism()?.get() as f64;
        let number = |name: &str| report[name].as_f64().unwrap_or(f64::NAN);
        let inputs = Inputs {
            scene: scene.to_string(),
            pixels: number("width") * number("height"),
            start: median(start),
            sample: (median(more) - median(few)) / f64::from(MORE - FEW) / cores,
            write: median(write),
            bytes: fs::metadata(self.path("part.exr"))?.len() as f64,
            merge,
        };
        Ok((inputs, report["driver"].as_str().unwrap_or_default().to_string()))
    }

    /// Many parts of a small image: the rows of a table.
    fn many_parts(&self) -> Result<String> {
        let mut text = "| parts of 240x135 pixels | processor seconds | parts a second | million pixels a second |\n|---:|---:|---:|---:|\n".to_string();
        self.render("weekend", &format!("--size 240x135 --samples {FIRST}..{} -o part.exr --force", FIRST + CUT))?;
        for count in [64, 512] {
            eprintln!("merging {count} parts");
            self.copy_parts(CUT, count)?;
            let seconds = self.merge(count)?.processor;
            let rate = f64::from(count) / seconds;
            let _ = writeln!(
                text,
                "| {count} | {} | {} | {} |",
                short(seconds),
                short(rate),
                short(rate * 240.0 * 135.0 / 1e6)
            );
        }
        Ok(text)
    }

    /// One render as one part and as several, one after another, and joined.
    fn overhead(&self) -> Result<String> {
        let mut text =
            "| parts | processor seconds | of one process | seconds | of one process |\n|---:|---:|---:|---:|---:|\n"
                .to_string();
        let counts = [1, 2, 4, 8];
        let mut times: Vec<Vec<Took>> = vec![Vec::new(); counts.len()];
        // In turn, so that what else the machine does meets all alike.
        for _ in 0..TIMES {
            for (times, parts) in times.iter_mut().zip(counts) {
                eprintln!("{parts} parts");
                let each = CUT / parts;
                let mut sum = Took::default();
                let mut add =
                    |took: Took| (sum.wall, sum.processor) = (sum.wall + took.wall, sum.processor + took.processor);
                for part in 0..parts {
                    let range = format!("{}..{}", each * part, each * (part + 1));
                    add(self.render("weekend", &format!("--samples {range} -o part-{part}.exr --force"))?.1);
                }
                if parts > 1 {
                    let names: Vec<String> = (0..parts).map(|part| format!("part-{part}.exr")).collect();
                    add(self.run(&format!("merge {} -o joined.exr", names.join(" ")))?.1);
                }
                times.push(sum);
            }
        }
        let one = middle(&times[0]);
        for (times, parts) in times.iter().zip(counts) {
            let took = middle(times);
            let more = |took: f64, one: f64| format!("{:+.1} %", 100.0 * (took / one - 1.0));
            let _ = writeln!(
                text,
                "| {parts} | {} | {} | {} | {} |",
                short(took.processor),
                more(took.processor, one.processor),
                short(took.wall),
                more(took.wall, one.wall)
            );
        }
        Ok(text)
    }
}

fn middle(times: &[Took]) -> Took {
    Took {
        wall: median(times.iter().map(|took| took.wall).collect()),
        processor: median(times.iter().map(|took| took.processor).collect()),
    }
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let program = match &words[..] {
        [] => env!("CARGO_BIN_EXE_gpu-rt").into(),
        [option, program] if option == "--program" => program.into(),
        _ => return Err("expected nothing or --program PATH".into()),
    };
    let bench = Bench { program, folder: tempfile::tempdir()? };
    let measured = SCENES.into_iter().map(|scene| bench.inputs(scene)).collect::<Result<Vec<_>>>()?;
    let (inputs, drivers): (Vec<Inputs>, Vec<String>) = measured.into_iter().unzip();
    let many = bench.many_parts()?;
    let overhead = bench.overhead()?;
    let cores = std::thread::available_parallelism()?;
    let text = format!(
        "Written by `make scaling`; do not edit. {}, {cores} cores; medians of {TIMES}.\n\n{}\n{many}\n\
         {CUT} samples of weekend.ron as one process and as several, one after another, and joined:\n\n{overhead}",
        drivers[0],
        table_of_inputs(&inputs)
    );
    println!("{text}");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let document = with_measurements(&fs::read_to_string(root.join(DOCUMENT))?, &text);
    let document = document.as_deref().and_then(with_tables).ok_or("the document lacks its sections")?;
    fs::write(root.join(PLOT), plot(&inputs_of(&document)))?;
    fs::write(root.join(DOCUMENT), document)?;
    Ok(())
}
