//! The requests of `gpu-rt serve`: a JSON object in each line of standard input.

use std::collections::{BTreeMap, VecDeque};
use std::io::stdin;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;

use serde::Deserialize;

use super::signals::Signals;
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
    /// Beside it: there are no more requests.
    close: bool,
}

/// The requests that come.
#[derive(Clone)]
pub struct Requests {
    queue: Arc<(Mutex<Queue>, Condvar)>,
    signals: Signals,
}

/// Requests that have not begun, and whether no more come.
#[derive(Default)]
struct Queue {
    /// A request, and whether it is interrupted.
    waiting: VecDeque<(Result<Request>, bool)>,
    has_ended: bool,
}

impl Requests {
    /// Listens from now on. An interrupt is as a signal that ends no program. `temporary` is the folder of a parent process: if standard input ends without
    /// `close`, the parent has died. So does this program then, and removes the folder.
    ///
    /// # Errors
    /// `Error::File` if the system gives no thread.
    pub fn listen(signals: &Signals, temporary: Option<PathBuf>) -> Result<Requests> {
        let requests = Requests { queue: Arc::default(), signals: signals.clone() };
        let reader = requests.clone();
        let read = move || {
            let is_closed = reader.read();
            if let Some(folder) = temporary.filter(|_| !is_closed) {
                // A file may be made in it meanwhile.
                let _ = std::fs::remove_dir_all(&folder).or_else(|_| std::fs::remove_dir_all(&folder));
                signal_hook::low_level::exit(1);
            }
            reader.locked().has_ended = true;
            reader.queue.1.notify_all();
        };
        Builder::new().name("requests".to_owned()).spawn(read).map_err(Error::file("stdin", "read"))?;
        Ok(requests)
    }

    /// The next request, or what is wrong with it; nothing behind the last one.
    pub fn next(&mut self) -> Option<Result<Request>> {
        let is_empty = |queue: &mut Queue| queue.waiting.is_empty() && !queue.has_ended;
        let mut queue = self.queue.1.wait_while(self.locked(), is_empty).unwrap_or_else(PoisonError::into_inner);
        let (request, is_interrupted) = queue.waiting.pop_front()?;
        self.signals.set_stop(is_interrupted);
        Some(request)
    }

    /// Reads requests up to `close`, which gives true, or up to the end of standard input.
    fn read(&self) -> bool {
        for line in stdin().lines() {
            let line = line.map_err(Error::file("stdin", "read"));
            let wrong = |error: serde_json::Error| Error::Usage(format!("the request: {error}"));
            let request = line.and_then(|line| serde_json::from_str::<Request>(&line).map_err(wrong));
            let mut queue = self.locked();
            match request {
                Ok(Request { interrupt: true, close, .. }) => {
                    queue.waiting.iter_mut().for_each(|(_, is_interrupted)| *is_interrupted = true);
                    self.signals.set_stop(true);
                    if close {
                        return true;
                    }
                }
                request => queue.waiting.push_back((request, false)),
            }
            self.queue.1.notify_all();
        }
        false
    }

    fn locked(&self) -> MutexGuard<'_, Queue> {
        self.queue.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
