//! A film with the samples that it has: what an earlier render has left in the output, and what is left to do.

use std::ops::Range;
use std::path::Path;

use super::args::Resume;
use super::request::Request;
use crate::commands::console::tell;
use crate::data::RUN_LENGTH;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::gpu::device::{AdapterName, Device};
use crate::job::{Goal, Job};
use crate::output::exr::{State, add_film, read_state};
use crate::render::{Noise, check_error, empty_film, samples_at_check};
use crate::samples::Samples;

/// A film with its samples and devices, as a file with a state holds them.
pub struct Accumulation {
    pub film: Film,
    pub samples: Samples,
    /// How often `--noise` has compared the error with the requested one.
    pub checks: u32,
    /// The devices and drivers that have rendered it.
    pub devices: Vec<(String, String)>,
}

impl Request<'_> {
    /// The state of the output that the render resumes; `None` if the render starts afresh.
    ///
    /// # Errors
    /// `Error::Usage` if there is nothing to resume, if the output is of another render, or if it has more samples than requested.
    pub fn earlier(&self) -> Result<Option<State>> {
        let Some(exr) = self.exr() else { return Ok(None) };
        let Some(resume) = self.args.resume else { return self.refuse_to_lose().map(|()| None) };
        let name = exr.display();
        let nothing = |why: String| match resume {
            Resume::Auto => {
                if !self.args.quiet {
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
        if !self.args.quiet && missing.ranges().iter().any(cut) {
            tell(&format!(
                "{name} ends within a run of {RUN_LENGTH} samples: the result is that of one render, but for the rounding of f32"
            ));
        }
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

impl Accumulation {
    /// An empty film.
    fn new(film: Film) -> Accumulation {
        Accumulation { film, samples: Samples::default(), checks: 0, devices: Vec::new() }
    }

    /// The film that these devices begin with: that of the output, if it has this state, or an empty one.
    ///
    /// # Errors
    /// `Error::File` if the pixels of the output cannot be read. `Error::Usage` as of [`Accumulation::add_devices`].
    pub fn begin(request: &Request<'_>, earlier: Option<&State>, devices: &[Device]) -> Result<Accumulation> {
        let mut begun = match earlier {
            Some(state) => {
                let mut film = state.film()?.not_sampling(request.flat.not_sampled).with_lamps(&request.flat.lamps);
                add_film(&request.image, state, &mut film)?;
                let State { samples, checks, devices, .. } = state.clone();
                Accumulation { film, samples, checks, devices }
            }
            None => {
                let film = empty_film(&request.flat, request.job.size, &request.args.options)?;
                Accumulation::new(film.of_part(request.frame).with_lamps(&request.flat.lamps))
            }
        };
        let names = devices.iter().map(|device| &device.name);
        begun.add_devices(names, &request.image, request.args.mixed_drivers)?;
        Ok(begun)
    }

    /// Adds the devices that render from now on to those that have rendered it.
    ///
    /// # Errors
    /// `Error::Usage` if the drivers differ, among these devices or from those that rendered the film, unless drivers may be mixed.
    fn add_devices<'a>(
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

    /// The result of the last check of this film by `--noise`, if it ended the render.
    pub fn noise_reached(&self, job: &Job) -> Option<Noise> {
        let Goal::Noise { error, .. } = job.goal else { return None };
        let last = self.checks.checked_sub(1)?;
        let samples = samples_at_check(last);
        if self.samples.count() != u64::from(samples) {
            return None;
        }
        Some(check_error(&self.film, samples, last, error).0).filter(|noise| noise.reached)
    }

    /// What is left of a job.
    pub fn jobs(&self, job: &Job, reached: Option<Noise>) -> Vec<Job> {
        let missing = match reached {
            Some(_) => Samples::default(),
            None => self.samples.missing(job.first_sample..job.goal.end()),
        };
        // Several devices that were stopped leave gaps. They are filled before a goal is aimed at.
        let is_gap = |range: &Range<u32>| range.start < self.samples.range().end;
        let part = |range: &Range<u32>| {
            let goal = match job.goal {
                Goal::Until { deadline, .. } | Goal::Noise { deadline: Some(deadline), .. } if is_gap(range) => {
                    Goal::Until { deadline, end: range.end }
                }
                Goal::Noise { error, deadline, end, begun, .. } if !is_gap(range) => {
                    Goal::Noise { error, deadline, end, begun, checks: self.checks }
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
        let add = |film: &mut Accumulation, names: &[&AdapterName], mixed| {
            film.add_devices(names.iter().copied(), Path::new("a.exr"), mixed).map_err(|error| error.to_string())
        };
        let empty = || Accumulation::new(Film::new(1, 1, 0).unwrap());
        let mut film = empty();
        assert_eq!(add(&mut film, &[&old, &old], false), Ok(()));
        assert_eq!(film.devices, [("GPU".to_string(), "driver 1".to_string())]);
        let error = add(&mut film, &[&new], false).unwrap_err();
        assert!(error.contains("a.exr cannot be resumed") && error.contains("GPU (driver 2)"), "{error}");
        let error = add(&mut empty(), &[&old, &new], false).unwrap_err();
        assert!(error.contains("one film cannot be rendered by") && error.contains("--mixed-drivers"), "{error}");
        assert_eq!(add(&mut film, &[&new, &old], true), Ok(()));
        assert_eq!(film.devices.len(), 2);
    }
}
