//! Who sees the image while it renders: a viewer on a port, or the terminal.

use super::RenderArgs;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::output::display::Display;
use crate::output::preview::Preview;
use crate::output::progress::{Progress, is_terminal};

/// Those who see the image so far at each look, and the image at the end.
#[derive(Default)]
pub struct Viewers {
    preview: Option<Preview>,
    display: Option<Display>,
    /// Where the viewer listens.
    address: String,
    pixels: usize,
}

impl Viewers {
    /// Refuses what nobody would see, before anything costs time.
    pub fn check(args: &RenderArgs) -> Result<()> {
        match args.preview && !is_terminal() {
            true => Err(Error::Usage(
                "--preview draws in the terminal that standard error is, and it is none; nothing has been rendered"
                    .to_owned(),
            )),
            false => Ok(()),
        }
    }

    /// Those whom the options ask for. `name` is that of the image.
    pub fn open(args: &RenderArgs, name: String, size: (u32, u32)) -> Viewers {
        let address = args.display_server.clone().unwrap_or_default();
        let display = args.display_server.clone().map(|address| Display::open(address, name, size));
        let preview = args.preview.then(|| Preview::new(size, args.view.transform()));
        Viewers { preview, display, address, pixels: size.0 as usize * size.1 as usize }
    }

    /// Whether there is anybody.
    pub fn any(&self) -> bool {
        self.display.is_some() || self.preview.is_some()
    }

    /// Shows the image so far.
    pub fn show(&mut self, film: &Film, progress: &Progress) {
        if let Some(display) = self.display.as_ref().filter(|display| display.is_open()) {
            display.show((0..self.pixels).flat_map(|index| film.developed(index).rgb).collect());
        }
        if let Some(preview) = &mut self.preview {
            preview.show(&|index| film.developed(index).rgb, progress);
        }
        self.tell_failure(progress);
    }

    /// Shows the image at the end.
    pub fn end(&mut self, film: &Film, progress: &Progress) {
        self.show(film, progress);
        if let Some(display) = &self.display {
            display.close();
        }
        self.tell_failure(progress);
    }

    /// A viewer that fails is told of once, and is no reason to stop.
    fn tell_failure(&self, progress: &Progress) {
        if let Some(reason) = self.display.as_ref().and_then(Display::failure) {
            let address = &self.address;
            progress.message(&format!("warning: --display-server {address}: {reason}. It gets no more images"));
        }
    }
}
