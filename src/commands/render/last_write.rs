//! The last write of a render. Where the image cannot be written, it goes to another name, so that the work is not lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use super::record::attributes_of;
use super::request::Request;
use crate::commands::console::{command_of_image, tell};
use crate::commands::signals::{Signals, WAIT};
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::output::destination::can_be_replaced;
use crate::output::exr::{Attribute, State};
use crate::output::rescue::{folders, reserve};

/// How long a full disk is tried again if the image has been written under another name. If not, it is tried until a signal comes.
const PATIENCE: Duration = Duration::from_secs(5);
/// The first pause before another attempt. Each later one is twice as long, up to the last.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LAST_PAUSE: Duration = Duration::from_secs(60);

/// What is written at the end.
pub struct LastWrite<'a> {
    request: &'a Request<'a>,
    signals: &'a Signals,
    film: &'a Accumulation,
    /// `None` if the film cannot be resumed.
    state: Option<State>,
    attributes: Vec<(String, Attribute)>,
}

impl<'a> LastWrite<'a> {
    /// The last write of a film with this record.
    pub fn new(
        request: &'a Request<'a>,
        signals: &'a Signals,
        film: &'a Accumulation,
        record: &Map<String, Value>,
    ) -> LastWrite<'a> {
        LastWrite { request, signals, film, state: None, attributes: attributes_of(record) }
    }

    /// Writes the image, if the render has added something to it, and its picture. An EXR with more samples than the complete render is kept: the
    /// number of samples of `--time` and `--noise` is known only now. The result is the number of those samples.
    pub fn write(mut self, has_rendered: bool, complete: bool) -> Result<Option<u64>> {
        let (request, Accumulation { film, samples, .. }) = (self.request, self.film);
        let more = if complete { request.more_than(samples.count()) } else { None };
        if has_rendered && more.is_none() {
            self.state = Some(State::new(request.identity().clone(), self.film));
            if let Err(error) = self.write_image() {
                let _ = request.write_png(film);
                return Err(error);
            }
        }
        let image = request.image.display();
        let contents = if request.args.keep.watch { "last picture" } else { "image" };
        self.signals.set_loss(format!("{image} holds the {contents}"));
        let develop = command_of_image("develop", &request.image, "NAME.png");
        let held = format!("{image} holds the image. `{develop}` makes the picture");
        request.write_png(film).map_err(|error| error.and(&held)).map(|()| more)
    }

    /// Keeps what there is where the device has failed for good; `kept` is the state in the output. The error says what that is.
    pub fn keep(self, error: Error, kept: Option<State>) -> Error {
        let (request, film) = (self.request, &self.film.film);
        if !matches!(error, Error::Device(_)) {
            return error;
        }
        if let Some(state) = kept {
            return error.and(&request.what_is_in(&request.image, &state.samples));
        }
        // A film with runs under way left out favours short paths. Nothing can go on from it.
        if film.totals.paths == 0 {
            return error.and("nothing has been written");
        }
        match self.write_image().and_then(|()| request.write_png(film)) {
            Ok(()) => error.and(&format!("{} holds what there was, and cannot be resumed", request.image.display())),
            Err(failed) => error.and(&failed.to_string()),
        }
    }

    /// Writes the image under its name, or under another one if that fails. A full disk is tried again.
    ///
    /// # Errors
    /// The first error, even if the image has another name now. It names that file, what it holds, and the command that resumes the render.
    fn write_image(&self) -> Result<()> {
        let Request { args, image, .. } = self.request;
        let (begin, mut pause) = (Instant::now(), FIRST_PAUSE);
        let (was_interrupted, mut rescued, mut is_reported) = (self.signals.are_pending(), None, false);
        loop {
            let Err(error) = self.request.write(&self.film.film, self.state.as_ref(), &self.attributes) else {
                if is_reported {
                    tell(&format!("{} is written after all", image.display()));
                }
                rescued.iter().for_each(|path: &PathBuf| _ = fs::remove_file(path));
                return Ok(());
            };
            // Nothing is lost if the file has more samples of this render, or if this is a preview.
            if self.request.more_than(self.film.samples.count()).is_some() || (args.keep.watch && args.keep.no_state) {
                return Err(error);
            }
            let mut failures = Vec::new();
            if rescued.is_none() {
                rescued = self.rescue(&mut failures);
            }
            let reasons = failures.iter().map(Error::to_string).collect::<Vec<_>>().join("; ");
            let found = match &rescued {
                Some(path) => self.words(path),
                None => format!("the image cannot be written elsewhere: {reasons}"),
            };
            let is_full = std::iter::once(&error).chain(&failures).any(|error| matches!(error, Error::NoRoom { .. }));
            let is_over = match rescued {
                Some(_) => begin.elapsed() + pause > PATIENCE,
                None => !was_interrupted && self.signals.are_pending(),
            };
            // Under --watch, the next save does not wait.
            if is_over || args.keep.watch || !is_full || !can_be_replaced(image) {
                return Err(error.and(&found));
            }
            if !is_reported {
                self.signals.set_loss(match rescued {
                    Some(_) => found.clone(),
                    None => format!("{} samples per pixel are lost", self.film.samples.count()),
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
                let written = self.request.write_to(&path, &self.film.film, self.state.as_ref(), &self.attributes);
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
            Some(_) => self.request.what_is_in(path, &self.film.samples),
            None => format!("{} holds what there was, and cannot be resumed", path.display()),
        }
    }
}
