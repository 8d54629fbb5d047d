//! What the caller of a render sees after each submission, and decides.

use std::time::Instant;

use super::outcome::Outcome;
use crate::film::Film;

/// The film of a render that goes on.
pub struct Snapshot<'a> {
    pub film: &'a Film,
    /// When the device became idle for it.
    pub begin: Instant,
    /// True if every pixel has exactly the outcome's samples.
    pub is_complete: bool,
}

/// Called after each submission with the render's outcome so far, and with the film if the last call asked for a snapshot. Each device has a
/// thread, which calls.
pub type Watch<'a> = &'a mut (dyn FnMut(&Outcome, Option<Snapshot<'_>>) -> Next + Send);

/// The caller's decision after each submission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    GoOn,
    /// Bring the film up to date, and show it as a [`Snapshot`]. Runs that are under way are not in it.
    Snapshot,
    /// End the block of samples that has been started, and show the film when it is whole.
    CompleteSnapshot,
    /// End the block of samples that has been started, and nothing after it.
    Stop,
    /// End at once. Nobody wants the image: the render fails with [`Error::Dropped`].
    Drop,
}
