//! The requests of `gpu-rt serve`: a JSON object in each line of standard input.

use std::collections::BTreeMap;
use std::io::stdin;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, sleep};

use serde::Deserialize;

use super::signals::{Signals, WAIT};
use crate::error::{Error, Result};
use crate::scene::Rows;

/// A request to render the scene. What it does not give is as on the command line of `serve`, and as in the scene.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Request {
    /// The .exr to write.
    pub output: PathBuf,
    pub seed: Option<u32>,
    pub spp: Option<u32>,
    pub aov: Option<String>,
    pub frame: Option<f64>,
    /// These three are as in [`Change`](crate::scene::Change).
    pub camera: Option<String>,
    pub objects: Option<BTreeMap<String, Rows>>,
    pub materials: Option<BTreeMap<String, String>>,
    /// This one renders nothing and has no answer: it ends the renders that were requested before it.
    interrupt: bool,
    /// Beside it: there are no more requests, and the folder of temporary files stays.
    close: bool,
}

/// The requests that come.
pub struct Requests {
    coming: Receiver<Result<Request>>,
    turns: Arc<Mutex<Turns>>,
    signals: Signals,
    /// The folder of temporary files, and the parent process.
    temporary: Option<PathBuf>,
    parent: u32,
}

/// How many requests have come, how many have begun, and how many are interrupted.
#[derive(Default)]
struct Turns {
    read: u64,
    begun: u64,
    interrupted: u64,
    closed: bool,
}

impl Requests {
    /// Listens from now on. An interrupt is as a signal that ends no program. If the parent process ends first, so does this one, and removes the
    /// folder of temporary files.
    ///
    /// # Errors
    /// `Error::File` if the system gives no thread.
    pub fn listen(signals: &Signals, temporary: Option<PathBuf>) -> Result<Requests> {
        let (sender, coming) = channel();
        let turns = Arc::new(Mutex::new(Turns::default()));
        let reader = Reader { sender, turns: Arc::clone(&turns), signals: signals.clone() };
        let (parent, images) = (parent(), temporary.clone());
        let read = move || {
            reader.read();
            while parent == self::parent() {
                sleep(WAIT);
            }
            images.iter().for_each(|folder| _ = std::fs::remove_dir_all(folder));
            signal_hook::low_level::exit(1);
        };
        Builder::new().name("requests".to_owned()).spawn(read).map_err(Error::file("stdin", "read"))?;
        Ok(Requests { coming, turns, signals: signals.clone(), temporary, parent })
    }

    /// The next request, or what is wrong with it; nothing behind the last one.
    pub fn next(&mut self) -> Option<Result<Request>> {
        let Ok(request) = self.coming.recv() else {
            self.end();
            return None;
        };
        let mut turns = locked(&self.turns);
        turns.begun += 1;
        self.signals.set_stop(turns.interrupted >= turns.begun);
        Some(request)
    }

    /// Removes the folder of temporary files if the parent has ended. Its end of the input closes a moment before that.
    fn end(&self) {
        let Some(folder) = self.temporary.as_ref().filter(|_| !locked(&self.turns).closed) else { return };
        for _ in 0..100 {
            if self.parent != parent() {
                let _ = std::fs::remove_dir_all(folder);
                return;
            }
            sleep(WAIT);
        }
    }
}

struct Reader {
    sender: Sender<Result<Request>>,
    turns: Arc<Mutex<Turns>>,
    signals: Signals,
}

impl Reader {
    /// Reads requests up to the end of standard input.
    fn read(self) {
        for line in stdin().lines() {
            let line = line.map_err(Error::file("stdin", "read"));
            let wrong = |error: serde_json::Error| Error::Usage(format!("the request: {error}"));
            let request = line.and_then(|line| serde_json::from_str::<Request>(&line).map_err(wrong));
            let mut turns = locked(&self.turns);
            if request.as_ref().is_ok_and(|request| request.interrupt) {
                turns.interrupted = turns.read;
                self.signals.set_stop(true);
                turns.closed = request.is_ok_and(|request| request.close);
                if turns.closed {
                    return;
                }
                continue;
            }
            turns.read += 1;
            if self.sender.send(request).is_err() {
                return;
            }
        }
    }
}

fn locked(turns: &Mutex<Turns>) -> MutexGuard<'_, Turns> {
    turns.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The number of the parent process, which is another one when that has ended.
#[cfg(unix)]
fn parent() -> u32 {
    std::os::unix::process::parent_id()
}

#[cfg(not(unix))]
fn parent() -> u32 {
    0
}
