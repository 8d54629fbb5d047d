//! The last write of a render. Where the image cannot be written, it goes to another name, so that the work is not lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::request::Request;
use crate::commands::console::tell;
use crate::commands::signals::{Signals, WAIT};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::output::destination::can_be_replaced;
use crate::output::exr::{Attribute, State};
use crate::output::rescue::{folders, reserve};
use crate::samples::Samples;

/// How long a full disk is tried again if the image has been written under another name. If not, it is tried until a signal comes.
const PATIENCE: Duration = Duration::from_secs(5);
/// The first pause before another attempt. Each later one is twice as long, up to the last.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LAST_PAUSE: Duration = Duration::from_secs(60);

/// What is written at the end.
pub struct LastWrite<'a> {
    pub request: &'a Request<'a>,
    pub signals: &'a Signals,
    pub film: &'a Film,
    pub samples: &'a Samples,
    /// `None` if the film cannot be resumed.
    pub state: Option<State>,
    pub attributes: Vec<(String, Attribute)>,
}

impl LastWrite<'_> {
    /// Writes the image under its name, or under another one if that fails. A full disk is tried again.
    ///
    /// # Errors
    /// The first error, even if the image has another name now. It names that file, what it holds, and the command that resumes the render.
    pub fn write(&self) -> Result<()> {
        let Request { args, image, .. } = self.request;
        let (begin, mut pause) = (Instant::now(), FIRST_PAUSE);
        let (was_interrupted, mut rescued, mut is_reported) = (self.signals.are_pending(), None, false);
        loop {
            let Err(error) = self.request.write(self.film, self.state.as_ref(), &self.attributes) else {
                if is_reported {
                    tell(&format!("{} is written after all", image.display()));
                }
                rescued.iter().for_each(|path: &PathBuf| _ = fs::remove_file(path));
                return Ok(());
            };
            // Nothing is lost if the file has more samples of this render, or if this is a preview.
            if self.request.more_than(self.samples.count()).is_some() || (args.watch && args.no_state) {
                return Err(error);
            }
            let mut failures = Vec::new();
            if rescued.is_none() {
                rescued = self.rescue(&mut failures);
            }
            let found = match &rescued {
                Some(path) => self.words(path),
                None => format!("the image cannot be written elsewhere: {}", words_of(&failures)),
            };
            let is_full = std::iter::once(&error).chain(&failures).any(|error| matches!(error, Error::NoRoom { .. }));
            let is_over = match rescued {
                Some(_) => begin.elapsed() + pause > PATIENCE,
                None => !was_interrupted && self.signals.are_pending(),
            };
            // Under --watch, the next save does not wait.
            if is_over || args.watch || !is_full || !can_be_replaced(image) {
                return Err(error.and(&found));
            }
            if !is_reported {
                self.signals.set_loss(match rescued {
                    Some(_) => found.clone(),
                    None => format!("{} samples per pixel are lost", self.samples.count()),
                });
                let until = if rescued.is_some() { "" } else { " until it can be written or a signal comes" };
                tell(&format!("warning: {error}; {found}. {} is tried again{until}", image.display()));
                is_reported = true;
            }
            self.wait(pause, was_interrupted);
            pause = (2 * pause).min(LAST_PAUSE);
        }
    }

    /// Waits, but not beyond the first signal.
    fn wait(&self, pause: Duration, was_interrupted: bool) {
        let begin = Instant::now();
        while begin.elapsed() < pause && (was_interrupted || !self.signals.are_pending()) {
            sleep(WAIT);
        }
    }

    /// Writes the image as an EXR under another name, in the folder of the image or in that of temporary files. Returns its path. Each folder in
    /// which that fails adds a failure.
    fn rescue(&self, failures: &mut Vec<Error>) -> Option<PathBuf> {
        let Request { args, image, .. } = self.request;
        let default = args.default_image();
        let name = if can_be_replaced(image) { image } else { &default };
        for folder in folders(image) {
            let written = reserve(&folder, name, image).map_err(|error| Error::of_write(&folder, &error));
            let written = written.and_then(|path| {
                let written = self.request.write_to(&path, self.film, self.state.as_ref(), &self.attributes);
                if written.is_err() {
                    let _ = fs::remove_file(&path);
                }
                written.map(|()| path)
            });
            match written {
                Ok(path) => return Some(path),
                Err(error) => failures.push(error),
            }
        }
        None
    }

    fn words(&self, path: &Path) -> String {
        match &self.state {
            Some(_) => self.request.what_is_in(path, self.samples),
            None => format!("{} holds what there was, and cannot be resumed", path.display()),
        }
    }
}

fn words_of(errors: &[Error]) -> String {
    errors.iter().map(Error::to_string).collect::<Vec<_>>().join("; ")
}
