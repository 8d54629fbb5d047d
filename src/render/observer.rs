//! Who follows a render, and decides after each submission how it goes on.

use std::sync::Arc;
use std::time::Instant;

use super::outcome::Outcome;
use crate::error::{Error, Result};
use crate::film::Accumulation;
use crate::flatten::DeviceScene;
use crate::gpu::device::Device;
use crate::gpu::numerics::Numerics;
use crate::job::Job;

/// Follows a render of a [`Session`](crate::session::Session). By default it lets the render go on.
pub trait Observer: Send {
    /// Kernels compile for these devices, until [`Observer::compiled`] is called.
    ///
    /// # Errors
    /// Where the render is to end before that.
    fn compiling(&mut self, _devices: &[Arc<Device>]) -> Result<()> {
        Ok(())
    }

    /// They are compiled, or one of them has failed.
    fn compiled(&mut self) {}

    /// A job begins on a film by devices with these numerics.
    fn begin(&mut self, _job: &Job, _film: &Accumulation, _numerics: &Numerics) {}

    /// Called after each submission with the render's outcome so far, and with the film if the last call returned a snapshot as its decision. The
    /// threads of all devices call it.
    fn follow(&mut self, _so_far: &Outcome, _snapshot: Option<Snapshot<'_>>) -> Next {
        Next::GoOn
    }

    /// One of the devices has failed, with this error, while they rendered this film of the view. The result is the film to go on with once they are
    /// opened again; `None` ends the render with the error.
    fn lost(&mut self, _: &Error, _: &DeviceScene, _: &[Arc<Device>], _: &Accumulation) -> Option<Accumulation> {
        None
    }
}

/// Follows nothing.
impl Observer for () {}

/// Follows a render by a function that is called after each submission.
pub fn following<F: FnMut(&Outcome, Option<Snapshot<'_>>) -> Next + Send>(follow: F) -> F {
    follow
}

impl<F: FnMut(&Outcome, Option<Snapshot<'_>>) -> Next + Send> Observer for F {
    fn follow(&mut self, so_far: &Outcome, snapshot: Option<Snapshot<'_>>) -> Next {
        self(so_far, snapshot)
    }
}

/// Follows a render that ends early where `stops` says so.
pub fn stopping(stops: impl Fn() -> bool + Send) -> impl Observer {
    following(move |_, _| if stops() { Next::Stop } else { Next::GoOn })
}

/// The film of a render that goes on.
pub struct Snapshot<'a> {
    pub film: &'a Accumulation,
    /// When the device became idle for it.
    pub begin: Instant,
    /// True if every pixel has exactly the film's samples.
    pub is_complete: bool,
}

/// An observer's decision after each submission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    GoOn,
    /// Call again with the film, up to date but for the runs in flight.
    Snapshot,
    /// End the block of samples that has been started, and call again with the complete film.
    CompleteSnapshot,
    /// End the block of samples that has been started, and render no other.
    Stop,
    /// End at once, without the image: the render fails with [`Error::Dropped`].
    Drop,
}
