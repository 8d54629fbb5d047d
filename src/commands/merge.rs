//! `gpu-rt merge`: joins renders of disjoint samples of one scene.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::console::{command_line, object, path_text, print_json, tell};
use super::outputs::{EXR, check_name, check_outputs};
use super::render::{Finish, attributes_of, error_words, excluded, matte_warning, noise_words, reliability_warnings};
use crate::aov::MATTE_ATTRIBUTES;
use crate::cli::{relative_error, sample_range};
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::output::exr::{State, StateFile, add_film, attribute_text, read_state, write_render};
use crate::output::progress::Loading;
use crate::printable::counted;
use crate::render::{Noise, check_error, samples_at_check};
use crate::samples::Samples;

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The parts: EXRs of `gpu-rt render --samples A..B`, or of this command, or folders of them.
    #[arg(value_name = "PART.exr", required = true)]
    pub parts: Vec<PathBuf>,
    /// Fail unless the parts together have exactly these samples.
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with = "allow_gaps")]
    pub samples: Option<Range<u32>>,
    /// Join parts until the relative error is below this, as `render --noise` would: it is checked at 16, 32, 64 … samples, and a part
    /// must end at each check.
    #[arg(long, value_name = "E", value_parser = relative_error, conflicts_with = "allow_gaps")]
    pub noise: Option<f64>,
    /// The EXR to write. It can be resumed, and joined with others.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Join parts that leave out samples between them.
    #[arg(long)]
    pub allow_gaps: bool,
    /// Join parts of several devices or drivers, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// Joins the parts. It takes the memory of one film, whatever their number.
pub fn run(args: &MergeArgs) -> Result<()> {
    let paths = files(&args.parts)?;
    paths.iter().try_for_each(|path| check_name(path, "an EXR: parts are read more than once"))?;
    check_outputs(&[("-o", Some(args.output.as_path()), EXR)], &paths, None, "nothing has been joined")?;
    let mut loading = Loading::new(args.quiet);
    let parts = parts_of(args, &paths, &mut loading)?;
    let Some(first) = parts.first() else { return Err(Error::Usage("no part is there".to_string())) };
    let mut joined = Joined { count: 0, film: first.state.film()?, noise: None };
    for (number, part) in parts.iter().enumerate() {
        loading.show(&format!("joining {}", part.path.display()), number as f64 / parts.len() as f64);
        add_film(part.path, &part.state, &mut joined.film)?;
        joined.count += 1;
        if let Some(error) = args.noise
            && joined.check(&parts, part, error)?
        {
            break;
        }
    }
    drop(loading);

    let Joined { count, film, noise } = &joined;
    let samples = &film.samples;
    let complete = samples.ranges().len() == 1;
    // The parts have the same request; the results are those of the joined image.
    let mut attributes = StateFile::open(first.path)?.map(|file| file.attributes()).unwrap_or_default();
    let biases = attribute_text(&attributes, "gpu-rt:biases");
    let finish = Finish::new(film, *noise, complete);
    let mut record = finish.record(&excluded(&biases));
    record.insert("command".to_string(), json!(command_line()));
    if let (Some(error), Some(noise)) = (args.noise, noise) {
        record.insert("noise".to_string(), json!(error));
        record.insert("noise_reached".to_string(), json!(noise.reached));
    }
    // Also values that the joined image lacks, and that have no attribute.
    let is_of_one_part = |name: &str| name.starts_with("seconds_") || name.starts_with("noise");
    attributes.retain(|(name, _)| {
        name.starts_with(MATTE_ATTRIBUTES)
            || name.strip_prefix("gpu-rt:").is_some_and(|name| !record.contains_key(name) && !is_of_one_part(name))
    });
    attributes.extend(attributes_of(&record));
    let state = State::new(first.state.identity.clone(), film);
    write_render(&args.output, &film.film, &attributes, Some(&state), || Ok(()))?;

    let ends =
        parts[..*count].iter().flat_map(|part| part.state.samples.ranges()).flat_map(|range| [range.start, range.end]);
    let range = samples.range();
    let off_runs = ends.into_iter().any(|at| !at.is_multiple_of(RUN_LENGTH) && at != range.start && at != range.end);
    if !args.quiet {
        if off_runs {
            tell(&format!(
                "parts end within a run of {RUN_LENGTH} samples: the result is that of one render, but for the rounding of f32"
            ));
        }
        if let (Some(error), Some(noise)) = (args.noise, noise) {
            tell(&noise_words(error, noise, &finish.verdict));
        }
        matte_warning(&finish).into_iter().chain(reliability_warnings(&finish)).for_each(|warning| tell(&warning));
        let error = error_words(&finish);
        let (parts, samples) = (counted(*count as u64, "part"), counted(samples.count(), "sample"));
        tell(&format!("{}: {parts}, {samples}, {error}", args.output.display()));
    }
    if args.json {
        let mut report = object(json!({
            "output": path_text(&args.output),
            "parts": count,
            "width": film.film.width(),
            "height": film.film.height(),
            "samples_per_pixel": samples.count(),
        }));
        report.extend(record);
        print_json(&Value::Object(report))?;
    }
    Ok(())
}

struct Part<'a> {
    path: &'a Path,
    state: State,
}

