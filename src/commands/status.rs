//! `gpu-rt status`: what has come of a render that many processes share. It reads the headers of the parts, and changes no file.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use serde_json::{Value, json};

use super::console::{object, path_text, print_json, print_line, tell};
use super::outputs::{PNG, check_name, check_outputs};
use super::render::{Finish, error_words, excluded, reliability_warnings};
use crate::cli::{CHECKPOINT, ViewArgs, duration};
use crate::cluster::parts::{Part, Parts, Progress};
use crate::cluster::{Folder, JOB_FILE};
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::output::exr::{Attribute, StateFile, attribute, attribute_text, read_attributes};
use crate::output::png::write_png;
use crate::output::progress::Loading;
use crate::printable::counted;

#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The folder that `gpu-rt submit` has written.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Also join the samples that are there, and print the error of their image.
    #[arg(long)]
    pub error: bool,
    /// Also join the samples that are there, and write a tone-mapped picture of them.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Print results and errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// A part is under way if its file was written within so many intervals of `--checkpoint`: one checkpoint may be late, and another one fail.
const INTERVALS: u32 = 3;

/// Reports the state of the parts.
pub fn run(args: &StatusArgs) -> Result<()> {
    check_name(&args.folder, "a folder")?;
    let folder = Folder::read(&args.folder)?;
    if let Some(png) = args.png.as_deref() {
        check_outputs(&[("--png", Some(png), PNG)], &files_of(&folder), Some("the report"), "nothing has been joined")?;
    }
    let mut loading = Loading::new(args.quiet);
    let count = folder.parts().len().max(1) as f64;
    let recent = INTERVALS * checkpoint(&folder.request.options);
    let mut parts =
        Parts::read(&folder, recent, &mut |number| loading.show("reading the parts", number as f64 / count));
    let joined = match args.error || args.png.is_some() {
        true => join(&folder, &mut parts, &mut loading)?,
        false => None,
    };
    drop(loading);
    if let (Some(png), Some(Accumulation { film, .. })) = (&args.png, &joined) {
        let size = (film.width(), film.height());
        write_png(png, size, &|index| film.developed(index).rgb, &args.view.transform())?;
    }
    let finish = joined.as_ref().filter(|_| args.error).map(|joined| {
        let [start, end] = folder.request.samples;
        Finish::new(joined, None, joined.samples.missing(start..end).is_empty())
    });

    let report = StatusReport::new(&folder, &parts);
    match args.json {
        true => print_json(&report.json(args, finish.as_ref()))?,
        false => report.lines(args, finish.as_ref()).iter().try_for_each(|line| print_line(line))?,
    }
    if !args.quiet {
        notes(&folder, &parts, &args.png, joined.is_some()).iter().for_each(|note| tell(note));
        finish.iter().flat_map(reliability_warnings).for_each(|warning| tell(&warning));
    }
    Ok(())
}

/// The interval of the parts' checkpoints.
fn checkpoint(options: &[String]) -> Duration {
    let after = options.iter().zip(options.iter().skip(1)).find(|(word, _)| *word == "--checkpoint");
    let within = || options.iter().find_map(|word| word.strip_prefix("--checkpoint="));
    let given = after.map(|(_, value)| value.as_str()).or_else(within);
    given.and_then(|value| duration(value).ok()).or(duration(CHECKPOINT).ok()).unwrap_or_default()
}

/// The files of the folder that a picture must not replace.
fn files_of(folder: &Folder) -> Vec<PathBuf> {
    let parts = folder.parts().map(|part| folder.part_path(&part));
    let own = [folder.path.join(JOB_FILE), folder.output()];
    let below = folder.request.scene.components().next().map(|first| folder.path.join(first));
    parts.chain(own).chain(below.iter().flat_map(|below| files_below(below))).collect()
}

/// A file, or all files below a folder. What cannot be listed is left out.
fn files_below(path: &Path) -> Vec<PathBuf> {
    // A link may lead back to a folder above.
    let is_folder = path.symlink_metadata().is_ok_and(|metadata| metadata.is_dir());
    match is_folder.then(|| path.read_dir()) {
        None => vec![path.to_owned()],
        Some(entries) => entries.into_iter().flatten().flatten().flat_map(|entry| files_below(&entry.path())).collect(),
    }
}

