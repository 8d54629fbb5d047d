//! `gpu-rt view`: a scene in a window, to look around in.

mod args;
#[cfg(feature = "window")]
mod window;

pub use args::WindowArgs;
#[cfg(feature = "window")]
pub use window::{Link, Rendering, ViewState, Window};

use crate::error::Result;

/// Opens the window, until it is closed or a signal comes.
///
/// # Errors
/// `Error::Usage` if this program has no window, or there is no display. Else those of `render`.
#[cfg(feature = "window")]
pub fn run(args: &WindowArgs) -> Result<()> {
    window::run(args)
}

#[cfg(not(feature = "window"))]
pub fn run(_: &WindowArgs) -> Result<()> {
    Err(crate::error::Error::Usage(
        "this program is built without a window: `cargo build --release --features window` builds one with it, and releases have it. `gpu-rt \
         render --preview` draws in the terminal"
            .to_owned(),
    ))
}