/// The parts that have been joined.
struct Joined {
    /// Their number.
    count: usize,
    film: Accumulation,
    noise: Option<Noise>,
}

impl Joined {
    /// Checks the error where `render --noise` does. Returns whether that render would end here.
    ///
    /// # Errors
    /// `Error::Usage` where the part goes on beyond such a number of samples.
    fn check(&mut self, parts: &[Part<'_>], part: &Part<'_>, error: f64) -> Result<bool> {
        let Accumulation { film, samples: joined, checks: all_checks, .. } = &mut self.film;
        let checks = self.noise.map_or(0, |noise| noise.checks);
        let samples = joined.range().end - joined.range().start;
        let aim = samples_at_check(checks);
        let last = self.count == parts.len();
        if samples > aim || joined.ranges().len() > 1 {
            return Err(Error::Usage(format!(
                "{}: --noise checks the error at {aim} samples, and this part goes on beyond: end it there",
                part.path.display()
            )));
        }
        if samples == aim || last {
            let (noise, ends) = check_error(film, samples, checks, error);
            (self.noise, *all_checks) = (Some(noise), noise.checks);
            return Ok(ends);
        }
        Ok(false)
    }
}

/// The files, and those of the folders.
fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let failed = Error::file(path, "read");
        let entries = std::fs::read_dir(path).map_err(&failed)?;
        let inside: std::io::Result<Vec<PathBuf>> = entries.map(|entry| Ok(entry?.path())).collect();
        let mut inside = inside.map_err(&failed)?;
        inside.retain(|file| file.extension().is_some_and(|ending| ending == "exr"));
        inside.sort();
        files.append(&mut inside);
    }
    Ok(files)
}

/// Reads what the parts are of, and sorts them by their first samples.
///
/// # Errors
/// `Error::Usage` where they are not of one render, overlap, or leave a gap.
fn parts_of<'a>(args: &MergeArgs, paths: &'a [PathBuf], loading: &mut Loading) -> Result<Vec<Part<'a>>> {
    let mut parts: Vec<Part<'a>> = Vec::new();
    for (number, path) in paths.iter().enumerate() {
        loading.show(&format!("reading {}", path.display()), number as f64 / paths.len() as f64);
        let state = read_state(path)?.ok_or_else(|| {
            Error::Usage(format!(
                "{}: it cannot be joined, because it has no state. Images of other programs, of --no-state and of denoise have none",
                path.display()
            ))
        })?;
        if let Some(first) = parts.first() {
            fits(first, path, &state, args.mixed_drivers)?;
        }
        parts.push(Part { path, state });
    }
    parts.sort_by_key(|part| part.state.samples.range().start);
    let mut samples = Samples::default();
    for (number, part) in parts.iter().enumerate() {
        if let Some(range) = samples.overlap(&part.state.samples) {
            let other = parts[..number].iter().find(|other| other.state.samples.overlap(&part.state.samples).is_some());
            return Err(Error::Usage(format!(
                "overlap: {} and {} both have the samples {}..{}",
                other.map_or(Path::new(""), |other| other.path).display(),
                part.path.display(),
                range.start,
                range.end
            )));
        }
        samples.join(&part.state.samples);
    }
    let wanted = args.samples.clone().unwrap_or(samples.range());
    let gaps = samples.missing(wanted.clone());
    if !gaps.is_empty() && !args.allow_gaps {
        let end = |at: u32| parts.iter().find(|part| part.state.samples.ranges().iter().any(|range| range.end == at));
        let before = gaps.ranges().first().and_then(|gap| end(gap.start));
        let after = before.map_or(String::new(), |part| format!(" after {}", part.path.display()));
        let remedy = match args.samples {
            Some(_) => "",
            None => ". --allow-gaps joins the parts nevertheless",
        };
        return Err(Error::Usage(format!("gap: no part has the samples {gaps}{after}{remedy}")));
    }
    let beyond = parts.iter().find(|part| {
        let range = part.state.samples.range();
        range.start < wanted.start || range.end > wanted.end
    });
    match beyond {
        Some(part) => Err(Error::Usage(format!(
            "{}: it has the samples {}, beyond --samples {}..{}",
            part.path.display(),
            part.state.samples,
            wanted.start,
            wanted.end
        ))),
        None => Ok(parts),
    }
}

/// Checks that a part is of the same render as the first one.
fn fits(first: &Part<'_>, path: &Path, state: &State, mixed_drivers: bool) -> Result<()> {
    let [a, b] = [first.path, path].map(|path| path.display().to_string());
    if let Some(difference) = first.state.difference(&a, state, &b) {
        return Err(Error::Usage(format!("mismatch: {a} and {b} cannot be joined: {difference}")));
    }
    if !mixed_drivers && first.state.devices != state.devices {
        let names = |state: &State| {
            let names: Vec<String> = state.devices.iter().map(|(name, driver)| format!("{name} ({driver})")).collect();
            names.join(" and ")
        };
        return Err(Error::Usage(format!(
            "mismatch: {a} was rendered by {}, {b} by {}, whose rounding may differ. --mixed-drivers joins them nevertheless",
            names(&first.state),
            names(state)
        )));
    }
    Ok(())
}