/// A film of all samples that are there, and which they are; nothing where there are none. It takes the memory of one film. What has come
/// since the headers were read is noted in the parts.
///
/// # Errors
/// `Error::File` where the pixels of a part are damaged. The film would have a part of them.
fn join(folder: &Folder, parts: &mut Parts, loading: &mut Loading) -> Result<Option<Accumulation>> {
    let Some((_, reference)) = &parts.reference else { return Ok(None) };
    let mut joined = reference.film()?;
    let count = parts.all.len().max(1) as f64;
    for number in 0..parts.all.len() {
        let mut part = parts.all[number].clone();
        loading.show(&format!("joining {}", part.path.display()), number as f64 / count);
        if !part.is_usable() {
            continue;
        }
        if let Some(file) = StateFile::open(&part.path)? {
            let is_recent = part.progress != Progress::Stopped;
            parts.add_state(&mut part, &file.state, is_recent, folder);
            if part.is_usable() {
                file.add_to(&mut joined)?;
            }
        }
        parts.all[number] = part;
    }
    joined.devices.clone_from(&parts.devices);
    Ok(Some(joined).filter(|joined| !joined.samples.is_empty()))
}

/// What the stated error excludes, by the header of a part.
fn excluded_of(parts: &Parts) -> String {
    let attributes = parts.reference.as_ref().and_then(|(path, _)| read_attributes(path).ok()).unwrap_or_default();
    excluded(&attribute_text(&attributes, "gpu-rt:biases"))
}

/// What the image of all parts is.
enum Image {
    Absent,
    Complete,
    /// It has so many samples, and not all; or all of the rounds so far, and not the requested error.
    Incomplete(u64),
    NotUsable(String),
}

impl Image {
    fn read(folder: &Folder, parts: &Parts) -> Image {
        let path = folder.output();
        if !path.exists() {
            return Image::Absent;
        }
        let file = match StateFile::open(&path) {
            Ok(Some(file)) => file,
            Ok(None) => return Image::NotUsable("it has no state".to_string()),
            Err(Error::File { reason, .. }) => return Image::NotUsable(reason),
            Err(error) => return Image::NotUsable(error.to_string()),
        };
        let of_parts = parts.reference.as_ref();
        let state = &file.state;
        let difference = of_parts.and_then(|(path, part)| state.difference("it", part, &path.display().to_string()));
        let [start, end] = folder.request.samples;
        let is_complete = match folder.request.noise {
            None => state.samples.missing(start..end).is_empty(),
            Some(_) => attribute(&file.attributes(), "gpu-rt:noise_reached") == Some(&Attribute::Int(1)),
        };
        match difference {
            Some(difference) => Image::NotUsable(format!("it is of another render than the parts: {difference}")),
            None if is_complete => Image::Complete,
            None => Image::Incomplete(state.samples.count()),
        }
    }

    fn words(&self, path: &Path, requested: u64) -> String {
        let path = path.display();
        match self {
            Image::Absent => format!("{path} is not there yet"),
            Image::Complete => format!("{path} is complete"),
            Image::Incomplete(samples) => format!("{path} has {samples} of {requested} samples"),
            Image::NotUsable(why) => format!("{path}: {why}"),
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Image::Absent => "absent",
            Image::Complete => "complete",
            Image::Incomplete(_) => "incomplete",
            Image::NotUsable(_) => "not usable",
        }
    }
}

/// The report.
struct StatusReport<'a> {
    folder: &'a Folder,
    parts: &'a Parts,
    image: Image,
    /// Samples of a pixel: requested, and rendered so far.
    requested: u64,
    done: u64,
    /// Seconds that a process takes for one sample of every pixel: the mean over the parts that report it.
    seconds_per_sample: Option<f64>,
}

