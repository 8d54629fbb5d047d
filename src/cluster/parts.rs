//! The progress of the parts of a render that many processes share. Only the headers of their files are read.

use std::cmp::Reverse;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::Folder;
use crate::error::Error;
use crate::film::add_devices;
use crate::output::exr::{Attribute, State, StateFile, attribute};
use crate::samples::Samples;

/// A part, and what has come of it.
#[derive(Clone, Debug)]
pub struct Part {
    pub path: PathBuf,
    /// The samples that it is to have.
    pub requested: Range<u32>,
    /// Those that its file has.
    pub samples: Samples,
    pub progress: Progress,
    /// Seconds that a process has taken for one sample of every pixel, if the file has it.
    pub seconds_per_sample: Option<f64>,
}

/// What has come of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// All its samples are there.
    Done,
    /// Samples are missing, and its file has been written of late.
    UnderWay,
    /// Samples are missing, and its file has not been written of late.
    Stopped,
    /// There is no file: no process has come to its first checkpoint.
    NotBegun,
    /// There is a file that cannot be joined with the others, for this reason.
    NotUsable(String),
}

impl Part {
    /// Samples of a pixel that are still to be rendered.
    pub fn missing(&self) -> u64 {
        self.samples.missing(self.requested.clone()).count()
    }

    pub fn is_usable(&self) -> bool {
        matches!(self.progress, Progress::Done | Progress::UnderWay | Progress::Stopped)
    }
}

/// All parts, and what they are of.
#[derive(Clone, Debug)]
pub struct Parts {
    pub all: Vec<Part>,
    /// A file that describes the render of all usable parts, and its state; `None` if no part is usable.
    pub reference: Option<(PathBuf, State)>,
    /// The devices and drivers of the usable parts.
    pub devices: Vec<(String, String)>,
}

/// The contents of a header: the state, the seconds for one sample of every pixel, and when the file was written.
type PartHeader = (State, Option<f64>, SystemTime);

impl Parts {
    /// Reads the headers of the parts. A file is called under way if it was written in the `recent` time. `watch` is called with the number
    /// of each part.
    pub fn read(folder: &Folder, recent: Duration, watch: &mut dyn FnMut(usize)) -> Parts {
        let mut headers = Vec::new();
        for (number, requested) in folder.parts().enumerate() {
            watch(number);
            let path = folder.part_path(&requested);
            headers.push((read_header(&path), path, requested));
        }
        let states: Vec<(&Path, &State)> = headers
            .iter()
            .filter_map(|(header, path, _)| Some((path.as_path(), &header.as_ref().ok()?.as_ref()?.0)))
            .collect();
        let reference = most_common(&states).map(|(path, state)| (path.to_owned(), state.clone()));

        let mut parts = Parts { all: Vec::new(), reference, devices: Vec::new() };
        for (header, path, requested) in headers {
            let mut part = Part {
                path,
                requested,
                samples: Samples::default(),
                progress: Progress::NotBegun,
                seconds_per_sample: None,
            };
            match header {
                Ok(None) => {}
                Err(why) => part.progress = Progress::NotUsable(why),
                Ok(Some((state, seconds_per_sample, written))) => {
                    // A clock that is ahead of this one makes the file look as if it were of the future.
                    let is_recent = written.elapsed().unwrap_or(Duration::ZERO) <= recent;
                    part.seconds_per_sample = seconds_per_sample;
                    parts.add_state(&mut part, &state, is_recent, folder);
                }
            }
            parts.all.push(part);
        }
        parts
    }

    /// Sets the progress of a part from its state.
    pub fn add_state(&mut self, part: &mut Part, state: &State, is_recent: bool, folder: &Folder) {
        if let Err(why) = self.fits(part, state, folder) {
            part.progress = Progress::NotUsable(why);
            part.samples = Samples::default();
            return;
        }
        part.samples = state.samples.clone();
        part.progress = match part.missing() {
            0 => Progress::Done,
            _ if is_recent => Progress::UnderWay,
            _ => Progress::Stopped,
        };
        add_devices(&mut self.devices, &state.devices);
    }

    /// Checks that a file is of this render and holds samples of its part alone.
    fn fits(&self, part: &Part, state: &State, folder: &Folder) -> Result<(), String> {
        let size = (folder.request.width, folder.request.height);
        if state.size != size {
            return Err(format!("it has {}x{} pixels instead of {}x{}", state.size.0, state.size.1, size.0, size.1));
        }
        if let Some((path, reference)) = &self.reference
            && let Some(difference) = state.difference("it", reference, &path.display().to_string())
        {
            return Err(format!("it is of another render than most parts: {difference}"));
        }
        let range = state.samples.range();
        if range.start < part.requested.start || range.end > part.requested.end {
            let Range { start, end } = part.requested;
            return Err(format!("it holds the samples {}, and those of this part are {start}..{end}", state.samples));
        }
        Ok(())
    }
}

/// Reads the header of a part; nothing where there is no file. The error is why it cannot be used.
fn read_header(path: &Path) -> Result<Option<PartHeader>, String> {
    let read = || -> Result<Option<PartHeader>, String> {
        let metadata = match std::fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            metadata => metadata.map_err(|error| error.to_string())?,
        };
        let file = StateFile::open(path).map_err(reason)?;
        let file = file.ok_or("it has no state. Images of other programs, of --no-state and of denoise have none")?;
        let seconds_per_sample = match attribute(&file.attributes(), "gpu-rt:seconds_per_sample") {
            Some(Attribute::Float(seconds)) if seconds.is_finite() && *seconds > 0.0 => Some(*seconds),
            _ => None,
        };
        let written = metadata.modified().map_err(|error| error.to_string())?;
        Ok(Some((file.state, seconds_per_sample, written)))
    };
    // Over a network, a file that is replaced while it is read may become an error.
    read().or_else(|_| read())
}

/// Why a file could not be read, without its name.
fn reason(error: Error) -> String {
    match error {
        Error::File { reason, .. } => reason,
        other => other.to_string(),
    }
}

/// The state that most others agree with; of equally many the first.
fn most_common<'a>(states: &[(&'a Path, &'a State)]) -> Option<(&'a Path, &'a State)> {
    let mut groups: Vec<((&Path, &State), usize)> = Vec::new();
    for state in states {
        match groups.iter_mut().find(|((_, first), _)| first.difference("", state.1, "").is_none()) {
            Some((_, count)) => *count += 1,
            None => groups.push((*state, 1)),
        }
    }
    let numbered = groups.into_iter().enumerate();
    numbered.max_by_key(|(number, (_, count))| (*count, Reverse(*number))).map(|(_, (state, _))| state)
}
