//! The state of an earlier render in the output, and the film that this one begins with.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::args::Resume;
use super::request::Request;
use crate::commands::console::tell;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::flatten::DeviceScene;
use crate::gpu::device::{AdapterName, Device};
use crate::job::Goal;
use crate::output::exr::{State, add_film, read_state};
use crate::render::empty_film;

impl Request<'_> {
    /// The state of the output that the render resumes; `None` if the render starts afresh.
    ///
    /// # Errors
    /// `Error::Usage` if there is nothing to resume, if the output is of another render, or if it has more samples than requested.
    pub fn earlier(&mut self) -> Result<Option<State>> {
        let Some(exr) = self.exr() else { return Ok(None) };
        let Some(resume) = self.args.keep.resume else { return self.refuse_to_lose().map(|()| None) };
        let name = exr.display();
        let nothing = |why: String| match resume {
            Resume::Auto => {
                if !self.args.messages.quiet {
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
        if let Some(difference) = self.identity().difference("this render", &state.identity, &name.to_string()) {
            return Err(Error::Usage(format!("{name} cannot be resumed: {difference}")));
        }
        let held = state.samples.range();
        let wanted = self.job.first_sample..self.job.goal.end();
        let missing = state.samples.missing(wanted.clone());
        let refused = |why: &str| {
            Err(Error::Usage(format!("{name} cannot be resumed: it holds the samples {}, {why}", state.samples)))
        };
        if !matches!(self.job.goal, Goal::Samples(_)) && held.start != wanted.start {
            return refused("and --time and --noise go on from the first sample");
        }
        if !missing.is_empty() && (held.start < wanted.start || held.end > wanted.end) {
            return refused("of which some are not asked for; `gpu-rt merge` joins parts");
        }
        let cut = |range: &Range<u32>| !range.start.is_multiple_of(RUN_LENGTH);
        if !self.args.messages.quiet && missing.ranges().iter().any(cut) {
            tell(&format!(
                "{name} ends within a run of {RUN_LENGTH} samples: the result is that of one render, but for the rounding of f32"
            ));
        }
        self.held = Some(state.samples.count());
        Ok(Some(state))
    }

    /// Refuses to overwrite an image of this render that has more samples than requested.
    fn refuse_to_lose(&self) -> Result<()> {
        let Goal::Samples(end) = self.job.goal else { return Ok(()) };
        let requested = u64::from(end - self.job.first_sample);
        match self.more_than(requested) {
            Some(more) => Err(Error::Usage(format!(
                "{} holds {more} samples per pixel of this render, more than the {requested} that are asked for. --force overwrites it",
                self.image.display()
            ))),
            None => Ok(()),
        }
    }
}

/// The film that a render of this view begins with: that of the output, if it has this state, or an empty one.
///
/// # Errors
/// `Error::File` if the pixels of the output cannot be read. `Error::Usage` as of [`add_devices`].
pub fn starting_film(
    request: &Request<'_>,
    earlier: Option<&State>,
    view: &DeviceScene,
    devices: &[Arc<Device>],
) -> Result<Accumulation> {
    let mut begun = match earlier {
        Some(state) => {
            let mut begun = state.film()?;
            begun.film = begun.film.with_lamps(&view.lamps);
            begun.film.bound.not_sampled = view.not_sampled;
            add_film(&request.image, state, &mut begun)?;
            begun
        }
        None => Accumulation::empty(empty_film(view, request.job.size, &request.args.options)?),
    };
    let names = devices.iter().map(|device| &device.name);
    add_devices(&mut begun.devices, names, &request.image, request.args.keep.mixed_drivers)?;
    Ok(begun)
}

/// Adds the devices that render from now on to those that have rendered a film.
///
/// # Errors
/// `Error::Usage` if the drivers differ, among these devices or from those that rendered the film, unless drivers may be mixed.
fn add_devices<'a>(
    known: &mut Vec<(String, String)>,
    devices: impl IntoIterator<Item = &'a AdapterName>,
    exr: &Path,
    mixed: bool,
) -> Result<()> {
    let earlier = known.len();
    for AdapterName { name, driver, .. } in devices {
        if known.iter().any(|(other, its)| (other, its) == (name, driver)) {
            continue;
        }
        if let Some((other, its)) = known.first()
            && !mixed
        {
            let devices = format!("{other} ({its}) and {name} ({driver})");
            let nevertheless = "whose rounding may differ. --mixed-drivers goes on nevertheless";
            return Err(Error::Usage(match earlier {
                0 => format!("one film cannot be rendered by {devices}, {nevertheless}"),
                _ => format!("{} cannot be resumed: the devices are {devices}, {nevertheless}", exr.display()),
            }));
        }
        known.push((name.clone(), driver.clone()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Films of several drivers are refused, at the start and later, unless they are allowed.
    #[test]
    fn devices_of_several_drivers_are_mixed_only_on_request() {
        let device = |driver: &str| AdapterName {
            name: "GPU".to_string(),
            driver: driver.to_string(),
            backend: "vulkan".to_string(),
            pci_bus_id: String::new(),
            kind: "discrete GPU",
            software: false,
        };
        let (old, new) = (device("driver 1"), device("driver 2"));
        let add = |known: &mut Vec<_>, names: &[&AdapterName], mixed| {
            add_devices(known, names.iter().copied(), Path::new("a.exr"), mixed).map_err(|error| error.to_string())
        };
        let mut known = Vec::new();
        assert_eq!(add(&mut known, &[&old, &old], false), Ok(()));
        assert_eq!(known, [("GPU".to_string(), "driver 1".to_string())]);
        let error = add(&mut known, &[&new], false).unwrap_err();
        assert!(error.contains("a.exr cannot be resumed") && error.contains("GPU (driver 2)"), "{error}");
        let error = add(&mut Vec::new(), &[&old, &new], false).unwrap_err();
        assert!(error.contains("one film cannot be rendered by") && error.contains("--mixed-drivers"), "{error}");
        assert_eq!(add(&mut known, &[&new, &old], true), Ok(()));
        assert_eq!(known.len(), 2);
    }
}
