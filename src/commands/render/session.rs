//! A session: what stays between the renders of `--watch` and of `--frames`.

use std::collections::HashSet;

use serde_json::Value;

use super::args::RenderArgs;
use super::changes::Changes;
use super::rendering::Clock;
use crate::commands::console::tell;
use crate::commands::scene::{load_with, size_of};
use crate::commands::signals::Signals;
use crate::commands::target::{open_devices, tell_driver};
use crate::error::Result;
use crate::flatten::{DeviceScene, Hierarchies, flatten_with};
use crate::gpu::device::Device;
use crate::output::progress::Loading;
use crate::scene::{Assets, Scene};
use crate::threads::join;

/// What stays between renders. The devices keep the kernels that they have compiled.
#[derive(Default)]
pub struct Session {
    /// Empty before the first render.
    pub devices: Vec<Device>,
    /// `None` before somebody listens.
    pub signals: Option<Signals>,
    /// Under `--watch`: the files that end a render when they change.
    pub changes: Option<Changes>,
    /// The seconds that the last render took for its kernels, linked or compiled.
    pub compile: f64,
    /// Whether the user wants errors only. Previews are quiet in any case, but for the progress of what they compile.
    pub quiet: bool,
    /// Whether the warnings about software devices have been printed.
    pub devices_reported: bool,
    /// Under `--watch` and `--frames`: the hierarchies of the scene's meshes.
    pub hierarchies: Option<Hierarchies>,
    pub assets: Assets,
    /// Under `--frames`.
    pub sequence: Option<Sequence>,
}

/// The frames of a sequence so far.
#[derive(Default)]
pub struct Sequence {
    /// The reports of `--json`.
    pub reports: Vec<Value>,
    /// The warnings that have been printed.
    reported: HashSet<String>,
    /// Whether the warnings about settings have been printed.
    has_begun: bool,
}

impl Session {
    /// Loads the scene; of what its files hold only what is new.
    pub fn load(&mut self, args: &RenderArgs) -> Result<Scene> {
        let mut loading = Loading::new(args.quiet);
        let progress = &mut |file: &_, done, total| loading.update(file, done, total);
        load_with(&args.scene, progress, &mut self.assets)
    }

    /// Prints warnings unless `quiet`; those of a sequence once, and not for each of its frames.
    pub fn tell_warnings(&mut self, warnings: &[String], quiet: bool) {
        let mut is_new = |warning: &String| match &mut self.sequence {
            Some(sequence) => sequence.reported.insert(without_times(warning)),
            None => true,
        };
        let new = warnings.iter().filter(|warning| is_new(warning));
        new.filter(|_| !quiet).for_each(|warning| tell(&format!("warning: {warning}")));
    }

    /// Begins a render. Returns whether it is that of a later frame of a sequence, whose settings are those of the first.
    pub fn begins_later_frame(&mut self) -> bool {
        self.sequence.as_mut().is_some_and(|sequence| std::mem::replace(&mut sequence.has_begun, true))
    }

    /// Flattens the scene. If no device is open, the driver loads meanwhile. A scene that does not load waits for no driver.
    pub fn flatten(
        &mut self,
        args: &RenderArgs,
        scene: &Scene,
        clock: &mut Clock,
    ) -> (Result<Vec<Device>>, Result<DeviceScene>) {
        let size = size_of(scene, args.size.0);
        let opening = || match self.devices.is_empty() {
            true => open_devices(args.paths.device.as_deref()),
            false => Ok(Vec::new()),
        };
        join(opening, || {
            let flat = flatten_with(scene, size, &args.options, self.hierarchies.as_mut());
            clock.seconds.build = clock.lap();
            flat
        })
    }

    /// Adds devices, and tells which of them are software, once in a session.
    pub fn add_devices(&mut self, opened: Vec<Device>, quiet: bool) {
        self.devices.extend(opened);
        for (number, device) in self.devices.iter().enumerate() {
            let is_repeated = self.devices.iter().take(number).any(|other| other.name == device.name);
            tell_driver(device, quiet || is_repeated || self.devices_reported);
        }
        self.devices_reported |= !quiet;
    }

    /// How many kernels have been compiled.
    pub fn compiled(&self) -> usize {
        self.devices.iter().map(|device| device.kernels.compiled_names().len()).sum()
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
