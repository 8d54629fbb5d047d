//! Who sees the image while it renders: a viewer on a port, or the terminal.

use std::time::Duration;

use super::args::RenderArgs;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::output::display::Display;
use crate::output::preview::Preview;
use crate::output::progress::{Progress, is_terminal};

/// What bringing the film from the device and measuring its error takes: 0.1 to 0.2 µs a pixel.
pub fn snapshot_time((width, height): (u32, u32)) -> Duration {
    Duration::from_nanos(u64::from(width) * u64::from(height) * 150)
}

/// The time between two snapshots: they shall cost 0.5 % at most, or 5 % where somebody watches the image, and nobody needs more than one a
/// second.
pub fn pause_after(snapshot: Duration, is_watched: bool) -> Duration {
    let share = if is_watched { 20 } else { 200 };
    (share * snapshot).max(Duration::from_secs(1))
}

/// Viewers of the image so far, at each snapshot, and of the image at the end.
#[derive(Default)]
pub struct Viewers {
    preview: Option<Preview>,
    /// With the address where it listens.
    display: Option<(Display, String)>,
}

impl Viewers {
    /// Refuses viewers that cannot show anything, before the render begins.
    pub fn check(args: &RenderArgs) -> Result<()> {
        match args.viewers.preview && !is_terminal() {
            true => Err(Error::Usage(
                "--preview draws on standard error, which is not a terminal; nothing has been rendered".to_owned(),
            )),
            false => Ok(()),
        }
    }

    /// The viewers of the options. `name` is the name of the image.
    pub fn open(args: &RenderArgs, name: String, size: (u32, u32)) -> Viewers {
        let display =
            args.viewers.display_server.clone().map(|address| (Display::open(address.clone(), name, size), address));
        Viewers { preview: args.viewers.preview.then(|| Preview::new(size, args.view.transform())), display }
    }

    /// Whether there is anybody.
    pub fn any(&self) -> bool {
        self.display.is_some() || self.preview.is_some()
    }

    /// Shows the image so far.
    pub fn show(&mut self, film: &Film, progress: &Progress) {
        let pixels = film.width() as usize * film.height() as usize;
        if let Some((display, _)) = self.display.as_ref().filter(|(display, _)| display.is_open()) {
            display.show((0..pixels).flat_map(|index| film.developed(index).rgb).collect());
        }
        if let Some(preview) = &mut self.preview {
            preview.show(&|index| film.developed(index).rgb, progress);
        }
        self.tell_failure(progress);
    }

    /// Shows the image at the end.
    pub fn end(&mut self, film: &Film, progress: &Progress) {
        self.show(film, progress);
        if let Some((display, _)) = &self.display {
            display.close();
        }
        self.tell_failure(progress);
    }

    /// The failure of a viewer is reported once, and does not stop the render.
    fn tell_failure(&self, progress: &Progress) {
        let failure = self.display.as_ref().and_then(|(display, address)| Some((display.failure()?, address)));
        if let Some((reason, address)) = failure {
            progress.message(&format!("warning: --display-server {address}: {reason}. It gets no more images"));
        }
    }
}
