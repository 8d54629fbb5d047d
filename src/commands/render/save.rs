//! The files of a film that another command has rendered.

use std::time::Instant;

use super::args::RenderArgs;
use super::record::{Finish, Seconds, attributes_of, record};
use super::request::Request;
use crate::error::Result;
use crate::film::Accumulation;
use crate::output::exr::State;
use crate::scene::Scene;
use crate::session::Session;

/// Writes the film of the session's view as `render` with these arguments writes it.
///
/// # Errors
/// As of `render`, where a file cannot be written.
pub fn save(args: &RenderArgs, scene: &Scene, session: &Session, film: &Accumulation) -> Result<()> {
    let mut request = Request::new(args, scene, Instant::now())?;
    request.take(&session.scene)?;
    let facts = record(&request, session.numerics()?, &Finish::new(film, None, true), &Seconds::default());
    let state = State::new(request.identity().clone(), film);
    request.write(&film.film, Some(&state), &attributes_of(&facts))?;
    request.write_png(&film.film)
}
