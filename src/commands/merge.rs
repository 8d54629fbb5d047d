//! `gpu-rt merge`: joins renders of disjoint samples of one scene.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::outputs::check_outputs;
use super::render::{Finish, attributes_of, excluded};
use super::{path_text, print_json, tell};
use crate::cli::MergeArgs;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::output::exr::{Attribute, State, add_film, read_attributes, read_state, write_render};
use crate::output::progress::Loading;
use crate::samples::Samples;

/// Joins the parts. It takes the memory of one film, whatever their number.
pub fn run(args: &MergeArgs) -> Result<()> {
    check_outputs(&[("-o", &args.output)], &args.parts, "nothing has been joined")?;
    let mut loading = Loading::new(args.quiet);
    let joined = Joined::of(args, &mut loading)?;
    let first = &joined.parts[0];
    let mut film = first.state.film()?;
    for (number, part) in joined.parts.iter().enumerate() {
        loading.show(&format!("joining {}", part.path.display()), number as f64 / joined.parts.len() as f64);
        add_film(part.path, &part.state, &mut film)?;
    }
    drop(loading);

    let Joined { samples, devices, looks, .. } = &joined;
    let finish = Finish::of(&film, samples, devices, None, joined.complete);
    // What the parts were asked is the same; what came of them is told of the whole.
    let mut attributes = joined.attributes.clone();
    let text = |name: &str| match attributes.iter().find(|(known, _)| known == name) {
        Some((_, Attribute::Text(text))) => text.clone(),
        _ => String::new(),
    };
    let record = json!(finish.record(&excluded(&text("gpu-rt:biases"))));
    // Also what is not known of the whole, and has no attribute.
    let is_of_film = |name: &str| record.get(name).is_some();
    let is_of_one_part = |name: &str| name.starts_with("seconds_") || name.starts_with("noise");
    attributes.retain(|(name, _)| {
        name.strip_prefix("gpu-rt:").is_some_and(|name| !is_of_film(name) && !is_of_one_part(name))
    });
    attributes.extend(attributes_of(&record));
    let state = State::new(first.state.identity.clone(), devices.clone(), &film, samples.clone(), *looks);
    write_render(&args.output, &film, &attributes, Some(&state), || Ok(()))?;

    let ends =
        joined.parts.iter().flat_map(|part| part.state.samples.ranges()).flat_map(|range| [range.start, range.end]);
    let hull = samples.hull();
    let off_runs = ends.into_iter().any(|at| !at.is_multiple_of(RUN_LENGTH) && at != hull.start && at != hull.end);
    if !args.quiet {
        if off_runs {
            tell(&format!(
                "parts end within a run of {RUN_LENGTH} samples: the result is that of one render, but for the rounding of f32"
            ));
        }
        let error = finish
            .error
            .map_or("error unknown".to_string(), |error| format!("relative error {:.2} %", 100.0 * error.value));
        tell(&format!("{}: {} parts, {} samples, {error}", args.output.display(), joined.parts.len(), samples.count()));
    }
    if args.json {
        let mut report = json!({
            "output": path_text(&args.output),
            "parts": joined.parts.len(),
            "width": film.width(),
            "height": film.height(),
            "samples_per_pixel": samples.count(),
        });
        if let (Some(report), Some(record)) = (report.as_object_mut(), record.as_object()) {
            report.extend(record.clone());
        }
        print_json(&report)?;
    }
    Ok(())
}

struct Part<'a> {
    path: &'a Path,
    state: State,
}

/// Parts that fit together.
struct Joined<'a> {
    /// Sorted by their first samples.
    parts: Vec<Part<'a>>,
    samples: Samples,
    devices: Vec<(String, String)>,
    looks: u32,
    complete: bool,
    /// The header of the first part.
    attributes: Vec<(String, Attribute)>,
}

impl<'a> Joined<'a> {
    /// Reads what the parts are of.
    ///
    /// # Errors
    /// `Error::Usage` where they are not of one render, overlap, or leave a gap.
    fn of(args: &'a MergeArgs, loading: &mut Loading) -> Result<Joined<'a>> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        for (number, path) in args.parts.iter().enumerate() {
            loading.show(&format!("reading {}", path.display()), number as f64 / args.parts.len() as f64);
            let state = read_state(path)?.ok_or_else(|| {
                Error::Usage(format!(
                    "{}: it cannot be joined, because it has no state. Images of other programs and of --no-state have none",
                    path.display()
                ))
            })?;
            if let Some(first) = parts.first() {
                fits(first, path, &state, args.mixed_drivers)?;
            }
            parts.push(Part { path, state });
        }
        parts.sort_by_key(|part| part.state.samples.hull().start);
        let mut samples = Samples::default();
        let (mut devices, mut looks) = (Vec::new(), 0u32);
        for (number, part) in parts.iter().enumerate() {
            if let Some(range) = samples.overlap(&part.state.samples) {
                return Err(overlap(&parts[..number], part, &range));
            }
            part.state.samples.ranges().iter().for_each(|range| samples.add(range.clone()));
            looks = looks.saturating_add(part.state.looks);
            for device in &part.state.devices {
                if !devices.contains(device) {
                    devices.push(device.clone());
                }
            }
        }
        let gaps = samples.missing(samples.hull());
        if !gaps.is_empty() && !args.allow_gaps {
            let end =
                |at: u32| parts.iter().find(|part| part.state.samples.ranges().iter().any(|range| range.end == at));
            let before = gaps.ranges().first().and_then(|gap| end(gap.start));
            let after = before.map_or(String::new(), |part| format!(" after {}", part.path.display()));
            return Err(Error::Usage(format!(
                "gap: no part has the samples {gaps}{after}. --allow-gaps joins the parts nevertheless"
            )));
        }
        let complete = gaps.is_empty();
        let first = parts.first().map_or(Path::new(""), |part| part.path);
        let attributes = read_attributes(first)?;
        Ok(Joined { parts, samples, devices, looks, complete, attributes })
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

fn overlap(before: &[Part<'_>], part: &Part<'_>, range: &Range<u32>) -> Error {
    let other = before.iter().find(|other| other.state.samples.overlap(&part.state.samples).is_some());
    let other = other.map_or(PathBuf::new(), |other| other.path.to_path_buf());
    Error::Usage(format!(
        "overlap: {} and {} both have the samples {}..{}",
        other.display(),
        part.path.display(),
        range.start,
        range.end
    ))
}
