//! What an earlier render has left in the output, and what is left to do.

use std::ops::{Deref, Range};
use std::path::Path;

use super::{RenderArgs, Resume};
use crate::commands::tell;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::flatten::DeviceScene;
use crate::gpu::device::AdapterName;
use crate::identity::Identity;
use crate::job::{Frame, Goal, Job};
use crate::options::RenderOptions;
use crate::output::exr::{State, add_film, read_state};
use crate::render::{Noise, empty_film, look_after, look_at};
use crate::samples::Samples;

/// A film, and what it is of: what a file with a state holds.
pub struct Accumulation {
    pub film: Film,
    pub samples: Samples,
    /// How often `--noise` has compared the error with the one asked.
    pub looks: u32,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
}

/// The state of the output that a render goes on with; nothing where it starts afresh.
///
/// # Errors
/// `Error::Usage` where there is nothing to resume, or what there is is not of this render, or is more than is asked and would be lost.
pub fn earlier(
    args: &RenderArgs,
    exr: &Path,
    identity: &dyn Deref<Target = Identity>,
    job: &Job,
) -> Result<Option<State>> {
    let name = exr.display();
    let Some(resume) = args.resume else { return refuse_to_lose(args, exr, identity, job).map(|()| None) };
    let nothing = |why: String| match resume {
        Resume::Auto => {
            if !args.quiet {
                tell(&format!("{why}: the render starts afresh"));
            }
            Ok(None)
        }
        Resume::Yes => {
            Err(Error::Usage(format!("{why}; --resume=auto starts afresh where there is nothing to resume")))
        }
    };
    if !exr.is_file() {
        return nothing(format!("nothing to resume: {name} is not there"));
    }
    let Some(state) = read_state(exr)? else {
        return nothing(format!(
            "nothing to resume: {name} has no state, as images of other programs, of --no-state and of denoise"
        ));
    };
    if let Some(difference) = identity.difference("this render", &state.identity, &name.to_string()) {
        return Err(Error::Usage(format!("{name} cannot be resumed: {difference}")));
    }
    let hull = state.samples.hull();
    let wanted = job.first_sample..job.goal.end();
    let missing = state.samples.missing(wanted.clone());
    let refused = |why: &str| {
        Err(Error::Usage(format!("{name} cannot be resumed: it holds the samples {}, {why}", state.samples)))
    };
    if !matches!(job.goal, Goal::Samples(_)) && hull.start != wanted.start {
        return refused("and --time and --noise go on from the first sample");
    }
    if !missing.is_empty() && (hull.start < wanted.start || hull.end > wanted.end) {
        return refused("of which some are not asked for; `gpu-rt merge` joins parts");
    }
    let cut = |range: &Range<u32>| !range.start.is_multiple_of(RUN_LENGTH);
    if !args.quiet && missing.ranges().iter().any(cut) {
        tell(&format!(
            "{name} ends within a run of {RUN_LENGTH} samples: the result is that of one render, but for the rounding of f32"
        ));
    }
    Ok(Some(state))
}

/// Refuses to overwrite an image of this render that has more samples than are asked for.
fn refuse_to_lose(args: &RenderArgs, exr: &Path, identity: &dyn Deref<Target = Identity>, job: &Job) -> Result<()> {
    let Goal::Samples(end) = job.goal else { return Ok(()) };
    let asked = u64::from(end - job.first_sample);
    match more_there(exr, identity, asked) {
        Some(more) if !args.force => Err(Error::Usage(format!(
            "{} holds {more} samples per pixel of this render, more than the {asked} that are asked for. --force overwrites it",
            exr.display()
        ))),
        _ => Ok(()),
    }
}

/// How many samples a file holds, if it is of this render and has more than so many.
pub fn more_there(exr: &Path, identity: &dyn Deref<Target = Identity>, than: u64) -> Option<u64> {
    if !exr.is_file() {
        return None;
    }
    let state = read_state(exr).ok().flatten().filter(|state| state.samples.count() > than)?;
    identity.difference("", &state.identity, "").is_none().then(|| state.samples.count())
}

impl Accumulation {
    pub fn new(frame: Frame, flat: &DeviceScene, options: &RenderOptions) -> Result<Accumulation> {
        let film = empty_film(flat, frame.part.size(), options)?.of_part(frame);
        Ok(Accumulation { film, samples: Samples::default(), looks: 0, devices: Vec::new() })
    }

