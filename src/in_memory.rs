//! A scene rendered in memory, for programs that use this one as a library.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::film::Picture;
use crate::gpu::device::{Adapters, Device};
use crate::job::{Frame, Goal, Job, MOST_SAMPLES, MOST_SIDE};
use crate::options::RenderOptions;
use crate::scene::Scene;
use crate::session::Session;

/// What to render, where it is not what the scene says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels.
    pub size: Option<(u32, u32)>,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// The seed of the random numbers.
    pub seed: u32,
    /// The device, by its index or a part of its name as `gpu-rt devices` lists them. The default is the most capable kind of device.
    pub device: Option<String>,
}

/// The picture of a scene, as `gpu-rt render` makes it.
///
/// # Errors
/// If a setting is out of range, if there is no such device, or if the device fails.
pub fn render_scene(scene: &Scene, settings: &RenderSettings) -> Result<Picture> {
    let size = settings.size.unwrap_or((scene.image.width, scene.image.height));
    let samples = settings.samples.unwrap_or(scene.render.samples);
    if [size.0, size.1].iter().any(|side| !(1..=MOST_SIDE).contains(side)) {
        let (width, height) = size;
        return Err(Error::Usage(format!("expected sides from 1 to {MOST_SIDE} pixels, found {width} x {height}")));
    }
    if !(1..=MOST_SAMPLES).contains(&i64::from(samples)) {
        return Err(Error::Usage(format!("expected from 1 to {MOST_SAMPLES} samples, found {samples}")));
    }
    let device = Device::open(Adapters::find().choose(settings.device.as_deref())?)?;
    let mut session = Session::on(vec![Arc::new(device)]);
    session.view(scene, &Frame::full(size), &RenderOptions::default())?;
    let mut film = session.film(size)?;
    let goal = Goal::Samples(samples);
    let job = Job { size, max_depth: scene.render.max_depth, seed: settings.seed, first_sample: 0, goal };
    session.render(&job, &mut film, &mut ())?;
    Ok(film.film.develop())
}