impl StatusReport<'_> {
    fn new<'a>(folder: &'a Folder, parts: &'a Parts) -> StatusReport<'a> {
        let [start, end] = folder.request.samples;
        let usable = || parts.all.iter().filter(|part| part.is_usable());
        let paces: Vec<f64> = usable().filter_map(|part| part.seconds_per_sample).collect();
        StatusReport {
            folder,
            parts,
            image: Image::read(folder, parts),
            requested: u64::from(end - start),
            done: usable().map(|part| part.samples.count()).sum(),
            seconds_per_sample: (!paces.is_empty()).then(|| paces.iter().sum::<f64>() / paces.len() as f64),
        }
    }

    fn count(&self, progress: &Progress) -> usize {
        self.parts.all.iter().filter(|part| part.progress == *progress).count()
    }

    /// The parts by their states.
    fn counts(&self) -> [(&'static str, usize); 5] {
        [
            ("done", self.count(&Progress::Done)),
            ("under way", self.count(&Progress::UnderWay)),
            ("stopped", self.count(&Progress::Stopped)),
            ("not begun", self.count(&Progress::NotBegun)),
            ("not usable", self.not_usable().count()),
        ]
    }

    fn not_usable(&self) -> impl Iterator<Item = (&Path, &str)> {
        self.parts.all.iter().filter_map(|part| match &part.progress {
            Progress::NotUsable(why) => Some((part.path.as_path(), why.as_str())),
            _ => None,
        })
    }

    /// Seconds until all samples are there, if as many parts are rendered at a time as now: a share of all that is missing, and at least
    /// what the part under way that misses most needs.
    fn seconds_left(&self) -> Option<f64> {
        if matches!(self.image, Image::Complete) || self.done == self.requested {
            return Some(0.0);
        }
        let pace = self.seconds_per_sample?;
        let under_way = self.parts.all.iter().filter(|part| part.progress == Progress::UnderWay);
        let longest = under_way.map(Part::missing).max().unwrap_or(0);
        let shared = (self.requested - self.done) as f64 / self.count(&Progress::UnderWay).max(1) as f64;
        Some(pace * shared.max(longest as f64))
    }

    fn lines(&self, args: &StatusArgs, finish: Option<&Finish>) -> Vec<String> {
        let StatusReport { folder, requested, done, .. } = self;
        let share = 100.0 * *done as f64 / (*requested).max(1) as f64;
        let counts: Vec<String> = self
            .counts()
            .into_iter()
            .filter(|(_, count)| *count > 0)
            .map(|(state, count)| format!("{count} {state}"))
            .collect();
        let mut lines = vec![format!("samples: {done} of {requested} ({share:.1} %)")];
        if let Some(noise) = folder.request.noise {
            let most = folder.request.most.map_or(String::new(), |most| format!(", of {most} at most"));
            lines.push(match self.image {
                Image::Complete => format!("rounds: --noise {noise} is reached"),
                _ => format!("rounds: --noise {noise} is not reached; {requested} samples are asked for so far{most}"),
            });
        }
        lines.push(format!("parts: {}: {}", self.parts.all.len(), counts.join(", ")));
        lines.extend(self.not_usable().map(|(path, why)| format!("not usable: {}: {why}", path.display())));
        lines.push(format!("time left: {}", self.time_left()));
        lines.push(format!("image: {}", self.image.words(&folder.output(), *requested)));
        if args.error {
            let samples = finish.map_or(0, |finish| finish.samples.count());
            let error = finish.map_or("error unknown: there are no samples".to_string(), error_words);
            lines.push(format!("{error}, of {}", counted(samples, "sample")));
        }
        lines
    }

    fn time_left(&self) -> String {
        let at_a_time = match self.count(&Progress::UnderWay) {
            0 => "with one part at a time; none is under way".to_string(),
            1 => "with one part at a time".to_string(),
            parts => format!("with {parts} parts at a time"),
        };
        // Seconds do not matter in hours.
        let step = |seconds: f64| if seconds > 3600.0 { 60.0 } else { 1.0 };
        let rounded = |seconds: f64| (seconds / step(seconds)).ceil() * step(seconds);
        match self.seconds_left().map(|seconds| (seconds, Duration::try_from_secs_f64(rounded(seconds)))) {
            Some((0.0, _)) => "none, all samples are there".to_string(),
            Some((_, Ok(time))) => format!("{}, {at_a_time}", humantime::format_duration(time)),
            _ => "unknown, because no part tells its pace".to_string(),
        }
    }

    fn json(&self, args: &StatusArgs, finish: Option<&Finish>) -> Value {
        let request = &self.folder.request;
        let counts = self.counts().into_iter().map(|(state, count)| (state.replace(' ', "_"), json!(count)));
        let not_usable: Vec<Value> =
            self.not_usable().map(|(path, why)| json!({"path": path_text(path), "reason": why})).collect();
        let mut report = object(json!({
            "folder": path_text(&self.folder.path),
            "output": path_text(&self.folder.output()),
            "width": request.width,
            "height": request.height,
            "samples_asked": self.requested,
            "samples_done": self.done,
            "noise": request.noise,
            "most_samples": request.most,
            "parts": self.parts.all.len(),
            "parts_by_state": counts.collect::<serde_json::Map<String, Value>>(),
            "not_usable": not_usable,
            "seconds_per_sample": self.seconds_per_sample,
            "seconds_left": self.seconds_left(),
            "image": self.image.name(),
        }));
        if args.error {
            let unknown = || object(json!({"relative_error": null, "relative_error_bound": null, "reliable": null}));
            report.extend(finish.map_or_else(unknown, |finish| finish.record(&excluded_of(self.parts))));
        }
        Value::Object(report)
    }
}

/// Warnings and notes that follow the report.
fn notes(folder: &Folder, parts: &Parts, png: &Option<PathBuf>, is_joined: bool) -> Vec<String> {
    let mut notes = Vec::new();
    if parts.devices.len() > 1 && !folder.request.options.iter().any(|word| word == "--mixed-drivers") {
        let names: Vec<String> = parts.devices.iter().map(|(name, driver)| format!("{name} ({driver})")).collect();
        notes.push(format!(
            "warning: several drivers have rendered the parts, which join only with --mixed-drivers: {}",
            names.join(", ")
        ));
    }
    if let (Some(png), false) = (png, is_joined) {
        notes.push(format!("warning: {} has not been written, because there are no samples", png.display()));
    }
    notes
}
