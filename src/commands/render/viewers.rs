//! Who sees the image while it renders: a viewer on a port.

use crate::cli::RenderArgs;
use crate::film::Film;
use crate::output::display::Display;
use crate::output::progress::Progress;

/// Those who see the image so far at each look, and the image at the end.
#[derive(Default)]
pub struct Viewers {
    display: Option<Display>,
    /// Where the viewer listens.
    address: String,
    pixels: usize,
}

impl Viewers {
    /// Those whom the options ask for. `name` is that of the image.
    pub fn open(args: &RenderArgs, name: String, size: (u32, u32)) -> Viewers {
        let address = args.display_server.clone().unwrap_or_default();
        let display = args.display_server.clone().map(|address| Display::open(address, name, size));
        Viewers { display, address, pixels: size.0 as usize * size.1 as usize }
    }

    /// Whether there is anybody.
    pub fn any(&self) -> bool {
        self.display.is_some()
    }

    /// Shows the image so far.
    pub fn show(&mut self, film: &Film, progress: &Progress) {
        if let Some(display) = self.display.as_ref().filter(|display| display.is_open()) {
            display.show((0..self.pixels).flat_map(|index| film.developed(index).rgb).collect());
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
