//! The line of progress while kernels compile. A driver takes up to minutes for that, and cannot be stopped.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use crate::gpu::device::Device;
use crate::output::progress::Loading;
use crate::printable::counted;

/// How often the progress is shown.
const TICK: Duration = Duration::from_millis(200);

/// Shows how many kernels are compiled, until it is dropped. Where the system has no thread for that, nothing is shown.
pub struct Compiling {
    over: Option<Sender<()>>,
    showing: Option<JoinHandle<()>>,
}

impl Compiling {
    /// Begins for these devices; at once if somebody watches the image. `quiet` shows nothing.
    pub fn show(devices: &[Arc<Device>], quiet: bool, is_watched: bool) -> Compiling {
        let (begin, devices) = (Instant::now(), devices.to_vec());
        let (over, is_over) = channel::<()>();
        let show = move || {
            let mut progress = if is_watched { Loading::at_once(quiet) } else { Loading::new(quiet) };
            while is_over.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                let each = devices.iter().map(|device| device.compiling.get());
                let (ready, all) = each.fold((0, 0), |sum, (ready, all)| (sum.0 + ready, sum.1 + all));
                if all > 0 {
                    progress.show(&words(ready, all, begin.elapsed()), ready as f64 / all as f64);
                }
            }
        };
        Compiling { over: Some(over), showing: Builder::new().spawn(show).ok() }
    }
}

impl Drop for Compiling {
    fn drop(&mut self) {
        self.over = None;
        // What it has drawn is gone before anything else is printed.
        self.showing.take().map(JoinHandle::join);
    }
}

/// `compiling 3 of 5 kernels, 12 s`, of which two are ready.
fn words(ready: usize, all: usize, time: Duration) -> String {
    format!("compiling {} of {}, {} s", (ready + 1).min(all), counted(all as u64, "kernel"), time.as_secs())
}

#[cfg(test)]
mod tests {
    use super::words;
    use std::time::Duration;

    #[test]
    fn the_kernel_that_compiles_is_counted() {
        let at = |ready, all| words(ready, all, Duration::from_millis(12_900));
        assert_eq!(at(2, 5), "compiling 3 of 5 kernels, 12 s");
        assert_eq!(
            (at(0, 1), at(5, 5)),
            ("compiling 1 of 1 kernel, 12 s".into(), "compiling 5 of 5 kernels, 12 s".into())
        );
    }
}
