//! A series of renders: one, those of `--watch`, or those of `--frames`.

use std::collections::HashSet;
use std::time::Instant;

use serde_json::Value;

use super::args::RenderArgs;
use crate::aov::Aov;
use crate::commands::changes::Changes;
use crate::commands::console::tell;
use crate::commands::scene::load_from;
use crate::commands::signals::Signals;
use crate::commands::target::tell_driver;
use crate::error::Result;
use crate::output::progress::Loading;
use crate::scene::{Assets, Scene};
use crate::session::Session;

/// Renders a scene that has been loaded since an instant.
pub type Render = fn(&RenderArgs, &Scene, &mut Series, Instant) -> Result<()>;

/// The things that stay from render to render.
#[derive(Default)]
pub struct Series {
    pub session: Session,
    pub assets: Assets,
    /// `None` before somebody listens.
    pub signals: Option<Signals>,
    /// Under `--watch`: the files that end a render when they change.
    pub changes: Option<Changes>,
    /// The seconds that the last render took for its kernels, linked or compiled.
    pub compile: f64,
    /// Whether the user wants errors only. Previews are quiet in any case, but for the progress of what they compile.
    pub quiet: bool,
    /// Whether the warnings about devices have been printed.
    pub devices_reported: bool,
    /// Under `--frames`.
    pub frames: Option<Reported>,
}

/// The reports and warnings about the frames of a sequence so far.
#[derive(Default)]
pub struct Reported {
    /// The reports of `--json`.
    pub reports: Vec<Value>,
    /// The warnings that have been printed.
    warnings: HashSet<String>,
    /// Whether a frame has begun. Later ones have its settings.
    has_begun: bool,
}

impl Series {
    pub fn new(args: &RenderArgs) -> Series {
        let session = Session::opening(args.paths.device.as_deref());
        Series { session, quiet: args.messages.quiet, ..Series::default() }
    }

    /// Loads the scene; of what its files hold only what is new.
    pub fn load(&mut self, args: &RenderArgs) -> Result<Scene> {
        let mut loading = Loading::new(args.messages.quiet);
        let progress = &mut |file: &_, done, total| loading.update(file, done, total);
        let motion = args.options.aov.has(Aov::Motion);
        load_from(&args.scene, motion, std::io::stdin().lock(), progress, &mut self.assets)
    }

    /// Whether a render hides its warnings. One of a sequence may itself be quiet and still tell what is new.
    pub fn hides_warnings(&self, quiet: bool) -> bool {
        quiet && (self.quiet || self.frames.is_none())
    }

    /// Prints warnings unless `quiet`; those of a sequence once, and not for each of its frames.
    pub fn tell_warnings(&mut self, warnings: &[String], quiet: bool) {
        let mut is_new = |warning: &String| match &mut self.frames {
            Some(reported) => reported.warnings.insert(without_times(warning)),
            None => true,
        };
        let new = warnings.iter().filter(|warning| is_new(warning));
        new.filter(|_| !quiet).for_each(|warning| tell(&format!("warning: {warning}")));
    }

    /// Whether the next render is that of a later frame of a sequence, whose settings are those of the first.
    pub fn is_at_later_frame(&self) -> bool {
        self.frames.as_ref().is_some_and(|reported| reported.has_begun)
    }

    /// Notes that a render has begun.
    pub fn begin(&mut self) {
        self.frames.iter_mut().for_each(|reported| reported.has_begun = true);
    }

    /// Tells which of the devices are software, once.
    pub fn tell_devices(&mut self, quiet: bool) {
        let devices = &self.session.devices;
        for (number, device) in devices.iter().enumerate() {
            let is_repeated = devices.iter().take(number).any(|other| other.name == device.name);
            tell_driver(device, quiet || is_repeated || self.devices_reported);
        }
        self.devices_reported |= !quiet;
    }

    /// How many kernels have been compiled.
    pub fn compiled(&self) -> usize {
        self.session.devices.iter().map(|device| device.kernels.compiled_names().len()).sum()
    }
}

/// A warning without the times in the names of posed meshes, in which alone those of two frames may differ.
fn without_times(warning: &str) -> String {
    let mut parts = warning.split("/seconds/");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.trim_start_matches(|c: char| c.is_ascii_digit() || "-.e".contains(c)))
}

#[cfg(test)]
mod tests {
    use super::without_times;

    #[test]
    fn warnings_about_two_frames_of_a_mesh_are_one() {
        let warning = |seconds: &str| without_times(&format!("a.glb#nodes/1/primitives/0{seconds}: 3 faces"));
        assert_eq!(warning("/seconds/0.041666666666666664"), "a.glb#nodes/1/primitives/0: 3 faces");
        assert_eq!(warning("/seconds/-1e-7"), warning(""));
        assert_ne!(without_times("a.glb#nodes/2/primitives/0: 3 faces"), warning(""));
    }
}
