//! The orders of the window to the thread that renders, and the state of that.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::Instant;

use super::layers::{PictureLayer, Shown};
use crate::output::view_transform::ViewTransform;
use crate::scene::Camera;

/// Orders of the window.
#[derive(Clone, Debug, Default)]
pub struct Orders {
    /// The camera in the notation of scene files, if it has been moved.
    pub camera: Option<String>,
    pub layer: PictureLayer,
    /// Counts the changes after which the image is another one.
    pub revision: u64,
    /// When the camera was moved last.
    pub moved: Option<Instant>,
    pub paused: bool,
    /// A pixel of the image whose surface is wanted.
    pub pixel: Option<(u32, u32)>,
    /// The image is to be saved, with a PNG of this view.
    pub save: Option<ViewTransform>,
    pub ends: bool,
}

/// The state of the thread that renders, as the window shows it.
#[derive(Clone, Debug, Default)]
pub struct ViewState {
    pub shown: Option<Arc<Shown>>,
    /// The camera of the scene file.
    pub camera: Camera,
    /// The size of the image, and its last sample.
    pub size: (u32, u32),
    pub samples: u64,
    pub is_compiling: bool,
    /// The last errors, until something succeeds.
    pub errors: Vec<String>,
    /// The last message, such as the name of a saved file.
    pub message: String,
    pub surface: Option<PixelSurface>,
}

/// The surface that a pixel shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelSurface {
    pub pixel: (u32, u32),
    /// The object, its material, and the distance along the ray.
    pub words: String,
    /// The distance along the camera's axis, in scene units. Without it the pixel shows no surface.
    pub depth: Option<f64>,
}

/// Both, shared by the two threads.
#[derive(Default)]
pub struct Link {
    orders: Mutex<Orders>,
    state: Mutex<ViewState>,
    /// The thread that renders.
    pub renderer: OnceLock<Thread>,
    /// Wakes the window.
    pub repaint: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

/// A poisoned lock still holds a value.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Link {
    pub fn orders(&self) -> Orders {
        lock(&self.orders).clone()
    }

    /// Changes what the window wants, and wakes the thread that renders.
    pub fn order(&self, change: impl FnOnce(&mut Orders)) {
        change(&mut lock(&self.orders));
        self.renderer.get().inspect(|thread| thread.unpark());
    }

    pub fn state(&self) -> ViewState {
        lock(&self.state).clone()
    }

    /// Changes what the thread has found, and wakes the window.
    pub fn tell(&self, change: impl FnOnce(&mut ViewState)) {
        change(&mut lock(&self.state));
        self.repaint.get().inspect(|repaint| repaint());
    }
}
