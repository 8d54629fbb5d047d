//! The requests of `gpu-rt serve`: a JSON object in each line of standard input.

use std::collections::BTreeMap;
use std::io::stdin;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::Builder;

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
    /// As `--size` and `--display-server` have them.
    pub size: Option<String>,
    pub display: Option<String>,
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

/// The requests that come, each with the number of interrupts before it.
pub struct Requests {
    coming: Receiver<(Result<Request>, usize)>,
    interrupts: Arc<AtomicUsize>,
    signals: Signals,
}

impl Requests {
    /// Listens from now on. An interrupt is as a signal that ends no program. `temporary` is the folder of a parent process: if standard input ends without
    /// `close`, the parent has died. So does this program then, and removes the folder.
    ///
    /// # Errors
    /// `Error::File` if the system gives no thread.
    pub fn listen(signals: &Signals, temporary: Option<PathBuf>) -> Result<Requests> {
        let (sender, coming) = channel();
        let requests = Requests { coming, interrupts: Arc::default(), signals: signals.clone() };
        let (interrupts, signals) = (Arc::clone(&requests.interrupts), signals.clone());
        let listen = move || {
            let is_closed = read(&sender, &interrupts, &signals);
            if let Some(folder) = temporary.filter(|_| !is_closed) {
                // A file may be made in it meanwhile.
                let _ = std::fs::remove_dir_all(&folder).or_else(|_| std::fs::remove_dir_all(&folder));
                signal_hook::low_level::exit(1);
            }
        };
        Builder::new().name("requests".to_owned()).spawn(listen).map_err(Error::file("stdin", "read"))?;
        Ok(requests)
    }

    /// The next request, or what is wrong with it; nothing behind the last one, or once a signal has come.
    pub fn next(&self) -> Option<Result<Request>> {
        let (request, interrupts_before) = loop {
            match self.coming.recv_timeout(WAIT) {
                _ if self.signals.have_come() => return None,
                Err(RecvTimeoutError::Timeout) => {}
                next => break next.ok()?,
            }
        };
        // In this order, so that none is lost that comes just now.
        self.signals.set_stop(false);
        if self.interrupts.load(Ordering::SeqCst) > interrupts_before {
            self.signals.set_stop(true);
        }
        Some(request)
    }
}

/// Reads requests up to `close`, which gives true, or up to the end of standard input.
fn read(sender: &Sender<(Result<Request>, usize)>, interrupts: &AtomicUsize, signals: &Signals) -> bool {
    for line in stdin().lines() {
        let line = line.map_err(Error::file("stdin", "read"));
        let wrong = |error: serde_json::Error| Error::Usage(format!("the request: {error}"));
        match line.and_then(|line| serde_json::from_str::<Request>(&line).map_err(wrong)) {
            Ok(Request { interrupt: true, close, .. }) => {
                interrupts.fetch_add(1, Ordering::SeqCst);
                signals.set_stop(true);
                if close {
                    return true;
                }
            }
            // Nobody takes requests once the program ends.
            request => drop(sender.send((request, interrupts.load(Ordering::SeqCst)))),
        }
    }
    false
}
