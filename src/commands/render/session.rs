//! A session: what stays between the renders of `--watch`.

use super::args::RenderArgs;
use super::changes::Changes;
use super::rendering::Clock;
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
    /// Under `--watch`: the hierarchies of the scene's meshes.
    pub hierarchies: Option<Hierarchies>,
    pub assets: Assets,
}

impl Session {
    /// Loads the scene; of what its files hold only what is new.
    pub fn load(&mut self, args: &RenderArgs) -> Result<Scene> {
        let mut loading = Loading::new(args.quiet);
        let progress = &mut |file: &_, done, total| loading.update(file, done, total);
        load_with(&args.scene, progress, &mut self.assets)
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
