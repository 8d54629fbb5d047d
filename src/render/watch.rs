//! What the caller of a render gets and decides after each submission.

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

/// Called after each submission with the render's outcome so far, and with the film if the last call returned a snapshot as its decision. The
/// threads of all devices call it.
pub type Watch<'a> = &'a mut (dyn FnMut(&Outcome, Option<Snapshot<'_>>) -> Next + Send);

/// The caller's decision after each submission.
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