    /// What a file holds.
    pub fn of_file(path: &Path, state: &State) -> Result<Accumulation> {
        let mut film = state.film()?;
        add_film(path, state, &mut film)?;
        let State { samples, looks, devices, .. } = state.clone();
        Ok(Accumulation { film, samples, looks, devices })
    }

    /// Adds the devices that render from now on to those that have rendered it.
    ///
    /// # Errors
    /// `Error::Usage` where they have other drivers than each other, or than those that have rendered what is there, unless drivers may be mixed.
    pub fn note_devices<'a>(
        &mut self,
        devices: impl IntoIterator<Item = &'a AdapterName>,
        exr: &Path,
        mixed: bool,
    ) -> Result<()> {
        let earlier = self.devices.len();
        for AdapterName { name, driver, .. } in devices {
            let known = |(other, its): &(String, String)| (other, its) == (name, driver);
            if self.devices.iter().any(known) {
                continue;
            }
            if let Some((other, its)) = self.devices.first()
                && !mixed
            {
                let devices = format!("{other} ({its}) and {name} ({driver})");
                let nevertheless = "whose rounding may differ. --mixed-drivers goes on nevertheless";
                return Err(Error::Usage(match earlier {
                    0 => format!("one film cannot be rendered by {devices}, {nevertheless}"),
                    _ => format!("{} cannot be resumed: the devices are {devices}, {nevertheless}", exr.display()),
                }));
            }
            self.devices.push((name.clone(), driver.clone()));
        }
        Ok(())
    }

    /// Of a render until an error: what came of the last look at this film, if it was enough.
    pub fn noise_reached(&self, job: &Job) -> Option<Noise> {
        let Goal::Noise { error, .. } = job.goal else { return None };
        let last = self.looks.checked_sub(1)?;
        let samples = look_after(last);
        if self.samples.count() != u64::from(samples) {
            return None;
        }
        Some(look_at(&self.film, samples, last, error).0).filter(|noise| noise.reached)
    }

    /// What is left of a job.
    pub fn jobs(&self, job: &Job, reached: Option<Noise>) -> Vec<Job> {
        let missing = match reached {
            Some(_) => Samples::default(),
            None => self.samples.missing(job.first_sample..job.goal.end()),
        };
        // Several devices that were stopped leave gaps. They are filled before a goal is aimed at.
        let is_gap = |range: &Range<u32>| range.start < self.samples.hull().end;
        let part = |range: &Range<u32>| {
            let goal = match job.goal {
                Goal::Until { deadline, .. } | Goal::Noise { deadline: Some(deadline), .. } if is_gap(range) => {
                    Goal::Until { deadline, end: range.end }
                }
                Goal::Noise { error, deadline, end, begun, .. } if !is_gap(range) => {
                    Goal::Noise { error, deadline, end, begun, looks: self.looks }
                }
                until @ Goal::Until { .. } => until,
                Goal::Samples(_) | Goal::Noise { .. } => Goal::Samples(range.end),
            };
            Job { first_sample: range.start, goal, ..job.clone() }
        };
        missing.ranges().iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Films of several drivers, at the start or by and by, are refused unless they are asked for.
    #[test]
    fn devices_of_several_drivers_are_mixed_only_when_asked() {
        let device = |driver: &str| AdapterName {
            name: "GPU".to_string(),
            driver: driver.to_string(),
            backend: "vulkan".to_string(),
            pci_bus_id: String::new(),
            kind: "discrete GPU",
            software: false,
        };
        let (old, new) = (device("driver 1"), device("driver 2"));
        let note = |film: &mut Accumulation, names: &[&AdapterName], mixed| {
            film.note_devices(names.iter().copied(), Path::new("a.exr"), mixed).map_err(|error| error.to_string())
        };
        let empty =
            || Accumulation::new(Frame::whole((1, 1)), &DeviceScene::default(), &RenderOptions::default()).unwrap();
        let mut film = empty();
        assert_eq!(note(&mut film, &[&old, &old], false), Ok(()));
        assert_eq!(film.devices, [("GPU".to_string(), "driver 1".to_string())]);
        let error = note(&mut film, &[&new], false).unwrap_err();
        assert!(error.contains("a.exr cannot be resumed") && error.contains("GPU (driver 2)"), "{error}");
        let error = note(&mut empty(), &[&old, &new], false).unwrap_err();
        assert!(error.contains("one film cannot be rendered by") && error.contains("--mixed-drivers"), "{error}");
        assert_eq!(note(&mut film, &[&new, &old], true), Ok(()));
        assert_eq!(film.devices.len(), 2);
    }
}
